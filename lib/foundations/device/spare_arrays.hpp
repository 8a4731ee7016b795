#pragma once

#include "core/large_memory.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <mutex>
#include <utility>
#include <vector>

namespace clsdf::device {

/// Elements of arrays of bytes, so many at once that making them costs nothing where compilers do not optimise.
struct MemoryLine {
    std::byte bytes[64];
};
using LinesOfMemory = UninitializedVector<MemoryLine>;

/// Arrays of the host that calls have given back, for later calls. They have no more than most_bytes in all.
class SpareArrays {
public:
    static constexpr std::size_t most_bytes = std::size_t{32} << 20;

    /// An array with room for so many lines, and not far more; an empty one if there is none.
    LinesOfMemory take(std::size_t lines) noexcept {
        const std::scoped_lock lock(mutex_);
        const auto fits = [lines](const LinesOfMemory& array) {
            return array.capacity() >= lines && array.capacity() <= 2 * lines;
        };
        const auto found = std::ranges::find_if(arrays_, fits);
        if (lines == 0 || found == arrays_.end()) return {};
        LinesOfMemory taken = std::move(*found);
        arrays_.erase(found);
        return taken;
    }
    /// Its contents are not needed any more. Those that were given back first go first.
    void keep(LinesOfMemory array) noexcept {
        if (array.capacity() == 0 || bytes_of(array) > most_bytes) return;
        try {
            const std::scoped_lock lock(mutex_);
            arrays_.push_back(std::move(array));
            while (bytes_of_all() > most_bytes) arrays_.erase(arrays_.begin());
        } catch (const std::exception&) {
            // No memory to remember it by.
        }
    }
    /// Returns the bytes that are released.
    std::size_t release() noexcept {
        const std::scoped_lock lock(mutex_);
        const std::size_t bytes = bytes_of_all();
        arrays_.clear();
        return bytes;
    }
    std::size_t bytes() const {
        const std::scoped_lock lock(mutex_);
        return bytes_of_all();
    }

private:
    static std::size_t bytes_of(const LinesOfMemory& array) { return array.capacity() * sizeof(MemoryLine); }
    std::size_t bytes_of_all() const {
        std::size_t bytes = 0;
        for (const LinesOfMemory& array : arrays_) bytes += bytes_of(array);
        return bytes;
    }

    mutable std::mutex mutex_;
    std::vector<LinesOfMemory> arrays_;  // given back first, first
};

}  // namespace clsdf::device
