#pragma once

#include <atomic>
#include <cstddef>

namespace clsdf {

/// The least of the indices that threads take.
class LeastIndex {
public:
    explicit LeastIndex(std::size_t none) : least_(none) {}

    void take(std::size_t index) {
        std::size_t least = least_;
        while (index < least && !least_.compare_exchange_weak(least, index)) {
        }
    }
    std::size_t get() const { return least_; }

private:
    std::atomic<std::size_t> least_;
};

}  // namespace clsdf
