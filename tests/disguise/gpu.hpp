#pragma once

#include "disguise/record.hpp"

namespace clsdf::disguise {

constexpr std::size_t largest_group = 128;   ///< work-items; many GPUs have more, few have fewer
constexpr cl_ulong local_memory = 48 << 10;  ///< bytes of a group, as NVIDIA's GPUs have

/// Whether processors answer as GPUs.
inline bool is_gpu() {
    return record().settings.gpu;
}

/// A read that does not block, into `target`.
void note_read(cl_event event, const void* target);
/// Whether it reads into mapped memory; asked once.
bool is_pinned_read(cl_event event);

}  // namespace clsdf::disguise
