#pragma once

#include "core/kernel_language.hpp"
#include "frusta/frames.hpp"

#include "face_sources.h"

// OpenCL C gets no warnings for C++.
#ifdef __GNUC__
#pragma GCC system_header
#endif

/// kernels/frusta/face_frames.h and gap_test.h, compiled by the host with one lane.
namespace clsdf::engine::one_lane {

using namespace kernel_language;

#define LANES 1
#define __global
#define __private
#include "face_frames.h"
#include "gap_test.h"
#undef LANES
#undef __global
#undef __private

}  // namespace clsdf::engine::one_lane
