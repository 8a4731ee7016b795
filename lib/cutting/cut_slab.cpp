#include "cutting/cut_slab.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clsdf::cutting {

/// A convex polygon: a triangle has at most nine corners after six cuts.
class Slab::Polygon {
public:
    Polygon() = default;
    explicit Polygon(const std::array<Vec3, 3>& corners) : count_(3) { std::ranges::copy(corners, corners_.begin()); }

    std::span<const Vec3> corners() const { return std::span(corners_).first(count_); }
    bool is_empty() const { return count_ < 3; }

    /// Its part from `low` up to a cell farther. In `room`, unless it is all of it.
    const Polygon& in_cell(std::size_t axis, double low, Polygon& room) const {
        bool is_below = false, is_above = false;
        for (const Vec3& p : corners()) {
            is_below = is_below || p[axis] < low;
            is_above = is_above || p[axis] >= low + 1;
        }
        if (is_below && is_above) {
            Polygon above;
            cut(axis, low, true, above);
            above.cut(axis, low + 1, false, room);
        } else if (is_below || is_above) {
            cut(axis, is_below ? low : low + 1, is_below, room);
        } else {
            return *this;
        }
        return room;
    }

private:
    /// Its part at or above a value, or below.
    void cut(std::size_t axis, double value, bool is_above, Polygon& part) const {
        const auto is_in = [&](const Vec3& p) { return (p[axis] >= value) == is_above; };
        part.count_ = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const Vec3 &p = corners_[i], &q = corners_[i + 1 < count_ ? i + 1 : 0];
            if (is_in(p)) part.corners_[part.count_++] = p;
            if (is_in(p) != is_in(q)) part.corners_[part.count_++] = point_at(p, q, axis, value);
        }
    }

    std::array<Vec3, 12> corners_;  // NOLINT(*-member-init): those beyond the count are never read
    std::size_t count_ = 0;
};

std::size_t moved_axis(const std::array<Vec3, 3>& corners, WallCell walls) {
    if (walls == WallCell::above) return 3;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double at = corners[0][axis];
        if (at != corners[1][axis] || at != corners[2][axis] || at != std::floor(at)) continue;
        const double normal = cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]))[axis];
        return (walls == WallCell::fluid ? normal < 0 : normal > 0) ? axis : 3;
    }
    return 3;
}

Slab::Slab(std::span<const Triangle> triangles, std::span<const Vec3> positions, const Grid& grid, WallCell walls)
    : triangles_(triangles),
      positions_(positions),
      grid_(grid),
      walls_(walls),
      counts_{grid.size[0] - 1, grid.size[1] - 1, 1} {}

