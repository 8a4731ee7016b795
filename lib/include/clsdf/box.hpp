#pragma once

#include <clsdf/version.hpp>

#include <array>
#include <cstdint>

namespace clsdf {

/// A point or vector (x, y, z) in the mesh's units.
using Vec3 = std::array<double, 3>;

/// A triple of sample counts or sample indices (i, j, k); i runs along x.
using Index3 = std::array<std::int64_t, 3>;

/// An axis-parallel box in the mesh's units, limits included.
struct Box {
    Vec3 lower{};
    Vec3 upper{};

    Vec3 extent() const { return {upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]}; }

    /// The longest side: the unit of a length given in percent.
    double longest_side() const;
};

}  // namespace clsdf
