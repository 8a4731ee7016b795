#pragma once

#include <cstdint>

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

}  // namespace clsdf
