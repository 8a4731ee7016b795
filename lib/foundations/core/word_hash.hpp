#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace clsdf {

/// A hash of words in their order, the same on every machine. It tells damage and differences, not forgery.
class WordHash {
public:
    /// Maps different states to different states, and different words, too. So one word that differs is never lost.
    void add(std::uint64_t word) {
        value_ = (value_ ^ word) * 0x9E3779B97F4A7C15U;
        value_ ^= value_ >> 32;
    }
    std::uint64_t value() const { return value_; }

private:
    std::uint64_t value_ = 0;
};

inline std::uint64_t hash_of(std::span<const std::byte> bytes) {
    WordHash hash;
    std::size_t at = 0;
    for (; at + sizeof(std::uint64_t) <= bytes.size(); at += sizeof(std::uint64_t)) {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes.data() + at, sizeof(word));
        hash.add(word);
    }
    for (; at < bytes.size(); ++at) hash.add(std::to_integer<std::uint64_t>(bytes[at]));
    return hash.value();
}

}  // namespace clsdf
