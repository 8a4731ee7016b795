#pragma once

#include "core/kernel_language.hpp"

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <span>

// OpenCL C gets no warnings for C++.
#ifdef __GNUC__
#pragma GCC system_header
#endif

/// kernels/common/ray_side.h and expansions.h, compiled by the host: the signs of predicates.hpp in a range of
/// coordinates, without multiple precision.
namespace clsdf::expansions {

using namespace kernel_language;

#define __private
#include "ray_side.h"
#undef __private

inline double3 vector(const Vec3& p) {
    return {p[0], p[1], p[2]};
}

/// Whether the signs are exact for these positions.
inline bool are_exact(std::span<const Vec3> positions) {
    return std::ranges::all_of(positions, [](const Vec3& p) { return std::ranges::all_of(p, is_in_exact_range); });
}

}  // namespace clsdf::expansions
