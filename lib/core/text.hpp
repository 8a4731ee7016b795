#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf {

/// A text from a file for a message: in quotes, cut after `limit` bytes, with '?' for each byte that is a control
/// character or not ASCII. (A NUL would end the message.)
std::string quoted(std::string_view text, std::size_t limit = 40);

/// The fewest insertions, deletions and replacements of one character that turn one word into the other (Levenshtein).
/// Defined in the header, because the command cannot link hidden functions of the library.
inline std::size_t edit_distance(std::string_view from, std::string_view to) {
    std::vector<std::size_t> row(to.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (const char letter : from) {
        std::size_t diagonal = row[0]++;
        for (std::size_t j = 0; j < to.size(); ++j) {
            const std::size_t replaced = diagonal + (letter == to[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

}  // namespace clsdf
