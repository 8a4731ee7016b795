#pragma once

#include "core/kernel_language.hpp"

#include <clsdf/mesh.hpp>

#include <array>

// OpenCL C gets no warnings for C++.
#ifdef __GNUC__
#pragma GCC system_header
#endif

/// kernels/common/segment_crossings.h, compiled by the host: how a segment crosses a face, exact for coordinates in
/// the range of expansions.h.
namespace clsdf::crossing {

using namespace kernel_language;

#define __private
#include "segment_crossings.h"
#undef __private

using Corners = std::array<Vec3, 3>;

inline double3 vector(const Vec3& p) {
    return {p[0], p[1], p[2]};
}
inline Segment segment(const Vec3& from, const Vec3& to) {
    return segment_between(vector(from), vector(to));
}
inline Segment ray(const Vec3& from, const Vec3& direction) {
    return ray_from(vector(from), vector(direction));
}
inline FaceCrossing crossing_of(const Corners& face, const Segment& segment) {
    return crossing_of(vector(face[0]), vector(face[1]), vector(face[2]), segment);
}
inline double place_of(const Corners& face, const Segment& segment) {
    return place_of(vector(face[0]), vector(face[1]), vector(face[2]), segment);
}

}  // namespace clsdf::crossing
