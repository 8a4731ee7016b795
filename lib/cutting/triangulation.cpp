#include "cutting/triangulation.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>

namespace clsdf::cutting {

FaceTriangulation::FaceTriangulation(const CutPoints& points, const Triangle& corners, const View& view)
    : points_(points), view_(view) {
    cells_.emplace_back();
    set(0, corners, {none, none, none});
}

void FaceTriangulation::refuse() const {
    const Vec3& at = points_.rounded(cells_[0].corners[0]);
    throw Error(ErrorCode::unsupported,
                fmt::format("a face near ({}, {}, {}) cannot be cut, which must not happen: please report the mesh",
                            at[0], at[1], at[2]));
}

int FaceTriangulation::orientation(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return view_.direction * points_.orientation(a, b, c, view_.axis, cache_);
}

std::vector<Triangle> FaceTriangulation::triangles() const {
    std::vector<Triangle> all;
    all.reserve(cells_.size());
    for (const Cell& cell : cells_) all.push_back(cell.corners);
    return all;
}

unsigned FaceTriangulation::corner_index(std::uint32_t cell, std::uint32_t corner) const {
    const Triangle& corners = cells_[cell].corners;
    return corners[0] == corner ? 0 : corners[1] == corner ? 1 : 2;
}

void FaceTriangulation::set(std::uint32_t cell, const Triangle& corners, const Triangle& beyond) {
    cells_[cell] = {corners, beyond};
    for (unsigned i = 0; i < 3; ++i) {
        cell_of_[corners[i]] = cell;
        if (beyond[i] == none) continue;
        Cell& other = cells_[beyond[i]];
        // The corner that is not on the common edge.
        for (unsigned k = 0; k < 3; ++k)
            if (other.corners[k] != corners[(i + 1) % 3] && other.corners[k] != corners[(i + 2) % 3])
                other.beyond[k] = cell;
    }
}

std::pair<std::uint32_t, unsigned> FaceTriangulation::locate(std::uint32_t point) {
    const auto beside = [&](std::uint32_t cell, unsigned i) {
        const Triangle& corners = cells_[cell].corners;
        return orientation(corners[(i + 1) % 3], corners[(i + 2) % 3], point);
    };
    const auto look = [&](std::uint32_t cell, std::uint32_t& next) {
        unsigned on = 0;
        for (unsigned i = 0; i < 3; ++i) {
            const int side = beside(cell, i);
            if (side < 0) {
                next = cells_[cell].beyond[i];
                return 8U;
            }
            if (side == 0) on |= 1U << i;
        }
        return on;
    };
    // A walk may turn in circles; then all cells are looked at.
    std::uint32_t cell = last_, next = none;
    for (std::size_t steps = 0; steps <= cells_.size() && cell != none; ++steps) {
        if (const unsigned on = look(cell, next); on < 8) return {cell, on};
        cell = next;
    }
    for (cell = 0; cell < cells_.size(); ++cell)
        if (const unsigned on = look(cell, next); on < 8) return {cell, on};
    return {none, 0};
}

void FaceTriangulation::add_point(std::uint32_t point) {
    if (cell_of_.contains(point)) return;
    const auto [cell, on] = locate(point);
    if (cell == none) refuse();
    if (on == 0)
        split_cell(cell, point);
    else
        split_edge({cell, on == 1 ? 0U : on == 2 ? 1U : 2U}, point);
    improve(point);
    last_ = cell_of_.at(point);
}

void FaceTriangulation::split_cell(std::uint32_t cell, std::uint32_t point) {
    const auto [corners, beyond] = cells_[cell];
    const auto second = static_cast<std::uint32_t>(cells_.size()), third = second + 1;
    cells_.resize(cells_.size() + 2);
    // Corners first, so that each finds the others.
    cells_[second].corners = {point, corners[2], corners[0]};
    cells_[third].corners = {point, corners[0], corners[1]};
    set(cell, {point, corners[1], corners[2]}, {beyond[0], second, third});
    set(second, {point, corners[2], corners[0]}, {beyond[1], third, cell});
    set(third, {point, corners[0], corners[1]}, {beyond[2], cell, second});
}

void FaceTriangulation::split_edge(const Side& side, std::uint32_t point) {
    const auto [corners, beyond] = cells_[side.cell];
    const std::uint32_t top = corners[side.corner], a = corners[(side.corner + 1) % 3],
                        b = corners[(side.corner + 2) % 3], across = beyond[side.corner],
                        beyond_a = beyond[(side.corner + 1) % 3], beyond_b = beyond[(side.corner + 2) % 3];
    const auto half = static_cast<std::uint32_t>(cells_.size());
    if (across == none) {
        cells_.resize(cells_.size() + 1);
        cells_[half].corners = {top, point, b};
        set(side.cell, {top, a, point}, {none, half, beyond_b});
        set(half, {top, point, b}, {none, beyond_a, side.cell});
        return;
    }
    const unsigned index = corner_index(across, [&] {
        for (const std::uint32_t corner : cells_[across].corners)
            if (corner != a && corner != b) return corner;
        return none;
    }());
    const std::uint32_t bottom = cells_[across].corners[index], other_half = half + 1;
    // Seen from the other side the edge runs from b to a.
    const std::uint32_t below_b = cells_[across].beyond[(index + 1) % 3],
                        below_a = cells_[across].beyond[(index + 2) % 3];
    cells_.resize(cells_.size() + 2);
    cells_[side.cell].corners = {top, a, point};
    cells_[half].corners = {top, point, b};
    cells_[across].corners = {bottom, b, point};
    cells_[other_half].corners = {bottom, point, a};
    set(side.cell, {top, a, point}, {other_half, half, beyond_b});
    set(half, {top, point, b}, {across, beyond_a, side.cell});
    set(across, {bottom, b, point}, {half, other_half, below_a});
    set(other_half, {bottom, point, a}, {side.cell, below_b, across});
}

bool FaceTriangulation::is_convex(const Side& side) {
    const auto& [corners, beyond] = cells_[side.cell];
    const std::uint32_t across = beyond[side.corner];
    if (across == none) return false;
    const std::uint32_t top = corners[side.corner], a = corners[(side.corner + 1) % 3],
                        b = corners[(side.corner + 2) % 3];
    std::uint32_t bottom = none;
    for (const std::uint32_t corner : cells_[across].corners)
        if (corner != a && corner != b) bottom = corner;
    return orientation(top, a, bottom) > 0 && orientation(top, bottom, b) > 0;
}

void FaceTriangulation::flip(const Side& side) {
    const auto [corners, beyond] = cells_[side.cell];
    const std::uint32_t across = beyond[side.corner], top = corners[side.corner], a = corners[(side.corner + 1) % 3],
                        b = corners[(side.corner + 2) % 3];
    const auto [others, others_beyond] = cells_[across];
    unsigned index = 0;
    while (others[index] == a || others[index] == b) ++index;
    const std::uint32_t bottom = others[index];
    const std::uint32_t beyond_a = beyond[(side.corner + 1) % 3], beyond_b = beyond[(side.corner + 2) % 3];
    // The other cell is (bottom, b, a).
    const std::uint32_t below_b = others_beyond[(index + 1) % 3], below_a = others_beyond[(index + 2) % 3];
    cells_[side.cell].corners = {a, bottom, top};
    cells_[across].corners = {b, top, bottom};
    set(side.cell, {a, bottom, top}, {across, beyond_b, below_b});
    set(across, {b, top, bottom}, {side.cell, below_a, beyond_a});
}

bool FaceTriangulation::is_better_flipped(const Side& side) const {
    const auto& [corners, beyond] = cells_[side.cell];
    const std::uint32_t a = corners[(side.corner + 1) % 3], b = corners[(side.corner + 2) % 3];
    std::uint32_t bottom = none;
    for (const std::uint32_t corner : cells_[beyond[side.corner]].corners)
        if (corner != a && corner != b) bottom = corner;
    // By angles: Delaunay's rule.
    const auto cosine = [&](std::uint32_t apex) {
        const Vec3 &p = points_.rounded(apex), &q = points_.rounded(a), &r = points_.rounded(b);
        double of_both = 0, of_q = 0, of_r = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            of_both += (q[k] - p[k]) * (r[k] - p[k]);
            of_q += (q[k] - p[k]) * (q[k] - p[k]);
            of_r += (r[k] - p[k]) * (r[k] - p[k]);
        }
        const double squared = of_q * of_r;  // 0 if rounding has brought points together
        return squared > 0 ? of_both / std::sqrt(squared) : 1.0;
    };
    // The angles add up to more than half a turn.
    return cosine(corners[side.corner]) + cosine(bottom) < -1e-12;
}

