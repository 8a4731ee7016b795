#pragma once

#include "picture/plane.hpp"

#include <array>
#include <vector>

namespace clsdf::picture {

/// A point of the plane, in samples from the first column and row.
using PlanePoint = std::array<double, 2>;

/// Points joined by straight lines; a closed one repeats its first point at its end.
using Polyline = std::vector<PlanePoint>;

/// The lines at the value `level`, by marching squares, with points by linear interpolation on the edges between
/// neighbouring samples. A square with two opposite corners above is split as its bilinear interpolant is. A sample
/// equal to the level counts as above. Squares with a corner that is not finite have no line.
std::vector<Polyline> iso_lines(const Plane& plane, double level);

}  // namespace clsdf::picture
