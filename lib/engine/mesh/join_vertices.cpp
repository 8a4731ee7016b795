#include "mesh/join_vertices.hpp"

#include "mesh/box_index.hpp"
#include "mesh/disjoint_sets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace clsdf {

namespace {

bool are_near(const Vec3& a, const Vec3& b, double tolerance) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(std::abs(a[axis] - b[axis]) <= tolerance)) return false;
    return true;
}

/// The cells of a grid that hold points, for crowds of them.
class Cells {
public:
    Cells(std::span<const Vec3> positions, std::span<const std::uint32_t> points, double tolerance) {
        Vec3 lower = positions[points[0]];
        for (const std::uint32_t point : points)
            for (std::size_t axis = 0; axis < 3; ++axis) lower[axis] = std::min(lower[axis], positions[point][axis]);
        // A little longer than the tolerance, so that rounding puts no two points that are near farther apart than the
        // cells next to each other.
        const double side = tolerance * (1 + 0x1p-20);
        entries_.reserve(points.size());
        for (const std::uint32_t point : points) {
            Cell cell{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                cell[axis] = static_cast<std::int64_t>((positions[point][axis] - lower[axis]) / side);
            entries_.push_back({cell, point});
        }
        std::ranges::sort(entries_);
    }

    /// Calls f(points, others) for each cell with itself, then for each pair of cells next to each other.
    template <typename Function>
    void for_each_pair(const Function& f) const {
        for_each_cell([&](std::span<const Entry> own, std::span<const Entry>) { f(own, own); });
        for_each_cell([&](std::span<const Entry> own, std::span<const Entry> later) {
            const Cell at = own[0].first;
            for (std::int64_t n = 14; n < 27; ++n) {  // the later half of the neighbours
                const Cell cell{at[0] + n / 9 - 1, at[1] + n / 3 % 3 - 1, at[2] + n % 3 - 1};
                const auto [low, high] = std::ranges::equal_range(later, cell, {}, &Entry::first);
                if (low != high) f(own, std::span<const Entry>(low, high));
            }
        });
    }

private:
    using Cell = std::array<std::int64_t, 3>;

public:
    using Entry = std::pair<Cell, std::uint32_t>;

private:
    /// Calls f(points, all later points).
    template <typename Function>
    void for_each_cell(const Function& f) const {
        for (auto first = entries_.begin(); first != entries_.end();) {
            const auto end = std::ranges::upper_bound(first, entries_.end(), first->first, {}, &Entry::first);
            f(std::span<const Entry>(first, end), std::span<const Entry>(end, entries_.end()));
            first = end;
        }
    }

    std::vector<Entry> entries_;
};

/// Finds the clusters of points by splitting them at gaps.
class Joiner {
public:
    Joiner(std::span<const Vec3> positions, std::vector<std::uint32_t> candidates, double tolerance)
        : positions_(positions), points_(std::move(candidates)), tolerance_(tolerance) {}

    std::vector<JoinedVertex> join() {
        struct Open {
            std::size_t begin, end, axis, unsplit;
        };
        std::vector<Open> open;
        if (points_.size() > 1) open.push_back({0, points_.size(), 0, 0});
        while (!open.empty()) {
            const auto [begin, end, axis, unsplit] = open.back();
            open.pop_back();
            if (unsplit == 3) {
                connect(begin, end);
                continue;
            }
            const auto at = [&](std::uint32_t point) { return positions_[point][axis]; };
            std::sort(points_.begin() + static_cast<std::ptrdiff_t>(begin),
                      points_.begin() + static_cast<std::ptrdiff_t>(end),
                      [&](std::uint32_t a, std::uint32_t b) { return at(a) != at(b) ? at(a) < at(b) : a < b; });
            for (std::size_t first = begin, i = begin + 1; i <= end; ++i) {
                if (i != end && at(points_[i]) - at(points_[i - 1]) <= tolerance_) continue;
                const bool is_whole = first == begin && i == end;
                if (i - first > 1) open.push_back({first, i, (axis + 1) % 3, is_whole ? unsplit + 1 : 1});
                first = i;
            }
        }
        std::ranges::sort(joined_, {}, &JoinedVertex::vertex);
        return std::move(joined_);
    }

private:
    /// Points that no plane across an axis separates.
    void connect(std::size_t begin, std::size_t end) {
        const std::span<std::uint32_t> points(points_.data() + begin, end - begin);
        if (is_within(points, tolerance_)) {
            add(points);
            return;
        }
        DisjointSets sets(points.size());
        std::vector<std::uint32_t> places(points.begin(), points.end());
        std::ranges::sort(places);
        const auto place = [&](std::uint32_t point) {
            return static_cast<std::uint32_t>(std::ranges::lower_bound(places, point) - places.begin());
        };
        const auto join_near = [&](const Cells::Entry& a, const Cells::Entry& b) {
            const std::uint32_t one = place(a.second), other = place(b.second);
            if (sets.root(one) != sets.root(other) && are_near(positions_[a.second], positions_[b.second], tolerance_))
                sets.join(one, other);
        };
        const auto are_joined = [&](std::span<const Cells::Entry> ones, std::span<const Cells::Entry> others) {
            const std::uint32_t root = sets.root(place(ones[0].second));
            const auto is_in = [&](const Cells::Entry& entry) { return sets.root(place(entry.second)) == root; };
            return std::ranges::all_of(ones, is_in) && std::ranges::all_of(others, is_in);
        };
        Cells(positions_, points, tolerance_)
            .for_each_pair([&](std::span<const Cells::Entry> ones, std::span<const Cells::Entry> others) {
                for (const Cells::Entry& other : others) join_near(ones[0], other);
                if (are_joined(ones, others)) return;
                for (const Cells::Entry& one : ones)
                    for (const Cells::Entry& other : others) join_near(one, other);
            });
        std::ranges::sort(points, [&](std::uint32_t a, std::uint32_t b) {
            return std::pair(sets.root(place(a)), a) < std::pair(sets.root(place(b)), b);
        });
        for (std::size_t first = 0, i = 1; i <= points.size(); ++i) {
            if (i != points.size() && sets.root(place(points[i])) == sets.root(place(points[first]))) continue;
            const auto cluster = points.subspan(first, i - first);
            if (cluster.size() > 1 && is_within(cluster, longest_cluster * tolerance_)) add(cluster);
            first = i;
        }
    }

    bool is_within(std::span<const std::uint32_t> points, double length) const {
        Box box = empty_box;
        for (const std::uint32_t point : points) clsdf::add(box, {positions_[point], positions_[point]});
        return are_near(box.lower, box.upper, length);
    }

    void add(std::span<const std::uint32_t> cluster) {
        const std::uint32_t least =
            *std::ranges::min_element(cluster, {}, [&](std::uint32_t point) { return positions_[point]; });
        for (const std::uint32_t point : cluster)
            if (point != least) joined_.push_back({point, least});
    }

    std::span<const Vec3> positions_;
    std::vector<std::uint32_t> points_;
    double tolerance_;
    std::vector<JoinedVertex> joined_;
};

}  // namespace

std::vector<JoinedVertex> join_vertices(std::span<const Vec3> positions, std::vector<std::uint32_t> candidates,
                                        double tolerance) {
    if (!(tolerance > 0) || !std::isfinite(tolerance)) return {};
    return Joiner(positions, std::move(candidates), tolerance).join();
}

}  // namespace clsdf
