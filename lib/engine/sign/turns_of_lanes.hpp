#pragma once

#include "sign/film.hpp"
#include "solid_angle.h"
#include "surface/film_expansion.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace clsdf::engine {

/// The samples whose turns are computed at once: so many rows along x, beside each other along y, of so many samples.
constexpr std::size_t lanes = 4;

/// Where these samples are.
struct PlanePlace {
    double x;             ///< of the first sample
    std::int64_t y, z;    ///< as of snapped vertices
    std::int64_t next_y;  ///< from one row to the next
    double per_y, per_z;
    Vec3 spacing;
};

/// Turns of the samples of a row, with halves as numbers that vectors have.
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

using TurnsOfRows = std::array<TurnsOfLanes, lanes>;

/// Adds the turns of a loop: seen_vertex() and turned() of solid_angle.h in lanes, with the same bits.
void add_loop(std::span<const LatticeCorner> corners, const PlanePlace& place, TurnsOfRows& turns);

/// A piece of film far away.
struct FarPiece {
    const FilmExpansion* expansion;
    Vec3 centre;
};

/// The turns of pieces far away. first: the place of the first sample. spacing: from one to the next.
using FarTurns = std::array<std::array<double, lanes>, lanes>;
FarTurns turns_of_expansions(std::span<const FarPiece> pieces, const Vec3& first, const Vec3& spacing);

}  // namespace clsdf::engine
