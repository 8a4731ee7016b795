#pragma once

#include "polyhedra/triangle_frame.hpp"

#include <array>

/// Slopes of the lateral planes of a face's edges, above the face and below it (docs/method.md, 'Leaned frusta').
namespace clsdf::polyhedra {

/// The slopes of one edge's planes, above the face and below it.
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

/// If the corner opposite the base is obtuse, its two planes lean outward until each contains the wedge of the other;
/// otherwise they would cut it off. No other corner of a triangle is obtuse.
void lean(const TriangleFrame& frame, FaceSlopes& slopes);

}  // namespace clsdf::polyhedra
