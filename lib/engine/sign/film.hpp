#pragma once

#include <clsdf/mesh.hpp>

#include "layout.h"
#include "sweep.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace clsdf::engine {

/// A corner of an open edge as the sweep for the sign sees it. The predicate of crossings takes the snapped vertex,
/// lengths take the vertex as given.
struct LatticeCorner {
    SweepVertex snapped;    ///< x counted from sample LatticeBoundary::first_x
    double rest_y, rest_z;  ///< given minus snapped, in samples
};

/// The open edges of a surface on a lattice, as loops.
struct LatticeBoundary {
    std::vector<LatticeCorner> corners;  ///< loop after loop
    std::vector<std::size_t> begins;     ///< where each loop begins, and the end of the last
    int bits_y = 0, bits_z = 0;          ///< of a snapped vertex, below a sample
    std::int32_t first_x = 0;
    Vec3 spacing{1, 1, 1};                ///< in any unit
    std::optional<std::int64_t> floor{};  ///< snapped z, as of OpenBoundary::floor
};

/// What the open edges add to the crossings of a part's rows: see film_crossings() and wall_crossings().
struct FilmCrossings {
    std::vector<SweepRecord> records;
    std::vector<std::uint32_t> row_counts;  ///< of the records, for each row; empty if there are none
};

/// The film is the surface that closes the holes: where the winding number is one half. On a row the part of the open
/// edges in the winding number, rounded (rounded_turns() of kernels/common/solid_angle.h), changes only there. The
/// changes are records as those of crossings (kernels/sign/sign_sweep.cl), so that their running sum with the crossings
/// is the rounded winding number at every sample. They do not depend on the part. `between` may throw.
FilmCrossings film_crossings(const LatticeBoundary& boundary, const Layout& layout,
                             const std::function<void()>& between);

/// The same of walls, if the boundary has a floor: rows cross them exactly as they cross the snapped triangles at
/// whose edges they hang.
FilmCrossings wall_crossings(const LatticeBoundary& boundary, const Layout& layout,
                             const std::function<void()>& between);

}  // namespace clsdf::engine
