#pragma once

#include <clsdf/grid.hpp>

#include "layout.h"

#include <optional>

namespace clsdf::transform {

/// Triangles beyond it decide no sample of the grid's bricks. Nothing if all triangles may.
std::optional<Box> box_near_bricks(const Grid& grid, const Layout& layout);

/// What the rows of the grid's bricks can cross on the way to the samples.
Box box_near_rows(const Grid& grid, const Layout& layout);

/// A selection is worth its while if it leaves most of the mesh out.
inline bool is_small(double share) {
    return share < 0.5;
}

/// Which part of the mesh's box lies in another box.
double share_of(const Box& mesh, const Box& box);

}  // namespace clsdf::transform