void FaceTriangulation::improve(std::uint32_t point) {
    // Edges across from the point; rounded angles might flip for ever.
    std::vector<std::uint32_t> open;
    any_cell_at(point, [&](std::uint32_t cell, unsigned) {
        open.push_back(cell);
        return false;
    });
    for (std::size_t flips = 0; !open.empty() && flips < 64;) {
        const std::uint32_t cell = open.back();
        open.pop_back();
        const Side side{cell, corner_index(cell, point)};
        if (cells_[cell].corners[side.corner] != point) continue;
        const std::uint32_t across = cells_[cell].beyond[side.corner];
        if (across == none || !is_better_flipped(side) || !is_convex(side)) continue;
        flip(side);
        ++flips;
        open.push_back(cell);
        open.push_back(across);
    }
}

template <typename Function>
bool FaceTriangulation::any_cell_at(std::uint32_t point, const Function& f) const {
    const std::uint32_t start = cell_of_.at(point);
    std::uint32_t cell = start;
    do {  // counterclockwise
        const unsigned index = corner_index(cell, point);
        if (f(cell, index)) return true;
        cell = cells_[cell].beyond[(index + 1) % 3];
    } while (cell != none && cell != start);
    if (cell == start) return false;
    for (cell = cells_[start].beyond[(corner_index(start, point) + 2) % 3]; cell != none;) {
        const unsigned index = corner_index(cell, point);
        if (f(cell, index)) return true;
        cell = cells_[cell].beyond[(index + 2) % 3];
    }
    return false;
}

