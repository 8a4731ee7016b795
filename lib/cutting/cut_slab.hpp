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

/// The cells of a grid, and what is told of them.
CutGrid cut_grid_of(const Grid& grid, const FractionOptions& options);

/// The cells between two neighbouring planes across z: one slab after the other.
class Slab {
public:
    /// positions: in cells of the lattice.
    Slab(std::span<const Triangle> triangles, std::span<const CutPoint> positions, const CutGrid& grid);

    /// k: the slab, counted from the grid's first; faces: those that have a part in it or, if they move, in its high
    /// plane, ascending. Adds the cells that the surface meets, by y and x, and tells of each cell of the slab, x
    /// fastest, whether it is cut or what it is of the solid.
    void run(std::int64_t k, std::span<const std::uint32_t> faces, std::vector<CellFraction>& rows,
             std::span<CellType> types);

private:
    struct ListedSums : CellSums {
        std::uint32_t faces = 0;      ///< with a part in the cell
        std::uint32_t last_face = 0;  ///< of these, in the slab's list
    };
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
    void add_cells(const std::array<CutPoint, 3>& corners, std::uint32_t face);
    void add(const CutPolygon& part, const std::array<std::int64_t, 3>& cell, std::uint32_t face, int moved);
    CellFraction row(std::int64_t i, std::int64_t j, const ListedSums& sums);
    std::uint32_t pieces(const ListedSums& sums, const CutVector& low);

    std::span<const Triangle> triangles_;
    std::span<const CutPoint> positions_;
    CutGrid grid_;
    std::array<std::int64_t, 3> counts_, first_{};
    Sections x_{0}, y_{1}, z_{2};
    FewItems<ListedSums> cells_;
    std::vector<ListedFace> listed_;   // of all cells
    std::vector<std::size_t> places_;  // of the cells that are cut
    std::vector<Edge> edges_;          // of pieces(), as the next
    DisjointSets sets_{0};
};

}  // namespace clsdf::cutting
