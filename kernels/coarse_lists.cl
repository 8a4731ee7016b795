// The list of polyhedra of each coarse brick (32 x 32 x 32 samples), by count, scan, fill.
//
// Each work-item takes a contiguous range of polyhedra, a part, and counts into a histogram of its own, so that no
// atomics are needed and the lists are in the order of the polyhedra, whatever the number of work-items:
//   starts[brick * parts + part], the scanned counts, is where a part's entries of a brick begin.

#include "blocks.h"
#include "coarse.h"

// Every `stride`-th polyhedron's point.
__kernel void coarse_points(uint stride, uint count, __global const Polyhedron* polyhedra,
                            __global SurfacePoint* points) {
    const uint n = get_global_id(0);
    if (n >= count) return;
    __global const Polyhedron* p = polyhedra + (size_t)n * stride;
    points[n].origin[0] = p->origin_x;
    points[n].origin[1] = p->origin_y;
    points[n].origin[2] = p->origin_z;
    vstore3(vload3(0, p->foot), 0, points[n].foot);
}

// The first group of 4 x 4 x 4 coarse bricks that overlaps the part, and how many do.
INLINE int3 first_group(Layout layout) {
    return vload3(0, layout.coarse_first) >> 2;
}

INLINE int3 group_counts(Layout layout) {
    return ((vload3(0, layout.coarse_first) + vload3(0, layout.coarse_bricks) - 1) >> 2) - first_group(layout) + 1;
}

// An upper bound of the distance to the mesh for every sample of a coarse brick: the distance of its centre to the
// nearest of some of the surface's points, and the brick's radius. (A coarse bound is enough here, the bricks find
// finer ones.) One work-item LANES bricks of a group of 4 x 4 x 4, those beyond the part too, so that a group's bounds
// are the same in every part.
__kernel void coarse_caps(Layout layout, uint count, __global const SurfacePoint* points, __global float* caps,
                          uint first) {
    const uint vector = first + get_global_id(0);
    const int3 groups = group_counts(layout), start = first_group(layout);
    const int number = vector / (64 / LANES);
    const int3 group = (start + (int3)(number % groups.x, number / groups.x % groups.y, number / (groups.x * groups.y)))
                       << 2;
    const uintL block = LANE_NUMBERS + vector % (64 / LANES) * LANES;
    const float3 spacing = vload3(0, layout.spacing);
    const floatL side_x = convert_floatL(block & 3u) * (CLSDF_COARSE * spacing.x),
                 side_y = convert_floatL((block >> 2) & 3u) * (CLSDF_COARSE * spacing.y),
                 side_z = convert_floatL(block >> 4) * (CLSDF_COARSE * spacing.z);
    floatL least = INFINITY;
    for (uint i = 0; i < count; ++i) {
        const int3 offset = group * CLSDF_COARSE - vload3(0, points[i].origin);
        const float3 from_foot =
            (convert_float3(offset) + 0.5f * (CLSDF_COARSE - 1)) * spacing - vload3(0, points[i].foot);
        const floatL x = side_x + from_foot.x, y = side_y + from_foot.y, z = side_z + from_foot.z;
        const floatL squared = x * x + y * y + z * z;
        least = LESSER(least, squared);
    }
    const floatL bound = sqrt(least) * (1.0f + 1.0e-5f) + (layout.coarse_radius + layout.coarse_slack);
    store_lanes(LESSER(bound, layout.half_width), vector, caps);
}

// The largest integer not above the value; beyond the lattice's indices, which are below 2^30, a number that is too.
INLINE int3 index_below(int3 origin, float3 offset) {
    const float3 limited = clamp(offset, -2.0e9f, 2.0e9f);
    const int3 truncated = convert_int3(limited);
    const int3 below = truncated + (convert_float3(truncated) > limited);  // true is -1
    return clamp(add_sat(origin, below), (int3)(-0x7FFFFF00), (int3)(0x7FFFFF00));
}

