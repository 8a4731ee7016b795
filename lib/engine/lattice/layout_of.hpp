#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/topology.hpp>

#include "lattice/lattice_view.hpp"
#include "layout.h"

#include <cstddef>

namespace clsdf::engine {

/// The bricks of a part of a lattice, and the band in units, as the kernels read them. Only `first`, `size` and the
/// ranges of bricks depend on the part. Throws Error(invalid_argument) if a number is out of the kernels' range.
Layout layout_of(const Grid& grid, const Band& band, SignRule sign);

/// Gives a layout the bricks of another part of its lattice: the layout that layout_of() has for that part. Throws
/// Error(invalid_argument) if the part is out of the kernels' range.
void set_part(const Grid& part, Layout& layout);
/// A layout with the positions of samples, bricks and coarse bricks only.
Layout bricks_of(const Grid& grid);

/// How polyhedra see the lattice.
LatticeView lattice_of(const Grid& grid);

/// Slack of a test = base_slack + slack_rate * bound (docs/method.md, 'Rounding and slack': 1e-3 + 2e-5 bound), in
/// units. Rounding also grows with the size of the group of blocks whose centre the offsets are formed at.
inline constexpr double base_slack = 1e-3;
inline constexpr double slack_rate = 2e-5;

/// Whether the spacing is so unequal that float offsets within a brick are too coarse for the accuracy.
bool has_long_bricks(const Grid& grid);

std::size_t brick_count(const Layout& layout);
std::size_t coarse_brick_count(const Layout& layout);
/// Device memory that the sign takes for each slice of a grid.
std::size_t sign_bytes_of_slice(const Grid& grid);
/// Rows of sign bits: every row of samples of the part's bricks.
std::size_t sign_row_count(const Layout& layout);
/// Bytes of all rows of sign bits.
std::size_t sign_bytes(const Layout& layout);

}  // namespace clsdf::engine
