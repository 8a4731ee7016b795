#pragma once

#include "polyhedra/triangle_frame.hpp"

#include <array>

/// Slopes of the lateral planes of a face's edges, above the face and below it (docs/method.md, 'Leaned frusta').
namespace clsdf::polyhedra {

/// Of one edge's plane, above the face and below it.
struct EdgeSlope {
    float above;
    float below;
};

/// By edge of a face.
struct FaceSlopes {
    std::array<float, 3> above;
    std::array<float, 3> below;
};

/// `x` >= 0 as a float that is not below it, also after the roundings that led to it.
inline float widened(double x) {
    return static_cast<float>(x * (1 + 1e-6));
}

/// Where the corner opposite the base is obtuse, its two planes lean outward so that each contains what the other
/// contains: the obtuse corner's vertices are cut off otherwise. No other corner of a triangle is obtuse.
void lean(const TriangleFrame& frame, FaceSlopes& slopes);

}  // namespace clsdf::polyhedra
