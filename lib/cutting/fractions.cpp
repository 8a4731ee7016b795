#include <clsdf/error.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/outer.hpp>

#include "core/parallel.hpp"
#include "core/vectors.hpp"
#include "cutting/cancellation.hpp"
#include "mesh/disjoint_sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

using cutting::Cancellation;

/// A sum that rounds once (A. Neumaier, 1974).
class Sum {
public:
    void add(double value) {
        const double sum = sum_ + value;
        rest_ += std::abs(sum_) >= std::abs(value) ? (sum_ - sum) + value : (value - sum) + sum_;
        sum_ = sum;
    }
    double value() const { return sum_ + rest_; }

private:
    double sum_ = 0, rest_ = 0;
};

/// The point of an edge at which a coordinate has a value, with the same bits from both sides.
Vec3 point_at(Vec3 p, Vec3 q, std::size_t axis, double value) {
    if (q < p) std::swap(p, q);
    const double share = (value - p[axis]) / (q[axis] - p[axis]);
    Vec3 point;
    for (std::size_t k = 0; k < 3; ++k) point[k] = p[k] + share * (q[k] - p[k]);
    point[axis] = value;
    return point;
}

/// A convex polygon: a triangle has at most nine corners after six cuts.
class Polygon {
public:
    Polygon() = default;
    explicit Polygon(const std::array<Vec3, 3>& corners) : count_(3) { std::ranges::copy(corners, corners_.begin()); }

    std::span<const Vec3> corners() const { return std::span(corners_).first(count_); }
    bool is_empty() const { return count_ < 3; }

    /// Its part at or above a value, or below.
    Polygon cut(std::size_t axis, double value, bool is_above) const {
        Polygon part;
        const auto is_in = [&](const Vec3& p) { return (p[axis] >= value) == is_above; };
        for (std::size_t i = 0; i < count_; ++i) {
            const Vec3 &p = corners_[i], &q = corners_[i + 1 < count_ ? i + 1 : 0];
            if (is_in(p)) part.corners_[part.count_++] = p;
            if (is_in(p) != is_in(q)) part.corners_[part.count_++] = point_at(p, q, axis, value);
        }
        return part;
    }

private:
    std::array<Vec3, 12> corners_{};
    std::size_t count_ = 0;
};

/// The lowest and the highest of `count` cells from `first` on in which a range of coordinates lies, counted from the
/// first; none if low > high.
struct CellRange {
    std::int64_t low, high;

    CellRange(double least, double most, std::int64_t first, std::int64_t count) {
        const auto start = static_cast<double>(first), end = static_cast<double>(first + count);
        low = least < start ? 0 : static_cast<std::int64_t>(std::min(std::floor(least), end)) - first;
        high = most < start ? -1 : static_cast<std::int64_t>(std::min(std::floor(most), end - 1)) - first;
    }
};

/// Items of a long row, most of which are missing.
template <typename Item>
class FewItems {
public:
    void reset(std::size_t count) {
        if (numbers_.size() != count) numbers_.assign(count, 0);
        for (const std::size_t place : places_) numbers_[place] = 0;
        places_.clear();
        items_.clear();
    }
    Item& make(std::size_t place) {
        if (numbers_[place] == 0) {
            places_.push_back(place);
            items_.emplace_back();
            numbers_[place] = static_cast<std::uint32_t>(items_.size());
        }
        return items_[numbers_[place] - 1];
    }
    /// Null if it is missing.
    const Item* find(std::size_t place) const { return numbers_[place] == 0 ? nullptr : &items_[numbers_[place] - 1]; }

private:
    std::vector<std::uint32_t> numbers_;  // from 1
    std::vector<std::size_t> places_;
    std::vector<Item> items_;
};

/// Integrals over a solid's section with a face of a cell.
struct FaceSums {
    Sum area, first, second;  ///< of 1 and of the two coordinates in the face, from the cell's low corner
};

/// Integrals over the surface in a cell, in cells from its low corner.
struct CellSums {
    std::array<Sum, 3> normal, moment, second;  ///< of n_d, x_d n_d and x_d^2 n_d / 2 dA
    Sum area;                                   ///< in the mesh's units, as those that follow
    std::array<Sum, 3> centre;                  ///< of the coordinates
    std::vector<std::uint32_t> faces{};         ///< with a part in the cell
};

