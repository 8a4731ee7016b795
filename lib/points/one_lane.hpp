#pragma once

#include "core/kernel_language.hpp"

#include "binary_tree.h"
#include "layout.h"
#include "outputs.h"
#include "point_tree.h"

// OpenCL C gets no warnings for C++.
#ifdef __GNUC__
#pragma GCC system_header
#endif

/// kernels/tree/point_search.h and finish_point.h, compiled by the host with one lane.
namespace clsdf::points::one_lane {

using namespace kernel_language;

#define LANES 1
#define __global
#define __private
#include "finish_point.h"
#include "point_search.h"
#undef LANES
#undef __global
#undef __private

}  // namespace clsdf::points::one_lane
