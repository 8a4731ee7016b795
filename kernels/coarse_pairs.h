// The pairs of a cluster's polyhedra and the coarse bricks that they overlap: the loops of both kernel bodies.
//
// Before the #include, a program defines the struct PairSink, which takes its pairs, and add_pair().
#ifndef CLSDF_COARSE_PAIRS_H
#define CLSDF_COARSE_PAIRS_H

#include "coarse_clusters.h"

// Adds the pairs of a cluster and the `near` bricks of a group that starts at `start`. base: the number of the group's
// first brick in the part, negative if it lies before.
INLINE void find_pairs_of_group(Layout layout, __global const Polyhedron* polyhedra, Cluster cluster, int3 start,
                                ulong near, __private const float* bounds, float slack, int base, int2 size,
                                __private PairSink* sink) {
    const ClusterAtGroup at = cluster_at_group(layout, polyhedra, cluster, start, slack);
    for (; near; near &= near - 1) {
        const uint b = lowest_bit_of_long(near);
        const uint lanes = overlapping_lanes(&at, b, bounds[b]);
        const uint brick = (uint)(base + ((int)(b >> 4) * size.y + (int)(b >> 2 & 3u)) * size.x + (int)(b & 3u));
        add_pair(sink, cluster.first, brick, lanes);
    }
}

// Adds all pairs of a cluster. `uniform_bounds`: no bound is below the half width. group_bounds: room for the bounds of
// a group; each is the half width at first.
INLINE void find_pairs(Layout layout, __global const Polyhedron* polyhedra, Cluster cluster,
                       __global const float* bounds, int uniform_bounds, __private float* group_bounds,
                       __private PairSink* sink) {
    const int3 first = vload3(0, layout.coarse_first), size = vload3(0, layout.coarse_bricks);
    const float farthest = layout.half_width + layout.slack_rate * layout.half_width + layout.coarse_slack;
    float greatest = layout.half_width;
    CoarseRange range = bricks_within(layout, cluster, farthest);
    // Groups begin with the range, or, if each brick has its own bound, with the group of bounds.
    int3 start = uniform_bounds ? range.low : range.low & ~3;
    range.low = max(range.low, first);
    range.high = min(range.high, first + size - 1);
    start += (max(start, first) - start) & ~3;
    for (int z = start.z; z <= range.high.z; z += 4)
        for (int y = start.y; y <= range.high.y; y += 4)
            for (int x = start.x; x <= range.high.x; x += 4) {
                const int3 group = (int3)(x, y, z), relative = group - first;
                if (!uniform_bounds) greatest = load_bounds(bounds + coarse_bound_index(layout, x, y, z), group_bounds);
                const ulong near = near_bricks(layout, cluster, group, group_in_range(group, range), group_bounds);
                if (!near) continue;
                const float slack = greatest * layout.slack_rate + layout.coarse_slack;
                const int base = (relative.z * size.y + relative.y) * size.x + relative.x;
                find_pairs_of_group(layout, polyhedra, cluster, group, near, group_bounds, slack, base, size.xy, sink);
            }
}

#endif
