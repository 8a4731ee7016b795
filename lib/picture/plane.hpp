#pragma once

#include <clsdf/field.hpp>
#include <clsdf/picture.hpp>

#include <array>
#include <cstddef>
#include <vector>

namespace clsdf::picture {

/// The samples of a slice as they lie on paper: columns to the right, rows upwards.
struct Plane {
    std::array<Axis, 2> axes{Axis::x, Axis::y};  ///< to the right, upwards
    std::array<std::int64_t, 2> size{};          ///< columns, rows; each >= 2
    std::array<double, 2> lower{};               ///< position of the first column and row, in the mesh's units
    std::array<double, 2> upper{};               ///< position of the last ones
    std::vector<double> values;                  ///< columns fastest

    double sample(std::int64_t column, std::int64_t row) const {
        return values[static_cast<std::size_t>(row * size[0] + column)];
    }

    /// Bilinear between the samples; in samples from the first one, 0 ... size - 1.
    double at(double column, double row) const;
};

/// Throws Error(invalid_argument) if the grid or the band is invalid, if the distances do not fit the grid, or if the
/// grid cannot be drawn: a spacing beyond floats, or neighbouring samples with the same position.
void check_field(const Field& field);

/// Throws Error(invalid_argument) if the field has no such slice, or the slice fewer than two samples a side.
///
/// If the band ends between two samples, the outer one has no distance. Its value is extrapolated linearly from the
/// inner ones, so that the drawing ends at the band's limit and not in stairs of voxels. No sample within the band is
/// changed, and no sample beyond it gets a value within it.
Plane plane_of(const Field& field, const Slice& slice, const std::array<Axis, 2>& axes);

/// The two other axes: x before y before z.
std::array<Axis, 2> axes_beside(Axis axis);

/// A point of the plane, in samples from the first column and row.
using PlanePoint = std::array<double, 2>;

/// Points joined by straight lines; a closed one repeats its first point at its end.
using Polyline = std::vector<PlanePoint>;

/// The lines at the value `level`, by marching squares, with points by linear interpolation on the edges between
/// neighbouring samples. A square with two opposite corners above is split as its bilinear interpolant is. A sample
/// equal to the level counts as above. Squares with a corner that is not finite have no line.
std::vector<Polyline> iso_lines(const Plane& plane, double level);

}  // namespace clsdf::picture