// The coarse bricks of the lattice that the box of the triangle, enlarged by the half width, overlaps; limits included.
// The answer does not depend on the part that is computed.
INLINE void box_range(Layout layout, __global const Polyhedron* p, float reach, __private int3* low,
                      __private int3* high) {
    // Along an axis the frame's unit vectors are its gradients divided by the spacing.
    const float3 per_sample = 1.0f / vload3(0, layout.spacing);
    const float3 along_x = (float3)(p->gradient_x[0], p->gradient_y[0], p->gradient_z[0]) * per_sample,
                 along_y = (float3)(p->gradient_x[1], p->gradient_y[1], p->gradient_z[1]) * per_sample;
    const float3 right = along_x * p->base[CLSDF_HALF_RIGHT], left = along_x * -p->base[CLSDF_HALF_LEFT],
                 apex = along_y * (float)p->exact_altitude, foot = vload3(0, p->foot);
    const float3 margin = reach + 1.0e-5f * (fabs(right) + fabs(left) + fabs(apex) + fabs(foot));
    const float3 least = LESSER(LESSER(right, left), apex), greatest = GREATER(GREATER(right, left), apex);
    const int3 origin = (int3)(p->origin_x, p->origin_y, p->origin_z);
    *low = (index_below(origin, (foot + least - margin) * per_sample) - (CLSDF_COARSE - 1)) >> 5;
    *high = (index_below(origin, (foot + greatest + margin) * per_sample) + 1) >> 5;
}

// Bits 0 to 3: which of four neighbours that start at `base` lie in [low, high].
INLINE uint four_in_range(int base, int low, int high) {
    const int begin = max(low - base, 0), end = min(high - base, 3);
    return begin > end ? 0u : (0xFu >> (3 - end)) & (0xFu << begin);
}

// The blocks of a group of 4 x 4 x 4 that starts at `start` that lie in [low, high], as touched_group numbers them.
INLINE ulong group_in_range(int3 start, int3 low, int3 high) {
    const uint in_x = four_in_range(start.x, low.x, high.x), in_y = four_in_range(start.y, low.y, high.y),
               in_z = four_in_range(start.z, low.z, high.z);
    const uint rows =
        (in_y & 1u) * 0xFu | (in_y >> 1 & 1u) * 0xF0u | (in_y >> 2 & 1u) * 0xF00u | (in_y >> 3 & 1u) * 0xF000u;
    const ulong slice = in_x * 0x1111u & rows;
    return (in_z & 1u) * slice | (in_z >> 1 & 1u) * (slice << 16) | (in_z >> 2 & 1u) * (slice << 32) |
           (in_z >> 3 & 1u) * (slice << 48);
}

// The blocks of a group of 4 x 4 x 4 coarse bricks, which starts at `start`, that a polyhedron touches, of those that
// are wanted. caps: one a block; `greatest` is the greatest of them.
INLINE ulong touched_coarse_bricks(Layout layout, __global const Polyhedron* p, __private const float* caps,
                                   float greatest, int3 start, ulong wanted) {
    // First by distance alone, which most pairs of a wide band do not pass: no point of the triangle is farther from
    // the foot of its altitude than `extent`.
    const float extent = GREATER(GREATER(p->base[0], p->base[1]), (float)p->exact_altitude) * (1.0f + 1.0e-5f);
    const float beyond = extent + layout.coarse_radius + layout.coarse_slack;
    const float3 from_foot = from_foot_to(layout, p, start.x * CLSDF_COARSE, start.y * CLSDF_COARSE,
                                          start.z * CLSDF_COARSE, 0.5f * (CLSDF_COARSE - 1));
    const float3 side = CLSDF_COARSE * vload3(0, layout.spacing);
    const floatL lane_x = convert_floatL(LANE_NUMBERS & 3u) * side.x + from_foot.x,
                 lane_y = convert_floatL(LANE_NUMBERS >> 2 & 3u) * side.y + from_foot.y;
    ulong near = 0;
    for (uint first = 0; first < 64; first += LANES) {
        if (!(wanted >> first & LANE_BITS)) continue;
        const floatL x = lane_x + (float)(first & 3u) * side.x, y = lane_y + (float)(first >> 2 & 3u) * side.y;
        const float z = (float)(first >> 4) * side.z + from_foot.z;
        const floatL reach = load_lanes(0, caps + first) + beyond;
        near |= (ulong)lanes_to_bits((x * x + y * y + z * z) * (1.0f - 1.0e-5f) <= reach * reach) << first;
    }
    wanted &= near;
    if (wanted == 0) return 0;
    return touched_group(p, start.x * CLSDF_COARSE, start.y * CLSDF_COARSE, start.z * CLSDF_COARSE, CLSDF_COARSE,
                         wanted, caps, greatest * layout.slack_rate + layout.coarse_slack);
}

