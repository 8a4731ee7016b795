#pragma once

#include "disguise/record.hpp"

namespace clsdf::disguise {

constexpr std::size_t largest_group = 128;   ///< work-items; many GPUs have more, few have fewer
constexpr cl_ulong local_memory = 48 << 10;  ///< bytes of a group, as NVIDIA's GPUs have
// The limits of a launch.
constexpr std::size_t most_groups = 65535;  ///< along y and z
constexpr std::uint64_t most_items = (std::uint64_t{1} << 32) - 1;

/// Whether processors answer as GPUs.
inline bool is_gpu() {
    return record().settings.gpu;
}

/// For each buffer that a command uses: a GPU allocates it at its first use. Returns a code, or CL_SUCCESS.
cl_int use(cl_mem buffer);
/// The same for the buffers that a kernel has as arguments.
cl_int use_arguments(cl_kernel kernel);
void note_argument(cl_kernel kernel, cl_uint index, std::size_t bytes, const void* value);
/// A new kernel, which may have the handle of one that was released.
void forget_arguments(cl_kernel kernel);

/// A transfer of so many bytes from or to the host's memory.
void note_transfer(const void* host, std::size_t bytes);
/// A read that does not block, into `target`.
void note_read(cl_event event, const void* target, std::size_t bytes);
/// Whether it reads into mapped memory; asked once.
bool is_pinned_read(cl_event event);

}  // namespace clsdf::disguise