/// Lines along an axis: how often they are within the solid at the end of each cell, and integrals over the solid in
/// each.
class Lines {
public:
    void reset(std::size_t lines, std::int64_t first, std::size_t cells) {
        first_ = first;
        cells_ = cells;
        steps_.assign(lines * cells, 0);
        parts_.reset(lines * cells);
    }
    /// A line enters the solid (1) or leaves it (-1).
    void add(std::size_t line, double at, int way) {
        const CellRange cell(at, at, first_, static_cast<std::int64_t>(cells_));
        if (cell.low == static_cast<std::int64_t>(cells_)) return;
        const std::size_t place = line * cells_ + static_cast<std::size_t>(cell.low);
        steps_[place] += way;
        if (cell.high < 0) return;  // before the first cell: whole cells alone
        const double from = at - static_cast<double>(first_ + cell.low);
        Part& part = parts_.make(place);
        part.length.add(-way * from);
        part.moment.add(-way * from * from / 2);
    }
    /// Sums up what enters and leaves.
    void finish() {
        for (std::size_t first = 0; first < steps_.size(); first += cells_) {
            int inside = 0;
            for (std::size_t i = 0; i < cells_; ++i) inside = steps_[first + i] += inside;
        }
    }
    double length(std::size_t line, std::size_t cell) const {
        const Part* const part = parts_.find(line * cells_ + cell);
        return steps_[line * cells_ + cell] + (part == nullptr ? 0 : part->length.value());
    }
    double moment(std::size_t line, std::size_t cell) const {
        const Part* const part = parts_.find(line * cells_ + cell);
        return 0.5 * steps_[line * cells_ + cell] + (part == nullptr ? 0 : part->moment.value());
    }

private:
    struct Part {
        Sum length, moment;
    };

    std::int64_t first_ = 0;
    std::size_t cells_ = 0;
    std::vector<int> steps_;
    FewItems<Part> parts_;
};

/// Sections of the solid with planes across one axis, in the cells of a slab. In a plane, `side` and `along` are the
/// other axes: lines run along the latter. By Green's theorem the integral over a section is one along its boundary:
/// pieces of triangles cut by the plane, and the edge of the cell on the high side.
class Sections {
public:
    Sections(std::size_t across, std::size_t side, std::size_t along)
        : across_(across), side_(side), along_(along), orientation_((across + 1) % 3 == side ? 1 : -1) {}

    /// first: the first cell, on the lattice; counts: of cells on the three axes; planes: of planes.
    void reset(const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& counts,
               std::int64_t planes) {
        first_ = first;
        counts_ = counts;
        planes_ = planes;
        sums_.reset(static_cast<std::size_t>(planes * counts[side_] * counts[along_]));
        lines_.reset(static_cast<std::size_t>(planes * counts[side_]), first[along_],
                     static_cast<std::size_t>(counts[along_]));
    }

    /// corners: in cells of the lattice.
    void add(const std::array<Vec3, 3>& corners) {
        const auto [least, most] = std::minmax({corners[0][across_], corners[1][across_], corners[2][across_]});
        const auto low = static_cast<double>(first_[across_]), high = low + static_cast<double>(planes_ - 1);
        const double from = std::max(low, std::ceil(least)), to = std::min(high, std::floor(most));
        for (double plane = from; plane <= to; ++plane) add(corners, plane);
    }
    void finish() { lines_.finish(); }

    /// The integrals over the section in a cell's low face.
    std::array<double, 3> at(std::int64_t plane, std::int64_t side, std::int64_t along) const {
        const FaceSums* const sums = sums_.find(cell(plane, side, along));
        const std::size_t high = line(plane, side);
        const auto k = static_cast<std::size_t>(along);
        const double length = lines_.length(high, k);
        std::array<double, 3> found{length, length / 2, lines_.moment(high, k)};  // the side's coordinate is 1 there
        if (sums != nullptr) {
            found[0] += sums->area.value();
            found[1] += sums->first.value();
            found[2] += sums->second.value();
        }
        return found;
    }
    std::size_t side() const { return side_; }
    std::size_t along() const { return along_; }

private:
    std::size_t cell(std::int64_t plane, std::int64_t side, std::int64_t along) const {
        return static_cast<std::size_t>((plane * counts_[side_] + side) * counts_[along_] + along);
    }
    /// That on the high side of a cell.
    std::size_t line(std::int64_t plane, std::int64_t side) const {
        return static_cast<std::size_t>(plane * counts_[side_] + side);
    }

