#pragma once

#include "core/kernel_language.hpp"
#include "polyhedra/frames.hpp"

#include "face_sources.h"

/// kernels/frusta/face_frames.h, compiled by the host with one lane.
namespace clsdf::polyhedra::one_lane {

using namespace kernel_language;

#define LANES 1
#define __global
#define __private
#ifdef __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#endif
#include "face_frames.h"
#ifdef __GNUC__
#pragma GCC diagnostic pop
#endif
#undef LANES
#undef __global
#undef __private

}  // namespace clsdf::polyhedra::one_lane

namespace clsdf::polyhedra {

inline one_lane::Vectors vectors_of(const Vector& v) {
    return one_lane::vectors(v.x(), v.y(), v.z());
}
inline Vector to_vector(const one_lane::Vectors& v) {
    return {v.x, v.y, v.z};
}

}  // namespace clsdf::polyhedra
