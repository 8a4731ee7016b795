#pragma once

#include <string>
#include <vector>

/// The known word that was probably meant: one that begins with the word, or else the nearest one. Empty where none is
/// near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);
