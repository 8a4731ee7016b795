#include "cutting/cut_slab.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clsdf::cutting {

CutGrid cut_grid_of(const Grid& grid, const FractionOptions& options) {
    static_assert(static_cast<int>(WallCell::above) == CLSDF_WALLS_ABOVE &&
                  static_cast<int>(WallCell::solid) == CLSDF_WALLS_SOLID &&
                  static_cast<int>(WallCell::fluid) == CLSDF_WALLS_FLUID);
    CutGrid cut{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        cut.origin[axis] = grid.origin[axis];
        cut.spacing[axis] = grid.spacing[axis];
        cut.first[axis] = grid.first[axis];
        cut.counts[axis] = static_cast<clsdf_int32>(grid.size[axis] - 1);
    }
    cut.snap = options.snap;
    cut.walls = static_cast<clsdf_int32>(options.walls);
    cut.is_fluid = options.part == CellPart::fluid ? 1 : 0;
    cut.into_solid = options.normals_into_solid ? 1 : 0;
    cut.areas_of_faces = options.areas_of_faces ? 1 : 0;
    cut.as_points = options.centroids_as_points ? 1 : 0;
    return cut;
}

Slab::Slab(std::span<const Triangle> triangles, std::span<const CutPoint> positions, const CutGrid& grid)
    : triangles_(triangles), positions_(positions), grid_(grid), counts_{grid.counts[0], grid.counts[1], 1} {}

void Slab::run(std::int64_t k, std::span<const std::uint32_t> faces, std::vector<CellFraction>& rows,
               std::span<CellType> types) {
    first_ = {grid_.first[0], grid_.first[1], grid_.first[2] + k};
    x_.reset(first_, counts_, counts_[0] + 1);
    y_.reset(first_, counts_, counts_[1] + 1);
    z_.reset(first_, counts_, 2);
    cells_.reset(static_cast<std::size_t>(counts_[0] * counts_[1]));
    listed_.clear();
    for (const std::uint32_t face : faces) {
        std::array<CutPoint, 3> corners;
        for (std::size_t i = 0; i < 3; ++i) corners[i] = positions_[triangles_[face][i]];
        // Lines within the cells begin far below, so a face counts that is below them along one axis alone.
        bool is_beyond = false;
        int axes_below = 0;
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const auto [least, most] = cells_of_corners(corners, axis);
            is_beyond = is_beyond || least > static_cast<double>(first_[axis] + counts_[axis]);
            axes_below += most < static_cast<double>(first_[axis]) ? 1 : 0;
        }
        if (is_beyond || axes_below == 2) continue;
        x_.add(corners);
        y_.add(corners);
        z_.add(corners);
        if (axes_below == 0) add_cells(corners, face);
    }
    x_.finish();
    y_.finish();
    z_.finish();
    places_.assign(cells_.places().begin(), cells_.places().end());
    std::ranges::sort(places_);
    const auto width = static_cast<std::size_t>(counts_[0]);
    for (const std::size_t place : places_)
        rows.push_back(row(static_cast<std::int64_t>(place % width), static_cast<std::int64_t>(place / width),
                           *cells_.find(place)));
    // Without surface in a cell its high face is as that face's edge, which runs along y.
    std::ranges::fill(types, CellType::empty);
    for (std::int64_t i = 0; i < counts_[0]; ++i)
        for (std::int64_t j = 0; z_.may_be_solid(1, i) && j < counts_[1]; ++j)
            if (z_.is_edge_solid(1, i, j)) types[index(i, j)] = CellType::full;
    for (const std::size_t place : places_) types[place] = CellType::cut;
}

