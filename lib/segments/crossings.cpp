#include "segments/crossings.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace clsdf::segments {

namespace {

/// Of each axis, forwards and backwards: an edge is a link from its end outside.
constexpr std::array<LinkDirection, 6> directions{
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

}  // namespace

Crossings find_crossings(const LinkInputs& inputs, const Grid& grid, bool with_counts) {
    Crossings crossings;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EdgeCrossings& edges = crossings.axes[axis];
        edges.size = grid.size;
        --edges.size[axis];
        const auto count = static_cast<std::size_t>(edges.size[0] * edges.size[1] * edges.size[2]);
        edges.coordinates.assign(count, std::numeric_limits<double>::quiet_NaN());
        edges.triangles.assign(count, no_triangle);
        if (with_counts) edges.counts.assign(count, 0);
    }
    Links links = find_links(inputs, grid, directions, {.with_between = with_counts, .with_gaps = with_counts});
    crossings.inside = std::move(links.inside);
    for_each_index(links.size(), [&](std::size_t n) {
        const std::size_t axis = links.directions[n] / 2;
        const bool is_forward = links.directions[n] % 2 == 0;
        EdgeCrossings& edges = crossings.axes[axis];
        Index3 sample{};
        for (std::size_t k = 0; k < 3; ++k) sample[k] = links.samples[n][k] - grid.first[k];
        Index3 edge = sample, other = sample;
        other[axis] += is_forward ? 1 : -1;
        if (!is_forward) --edge[axis];
        if (edge[axis] < 0 || edge[axis] >= edges.size[axis]) return;  // it leads out of the grid
        const auto at = static_cast<std::size_t>((edge[2] * edges.size[1] + edge[1]) * edges.size[0] + edge[0]);
        constexpr auto equal_sides = static_cast<unsigned>(SegmentFlag::between) | static_cast<unsigned>(gap_flag);
        const bool are_equal = (static_cast<unsigned>(links.flags[n]) & equal_sides) != 0;
        if (are_equal && !is_forward) return;  // the same from the other end
        if (with_counts) edges.counts[at] = links.counts[n];
        if (are_equal) return;
        const double from = grid.position(sample[0], sample[1], sample[2])[axis],
                     to = grid.position(other[0], other[1], other[2])[axis];
        edges.coordinates[at] =
            std::clamp(std::fma(links.q[n], to - from, from), std::min(from, to), std::max(from, to));
        edges.triangles[at] = links.triangles[n];
    });
    return crossings;
}

}  // namespace clsdf::segments