void Slab::run(std::int64_t k, std::span<const std::uint32_t> faces, std::vector<CutCell>& rows,
               std::span<CellType> types) {
    first_ = {grid_.first[0], grid_.first[1], grid_.first[2] + k};
    x_.reset(first_, counts_, counts_[0] + 1);
    y_.reset(first_, counts_, counts_[1] + 1);
    z_.reset(first_, counts_, 2);
    cells_.reset(static_cast<std::size_t>(counts_[0] * counts_[1]));
    listed_.clear();
    for (const std::uint32_t face : faces) {
        std::array<Vec3, 3> corners;
        for (std::size_t i = 0; i < 3; ++i) corners[i] = positions_[triangles_[face][i]];
        // Lines within the cells begin far below, so a face counts that is below them along one axis alone.
        bool is_above = false;
        int axes_below = 0;
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const auto [least, most] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
            is_above = is_above || least > static_cast<double>(first_[axis] + counts_[axis]);
            axes_below += most < static_cast<double>(first_[axis]) ? 1 : 0;
        }
        if (is_above || axes_below == 2) continue;
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

void Slab::add_cells(const std::array<Vec3, 3>& corners, std::uint32_t face) {
    const std::size_t moved = moved_axis(corners, walls_);
    const auto part = [&](const Polygon& polygon, std::size_t axis, std::int64_t cell,
                          Polygon& room) -> const Polygon& {
        return axis == moved ? polygon : polygon.in_cell(axis, static_cast<double>(first_[axis] + cell), room);
    };
    const auto range = [&](const Polygon& polygon, std::size_t axis) {
        const auto [least, most] = std::ranges::minmax(polygon.corners(), {}, [&](const Vec3& p) { return p[axis]; });
        if (axis != moved) return CellRange(least[axis], most[axis], first_[axis], counts_[axis]);
        // The cell below the face, which may be the one below the first.
        const auto start = static_cast<double>(first_[axis]), end = start + static_cast<double>(counts_[axis]);
        if (least[axis] < start || least[axis] > end) return CellRange{0, -1};
        const std::int64_t below = static_cast<std::int64_t>(least[axis]) - first_[axis] - 1;
        return CellRange{below, below};
    };
    const Polygon whole(corners);
    std::array<Polygon, 3> rooms;
    const CellRange slabs = moved == 2 ? range(whole, 2) : CellRange{0, 0};
    for (std::int64_t k = slabs.low; k <= slabs.high; ++k) {
        const Polygon& in_slab = part(whole, 2, k, rooms[2]);
        if (in_slab.is_empty()) continue;
        const CellRange rows = range(in_slab, 1);
        for (std::int64_t j = rows.low; j <= rows.high; ++j) {
            const Polygon& in_row = part(in_slab, 1, j, rooms[1]);
            if (in_row.is_empty()) continue;
            const CellRange cells = range(in_row, 0);
            for (std::int64_t i = cells.low; i <= cells.high; ++i)
                if (const Polygon& in_cell = part(in_row, 0, i, rooms[0]); !in_cell.is_empty())
                    add(in_cell, {i, j, k}, face, moved);
        }
    }
}

void Slab::add(const Polygon& polygon, const std::array<std::int64_t, 3>& cell, std::uint32_t face, std::size_t moved) {
    const Vec3 low{static_cast<double>(first_[0] + cell[0]), static_cast<double>(first_[1] + cell[1]),
                   static_cast<double>(first_[2] + cell[2])};
    const std::span<const Vec3> corners = polygon.corners();
    const Vec3 a = difference(corners[0], low);
    CellSums* sums = nullptr;
    for (std::size_t n = 1; n + 1 < corners.size(); ++n) {
        const Vec3 b = difference(corners[n], low), c = difference(corners[n + 1], low);
        const Vec3 twice = cross(difference(b, a), difference(c, a));
        if (twice == Vec3{}) continue;  // an edge of the face in a plane between cells
        if (moved < 3) {
            Sections& section = moved == 0 ? x_ : moved == 1 ? y_ : z_;
            std::array<std::int64_t, 3> above = cell;
            ++above[moved];
            const double area = -twice[moved] / 2;
            const auto mean = [&](std::size_t axis) { return (a[axis] + b[axis] + c[axis]) / 3; };
            section.add(above, area, area * mean(section.side()), area * mean(section.along()));
            if (cell[moved] < 0) continue;
        }
        if (sums == nullptr) sums = &cells_.make(index(cell[0], cell[1]));
        Vec3 in_units;
        for (std::size_t d = 0; d < 3; ++d) {
            const double normal = twice[d] / 2;
            sums->normal[d].add(normal);
            sums->moment[d].add(normal * (a[d] + b[d] + c[d]) / 3);
            sums->second[d].add(
                normal * (a[d] * a[d] + b[d] * b[d] + c[d] * c[d] + a[d] * b[d] + b[d] * c[d] + c[d] * a[d]) / 12);
            in_units[d] = normal * grid_.spacing[(d + 1) % 3] * grid_.spacing[(d + 2) % 3];
        }
        const double area = length(in_units);
        sums->area.add(area);
        for (std::size_t d = 0; d < 3; ++d) sums->centre[d].add(area * (a[d] + b[d] + c[d]) / 3);
    }
    if (sums == nullptr) return;
    listed_.push_back({face, sums->last_face});
    sums->last_face = static_cast<std::uint32_t>(listed_.size() - 1);
    ++sums->faces;
}

CutCell Slab::row(std::int64_t i, std::int64_t j, const CellSums& sums) {
    CutCell row;
    row.cell = {static_cast<std::int32_t>(first_[0] + i), static_cast<std::int32_t>(first_[1] + j),
                static_cast<std::int32_t>(first_[2])};
    row.pieces = pieces(
        sums, {static_cast<double>(row.cell[0]), static_cast<double>(row.cell[1]), static_cast<double>(row.cell[2])});
    std::array<std::array<double, 3>, 6> sections;
    sections[0] = x_.at(i, 0, j);
    sections[1] = x_.at(i + 1, 0, j);
    sections[2] = y_.at(j, 0, i);
    sections[3] = y_.at(j + 1, 0, i);
    sections[4] = z_.at(0, i, j);
    sections[5] = z_.at(1, i, j);
    row.volume = sections[5][0] + sums.moment[2].value();
    row.area = sums.area.value();
    const std::array<const Sections*, 3> by_axis{&x_, &y_, &z_};
    for (std::size_t d = 0; d < 3; ++d) {
        row.vector_area[d] = sums.normal[d].value() * grid_.spacing[(d + 1) % 3] * grid_.spacing[(d + 2) % 3];
        row.moment[d] = sections[2 * d + 1][0] / 2 + sums.second[d].value() - row.volume / 2;
        row.surface_centroid[d] = row.area > 0 ? std::clamp(sums.centre[d].value() / row.area - 0.5, -0.5, 0.5) : 0;
        const bool is_side_first = by_axis[d]->side() < by_axis[d]->along();
        for (std::size_t face = 2 * d; face < 2 * d + 2; ++face) {
            const auto& [area, first, second] = sections[face];
            row.face_fractions[face] = area;
            row.face_moments[face] = is_side_first ? std::array{first - area / 2, second - area / 2}
                                                   : std::array{second - area / 2, first - area / 2};
        }
    }
    return row;
}

/// Faces are joined over an edge that has a part in the cell.
std::uint32_t Slab::pieces(const CellSums& sums, const Vec3& low) {
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
        if (one.ends != other.ends || sets_.root(other.face) == sets_.root(one.face) || !meets(other, low)) continue;
        --count;
        sets_.join(other.face, one.face);
    }
    return count;
}

/// Whether an edge has a part in the cell.
bool Slab::meets(const Edge& edge, const Vec3& low) const {
    const Vec3 &p = positions_[edge.low()], &q = positions_[edge.high()];
    double from = 0, to = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double step = q[axis] - p[axis];
        if (step == 0) {
            if (p[axis] < low[axis] || p[axis] > low[axis] + 1) return false;
            continue;
        }
        const auto [first, last] = std::minmax({(low[axis] - p[axis]) / step, (low[axis] + 1 - p[axis]) / step});
        from = std::max(from, first);
        to = std::min(to, last);
    }
    return from <= to;
}

}  // namespace clsdf::cutting
