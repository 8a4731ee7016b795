#include "nearest_word.hpp"

#include "tools/text.hpp"

#include <algorithm>
#include <cstddef>

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
    std::string nearest;
    // If more than a third of the letters differ, it is another word, not a mistyped one.
    std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string& candidate : known) {
        const bool is_beginning = word.size() > 3 && candidate.starts_with(word);
        const std::size_t distance = is_beginning ? 0 : clsdf::edit_distance(word, candidate);
        if (distance < least && distance < candidate.size()) {
            least = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

std::string did_you_mean(const std::string& word) {
    return word.empty() ? std::string() : "; did you mean " + word + '?';
}