    void add(const std::array<Vec3, 3>& corners, double plane) {
        std::array<bool, 3> are_above{};
        for (std::size_t i = 0; i < 3; ++i) are_above[i] = corners[i][across_] >= plane;
        if (are_above[0] == are_above[1] && are_above[1] == are_above[2]) return;
        // Seen from above, the solid is on the left of the way from one to the other.
        Vec3 down{}, up{};
        for (std::size_t i = 0; i < 3; ++i)
            if (const std::size_t next = (i + 1) % 3; are_above[i] != are_above[next])
                (are_above[i] ? down : up) = point_at(corners[i], corners[next], across_, plane);
        if (orientation_ < 0) std::swap(down, up);
        const auto number = static_cast<std::int64_t>(plane) - first_[across_];
        add_lines(number, down, up);
        const auto range = [&](const Vec3& p, const Vec3& q, std::size_t axis) {
            return CellRange(std::min(p[axis], q[axis]), std::max(p[axis], q[axis]), first_[axis], counts_[axis]);
        };
        const CellRange sides = range(down, up, side_);
        for (std::int64_t i = sides.low; i <= sides.high; ++i) {
            Vec3 p = down, q = up;
            const auto low_side = static_cast<double>(first_[side_] + i);
            if (!cut(p, q, side_, low_side)) continue;
            const CellRange cells = range(p, q, along_);
            for (std::int64_t k = cells.low; k <= cells.high; ++k) {
                Vec3 from = p, to = q;
                const auto low = static_cast<double>(first_[along_] + k);
                if (!cut(from, to, along_, low)) continue;
                const double b0 = from[side_] - low_side, b1 = to[side_] - low_side;
                const double c0 = from[along_] - low, c1 = to[along_] - low;
                const double step = to[along_] - from[along_];
                FaceSums& sums = sums_.make(cell(number, i, k));
                sums.area.add((b0 + b1) / 2 * step);
                sums.first.add((b0 * b0 + b0 * b1 + b1 * b1) / 6 * step);
                sums.second.add((2 * (b0 * c0 + b1 * c1) + b0 * c1 + b1 * c0) / 6 * step);
            }
        }
    }
    void add_lines(std::int64_t plane, const Vec3& down, const Vec3& up) {
        const auto [least, most] = std::minmax(down[side_], up[side_]);
        const auto low = static_cast<double>(first_[side_]), high = low + static_cast<double>(counts_[side_]);
        const double from = std::max(low + 1, std::ceil(least)), to = std::min(high, std::floor(most));
        for (double at = from; at <= to; ++at) {
            const bool is_up = up[side_] >= at;
            if ((down[side_] >= at) == is_up) continue;
            const std::int64_t side = static_cast<std::int64_t>(at) - first_[side_] - 1;
            lines_.add(line(plane, side), point_at(down, up, side_, at)[along_], is_up ? 1 : -1);
        }
    }
    /// Shortens a segment to a cell; its ends keep their order.
    static bool cut(Vec3& p, Vec3& q, std::size_t axis, double cell) {
        const Vec3 from = p, to = q;
        if ((from[axis] < cell && to[axis] < cell) || (from[axis] >= cell + 1 && to[axis] >= cell + 1)) return false;
        const auto is_in = [&](const Vec3& point) { return point[axis] >= cell && point[axis] < cell + 1; };
        if (!is_in(from)) p = point_at(from, to, axis, from[axis] < cell ? cell : cell + 1);
        if (!is_in(to)) q = point_at(from, to, axis, to[axis] < cell ? cell : cell + 1);
        return true;
    }

    std::size_t across_, side_, along_;
    int orientation_;
    std::array<std::int64_t, 3> first_{}, counts_{};
    std::int64_t planes_ = 0;
    FewItems<FaceSums> sums_;
    Lines lines_;
};

/// The cells between two neighbouring planes across z: one slab after the other.
class Slab {
public:
    /// positions: in cells of the lattice.
    Slab(const Mesh& mesh, std::span<const Vec3> positions, const Grid& grid)
        : mesh_(mesh), positions_(positions), grid_(grid), counts_{grid.size[0] - 1, grid.size[1] - 1, 1} {}

    /// k: the slab, counted from the grid's first; faces: those that have a part in it, ascending. Adds the cells that
    /// the surface meets, and finds those that are full.
    void run(std::int64_t k, std::span<const std::uint32_t> faces, std::vector<CellFraction>& rows,
             std::vector<bool>& are_full) {
        first_ = {grid_.first[0], grid_.first[1], grid_.first[2] + k};
        x_.reset(first_, counts_, counts_[0] + 1);
        y_.reset(first_, counts_, counts_[1] + 1);
        z_.reset(first_, counts_, 2);
        cells_.reset(static_cast<std::size_t>(counts_[0] * counts_[1]));
        for (const std::uint32_t face : faces) {
            std::array<Vec3, 3> corners;
            for (std::size_t i = 0; i < 3; ++i) corners[i] = positions_[mesh_.triangles()[face][i]];
            x_.add(corners);
            y_.add(corners);
            z_.add(corners);
            add_cells(corners, face);
        }
        x_.finish();
        y_.finish();
        z_.finish();
        for (std::int64_t j = 0; j < counts_[1]; ++j)
            for (std::int64_t i = 0; i < counts_[0]; ++i) {
                const std::size_t cell = index(i, j);
                if (const CellSums* const sums = cells_.find(cell))
                    rows.push_back(row(i, j, *sums));
                else
                    are_full[cell] = z_.at(1, i, j)[0] > 0.5;
            }
    }

private:
    std::size_t index(std::int64_t i, std::int64_t j) const { return static_cast<std::size_t>(j * counts_[0] + i); }

