#include "picture/text.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

namespace clsdf::picture {
namespace {

// The number of bytes of the first character, or 0 if it is not valid UTF-8.
std::size_t character_length(std::string_view text) {
    const auto byte = [&](std::size_t index) { return static_cast<unsigned char>(text[index]); };
    const unsigned first = byte(0);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xC2 ? 0
                               : first < 0xE0 ? 2
                               : first < 0xF0 ? 3
                               : first < 0xF5 ? 4
                                              : 0;
    if (length == 0 || length > text.size()) return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(i) & 0xC0U) != 0x80) return 0;
    // Overlong forms, surrogates and what lies beyond Unicode.
    if ((first == 0xE0 && byte(1) < 0xA0) || (first == 0xED && byte(1) > 0x9F) || (first == 0xF0 && byte(1) < 0x90) ||
        (first == 0xF4 && byte(1) > 0x8F))
        return 0;
    return length;
}

}  // namespace

std::string printable(const std::string& text, std::size_t characters) {
    std::vector<std::string> parts;
    for (std::string_view rest = text; !rest.empty();) {
        const std::size_t length = character_length(rest);
        const bool shown = length > 0 && static_cast<unsigned char>(rest[0]) >= 0x20;
        parts.push_back(shown ? std::string(rest.substr(0, length)) : "\uFFFD");
        rest.remove_prefix(length > 0 ? length : 1);
    }
    if (parts.size() > characters) {
        const auto half = static_cast<std::ptrdiff_t>(characters / 2);
        parts.erase(parts.begin() + half, parts.end() - half);
        parts.insert(parts.begin() + half, "…");
    }
    std::string result;
    for (const std::string& part : parts) result += part;
    return result;
}

std::string in_ascii(const std::string& text) {
    static constexpr std::array<std::pair<std::string_view, std::string_view>, 14> forms{{{"−", "-"},
                                                                                          {"×", "x"},
                                                                                          {"…", "..."},
                                                                                          {"⁻", "-"},
                                                                                          {"⁰", "0"},
                                                                                          {"¹", "1"},
                                                                                          {"²", "2"},
                                                                                          {"³", "3"},
                                                                                          {"⁴", "4"},
                                                                                          {"⁵", "5"},
                                                                                          {"⁶", "6"},
                                                                                          {"⁷", "7"},
                                                                                          {"⁸", "8"},
                                                                                          {"⁹", "9"}}};
    std::string result;
    bool raised = false;
    for (std::string_view rest = text; !rest.empty();) {
        const std::string_view character = rest.substr(0, std::max<std::size_t>(1, character_length(rest)));
        rest.remove_prefix(character.size());
        if (character.size() == 1) {
            result += character;
            raised = false;
            continue;
        }
        const auto* form = std::find_if(forms.begin(), forms.end(),
                                        [&](const auto& candidate) { return candidate.first == character; });
        const bool superscript = form != forms.end() && form - forms.begin() >= 3;
        if (superscript && !raised) result += '^';
        raised = superscript;
        result += form == forms.end() ? "?" : form->second;
    }
    return result;
}

}  // namespace clsdf::picture
