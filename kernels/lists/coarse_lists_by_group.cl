// The list of polyhedra of each coarse brick (32 x 32 x 32 samples), for GPUs, in one pass over the polyhedra.
//
// coarse_pairs finds the pairs of a polyhedron and a coarse brick that overlap, in no order: work-items take room
// for CLSDF_PAIR_BLOCK pairs at a time from a shared counter. Polyhedra that follow each other form segments; a counter
// of each brick and segment gives a pair its index among theirs. After a prefix sum of the counts, starts[brick *
// segments + segment] is where a segment's entries of a brick begin. coarse_scatter moves the pairs there, and
// coarse_sort orders each segment: the lists are in the order of the polyhedra, however work-items are scheduled.

#include "coarse.h"
#include "simd.h"

// Room for a work-item's pairs: pairs [next, end).
typedef struct PairSink {
    __global CoarsePair* pairs;
    uint capacity;
    __global uint* taken;   // pairs
    __global uint* counts;  // of the polyhedron's segment
    uint segments;
    uint next, end;
} PairSink;

INLINE void add_pair(__private PairSink* sink, uint polyhedron, uint brick, uint lanes) {
    if (!lanes) return;
    if (sink->next == sink->end) {
        sink->next = atomic_add(sink->taken, CLSDF_PAIR_BLOCK);
        sink->end = sink->next + CLSDF_PAIR_BLOCK;
    }
    const uint index = atomic_inc(sink->counts + (size_t)brick * sink->segments);
    if (sink->next < sink->capacity) {
        const CoarsePair pair = {brick, polyhedron, index};
        sink->pairs[sink->next] = pair;
    }
    ++sink->next;
}

#include "coarse_clusters.h"

// Polyhedra [begin, end), one a work-item. `uniform_bounds`: no bound is below the half width. `per_segment`:
// polyhedra. counts and taken are 0 at first.
__kernel void coarse_pairs(Layout layout, uint begin, uint end, __global const Polyhedron* polyhedra,
                           __global const float* bounds, int uniform_bounds, uint per_segment, uint segments,
                           __global uint* counts, __global uint* taken, uint capacity, __global CoarsePair* pairs) {
    const uint polyhedron = begin + get_global_id(0);
    if (polyhedron >= end) return;
    PairSink sink = {pairs, capacity, taken, counts + polyhedron / per_segment, segments, 0, 0};
    float group_bounds[CLSDF_COARSE_GROUP];
    for (uint b = 0; b < CLSDF_COARSE_GROUP; ++b) group_bounds[b] = layout.half_width;
    Cluster cluster;
    find_cluster(layout, polyhedra, polyhedron, 1, &cluster);
    find_pairs(layout, polyhedra, cluster, bounds, uniform_bounds, group_bounds, &sink);
    for (; sink.next != sink.end; ++sink.next)
        if (sink.next < capacity) pairs[sink.next].brick = CLSDF_NO_BRICK;
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
