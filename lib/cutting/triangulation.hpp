#pragma once

#include <clsdf/mesh.hpp>

#include "cutting/meetings.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace clsdf::cutting {

/// A triangulation of points in a face that has given segments as edges. Points are added before segments; segments
/// cross no other and have no point within. Choices by rounded numbers decide about the shape of triangles only.
class FaceTriangulation {
public:
    FaceTriangulation(const CutPoints& points, const Triangle& corners, const View& view);

    /// Does nothing for a point that is there.
    void add_point(std::uint32_t point);
    void add_segment(std::uint32_t from, std::uint32_t to);

    /// Oriented as the face is.
    std::vector<Triangle> triangles() const;

private:
    static constexpr std::uint32_t none = 0xFFFFFFFFU;

    struct Cell {
        Triangle corners;
        Triangle beyond;  ///< cells, each across from a corner; none on the face's edges
    };
    /// A cell's edge that is across from a corner.
    struct Side {
        std::uint32_t cell;
        unsigned corner;
    };

    [[noreturn]] void refuse() const;
    int orientation(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    /// The cell of a point, and on which edges of it the point lies, as bits.
    std::pair<std::uint32_t, unsigned> locate(std::uint32_t point);
    void split_cell(std::uint32_t cell, std::uint32_t point);
    void split_edge(const Side& side, std::uint32_t point);
    /// Sets a cell, and what its neighbours and corners know of it.
    void set(std::uint32_t cell, const Triangle& corners, const Triangle& beyond);
    unsigned corner_index(std::uint32_t cell, std::uint32_t corner) const;
    /// Whether the two cells at an edge form a convex quadrangle without a straight angle.
    bool is_convex(const Side& side);
    /// Gives the two cells at an edge (a, b) the other diagonal: the first becomes (a, bottom, top), the other one
    /// (b, top, bottom).
    void flip(const Side& side);
    void improve(std::uint32_t point);
    bool is_better_flipped(const Side& side) const;
    /// Calls f(cell, index of the point in it) for the cells at a point until f returns true.
    template <typename Function>
    bool any_cell_at(std::uint32_t point, const Function& f) const;
    /// The side of the edge from one point to another, if there is one.
    Side side_of(std::uint32_t from, std::uint32_t to) const;

    const CutPoints& points_;
    View view_;
    std::vector<Cell> cells_;
    std::unordered_map<std::uint32_t, std::uint32_t> cell_of_;  // one of the cells at each point
    std::uint32_t last_ = 0;
    CutPoints::Cache cache_;
};

}  // namespace clsdf::cutting
