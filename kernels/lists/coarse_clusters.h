// The pairs of polyhedra and coarse bricks that overlap, for both kernel bodies; and bounds of coarse bricks.
//
// A cluster is LANES consecutive polyhedra. In Morton order they are neighbours, so most coarse bricks are too far from
// all of them. Only the rest are tested, each against the cluster's polyhedra, one per lane.
//
// The result of a test depends on the cluster and on a group of 4 x 4 x 4 bricks, never on the part that is computed or
// on how the work is divided: clusters begin at multiples of LANES, and groups where the lattice or the cluster says.
//
// Before the #include, a program defines the struct PairSink, which takes the pairs of a polyhedron and a coarse brick
// that overlap, and add_pair().
#ifndef CLSDF_COARSE_CLUSTERS_H
#define CLSDF_COARSE_CLUSTERS_H

#include "overlap.h"

#if LANES > 1
#include "lane_polyhedra.h"
#endif

typedef struct Cluster {
    uint first, count;  // its polyhedra
    int3 sample;        // of the lattice, near it
    float3 from, to;    // a box around its triangles, in units from the sample
#if LANES > 1
    // Balls around the first `count` triangles. The centres are the feet of the altitudes, from the sample; the radii
    // include their rounding. Lanes from `count` on are padding.
    float x[LANES], y[LANES], z[LANES], radius[LANES];
#endif
} Cluster;

// (By a pointer: for a returned struct oclgrind's compiler writes code that its simulator does not know.)
INLINE void find_cluster(Layout layout, __global const Polyhedron* polyhedra, uint first, uint count,
                         __private Cluster* cluster) {
    cluster->first = first;
    cluster->count = count;
    cluster->sample = vload3(0, &polyhedra[first].origin_x);
    cluster->from = INFINITY;
    cluster->to = -INFINITY;
    const float3 spacing = vload3(0, layout.spacing);
    for (uint n = first; n < first + count; ++n) {
        __global const Polyhedron* p = polyhedra + n;
        const float3 foot =
            convert_float3(sub_sat(vload3(0, &p->origin_x), cluster->sample)) * spacing + vload3(0, p->foot);
        // The base is a triangle's longest edge: the altitude on it is at most sqrt(3) / 2 of it.
        const float right = p->base[CLSDF_HALF_RIGHT], left = p->base[CLSDF_HALF_LEFT];
        const float radius = GREATER(GREATER(right, left), 0.8661f * (right + left));
        cluster->from = LESSER(cluster->from, foot - radius);
        cluster->to = GREATER(cluster->to, foot + radius);
#if LANES > 1
        cluster->x[n - first] = foot.x;
        cluster->y[n - first] = foot.y;
        cluster->z[n - first] = foot.z;
        cluster->radius[n - first] = radius + 1.0e-5f * (fabs(foot.x) + fabs(foot.y) + fabs(foot.z) + radius);
#endif
    }
    const float3 rounding = 1.0e-5f * (fabs(cluster->from) + fabs(cluster->to));
    cluster->from -= rounding;
    cluster->to += rounding;
}

// floor(origin + offset), clamped; values outside the lattice's indices (below 2^30) stay outside.
INLINE int3 index_below(int3 origin, float3 offset) {
    const float3 limited = clamp(offset, -2.0e9f, 2.0e9f);
    const int3 truncated = convert_int3(limited);
    const int3 below = truncated + (convert_float3(truncated) > limited);  // true is -1
    return clamp(add_sat(origin, below), (int3)(-0x7FFFFF00), (int3)(0x7FFFFF00));
}

// The coarse bricks of the lattice within `distance` of the cluster's box; limits included.
typedef struct CoarseRange {
    int3 low, high;
} CoarseRange;

INLINE CoarseRange bricks_within(Layout layout, Cluster cluster, float distance) {
    const float3 per_sample = 1.0f / vload3(0, layout.spacing);
    CoarseRange range;
    range.low = (index_below(cluster.sample, (cluster.from - distance) * per_sample) - (CLSDF_COARSE - 1)) >> 5;
    range.high = (index_below(cluster.sample, (cluster.to + distance) * per_sample) + 1) >> 5;
    return range;
}

// Bits 0 to 3: which of four neighbours that start at `base` lie in [low, high].
INLINE uint four_in_range(int base, int low, int high) {
    const int begin = max(low - base, 0), end = min(high - base, 3);
    return begin > end ? 0u : (0xFu >> (3 - end)) & (0xFu << begin);
}