// Touches of one group that wait to be counted, or written to the lists, together: neighbours in the order of the
// polyhedra touch the same bricks.
typedef struct Held {
    uint polyhedra[LANES], low[LANES], high[LANES];  // of a touch: the polyhedron, and the bricks' bits
    uint count;
    int base;
    ulong bricks;  // of any
} Held;

INLINE void hold_none(__private Held* held) {
    store_lanes((uintL)0u, 0, held->low);
    store_lanes((uintL)0u, 0, held->high);
    held->count = 0;
    held->bricks = 0;
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

// Counts the bricks of the touches that are held, or, with `fill`, writes the polyhedra to their lists.
INLINE void add_held(__private Held* held, int3 size, Histogram next, int fill, __global uint* entries) {
    const uintL low = load_lanes(0, held->low), high = load_lanes(0, held->high);
    for (ulong rest = held->bricks; rest; rest &= rest - 1) {
        const int b = 63 - (int)clz(rest & (0 - rest));
        const int brick = held->base + ((b >> 4) * size.y + (b >> 2 & 3)) * size.x + (b & 3);
        uint touching = lanes_to_bits((((b < 32 ? low : high) >> (uint)(b & 31)) & 1u) != 0u);
        __global uint* own = next.first + brick * next.stride;
        uint slot = *own;
        *own = slot + popcount(touching);
        if (!fill) continue;
        for (; touching; touching &= touching - 1)
            entries[slot++] = held->polyhedra[31 - (int)clz(touching & (0 - touching))];
    }
    hold_none(held);
}

INLINE void add_touch(__private Held* held, Touch touch, int3 size, Histogram next, int fill, __global uint* entries) {
    // In a thin part the bits of groups that lie apart may mean the same brick, where their bases are the same; one
    // touch at a time keeps the lists in order there.
    const uint room = min(size.x, size.y) < 4 ? 1 : LANES;
    if (held->count >= room || held->base != touch.base) add_held(held, size, next, fill, entries);
    held->base = touch.base;
    held->polyhedra[held->count] = touch.polyhedron;
    held->low[held->count] = (uint)touch.bricks;
    held->high[held->count] = (uint)(touch.bricks >> 32);
    held->bricks |= touch.bricks;
    ++held->count;
}

// A group's caps, and the greatest of them.
INLINE float load_caps(__global const float* caps, __private float* group_caps) {
    floatL greatest = 0.0f;
    for (uint v = 0; v < 64 / LANES; ++v) {
        const floatL some = load_lanes(v, caps);
        store_lanes(some, v, group_caps);
        greatest = GREATER(greatest, some);
    }
    return greatest_lane(greatest);
}

INLINE uint share_of(uint count, uint number, uint numbers) {
    return (uint)((ulong)count * number / numbers);
}

// With `fill` 0 it counts each part's pairs, and keeps the first `capacity` of its touches. With 1 it writes the
// entries: from the touches that were kept, or, where they were too many, from the test again. Launch `step` of `steps`
// takes its share of each part. `uniform_caps`: no cap is below the half width. histograms: a part's counters or next
// entries.
__kernel void coarse_lists(Layout layout, uint count, __global const Polyhedron* polyhedra, __global const float* caps,
                           int uniform_caps, __global uint* histograms, __global uint* counts,
                           __global const uint* starts, __global uint* entries, uint capacity, __global Touch* touches,
                           __global uint* touch_counts, int fill, uint step, uint steps) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const int3 first = vload3(0, layout.coarse_first), size = vload3(0, layout.coarse_bricks);
    const size_t bricks = (size_t)size.x * size.y * size.z;
    const Histogram next = histogram_of(histograms, bricks, part, parts);
    if (step == 0)
        for (size_t brick = 0; brick < bricks; ++brick)
            next.first[brick * next.stride] = fill ? starts[brick * parts + part] : 0;

    Held held;
    held.base = 0;
    hold_none(&held);
    __global Touch* own = touches + (size_t)part * capacity;
    if (fill && touch_counts[part] <= capacity) {
        const uint end = share_of(touch_counts[part], step + 1, steps);
        for (uint n = share_of(touch_counts[part], step, steps); n < end; ++n)
            add_touch(&held, own[n], size, next, fill, entries);
        add_held(&held, size, next, fill, entries);
        return;
    }
    const uint part_begin = share_of(count, part, parts), part_count = share_of(count, part + 1, parts) - part_begin;
    const uint end = part_begin + share_of(part_count, step + 1, steps);
    const float reach = layout.half_width + layout.slack_rate * layout.half_width + layout.coarse_slack;
    float group_caps[64];
    float greatest = layout.half_width;
    for (uint v = 0; v < 64 / LANES; ++v) store_lanes((floatL)layout.half_width, v, group_caps);

    uint n = step == 0 ? 0 : touch_counts[part];
    // Where each brick has its own cap, neighbours in the order of the polyhedra look at the same groups together.
    const uint together = uniform_caps ? 1 : LANES;
    for (uint i = part_begin + share_of(part_count, step, steps); i < end; i += together) {
        const uint some = min(together, end - i);
        int3 low[LANES], high[LANES];
        int3 start = INT_MAX, last = INT_MIN;
        for (uint k = 0; k < some; ++k) {
            box_range(layout, polyhedra + i + k, reach, &low[k], &high[k]);
            start = min(start, low[k]);
            last = max(last, high[k]);
        }
        // Where groups of 4 x 4 x 4 begin does not depend on the part, so that a pair is tested alike in every part:
        // with the box, or, of groups that several look at, at multiples of four.
        if (!uniform_caps) start &= ~3;
        start += (max(start, first) - start) & ~3;
        last = min(last, first + size - 1);
        for (int z = start.z; z <= last.z; z += 4)
            for (int y = start.y; y <= last.y; y += 4)
                for (int x = start.x; x <= last.x; x += 4) {
                    const int3 group = (int3)(x, y, z), relative = group - first;
                    const int base = (relative.z * size.y + relative.y) * size.x + relative.x;
                    if (!uniform_caps) greatest = load_caps(caps + coarse_cap_place(layout, x, y, z), group_caps);
                    for (uint k = 0; k < some; ++k) {
                        const ulong wanted = group_in_range(group, max(low[k], first), min(high[k], first + size - 1));
                        const Touch touch = {
                            i + k, base,
                            touched_coarse_bricks(layout, polyhedra + i + k, group_caps, greatest, group, wanted)};
                        if (touch.bricks == 0) continue;
                        add_touch(&held, touch, size, next, fill, entries);
                        if (!fill && n < capacity) own[n] = touch;
                        ++n;
                    }
                }
    }
    add_held(&held, size, next, fill, entries);
    if (fill) return;
    touch_counts[part] = n;
    if (step + 1 == steps)
        for (size_t brick = 0; brick < bricks; ++brick) counts[brick * parts + part] = next.first[brick * next.stride];
}
