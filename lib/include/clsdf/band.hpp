#pragma once

#include <clsdf/version.hpp>
#include <limits>

namespace clsdf {

/// The half widths of a narrow band, in the mesh's units; each is >= 0 and may be infinite. They have no default: a
/// band with a half width that is not set is refused. If both are 0, the field tells inside from outside and holds no
/// distance. A sample with -inside <= distance <= outside carries its exact signed distance; every other one carries
/// +outside or -inside, with the right sign (-0.0 for inside = 0). An unsigned field uses `outside` alone.
struct Band {
    double inside = std::numeric_limits<double>::quiet_NaN();   ///< NaN: not set
    double outside = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not set

    static Band symmetric(double half_width) { return {half_width, half_width}; }
    /// Every sample of the grid carries its distance.
    static Band full();

    double widest() const { return inside > outside ? inside : outside; }

    /// Throws Error(invalid_argument) where a half width is not set, or negative.
    void validate() const;
};

}  // namespace clsdf
