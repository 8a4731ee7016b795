#pragma once

#include "polyhedra/frames.hpp"

#include "face_sources.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

/// kernels/frusta/face_frames.h, compiled by the host with one lane.
namespace clsdf::polyhedra::one_lane {

using uint = std::uint32_t;
using uchar = std::uint8_t;
using ulong = std::uint64_t;
using std::fabs;
using std::sqrt;

template <typename T>
float as_float(T x) {
    return std::bit_cast<float>(x);
}
template <typename T>
uint as_uint(T x) {
    return std::bit_cast<uint>(x);
}
inline double as_double(ulong x) {
    return std::bit_cast<double>(x);
}

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
