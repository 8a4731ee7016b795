#pragma once

#include "mesh/segment_crossings.hpp"
#include "tree/crossed_faces.hpp"

#include <clsdf/segments.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

/// Where one segment, or ray, meets one face.
namespace clsdf::segments {

/// The exponent of the power of two that is just above the greatest component.
inline int exponent_of(const Vec3& v) {
    int exponent = 0;
    std::frexp(std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}), &exponent);
    return exponent;
}
inline Vec3 times_power(const Vec3& v, int exponent) {
    return {std::ldexp(v[0], exponent), std::ldexp(v[1], exponent), std::ldexp(v[2], exponent)};
}

/// A segment or a ray in units, as faces are compared with it.
struct Line {
    crossing::Segment exact;
    Vec3 from, along;     ///< along: of a segment rounded
    double greatest = 0;  ///< of the components of `along`

    static Line ray(const Vec3& from, const Vec3& direction) { return {crossing::ray(from, direction), direction}; }
    static Line segment(const Vec3& from, const Vec3& to);

private:
    Line(const crossing::Segment& exact_in, const Vec3& along_in);
};

/// A face that the line meets: if walls are asked for, one that it crosses in some of the looks, else one that it
/// touches and is not parallel to.
struct FaceHit {
    std::uint32_t face;
    std::int8_t side;     ///< 1: the line comes from the face's front, -1: from its back
    std::uint8_t looks;   ///< in which it is crossed
    std::int8_t change;   ///< of the winding number along the line
    double place, error;  ///< within `error`, which may be infinite
};

/// Whether the line meets the face; sets all of `hit` but the face and the change.
bool meets(const Line& line, const engine::CrossedFaces::Corners& corners, Hits hits, FaceHit& hit);

/// Whether the segment runs in the plane of the face, exactly.
bool is_in_plane(const crossing::Segment& segment, const engine::CrossedFaces::Corners& corners);

}  // namespace clsdf::segments
