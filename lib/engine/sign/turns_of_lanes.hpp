#pragma once

#include "sign/film.hpp"
#include "solid_angle.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace clsdf::engine {

/// Samples next to each other in a row, from which loops are seen.
struct RowPlace {
    double x;           ///< of the first sample
    std::int64_t y, z;  ///< as of snapped vertices
    double per_y, per_z;
    Vec3 spacing;
};

/// The samples whose turns are computed at once.
constexpr std::size_t lanes = 4;

/// Turns of several samples, with halves as numbers that vectors have.
struct TurnsOfLanes {
    std::array<double, lanes> re, im, halves;

    TurnsOfLanes() {
        re.fill(1);
        im.fill(0);
        halves.fill(0);
    }
    Turns operator[](std::size_t lane) const {
        Turns turns;
        turns.re = re[lane];
        turns.im = im[lane];
        turns.halves = static_cast<int>(halves[lane]);
        return turns;
    }
};

/// On which side of the line of snapped corners a place lies: 1 left of it, as the kernels' left_of() has it, or -1.
/// The other way for the edge from b to a.
inline int side_of(const SweepVertex& a, const SweepVertex& b, std::int64_t y, std::int64_t z) {
    __extension__ typedef __int128 Wide;
    const Wide value = Wide{b.y - a.y} * (z - a.z) - Wide{b.z - a.z} * (y - a.y);
    if (value != 0) return value > 0 ? 1 : -1;
    if (b.z != a.z) return b.z < a.z ? 1 : -1;
    if (b.y != a.y) return b.y > a.y ? 1 : -1;
    return b.x > a.x ? 1 : -1;
}

/// Adds the turns of a loop of so many corners: seen_vertex() and turned() of solid_angle.h in lanes, with the same
/// bits.
void add_loop(const LatticeCorner* corners, std::size_t count, const RowPlace& place, TurnsOfLanes& turns);

}  // namespace clsdf::engine
