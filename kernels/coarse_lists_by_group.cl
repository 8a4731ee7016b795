// The list of polyhedra of each coarse brick (32 x 32 x 32 samples), for GPUs, in one pass over the polyhedra.
//
// coarse_pairs finds the pairs of a polyhedron and a coarse brick that overlap, in no order: work-items take room
// for CLSDF_PAIR_BLOCK pairs at a time from a shared counter. Polyhedra that follow each other form segments; a counter
// of each brick and segment gives a pair its index among theirs. After a prefix sum of the counts, starts[brick *
// segments + segment] is where a segment's entries of a brick begin. coarse_scatter moves the pairs there, and
// coarse_sort orders each segment: the lists are in the order of the polyhedra, however work-items are scheduled.

#include "coarse_clusters.h"

// Room for a work-item's pairs: pairs [next, end).
typedef struct PairWriter {
    __global CoarsePair* pairs;
    uint capacity;
    __global uint* taken;   // pairs
    __global uint* counts;  // of the polyhedron's segment
    uint segments;
    uint next, end;
} PairWriter;

INLINE void write_pair(__private PairWriter* writer, uint brick, uint polyhedron) {
    if (writer->next == writer->end) {
        writer->next = atomic_add(writer->taken, CLSDF_PAIR_BLOCK);
        writer->end = writer->next + CLSDF_PAIR_BLOCK;
    }
    const uint index = atomic_inc(writer->counts + (size_t)brick * writer->segments);
    if (writer->next < writer->capacity) {
        const CoarsePair pair = {brick, polyhedron, index};
        writer->pairs[writer->next] = pair;
    }
    ++writer->next;
}

// The pairs of a polyhedron and those bricks of a group, which starts at `start`, that are `near`. base: the number of
// the group's first brick in the part, negative if it lies before.
INLINE void find_pairs(Layout layout, __global const Polyhedron* polyhedra, Cluster cluster, int3 start, ulong near,
                       __private const float* bounds, float slack, int base, int2 size, __private PairWriter* writer) {
    const ClusterAtGroup at = cluster_at_group(layout, polyhedra, cluster, start, slack);
    for (; near; near &= near - 1) {
        const uint b = lowest_bit_of_long(near);
        if (!overlapping_lanes(&at, b, bounds[b])) continue;
        const uint brick = (uint)(base + ((int)(b >> 4) * size.y + (int)(b >> 2 & 3u)) * size.x + (int)(b & 3u));
        write_pair(writer, brick, cluster.first);
    }
}

// Polyhedra [begin, end), one a work-item. `uniform_bounds`: no bound is below the half width. `per_segment`:
// polyhedra. counts and taken are 0 at first.
__kernel void coarse_pairs(Layout layout, uint begin, uint end, __global const Polyhedron* polyhedra,
                           __global const float* bounds, int uniform_bounds, uint per_segment, uint segments,
                           __global uint* counts, __global uint* taken, uint capacity, __global CoarsePair* pairs) {
    const uint polyhedron = begin + get_global_id(0);
    if (polyhedron >= end) return;
    const int3 first = vload3(0, layout.coarse_first), size = vload3(0, layout.coarse_bricks);
    PairWriter writer = {pairs, capacity, taken, counts + polyhedron / per_segment, segments, 0, 0};
    const float farthest = layout.half_width + layout.slack_rate * layout.half_width + layout.coarse_slack;
    float group_bounds[CLSDF_COARSE_GROUP];
    float greatest = layout.half_width;
    for (uint b = 0; b < CLSDF_COARSE_GROUP; ++b) group_bounds[b] = greatest;
    Cluster cluster;
    find_cluster(layout, polyhedra, polyhedron, 1, &cluster);
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
                find_pairs(layout, polyhedra, cluster, group, near, group_bounds, slack, base, size.xy, &writer);
            }
    for (; writer.next != writer.end; ++writer.next)
        if (writer.next < capacity) pairs[writer.next].brick = CLSDF_NO_BRICK;
}

// list_starts: where each brick's list begins, and behind the last one, the end of all.
__kernel void coarse_list_starts(uint bricks, uint segments, __global const uint* starts, __global uint* list_starts) {
    const uint brick = get_global_id(0);
    if (brick <= bricks) list_starts[brick] = starts[(size_t)brick * segments];
}

// Moves pairs [begin, end) to their segments, in no order there.
__kernel void coarse_scatter(uint begin, uint end, __global const CoarsePair* pairs, uint per_segment, uint segments,
                             __global const uint* starts, __global uint* scattered) {
    const uint n = begin + get_global_id(0);
    if (n >= end) return;
    const CoarsePair pair = pairs[n];
    if (pair.brick == CLSDF_NO_BRICK) return;
    const size_t segment = (size_t)pair.brick * segments + pair.polyhedron / per_segment;
    scattered[starts[segment] + pair.index] = pair.polyhedron;
}

// Writes the entries of pairs [begin, end): a pair's index is the number of pairs of its segment before it.
__kernel void coarse_sort(uint begin, uint end, __global const CoarsePair* pairs, uint per_segment, uint segments,
                          __global const uint* starts, __global const uint* scattered, __global uint* entries) {
    const uint n = begin + get_global_id(0);
    if (n >= end) return;
    const CoarsePair pair = pairs[n];
    if (pair.brick == CLSDF_NO_BRICK) return;
    const size_t segment = (size_t)pair.brick * segments + pair.polyhedron / per_segment;
    const uint first = starts[segment], last = starts[segment + 1];
    uint before = 0;
    for (uint e = first; e < last; ++e) before += scattered[e] < pair.polyhedron;
    entries[first + before] = pair.polyhedron;
}
