#pragma once

#include <clsdf/version.hpp>

namespace clsdf {

/// The half widths of a narrow band, in the mesh's units; each is >= 0 and may be infinite.
/// A sample with -inside <= distance <= outside carries its exact signed distance; every other one carries +outside or
/// -inside, with the right sign (-0.0 for inside = 0). An unsigned field uses `outside` alone.
struct Band {
    double inside = 0;
    double outside = 0;

    static Band symmetric(double half_width) { return {half_width, half_width}; }
    /// Every sample of the grid carries its distance.
    static Band full();

    double widest() const { return inside > outside ? inside : outside; }

    /// Throws Error(invalid_argument) where a half width is negative or not a number.
    void validate() const;
};

}  // namespace clsdf