    void add_cells(const std::array<Vec3, 3>& corners, std::uint32_t face) {
        const auto part = [&](const Polygon& polygon, std::size_t axis, std::int64_t cell) {
            const auto low = static_cast<double>(first_[axis] + cell);
            return polygon.cut(axis, low, true).cut(axis, low + 1, false);
        };
        const auto range = [&](const Polygon& polygon, std::size_t axis) {
            const auto [least, most] =
                std::ranges::minmax(polygon.corners(), {}, [&](const Vec3& p) { return p[axis]; });
            return CellRange(least[axis], most[axis], first_[axis], counts_[axis]);
        };
        const Polygon slab = part(Polygon(corners), 2, 0);
        if (slab.is_empty()) return;
        const CellRange in_slab = range(slab, 1);
        for (std::int64_t j = in_slab.low; j <= in_slab.high; ++j) {
            const Polygon in_row = part(slab, 1, j);
            if (in_row.is_empty()) continue;
            const CellRange cells = range(in_row, 0);
            for (std::int64_t i = cells.low; i <= cells.high; ++i)
                if (const Polygon in_cell = part(in_row, 0, i); !in_cell.is_empty()) add(in_cell, i, j, face);
        }
    }

    void add(const Polygon& part, std::int64_t i, std::int64_t j, std::uint32_t face) {
        CellSums& sums = cells_.make(index(i, j));
        const Vec3 low{static_cast<double>(first_[0] + i), static_cast<double>(first_[1] + j),
                       static_cast<double>(first_[2])};
        const std::span<const Vec3> corners = part.corners();
        const Vec3 a = difference(corners[0], low);
        for (std::size_t n = 1; n + 1 < corners.size(); ++n) {
            const Vec3 b = difference(corners[n], low), c = difference(corners[n + 1], low);
            const Vec3 twice = cross(difference(b, a), difference(c, a));
            Vec3 in_units;
            for (std::size_t d = 0; d < 3; ++d) {
                const double normal = twice[d] / 2;
                sums.normal[d].add(normal);
                sums.moment[d].add(normal * (a[d] + b[d] + c[d]) / 3);
                sums.second[d].add(
                    normal * (a[d] * a[d] + b[d] * b[d] + c[d] * c[d] + a[d] * b[d] + b[d] * c[d] + c[d] * a[d]) / 12);
                in_units[d] = normal * grid_.spacing[(d + 1) % 3] * grid_.spacing[(d + 2) % 3];
            }
            const double area = length(in_units);
            sums.area.add(area);
            for (std::size_t d = 0; d < 3; ++d) sums.centre[d].add(area * (a[d] + b[d] + c[d]) / 3);
        }
        sums.faces.push_back(face);
    }

