#pragma once

#include <clsdf/mesh.hpp>

#include "core/vectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::cutting {

/// A sum that rounds once (A. Neumaier, 1974), with the rest of each addition by D. Knuth's, which has no branch.
class Sum {
public:
    void add(double value) {
        const double sum = sum_ + value, part = sum - sum_;
        rest_ += (sum_ - (sum - part)) + (value - part);
        sum_ = sum;
    }
    double value() const { return sum_ + rest_; }

private:
    double sum_ = 0, rest_ = 0;
};

/// The point of an edge at which a coordinate has a value, with the same bits from both sides.
inline Vec3 point_at(Vec3 p, Vec3 q, std::size_t axis, double value) {
    if (q < p) std::swap(p, q);
    if (value == q[axis]) return q;
    const double share = (value - p[axis]) / (q[axis] - p[axis]);
    Vec3 point;
    for (std::size_t k = 0; k < 3; ++k) point[k] = p[k] + share * (q[k] - p[k]);
    point[axis] = value;
    return point;
}

/// The lowest and the highest of `count` cells from `first` on in which a range of coordinates lies, counted from the
/// first; none if low > high.
struct CellRange {
    std::int64_t low, high;

    CellRange(std::int64_t low_in, std::int64_t high_in) : low(low_in), high(high_in) {}
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
        if (numbers_.size() == count)
            for (const std::size_t place : places_) numbers_[place] = 0;
        else
            numbers_.assign(count, 0);
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
    /// Those that are not missing, in the order in which they were made.
    std::span<const std::size_t> places() const { return places_; }
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

/// Lines along an axis: how often they are within the solid at the end of each cell, and integrals over the solid in
/// each.
class Lines {
public:
    void reset(std::size_t lines, std::int64_t first, std::size_t cells) {
        first_ = first;
        if (is_crossed_.size() == lines && cells_ == cells)
            for (const std::size_t line : crossed_) {
                std::ranges::fill(steps_of(line), 0);
                is_crossed_[line] = 0;
            }
        else {
            is_crossed_.assign(lines, 0);
            steps_.assign(lines * cells, 0);
        }
        crossed_.clear();
        cells_ = cells;
        parts_.reset(lines * cells);
    }
    /// A line enters the solid (1) or leaves it (-1).
    void add(std::size_t line, double at, int way) {
        const CellRange cell(at, at, first_, static_cast<std::int64_t>(cells_));
        if (cell.low == static_cast<std::int64_t>(cells_)) return;
        if (is_crossed_[line] == 0) crossed_.push_back(line);
        is_crossed_[line] = 1;
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
        for (const std::size_t line : crossed_) {
            int inside = 0;
            for (int& step : steps_of(line)) inside = step += inside;
        }
    }
    /// If not, none of its cells are within the solid.
    bool is_crossed(std::size_t line) const { return is_crossed_[line] != 0; }
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

    std::span<int> steps_of(std::size_t line) { return std::span(steps_).subspan(line * cells_, cells_); }

    std::int64_t first_ = 0;
    std::size_t cells_ = 0;
    std::vector<int> steps_;
    std::vector<std::uint8_t> is_crossed_;  // by line
    std::vector<std::size_t> crossed_;
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
               std::int64_t planes);

    /// corners: in cells of the lattice.
    void add(const std::array<Vec3, 3>& corners);
    /// Adds to the section in a cell's low face a part of it, which is in the face.
    void add(const std::array<std::int64_t, 3>& cell_from_first, double area, double first, double second);
    void finish() { lines_.finish(); }

    /// The integrals over the section in a cell's low face.
    std::array<double, 3> at(std::int64_t plane, std::int64_t side, std::int64_t along) const;
    /// If not, no edge on the high side of the cells of a row is solid.
    bool may_be_solid(std::int64_t plane, std::int64_t side) const { return lines_.is_crossed(line(plane, side)); }
    /// Whether most of the edge is solid on the high side of a cell's low face.
    bool is_edge_solid(std::int64_t plane, std::int64_t side, std::int64_t along) const {
        return lines_.length(line(plane, side), static_cast<std::size_t>(along)) > 0.5;
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

    void add(const std::array<Vec3, 3>& corners, double plane);
    void add_lines(std::int64_t plane, const Vec3& down, const Vec3& up);

    std::size_t across_, side_, along_;
    int orientation_;
    std::array<std::int64_t, 3> first_{}, counts_{};
    std::int64_t planes_ = 0;
    FewItems<FaceSums> sums_;
    Lines lines_;
};

}  // namespace clsdf::cutting
