#pragma once

#include "polyhedra/lateral_plane.hpp"

#include <span>

namespace clsdf::polyhedra {

/// Above the rounding of a product of three vectors no longer than ten, 1e-12.
inline constexpr double certain_product = 1e-9;
/// Vectors of steeper slopes, at sharp edges, would be longer than ten.
inline constexpr double steepest_slope = 8;
/// Of the margin; the rest covers the rounding of the conditions.
inline constexpr double certain_part = 0.99;

/// Whether it is certain that no direction is rejected by all faces of a fan, by the margin, each at the edge given
/// (docs/method.md, 'Gaps at saddle vertices'). The faces have one orientation. Answers no where it cannot tell
/// cheaply; that is rare where few faces meet.
bool cannot_all_reject(std::span<const LateralPlane> planes, double margin);

}  // namespace clsdf::polyhedra
