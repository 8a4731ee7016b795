#pragma once

#include "device/opencl.hpp"

#include <cstddef>
#include <mutex>
#include <optional>
#include <vector>

namespace clsdf::device {

/// Buffers in a device's own memory that no transform uses, kept for the next one: to make, touch and release one takes
/// longer than a small kernel. They are few enough not to be missed; if memory is short, all are released.
class SpareBuffers {
public:
    // NOLINTNEXTLINE(bugprone-exception-escape): OpenCL's binding would throw from a move if a release fails
    struct Spare {
        cl::Buffer buffer;
        std::size_t bytes = 0;
    };

    /// The most bytes that are kept; 0 keeps nothing.
    void set_limit(std::size_t bytes);
    /// Keeps a buffer. Commands in the context's queue may still use it. Releases those kept longest beyond the limit.
    void keep(Spare spare) noexcept;
    /// The smallest of at least `wanted` bytes, unless it is far larger.
    std::optional<Spare> take(std::size_t wanted);
    /// Releases all of them. Returns their bytes.
    std::size_t release();
    std::size_t bytes() const;

private:
    mutable std::mutex mutex_;
    std::vector<Spare> spares_;  // kept longest first
    std::size_t bytes_ = 0, limit_ = 0;
};

/// The smallest that is large enough, and not so large that its memory would be wasted; the end if there is none.
template <class Buffers>
auto smallest_fit(Buffers& buffers, std::size_t wanted) {
    auto best = buffers.end();
    for (auto it = buffers.begin(); it != buffers.end(); ++it)
        if (it->bytes >= wanted && it->bytes <= 2 * wanted + 4096 && (best == buffers.end() || it->bytes < best->bytes))
            best = it;
    return best;
}

}  // namespace clsdf::device