FaceTriangulation::Side FaceTriangulation::side_of(std::uint32_t from, std::uint32_t to) const {
    Side side{none, 0};
    any_cell_at(from, [&](std::uint32_t cell, unsigned index) {
        const Triangle& corners = cells_[cell].corners;
        if (corners[(index + 1) % 3] == to) side = {cell, (index + 2) % 3};
        if (corners[(index + 2) % 3] == to) side = {cell, (index + 1) % 3};
        return side.cell != none;
    });
    return side;
}

void FaceTriangulation::add_segment(std::uint32_t from, std::uint32_t to) {
    if (side_of(from, to).cell != none) return;
    // The edges that it crosses, from the first point on.
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    std::deque<Edge> crossed;
    std::uint32_t cell = none;
    any_cell_at(from, [&](std::uint32_t at, unsigned index) {
        const Triangle& corners = cells_[at].corners;
        const std::uint32_t right = corners[(index + 1) % 3], left = corners[(index + 2) % 3];
        if (orientation(from, to, right) >= 0 || orientation(from, to, left) <= 0) return false;
        crossed.emplace_back(right, left);
        cell = cells_[at].beyond[index];
        return true;
    });
    if (crossed.empty()) refuse();
    while (cell != none) {
        const auto [right, left] = crossed.back();
        std::uint32_t ahead = none;
        for (const std::uint32_t corner : cells_[cell].corners)
            if (corner != right && corner != left) ahead = corner;
        if (ahead == to) break;
        const Edge next = orientation(from, to, ahead) > 0 ? Edge(right, ahead) : Edge(ahead, left);
        const Side side = side_of(next.first, next.second);
        const std::uint32_t beyond = cells_[side.cell].beyond[side.corner];
        cell = side.cell == cell ? beyond : side.cell;
        crossed.push_back(next);
    }
    if (cell == none) refuse();
    // S. W. Sloan, A fast algorithm for generating constrained Delaunay triangulations, 1993.
    while (!crossed.empty()) {
        const Edge edge = crossed.front();
        crossed.pop_front();
        const Side side = side_of(edge.first, edge.second);
        if (!is_convex(side)) {
            crossed.push_back(edge);
            continue;
        }
        const std::uint32_t one = cells_[side.cell].corners[side.corner];
        flip(side);
        const std::uint32_t bottom = cells_[side.cell].corners[1];
        if (one == from || one == to || bottom == from || bottom == to) continue;
        if (orientation(from, to, one) * orientation(from, to, bottom) < 0) crossed.emplace_back(one, bottom);
    }
}

}  // namespace clsdf::cutting
