#pragma once

#include "core/descriptor.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

namespace clsdf {

/// What became of a read: how many bytes were there, in all, and the system's error number, 0 where it had none.
struct ReadResult {
    std::size_t bytes = 0;
    int error = 0;
};

/// Fills `room` with the bytes of a file from `offset` on, on all cores. Where the file ends before, or cannot be read,
/// fewer are counted.
ReadResult read_in_parallel(const Descriptor& file, std::uint64_t offset, std::span<std::byte> room);

}  // namespace clsdf
