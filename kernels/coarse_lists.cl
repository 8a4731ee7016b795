// The list of polyhedra of each coarse brick (32 x 32 x 32 samples), by count, scan, fill; for processors.
//
// Each work-item takes a contiguous range of clusters of polyhedra (coarse_clusters.h), a part, and counts into a
// histogram of its own, so that no atomics are needed and the lists are in the order of the polyhedra, whatever the
// number of work-items:
//   starts[brick * parts + part], the scanned counts, is where a part's entries of a brick begin.
// The first pass counts and stores the (cluster, brick) pairs; the second fills the lists from them.

#include "builtins.h"
#include "coarse_clusters.h"
#include "face_sources.h"
#include "shares.h"

// The pairs that a part has found. Pairs beyond the room are counted, but not stored.
typedef struct Found {
    __global ClusterPair* pairs;
    uint room, count;
    __global uint* histogram;  // of the part: a counter for each coarse brick
} Found;

// The first record of cluster c of those that are looked at: all, or the records of `groups`.
INLINE uint first_of_cluster(__global const uint* groups, int has_groups, uint c) {
    const uint n = c * LANES;
    return has_groups ? groups[n / CLSDF_RECORD_GROUP] * CLSDF_RECORD_GROUP + n % CLSDF_RECORD_GROUP : n;
}

// Finds the pairs of a cluster and the `near` bricks of a group that starts at `start`. base: the number of the group's
// first brick in the part, negative if it lies before.
INLINE void find_pairs(Layout layout, __global const Polyhedron* polyhedra, Cluster cluster, int3 start, ulong near,
                       __private const float* bounds, float slack, int base, int2 size, __private Found* found) {
    const ClusterAtGroup at = cluster_at_group(layout, polyhedra, cluster, start, slack);
    for (; near; near &= near - 1) {
        const uint b = lowest_bit_of_long(near);
        const uint lanes = overlapping_lanes(&at, b, bounds[b]);
        const uint brick = (uint)(base + ((int)(b >> 4) * size.y + (int)(b >> 2 & 3u)) * size.x + (int)(b & 3u));
        found->histogram[brick] += popcount(lanes);
        // A pair without lanes is overwritten by the next one: a branch that is hard to predict costs more.
        if (found->count < found->room) {
            const ClusterPair pair = {cluster.first / LANES, brick, lanes};
            found->pairs[found->count] = pair;
        }
        found->count += lanes != 0;
    }
}

// Counts each part's entries of each brick, and finds its pairs. Launch `step` of `steps` takes its share of each
// part. count: of all records; clusters: of those that are looked at. has_groups: those of `groups` are, else all.
// `uniform_bounds`: no bound is below the half width.
__kernel void coarse_count(Layout layout, uint count, uint clusters, __global const Polyhedron* polyhedra,
                           int has_groups, __global const uint* groups, __global const float* bounds,
                           int uniform_bounds, __global const uint* pair_starts, __global ClusterPair* pairs,
                           __global uint* pair_counts, __global uint* histograms, __global uint* counts, uint step,
                           uint steps) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const int3 first = vload3(0, layout.coarse_first), size = vload3(0, layout.coarse_bricks);
    const size_t bricks = coarse_brick_count(layout);
    Found found = {pairs + pair_starts[part], pair_starts[part + 1] - pair_starts[part],
                   step == 0 ? 0 : pair_counts[part], histograms + part * bricks};
    if (step == 0)
        for (size_t brick = 0; brick < bricks; ++brick) found.histogram[brick] = 0;

    const float farthest = layout.half_width + layout.slack_rate * layout.half_width + layout.coarse_slack;
    float group_bounds[CLSDF_COARSE_GROUP];
    float greatest = layout.half_width;
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
                    if (!uniform_bounds)
                        greatest = load_bounds(bounds + coarse_bound_index(layout, x, y, z), group_bounds);
                    const ulong near = near_bricks(layout, cluster, group, group_in_range(group, range), group_bounds);
                    if (!near) continue;
                    const float slack = greatest * layout.slack_rate + layout.coarse_slack;
                    const int base = (relative.z * size.y + relative.y) * size.x + relative.x;
                    find_pairs(layout, polyhedra, cluster, group, near, group_bounds, slack, base, size.xy, &found);
                }
    }
    pair_counts[part] = found.count;
    if (step + 1 == steps)
        for (size_t brick = 0; brick < bricks; ++brick) counts[brick * parts + part] = found.histogram[brick];
}

// Writes the entries. Launch `step` of `steps` takes its share of each part. histograms: a part's next entries.
__kernel void coarse_fill(Layout layout, __global const uint* pair_starts, __global const ClusterPair* pairs,
                          __global const uint* pair_counts, __global const uint* starts, __global uint* histograms,
                          __global uint* entries, uint step, uint steps) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const size_t bricks = coarse_brick_count(layout);
    __global uint* next = histograms + part * bricks;
    if (step == 0)
        for (size_t brick = 0; brick < bricks; ++brick) next[brick] = starts[brick * parts + part];
    const uint count = pair_counts[part], end = share_of(count, step + 1, steps);
    for (uint n = share_of(count, step, steps); n < end; ++n) {
        const ClusterPair pair = pairs[pair_starts[part] + n];
        __global uint* own = next + pair.brick;
        uint entry = *own;
        for (uint rest = pair.lanes; rest; rest &= rest - 1) entries[entry++] = pair.cluster * LANES + lowest_bit(rest);
        *own = entry;
    }
}
