#pragma once

#include <clsdf/fractions.hpp>

#include "cutting/sections.hpp"
#include "mesh/disjoint_sets.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::cutting {

/// Integrals over the surface in a cell, in cells from its low corner.
struct CellSums {
    std::array<Sum, 3> normal, moment, second;  ///< of n_d, x_d n_d and x_d^2 n_d / 2 dA
    Sum area;                                   ///< in the mesh's units, as those that follow
    std::array<Sum, 3> centre;                  ///< of the coordinates
    std::uint32_t faces = 0;                    ///< with a part in the cell
    std::uint32_t last_face = 0;                ///< of these, in the slab's list
};

/// A row before it is told in the way that is asked for: of the solid, with integrals in place of centroids.
struct CutCell {
    std::array<std::int32_t, 3> cell{};
    std::uint32_t pieces = 0;
    double volume = 0, area = 0;
    Vec3 moment{};  ///< of the solid, from the cell's middle
    Vec3 vector_area{}, surface_centroid{};
    std::array<double, 6> face_fractions{};
    std::array<std::array<double, 2>, 6> face_moments{};
};

/// The cells between two neighbouring planes across z: one slab after the other.
class Slab {
public:
    /// positions: in cells of the lattice; walls: of the surface in the faces between cells.
    Slab(std::span<const Triangle> triangles, std::span<const Vec3> positions, const Grid& grid, WallCell walls);

    /// k: the slab, counted from the grid's first; faces: those that have a part in it or, if they move, in its high
    /// plane, ascending. Adds the cells that the surface meets, by y and x, and tells of each cell of the slab, x
    /// fastest, whether it is cut or what it is of the solid.
    void run(std::int64_t k, std::span<const std::uint32_t> faces, std::vector<CutCell>& rows,
             std::span<CellType> types);

private:
    class Polygon;
    struct Edge {
        std::uint64_t ends;  ///< its vertices, the lower first
        std::uint32_t face;  ///< place among a cell's faces

        std::uint32_t low() const { return static_cast<std::uint32_t>(ends >> 32); }
        std::uint32_t high() const { return static_cast<std::uint32_t>(ends); }
    };
    struct ListedFace {
        std::uint32_t face, before;  ///< before: place in the list of the cell's face before this one
    };

    std::size_t index(std::int64_t i, std::int64_t j) const { return static_cast<std::size_t>(j * counts_[0] + i); }
    void add_cells(const std::array<Vec3, 3>& corners, std::uint32_t face);
    void add(const Polygon& part, const std::array<std::int64_t, 3>& cell, std::uint32_t face, std::size_t moved);
    CutCell row(std::int64_t i, std::int64_t j, const CellSums& sums);
    std::uint32_t pieces(const CellSums& sums, const Vec3& low);
    bool meets(const Edge& edge, const Vec3& low) const;

    std::span<const Triangle> triangles_;
    std::span<const Vec3> positions_;
    const Grid& grid_;
    WallCell walls_;
    std::array<std::int64_t, 3> counts_, first_{};
    Sections x_{0, 2, 1}, y_{1, 2, 0}, z_{2, 0, 1};
    FewItems<CellSums> cells_;
    std::vector<ListedFace> listed_;   // of all cells
    std::vector<std::size_t> places_;  // of the cells that are cut
    std::vector<Edge> edges_;          // of pieces(), as the next
    DisjointSets sets_{0};
};

/// The axis across which a triangle lies in a plane between cells, if its surface goes to the cell below; else 3.
std::size_t moved_axis(const std::array<Vec3, 3>& corners, WallCell walls);

}  // namespace clsdf::cutting
