#pragma once

#include "core/kernel_language.hpp"

#include "point_tree.h"

// OpenCL C gets no warnings for C++.
#ifdef __GNUC__
#pragma GCC system_header
#endif

/// kernels/tree/box_query.h and ray_boxes.h, compiled by the host with one lane.
namespace clsdf::engine::one_lane {

using namespace kernel_language;

#define LANES 1
#define __global
#define __private
#include "box_query.h"
#include "ray_boxes.h"
#undef LANES
#undef __global
#undef __private

}  // namespace clsdf::engine::one_lane
