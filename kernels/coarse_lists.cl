// The list of polyhedra of each coarse brick (32 x 32 x 32 samples), by count, scan, fill.
//
// Each work-item takes a contiguous range of clusters of polyhedra (coarse_clusters.h), a part, and counts into a
// histogram of its own, so that no atomics are needed and the lists are in the order of the polyhedra, whatever the
// number of work-items:
//   starts[brick * parts + part], the scanned counts, is where a part's entries of a brick begin.
// What touches what is found once, by counting, and kept for filling.

#include "coarse.h"
#include "coarse_clusters.h"
#include "request.h"

// An upper bound of the distance to the mesh for every sample of a coarse brick: how far from it the nearest of some of
// the surface's points is, taken at the sample that is farthest from that point. (A coarse bound is enough here, the
// bricks find finer ones.) One work-item LANES columns of four bricks along z of a group, those beyond the part too, so
// that a group's bounds are the same in every part.
__kernel void coarse_caps(Layout layout, uint count, __global const SurfacePoint* points, __global float* caps,
                          uint first) {
    const uint item = first + get_global_id(0), items = CLSDF_COARSE_COLUMNS / LANES;
    const int number = item / items;
    const int groups_x = coarse_groups(layout, 0), groups_y = coarse_groups(layout, 1);
    const int3 group = 4 * (int3)(first_coarse_group(layout, 0) + number % groups_x,
                                  first_coarse_group(layout, 1) + number / groups_x % groups_y,
                                  first_coarse_group(layout, 2) + number / (groups_x * groups_y));
    const uintL column = LANE_NUMBERS + item % items * LANES;
    const float3 spacing = vload3(0, layout.spacing), half_side = COARSE_CENTRE * spacing;
    const floatL side_x = convert_floatL(column & 3u) * (CLSDF_COARSE * spacing.x),
                 side_y = convert_floatL(column >> 2) * (CLSDF_COARSE * spacing.y);
    floatL least[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
    for (uint i = 0; i < count; ++i) {
        const int3 offset = group * CLSDF_COARSE - vload3(0, points[i].origin);
        const float3 from_foot = (convert_float3(offset) + COARSE_CENTRE) * spacing - vload3(0, points[i].foot);
        const floatL x = fabs(side_x + from_foot.x) + half_side.x, y = fabs(side_y + from_foot.y) + half_side.y;
        const floatL across = x * x + y * y;
#pragma unroll
        for (uint layer = 0; layer < 4; ++layer) {
            const float z = fabs((float)layer * (CLSDF_COARSE * spacing.z) + from_foot.z) + half_side.z;
            const floatL squared = across + z * z;
            least[layer] = LESSER(least[layer], squared);
        }
    }
#pragma unroll
    for (uint layer = 0; layer < 4; ++layer) {
        const floatL bound = sqrt(least[layer]) * (1.0f + 1.0e-5f) + layout.coarse_slack;
        store_lanes(LESSER(bound, layout.half_width), (number * 4 + layer) * items + item % items, caps);
    }
}

// A part's counter, or next entry, of each coarse brick. Those of work-items that run side by side on a GPU lie beside
// each other; the cores of a processor would write to the same lines of memory.
typedef struct Histogram {
    __global uint* first;
    size_t stride;
} Histogram;

INLINE Histogram histogram_of(__global uint* histograms, size_t bricks, uint part, uint parts) {
#if LANES == 1
    const Histogram histogram = {histograms + part, parts};
#else
    const Histogram histogram = {histograms + part * bricks, 1};
#endif
    return histogram;
}

INLINE size_t coarse_brick_count(Layout layout) {
    return (size_t)layout.coarse_bricks[0] * layout.coarse_bricks[1] * layout.coarse_bricks[2];
}

INLINE uint share_of(uint count, uint number, uint numbers) {
    return (uint)((ulong)count * number / numbers);
}

// A group's caps, and the greatest of them.
INLINE float load_caps(__global const float* caps, __private float* group_caps) {
    floatL greatest = 0.0f;
    for (uint v = 0; v < CLSDF_COARSE_GROUP / LANES; ++v) {
        const floatL some = load_lanes(v, caps);
        store_lanes(some, v, group_caps);
        greatest = GREATER(greatest, some);
    }
    return greatest_lane(greatest);
}

// What a part has found: `count` touches, of which those are kept that there is room for.
typedef struct Found {
    __global Touch* touches;
    uint room, count;
    Histogram histogram;
} Found;

// Of a cluster and those bricks of a group, which starts at `start`, that are `near`. base: the number of the group's
// first brick in the part, negative if it lies before.
INLINE void find_touches(Layout layout, __global const Polyhedron* polyhedra, Cluster cluster, int3 start, ulong near,
                         __private const float* caps, float slack, int base, int2 size, __private Found* found) {
    const ClusterAtGroup at = cluster_at_group(layout, polyhedra, cluster, start, slack);
    for (; near; near &= near - 1) {
        const uint b = lowest_bit_of_long(near);
        const uint lanes = touching_lanes(&at, b, caps[b]);
        const uint brick = (uint)(base + ((int)(b >> 4) * size.y + (int)(b >> 2 & 3u)) * size.x + (int)(b & 3u));
        found->histogram.first[brick * found->histogram.stride] += popcount(lanes);
        // What touches nothing is overwritten: a branch that cannot be foreseen costs more.
        if (found->count < found->room) {
            const Touch touch = {cluster.first / LANES, brick, lanes};
            found->touches[found->count] = touch;
        }
        found->count += lanes != 0;
    }
}

// Counts each part's entries of each brick, and finds its touches. Launch `step` of `steps` takes its share of each
// part. `uniform_caps`: no cap is below the half width.
__kernel void coarse_count(Layout layout, uint count, __global const Polyhedron* polyhedra, __global const float* caps,
                           int uniform_caps, __global const uint* touch_starts, __global Touch* touches,
                           __global uint* touch_counts, __global uint* histograms, __global uint* counts, uint step,
                           uint steps) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const int3 first = vload3(0, layout.coarse_first), size = vload3(0, layout.coarse_bricks);
    const size_t bricks = coarse_brick_count(layout);
    Found found = {touches + touch_starts[part], touch_starts[part + 1] - touch_starts[part],
                   step == 0 ? 0 : touch_counts[part], histogram_of(histograms, bricks, part, parts)};
    if (step == 0)
        for (size_t brick = 0; brick < bricks; ++brick) found.histogram.first[brick * found.histogram.stride] = 0;

    const float reach = layout.half_width + layout.slack_rate * layout.half_width + layout.coarse_slack;
    float group_caps[CLSDF_COARSE_GROUP];
    float greatest = layout.half_width;
    for (uint v = 0; v < CLSDF_COARSE_GROUP / LANES; ++v) store_lanes((floatL)layout.half_width, v, group_caps);

    const uint clusters = (count + LANES - 1) / LANES;
    const uint begin = share_of(clusters, part, parts), own = share_of(clusters, part + 1, parts) - begin;
    const uint end = begin + share_of(own, step + 1, steps);
    for (uint c = begin + share_of(own, step, steps); c < end; ++c) {
        for (uint lane = 0; lane < LANES; ++lane) request(polyhedra + min((c + 2) * LANES + lane, count - 1));
        Cluster cluster;
        find_cluster(layout, polyhedra, c * LANES, min(count - c * LANES, (uint)LANES), &cluster);
        CoarseRange range = bricks_within(layout, cluster, reach);
        // Groups begin with the range, or, where each brick has its own cap, where the caps' groups do.
        int3 start = uniform_caps ? range.low : range.low & ~3;
        range.low = max(range.low, first);
        range.high = min(range.high, first + size - 1);
        start += (max(start, first) - start) & ~3;
        for (int z = start.z; z <= range.high.z; z += 4)
            for (int y = start.y; y <= range.high.y; y += 4)
                for (int x = start.x; x <= range.high.x; x += 4) {
                    const int3 group = (int3)(x, y, z), relative = group - first;
                    if (!uniform_caps) greatest = load_caps(caps + coarse_cap_place(layout, x, y, z), group_caps);
                    const ulong near = near_bricks(layout, cluster, group, group_in_range(group, range), group_caps);
                    if (!near) continue;
                    const float slack = greatest * layout.slack_rate + layout.coarse_slack;
                    const int base = (relative.z * size.y + relative.y) * size.x + relative.x;
                    find_touches(layout, polyhedra, cluster, group, near, group_caps, slack, base, size.xy, &found);
                }
    }
    touch_counts[part] = found.count;
    if (step + 1 == steps)
        for (size_t brick = 0; brick < bricks; ++brick)
            counts[brick * parts + part] = found.histogram.first[brick * found.histogram.stride];
}

// Writes the entries. Launch `step` of `steps` takes its share of each part. histograms: a part's next entries.
__kernel void coarse_fill(Layout layout, __global const uint* touch_starts, __global const Touch* touches,
                          __global const uint* touch_counts, __global const uint* starts, __global uint* histograms,
                          __global uint* entries, uint step, uint steps) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const size_t bricks = coarse_brick_count(layout);
    const Histogram next = histogram_of(histograms, bricks, part, parts);
    if (step == 0)
        for (size_t brick = 0; brick < bricks; ++brick) next.first[brick * next.stride] = starts[brick * parts + part];
    const uint count = touch_counts[part], end = share_of(count, step + 1, steps);
    for (uint n = share_of(count, step, steps); n < end; ++n) {
        const Touch touch = touches[touch_starts[part] + n];
        __global uint* own = next.first + touch.brick * next.stride;
        uint entry = *own;
        for (uint rest = touch.lanes; rest; rest &= rest - 1)
            entries[entry++] = touch.cluster * LANES + lowest_bit(rest);
        *own = entry;
    }
}
