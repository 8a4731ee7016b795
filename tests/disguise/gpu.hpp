#pragma once

#include "disguise/record.hpp"

namespace clsdf::disguise {

// As NVIDIA's GPUs have.
constexpr std::size_t largest_group = 1024;  ///< work-items
constexpr cl_ulong local_memory = 48 << 10;  ///< bytes of a group

/// Whether processors answer as GPUs.
inline bool is_gpu() {
    return record().settings.gpu;
}

}  // namespace clsdf::disguise