// The bricks of a group that starts at `start` that lie in the range: bit b is brick x = b & 3, y = b >> 2 & 3,
// z = b >> 4.
INLINE ulong group_in_range(int3 start, CoarseRange range) {
    const uint in_x = four_in_range(start.x, range.low.x, range.high.x),
               in_y = four_in_range(start.y, range.low.y, range.high.y),
               in_z = four_in_range(start.z, range.low.z, range.high.z);
    const uint rows =
        (in_y & 1u) * 0xFu | (in_y >> 1 & 1u) * 0xF0u | (in_y >> 2 & 1u) * 0xF00u | (in_y >> 3 & 1u) * 0xF000u;
    const ulong slice = in_x * 0x1111u & rows;
    return (in_z & 1u) * slice | (in_z >> 1 & 1u) * (slice << 16) | (in_z >> 2 & 1u) * (slice << 32) |
           (in_z >> 3 & 1u) * (slice << 48);
}

// The gap between two intervals, from the distance of their middles and half the sum of their lengths.
INLINE floatL gap_between(floatL middles, float half_lengths) {
    const floatL gap = fabs(middles) - half_lengths;
    return GREATER(gap, (floatL)0.0f);
}

// The centre of a group's first brick, from the cluster's sample, in units.
INLINE float3 first_centre(Layout layout, Cluster cluster, int3 start) {
    return (convert_float3(start * CLSDF_COARSE - cluster.sample) + COARSE_CENTRE) * vload3(0, layout.spacing);
}

// Selects the `wanted` bricks of a group that may have a sample within the brick's bound of the cluster.
INLINE ulong near_bricks(Layout layout, Cluster cluster, int3 start, ulong wanted, __private const float* bounds) {
    const float3 spacing = vload3(0, layout.spacing), side = CLSDF_COARSE * spacing;
    const float3 half_lengths = 0.5f * (cluster.to - cluster.from) + COARSE_CENTRE * spacing;
    const float3 middles = first_centre(layout, cluster, start) - 0.5f * (cluster.from + cluster.to);
    ulong near = 0;
    for (uint first = 0; first < CLSDF_COARSE_GROUP; first += LANES) {
        if ((wanted >> first & LANE_BITS) == 0) continue;
        const uintL block = LANE_NUMBERS + first;
        const floatL x = gap_between(convert_floatL(block & 3u) * side.x + middles.x, half_lengths.x),
                     y = gap_between(convert_floatL(block >> 2 & 3u) * side.y + middles.y, half_lengths.y),
                     z = gap_between(convert_floatL(block >> 4) * side.z + middles.z, half_lengths.z);
        const floatL far = load_lanes(0, bounds + first) + layout.coarse_slack;
        near |= (ulong)lanes_to_bits((x * x + y * y + z * z) * (1.0f - 1.0e-5f) <= far * far) << first;
    }
    return near & wanted;
}

// The cluster's polyhedra at a group of coarse bricks.
#if LANES == 1
typedef struct ClusterAtGroup {
    __global const Polyhedron* polyhedron;
    FramePosition position;
    Extent extent;
} ClusterAtGroup;

INLINE ClusterAtGroup cluster_at_group(Layout layout, __global const Polyhedron* polyhedra, Cluster cluster, int3 start,
                                       float slack) {
    ClusterAtGroup at;
    at.polyhedron = polyhedra + cluster.first;
    at.position = frame_position_at(at.polyhedron, start.x * CLSDF_COARSE, start.y * CLSDF_COARSE,
                                    start.z * CLSDF_COARSE, 2.0f * CLSDF_COARSE - 0.5f);
    at.extent = widened(extent_of_cube(at.polyhedron, COARSE_CENTRE), slack);
    return at;
}

