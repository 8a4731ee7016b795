#pragma once

#include "cutting/cut_shapes.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::cutting {

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
    void add(std::size_t line, const CutPoint& at, int along, int way) {
        const double place = cell_of(at, along);
        const CellRange cell = cells_between(place, place, first_, static_cast<std::int64_t>(cells_));
        if (cell.low == static_cast<std::int64_t>(cells_)) return;
        if (is_crossed_[line] == 0) crossed_.push_back(line);
        is_crossed_[line] = 1;
        const std::size_t item = line * cells_ + static_cast<std::size_t>(cell.low);
        steps_[item] += way;
        if (cell.high < 0) return;  // before the first cell: whole cells alone
        add_crossing(&parts_.make(item), way, above_plane(at, along, static_cast<double>(first_ + cell.low)));
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
        const std::size_t place = line * cells_ + cell;
        return length_in_cell(steps_[place], &part(place));
    }
    double moment(std::size_t line, std::size_t cell) const {
        const std::size_t place = line * cells_ + cell;
        return moment_in_cell(steps_[place], &part(place));
    }

private:
    const LineSums& part(std::size_t place) const {
        static constexpr LineSums none{};
        const LineSums* const found = parts_.find(place);
        return found != nullptr ? *found : none;
    }
    std::span<int> steps_of(std::size_t line) { return std::span(steps_).subspan(line * cells_, cells_); }

    std::int64_t first_ = 0;
    std::size_t cells_ = 0;
    std::vector<int> steps_;
    std::vector<std::uint8_t> is_crossed_;  // by line
    std::vector<std::size_t> crossed_;
    FewItems<LineSums> parts_;
};

/// Sections of the solid with planes across one axis, in the cells of a slab: see kernels/cutting/cut_sections.h.
class Sections {
public:
    explicit Sections(int across)
        : across_(static_cast<std::size_t>(across)),
          side_(static_cast<std::size_t>(side_of(across))),
          along_(static_cast<std::size_t>(along_of(across))) {}

    /// first: the first cell, on the lattice; counts: of cells on the three axes; planes: of planes.
    void reset(const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& counts,
               std::int64_t planes);

    /// corners: in cells of the lattice.
    void add(const std::array<CutPoint, 3>& corners);
    /// Adds to the section in a cell's low face a piece that goes to the cell below.
    void add(const std::array<std::int64_t, 3>& cell_from_first, const CutPiece& piece);
    void finish() { lines_.finish(); }

    /// The integrals over the section in a cell's low face.
    FaceValues at(std::int64_t plane, std::int64_t side, std::int64_t along) const;
    /// If not, no edge on the high side of the cells of a row is solid.
    bool may_be_solid(std::int64_t plane, std::int64_t side) const { return lines_.is_crossed(line(plane, side)); }
    /// Whether most of the edge is solid on the high side of a cell's low face.
    bool is_edge_solid(std::int64_t plane, std::int64_t side, std::int64_t along) const {
        return lines_.length(line(plane, side), static_cast<std::size_t>(along)) > 0.5;
    }

private:
    std::size_t cell(std::int64_t plane, std::int64_t side, std::int64_t along) const {
        return static_cast<std::size_t>((plane * counts_[side_] + side) * counts_[along_] + along);
    }
    /// That on the high side of a cell.
    std::size_t line(std::int64_t plane, std::int64_t side) const {
        return static_cast<std::size_t>(plane * counts_[side_] + side);
    }

    void add(const std::array<CutPoint, 3>& corners, double plane);
    void add_lines(std::int64_t plane, const CutPoint& down, const CutPoint& up);

    std::size_t across_, side_, along_;
    std::array<std::int64_t, 3> first_{}, counts_{};
    std::int64_t planes_ = 0;
    FewItems<FaceSums> sums_;
    Lines lines_;
};

}  // namespace clsdf::cutting
