#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace clsdf {

/// A text from a file for a message: in quotes, cut after `limit` bytes, with '?' for each byte that is a control
/// character or not ASCII. (A NUL would end the message.)
std::string quoted(std::string_view text, std::size_t limit = 40);

/// The fewest insertions, deletions and replacements of one character that turn one word into the other (Levenshtein).
std::size_t edit_distance(std::string_view from, std::string_view to);

}  // namespace clsdf
