#pragma once

#include "core/kernel_language.hpp"

#include "binary_tree.h"
#include "layout.h"
#include "point_tree.h"

#include <cstdint>

// OpenCL C gets no warnings for C++.
#ifdef __GNUC__
#pragma GCC system_header
#endif

/// The searches of points, compiled by the host with one lane, so that their work can be counted and their float
/// distances be looked at.
namespace clsdf::test {

struct SearchCounts {
    std::uint64_t boxes = 0;      ///< that a point is compared with
    std::uint64_t faces = 0;      ///< whose distance is computed in float
    std::uint64_t decisions = 0;  ///< distances in double
};

/// The sums of this thread's searches.
inline thread_local SearchCounts search_counts;

#undef COUNTED
#define COUNTED(what, number) clsdf::test::search_counts.what += (number)

namespace one_lane {

using namespace kernel_language;

#define LANES 1
#define __global
#define __local
#define __private
#include "binary_search.h"
#include "point_search.h"
#undef LANES
#undef __global
#undef __local
#undef __private

}  // namespace one_lane

}  // namespace clsdf::test
