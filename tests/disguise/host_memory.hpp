#pragma once

#include <cstddef>
#include <cstdint>

/// Memory of operator new, which a program that links host_memory.cpp counts.
namespace clsdf::test {

struct HostMemory {
    std::uint64_t arrays = 0;      ///< of 64 KiB or more; the number of smaller ones depends on the standard library
    std::uint64_t peak_bytes = 0;  ///< the most at once, small ones, too
};

/// Counts what the calling thread allocates, from now to end_counting_memory(), but not within calls of OpenCL: that is
/// the driver's. Memory that the driver gives back, on its threads or in a call, counts as if it were kept, because its
/// time is by chance. Other threads are not counted: the caller holds oneTBB to one.
void count_host_memory();
HostMemory end_counting_memory();

}  // namespace clsdf::test
