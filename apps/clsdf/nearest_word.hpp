#pragma once

#include <string>
#include <vector>

/// The known word that was probably meant: one that begins with the word, or else the nearest one. Empty if none is
/// near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// "; did you mean WORD?", or nothing if there is no word.
std::string did_you_mean(const std::string& word);