// Bit l: whether polyhedron l overlaps brick b of the group.
INLINE uint overlapping_lanes(const ClusterAtGroup* at, uint b, float bound) {
    const float i = ((float)(b & 3u) - 1.5f) * CLSDF_COARSE, j = ((float)(b >> 2 & 3u) - 1.5f) * CLSDF_COARSE,
                k = ((float)(b >> 4) - 1.5f) * CLSDF_COARSE;
    return overlapped_blocks(at->polyhedron, at->position, centres_of(at->polyhedron, at->position, i, j, k),
                             at->extent, bound);
}
#else
typedef struct ClusterAtGroup {
    LanePolyhedra polyhedra;
    PlaneDistances first;    // at the centre of the group's first brick, without extent
    LaneExtent extent;       // of a coarse brick, with slack
    floatL x, y, z, radius;  // of the balls, from there
    float3 side;             // of a coarse brick, in units
    uint lanes;
} ClusterAtGroup;

INLINE ClusterAtGroup cluster_at_group(Layout layout, __global const Polyhedron* polyhedra, Cluster cluster, int3 start,
                                       float slack) {
    uint numbers[LANES];
    for (uint lane = 0; lane < LANES; ++lane) numbers[lane] = cluster.first + min(lane, cluster.count - 1);
    const LanePolyhedra p = lane_polyhedra(polyhedra, numbers, start * CLSDF_COARSE, COARSE_CENTRE);
    ClusterAtGroup at;
    at.polyhedra = p;
    at.extent = extent_of_lanes(&p, COARSE_CENTRE, COARSE_CENTRE, COARSE_CENTRE, slack);
    at.first = without_extent(p.at, &at.extent);
    at.side = CLSDF_COARSE * vload3(0, layout.spacing);
    const float3 centre = first_centre(layout, cluster, start);
    at.x = load_lanes(0, cluster.x) - centre.x;
    at.y = load_lanes(0, cluster.y) - centre.y;
    at.z = load_lanes(0, cluster.z) - centre.z;
    at.radius = load_lanes(0, cluster.radius) + layout.coarse_slack;
    at.lanes = (1u << cluster.count) - 1;
    return at;
}

// Bit l: whether polyhedron l overlaps brick b of the group: by the distance of its triangle's ball, and by the planes
// that bound it.
INLINE uint overlapping_lanes(const ClusterAtGroup* at, uint b, float bound) {
    const LanePolyhedra* p = &at->polyhedra;
    const float bx = (float)(b & 3u), by = (float)(b >> 2 & 3u), bz = (float)(b >> 4);
    const float half_side = COARSE_CENTRE / CLSDF_COARSE;
    const floatL x = gap_between(at->x - bx * at->side.x, half_side * at->side.x),
                 y = gap_between(at->y - by * at->side.y, half_side * at->side.y),
                 z = gap_between(at->z - bz * at->side.z, half_side * at->side.z);
    const floatL far = at->radius + bound;
    const intL near = (x * x + y * y + z * z) * (1.0f - 1.0e-5f) <= far * far;

    const float i = bx * CLSDF_COARSE, j = by * CLSDF_COARSE, k = bz * CLSDF_COARSE;
#define AT(plane) (i * p->step_x.plane + (j * p->step_y.plane + (k * p->step_z.plane + at->first.plane)))
    const PlaneDistances brick = {AT(z), AT(base), AT(right), AT(left)};
#undef AT
    floatL slopes[3];
    slopes_at(p, brick.z, at->extent.z, slopes);
    return at->lanes & lanes_to_bits(near & overlaps(p, brick, slopes, &at->extent, bound));
}
#endif

// A group's bounds, and the greatest of them.
INLINE float load_bounds(__global const float* bounds, __private float* group_bounds) {
    floatL greatest = 0.0f;
    for (uint v = 0; v < CLSDF_COARSE_GROUP / LANES; ++v) {
        const floatL values = load_lanes(v, bounds);
        store_lanes(values, v, group_bounds);
        greatest = GREATER(greatest, values);
    }
    return greatest_lane(greatest);
}

INLINE size_t coarse_brick_count(Layout layout) {
    return (size_t)layout.coarse_bricks[0] * layout.coarse_bricks[1] * layout.coarse_bricks[2];
}

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

// An upper bound of the distances in a coarse brick: the least, over a sample of surface points, of the distance to the
// brick's farthest sample. (Bricks find finer bounds.) A work-item computes LANES columns of four bricks along z of a
// group, including bricks beyond the part, so a group has the same bounds in every part.
__kernel void coarse_bounds(Layout layout, uint count, __global const SurfacePoint* points, __global float* bounds,
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
        store_lanes(LESSER(bound, layout.half_width), (number * 4 + layer) * items + item % items, bounds);
    }
}

#endif