void Slab::add_cells(const std::array<CutPoint, 3>& corners, std::uint32_t face) {
    const int moved = moved_axis(corners.data(), grid_.walls);
    const auto part = [&](const CutPolygon& polygon, int axis, std::int64_t cell,
                          CutPolygon& room) -> const CutPolygon& {
        if (axis == moved) return polygon;
        return *part_in_cell(&polygon, axis, static_cast<double>(first_[static_cast<std::size_t>(axis)] + cell), &room);
    };
    const auto range = [&](const CutPolygon& polygon, int axis) {
        return cells_of_polygon(&polygon, axis, axis == moved, first_[static_cast<std::size_t>(axis)],
                                counts_[static_cast<std::size_t>(axis)]);
    };
    CutPolygon whole;  // NOLINT(*-member-init): corners beyond the count are never read, as of those that follow
    std::ranges::copy(corners, whole.corners);
    whole.count = 3;
    std::array<CutPolygon, 3> rooms;  // NOLINT(*-member-init)
    const CellRange slabs = moved == 2 ? range(whole, 2) : CellRange{0, 0};
    for (std::int64_t k = slabs.low; k <= slabs.high; ++k) {
        const CutPolygon& in_slab = part(whole, 2, k, rooms[2]);
        if (in_slab.count < 3) continue;
        const CellRange rows = range(in_slab, 1);
        for (std::int64_t j = rows.low; j <= rows.high; ++j) {
            const CutPolygon& in_row = part(in_slab, 1, j, rooms[1]);
            if (in_row.count < 3) continue;
            const CellRange cells = range(in_row, 0);
            for (std::int64_t i = cells.low; i <= cells.high; ++i)
                if (const CutPolygon& in_cell = part(in_row, 0, i, rooms[0]); in_cell.count >= 3)
                    add(in_cell, {i, j, k}, face, moved);
        }
    }
}

void Slab::add(const CutPolygon& polygon, const std::array<std::int64_t, 3>& cell, std::uint32_t face, int moved) {
    const CutVector low{{static_cast<double>(first_[0] + cell[0]), static_cast<double>(first_[1] + cell[1]),
                         static_cast<double>(first_[2] + cell[2])}};
    ListedSums* sums = nullptr;
    for (int n = 0; n < piece_count(&polygon); ++n) {
        CutPiece piece;  // NOLINT(*-member-init)
        if (!make_piece(&polygon, n, low, &piece)) continue;
        if (moved < CLSDF_NOT_MOVED) {
            std::array<std::int64_t, 3> above = cell;
            ++above[static_cast<std::size_t>(moved)];
            (moved == 0 ? x_ : moved == 1 ? y_ : z_).add(above, piece);
            if (cell[static_cast<std::size_t>(moved)] < 0) continue;
        }
        if (sums == nullptr) sums = &cells_.make(index(cell[0], cell[1]));
        add_piece(sums, &piece, grid_.spacing);
    }
    if (sums == nullptr) return;
    listed_.push_back({face, sums->last_face});
    sums->last_face = static_cast<std::uint32_t>(listed_.size() - 1);
    ++sums->faces;
}

CellFraction Slab::row(std::int64_t i, std::int64_t j, const ListedSums& sums) {
    const std::array<FaceValues, 6> sections{x_.at(i, 0, j),     x_.at(i + 1, 0, j), y_.at(j, 0, i),
                                             y_.at(j + 1, 0, i), z_.at(0, i, j),     z_.at(1, i, j)};
    FractionRow row;  // NOLINT(*-member-init)
    make_solid_row(&sums, sections.data(), grid_.spacing, &row);
    row.cell[0] = static_cast<std::int32_t>(first_[0] + i);
    row.cell[1] = static_cast<std::int32_t>(first_[1] + j);
    row.cell[2] = static_cast<std::int32_t>(first_[2]);
    row.pieces = pieces(
        sums, {{static_cast<double>(row.cell[0]), static_cast<double>(row.cell[1]), static_cast<double>(row.cell[2])}});
    tell_row(&row, &grid_);
    return as_fraction(row);
}

/// Faces are joined over an edge that has a part in the cell.
std::uint32_t Slab::pieces(const ListedSums& sums, const CutVector& low) {
    std::uint32_t count = sums.faces;
    if (count == 1) return 1;
    sets_.reset(count);
    edges_.clear();
    for (std::uint32_t n = 0, at = sums.last_face; n < sums.faces; ++n, at = listed_[at].before) {
        const Triangle& corners = triangles_[listed_[at].face];
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [a, b] = std::minmax(corners[i], corners[(i + 1) % 3]);
            edges_.push_back({std::uint64_t{a} << 32 | b, n});
        }
    }
    std::ranges::sort(edges_, {}, &Edge::ends);
    for (std::size_t n = 1; n < edges_.size() && count > 1; ++n) {
        const Edge &one = edges_[n - 1], &other = edges_[n];
        if (one.ends != other.ends || sets_.root(other.face) == sets_.root(one.face)) continue;
        if (!edge_meets_cell(positions_[other.low()], positions_[other.high()], low)) continue;
        --count;
        sets_.join(other.face, one.face);
    }
    return count;
}

}  // namespace clsdf::cutting
