// The list of polyhedra of each coarse brick (32 x 32 x 32 samples), by count, scan, fill; for processors.
//
// Each work-item takes a contiguous range of clusters of polyhedra (coarse_clusters.h), a part, and counts into a
// histogram of its own, so that no atomics are needed and the lists are in the order of the polyhedra, whatever the
// number of work-items:
//   starts[brick * parts + part], the scanned counts, is where a part's entries of a brick begin.
// The first pass counts and stores the (cluster, brick) pairs; the second fills the lists from them.
//
// A part's counters are a row of `histograms`. Loops over them run from row_begin to row_end, not from 0. PoCL 7.0 and
// 7.1 insert barriers into an innermost loop that all work-items enter and run alike; in a branch, that makes wrong
// code (docs/devices.md).

#include "coarse.h"
#include "shares.h"
#include "simd.h"

// The pairs that a part has found. Pairs beyond the room are counted, but not stored.
typedef struct PairSink {
    __global ClusterPair* pairs;
    uint room, count;
    __global uint* histogram;  // of the part: a counter for each coarse brick
} PairSink;

// The first record of cluster c of those that are looked at: all, or the records of `groups`.
INLINE uint first_of_cluster(__global const uint* groups, int has_groups, uint c) {
    const uint n = c * LANES;
    return has_groups ? groups[n / CLSDF_RECORD_GROUP] * CLSDF_RECORD_GROUP + n % CLSDF_RECORD_GROUP : n;
}

// Adds the pairs of a brick and the cluster's polyhedra in `lanes`. The next pair overwrites one without lanes: a
// branch that is hard to predict costs more.
INLINE void add_pair(__private PairSink* sink, uint polyhedron, uint brick, uint lanes) {
    sink->histogram[brick] += popcount(lanes);
    if (sink->count < sink->room) {
        const ClusterPair pair = {polyhedron / LANES, brick, lanes};
        sink->pairs[sink->count] = pair;
    }
    sink->count += lanes != 0;
}

#include "coarse_clusters.h"

// Counts each part's entries of each brick, and finds its pairs. Launch `step` of `steps` takes its share of each
// part. count: of all records; clusters: of those that are looked at. has_groups: those of `groups` are, else all.
// `uniform_bounds`: no bound is below the half width.
__kernel void coarse_count(Layout layout, uint count, uint clusters, __global const Polyhedron* polyhedra,
                           int has_groups, __global const uint* groups, __global const float* bounds,
                           int uniform_bounds, __global const uint* pair_starts, __global ClusterPair* pairs,
                           __global uint* pair_counts, __global uint* histograms, __global uint* counts, uint step,
                           uint steps) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const size_t bricks = coarse_brick_count(layout);
    const size_t row_begin = part * bricks, row_end = row_begin + bricks;
    PairSink sink = {pairs + pair_starts[part], pair_starts[part + 1] - pair_starts[part],
                     step == 0 ? 0 : pair_counts[part], histograms + row_begin};
    if (step == 0)
        for (size_t n = row_begin; n < row_end; ++n) histograms[n] = 0;

    float group_bounds[CLSDF_COARSE_GROUP];
    for (uint v = 0; v < CLSDF_COARSE_GROUP / LANES; ++v) store_lanes((floatL)layout.half_width, v, group_bounds);

    const uint begin = share_of(clusters, part, parts), own = share_of(clusters, part + 1, parts) - begin;
    const uint end = begin + share_of(own, step + 1, steps);
    for (uint c = begin + share_of(own, step, steps); c < end; ++c) {
        const uint ahead = first_of_cluster(groups, has_groups, min(c + 2, clusters - 1));
        for (uint lane = 0; lane < LANES; ++lane) prefetch_record(polyhedra + min(ahead + lane, count - 1));
        const uint n = first_of_cluster(groups, has_groups, c);
        if (n >= count) continue;  // the last group may have fewer records
        Cluster cluster;
        find_cluster(layout, polyhedra, n, min(count - n, (uint)LANES), &cluster);
        find_pairs(layout, polyhedra, cluster, bounds, uniform_bounds, group_bounds, &sink);
    }
    pair_counts[part] = sink.count;
    if (step + 1 == steps)
        for (size_t n = row_begin; n < row_end; ++n) counts[(n - row_begin) * parts + part] = histograms[n];
}

// Writes the entries. Launch `step` of `steps` takes its share of each part. histograms: a part's next entries.
__kernel void coarse_fill(Layout layout, __global const uint* pair_starts, __global const ClusterPair* pairs,
                          __global const uint* pair_counts, __global const uint* starts, __global uint* histograms,
                          __global uint* entries, uint step, uint steps) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const size_t bricks = coarse_brick_count(layout);
    const size_t row_begin = part * bricks, row_end = row_begin + bricks;
    if (step == 0)
        for (size_t n = row_begin; n < row_end; ++n) histograms[n] = starts[(n - row_begin) * parts + part];
    const uint count = pair_counts[part], end = share_of(count, step + 1, steps);
    for (uint n = share_of(count, step, steps); n < end; ++n) {
        const ClusterPair pair = pairs[pair_starts[part] + n];
        __global uint* own = histograms + row_begin + pair.brick;
        uint entry = *own;
        for (uint rest = pair.lanes; rest; rest &= rest - 1) entries[entry++] = pair.cluster * LANES + lowest_bit(rest);
        *own = entry;
    }
}
