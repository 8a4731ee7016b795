#pragma once

#include <clsdf/mesh.hpp>

#include <cmath>
#include <cstddef>

namespace clsdf::engine {

/// A mesh seen from a lattice: positions in units, in the metric frame, relative to the lattice's sample (0, 0, 0). The
/// unit is the caller's choice, of the order of the smallest spacing; a power of two scales without rounding.
struct LatticeView {
    Vec3 origin{};                   ///< of the lattice, in the mesh's units
    double unit = 1;                 ///< in the mesh's units
    Vec3 spacing_in_units{1, 1, 1};  ///< per axis

    /// On an axis, in units from sample (0, 0, 0). Beyond, one double is too coarse for a position.
    static constexpr double far = 0x1p24;

    /// The difference position - sample number `sample` on an axis, in units. If both are far from sample (0, 0, 0),
    /// each is taken as the sum of two doubles, so that the rounding is relative to the difference.
    double from_sample(std::size_t axis, double position, double sample) const {
        const double head = position - origin[axis];
        const double place = sample * spacing_in_units[axis];
        if (!(std::abs(head / unit) > far)) return head / unit - place;
        const double subtracted = head - position;
        const double tail = (position - (head - subtracted)) - (origin[axis] + subtracted);
        const double place_tail = std::fma(sample, spacing_in_units[axis], -place);
        return (head / unit - place) + (tail / unit - place_tail);
    }
};

}  // namespace clsdf::engine
