#include "field/base64.hpp"

#include <cstdint>

namespace clsdf {
namespace {

// The six bits of a letter, or -1.
int bits_of(char letter) {
    if (letter >= 'A' && letter <= 'Z') return letter - 'A';
    if (letter >= 'a' && letter <= 'z') return letter - 'a' + 26;
    if (letter >= '0' && letter <= '9') return letter - '0' + 52;
    if (letter == '+') return 62;
    return letter == '/' ? 63 : -1;
}

bool is_blank(char letter) {
    return letter == ' ' || letter == '\t' || letter == '\r' || letter == '\n';
}

}  // namespace

std::optional<std::vector<std::byte>> decode_base64(std::string_view text) {
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3);
    std::uint32_t group = 0;
    int letters = 0, padding = 0;
    for (const char letter : text) {
        if (is_blank(letter)) continue;
        const int bits = letter == '=' ? 0 : bits_of(letter);
        padding += letter == '=';
        const bool is_misplaced = letter == '=' ? letters < 2 : padding > 0;
        if (bits < 0 || is_misplaced) return std::nullopt;
        group = group << 6 | static_cast<std::uint32_t>(bits);
        if (++letters < 4) continue;
        for (int i = 0; i < 3 - padding; ++i) bytes.push_back(static_cast<std::byte>(group >> (16 - 8 * i) & 0xFFU));
        group = 0;
        letters = padding = 0;
    }
    if (letters != 0) return std::nullopt;
    return bytes;
}

}  // namespace clsdf