    CellFraction row(std::int64_t i, std::int64_t j, const CellSums& sums) const {
        CellFraction row;
        row.cell = {static_cast<std::int32_t>(first_[0] + i), static_cast<std::int32_t>(first_[1] + j),
                    static_cast<std::int32_t>(first_[2])};
        row.pieces = pieces(sums.faces, {static_cast<double>(row.cell[0]), static_cast<double>(row.cell[1]),
                                         static_cast<double>(row.cell[2])});
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
            const double moment = sections[2 * d + 1][0] / 2 + sums.second[d].value();
            row.centroid[d] = row.volume > 0 ? std::clamp(moment / row.volume - 0.5, -0.5, 0.5) : 0;
            row.surface_centroid[d] = row.area > 0 ? std::clamp(sums.centre[d].value() / row.area - 0.5, -0.5, 0.5) : 0;
            const bool is_side_first = by_axis[d]->side() < by_axis[d]->along();
            for (std::size_t face = 2 * d; face < 2 * d + 2; ++face) {
                const auto& [area, first, second] = sections[face];
                row.face_fractions[face] = area;
                const auto middle = [&](double sum) { return area > 0 ? std::clamp(sum / area - 0.5, -0.5, 0.5) : 0; };
                row.face_centroids[face] = is_side_first ? std::array{middle(first), middle(second)}
                                                         : std::array{middle(second), middle(first)};
            }
        }
        return row;
    }

    /// Faces are joined over an edge that has a part in the cell.
    std::uint32_t pieces(std::span<const std::uint32_t> faces, const Vec3& low) const {
        DisjointSets sets(faces.size());
        auto count = static_cast<std::uint32_t>(faces.size());
        using Edge = std::array<std::uint32_t, 3>;  // its vertices, and a place in `faces`
        std::vector<Edge> edges;
        for (std::uint32_t n = 0; n < faces.size(); ++n) {
            const Triangle& corners = mesh_.triangles()[faces[n]];
            for (std::size_t i = 0; i < 3; ++i)
                edges.push_back(
                    {std::min(corners[i], corners[(i + 1) % 3]), std::max(corners[i], corners[(i + 1) % 3]), n});
        }
        std::ranges::sort(edges);
        for (std::size_t n = 1; n < edges.size(); ++n) {
            if (edges[n][0] != edges[n - 1][0] || edges[n][1] != edges[n - 1][1]) continue;
            if (sets.root(edges[n][2]) == sets.root(edges[n - 1][2]) || !meets(edges[n], low)) continue;
            --count;
            sets.join(edges[n][2], edges[n - 1][2]);
        }
        return count;
    }

    /// Whether an edge has a part in the cell.
    bool meets(const std::array<std::uint32_t, 3>& edge, const Vec3& low) const {
        const Vec3 &p = positions_[edge[0]], &q = positions_[edge[1]];
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

    const Mesh& mesh_;
    std::span<const Vec3> positions_;
    const Grid& grid_;
    std::array<std::int64_t, 3> counts_, first_{};
    Sections x_{0, 2, 1}, y_{1, 2, 0}, z_{2, 0, 1};
    FewItems<CellSums> cells_;
};

}  // namespace

Fractions fractions(const Mesh& mesh, const Grid& grid, SignRule sign, const CallOptions& call) {
    grid.validate();
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (grid.size[axis] < 2)
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("the grid has {} sample along {}, so no cells: give two samples or more on each axis",
                            grid.size[axis], "xyz"[axis]));
    const Cancellation cancellation(call.should_stop);
    const Mesh surface = outer(mesh, sign, call).mesh;

    // In cells of the lattice, so that a part has the bytes of the whole.
    std::vector<Vec3> positions(surface.vertices().size());
    for_each_index(positions.size(), [&](std::size_t v) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            positions[v][axis] = (surface.vertices()[v][axis] - grid.origin[axis]) / grid.spacing[axis];
    });
    const auto slabs = static_cast<std::size_t>(grid.size[2] - 1);
    std::vector<std::vector<std::uint32_t>> faces(slabs);
    for (std::uint32_t face = 0; face < surface.triangles().size(); ++face) {
        const auto& [a, b, c] = surface.triangles()[face];
        const auto [least, most] = std::minmax({positions[a][2], positions[b][2], positions[c][2]});
        const CellRange range(least, most, grid.first[2], grid.size[2] - 1);
        for (std::int64_t k = range.low; k <= range.high; ++k) faces[static_cast<std::size_t>(k)].push_back(face);
    }

    Fractions result{grid, {}, {}};
    const std::size_t per_slab = result.counts()[0] * result.counts()[1];
    std::vector<std::vector<CellFraction>> rows(slabs);
    std::vector<std::vector<bool>> are_full(slabs);
    for_each_range(
        slabs,
        [&](std::size_t begin, std::size_t end) {
            Slab slab(surface, positions, grid);
            for (std::size_t k = begin; k != end; ++k) {
                cancellation.check();
                if (faces[k].empty()) continue;
                are_full[k].assign(per_slab, false);
                slab.run(static_cast<std::int64_t>(k), faces[k], rows[k], are_full[k]);
            }
        },
        4);
    result.full.assign((slabs * per_slab + 7) / 8, 0);
    std::size_t count = 0;
    for (std::size_t k = 0; k < slabs; ++k) {
        count += rows[k].size();
        for (std::size_t cell = 0; cell < are_full[k].size(); ++cell)
            if (are_full[k][cell]) {
                const std::size_t bit = k * per_slab + cell;
                result.full[bit / 8] = static_cast<std::uint8_t>(result.full[bit / 8] | 1U << bit % 8);
            }
    }
    result.cells.reserve(count);
    for (std::vector<CellFraction>& of_slab : rows) {
        result.cells.insert(result.cells.end(), of_slab.begin(), of_slab.end());
        of_slab = {};
    }
    return result;
}

}  // namespace clsdf
