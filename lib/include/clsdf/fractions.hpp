#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/export.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace clsdf {

/// A cell of a grid that the surface meets. The solid is what the mesh encloses.
struct CellFraction {
    std::array<std::int32_t, 3> cell{};  ///< indices on the lattice of the sample at its low corner
    /// Parts of the surface in the cell that are joined over edges. With more than one, a centroid and a normal say
    /// little.
    std::uint32_t pieces = 0;
    double volume = 0;   ///< of the solid, as a fraction of the cell
    Vec3 centroid{};     ///< of the solid in the cell, in cells from the middle of the cell: -0.5 to 0.5; 0 without
                         ///< solid
    double area = 0;     ///< of the surface in the cell, in squared units of the mesh
    Vec3 vector_area{};  ///< the integral of the surface's outward unit normal, in squared units
    Vec3 surface_centroid{};                 ///< as `centroid`
    std::array<double, 6> face_fractions{};  ///< of the solid in the low and high face across x, y and z
    /// Of the solid in these faces, along the two other axes in the order x, y, z, in cells from the face's middle.
    std::array<std::array<double, 2>, 6> face_centroids{};
};

/// The cells of a grid: those between neighbouring samples, one fewer than samples along each axis.
struct Fractions {
    Grid grid;
    std::vector<CellFraction> cells;  ///< that the surface meets, sorted by z, y, x
    /// Of the other cells those that are wholly solid: a bit a cell, x fastest, the lowest bit of a byte first. Those
    /// that the surface meets have 0.
    std::vector<std::uint8_t> full;

    std::array<std::size_t, 3> counts() const {
        return {static_cast<std::size_t>(grid.size[0] - 1), static_cast<std::size_t>(grid.size[1] - 1),
                static_cast<std::size_t>(grid.size[2] - 1)};
    }
    bool is_full(std::size_t i, std::size_t j, std::size_t k) const {
        const auto [x, y, z] = counts();
        const std::size_t cell = (k * y + j) * x + i;
        return (full[cell / 8] >> cell % 8 & 1U) != 0;
    }
};

/// The fractions of cells that a mesh fills: volumes, areas and centroids, by the mesh's triangles clipped at the
/// cells' faces. They are those of its outer() surface, so parts may overlap. Sums are the mesh's: the volumes add up
/// to the volume inside, the areas to its area, differences of opposite faces are the vector area, up to rounding.
///
/// A vertex on a face between cells counts as above it, so a piece of surface that lies in such a face belongs to the
/// cell above, and is counted once. Rounding may make a fraction differ from [0, 1] by some 1e-13.
///
/// A grid may be a part of a lattice: each cell has the same bytes as in the whole. Uses all cores; may be called by
/// many threads. Throws the errors of outer() and of the validation of the grid; Error(invalid_argument) unless it has
/// two samples or more on each axis. Of `call`, should_stop counts.
CLSDF_EXPORT Fractions fractions(const Mesh& mesh, const Grid& grid, SignRule sign = SignRule::automatic,
                                 const CallOptions& call = {});

}  // namespace clsdf
