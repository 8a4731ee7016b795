// The list of polyhedra of each coarse brick (32 x 32 x 32 samples), by count, scan, fill.
//
// Each work-item takes a contiguous range of polyhedra and counts into a histogram of its own, so that no atomics are
// needed and the lists are in the order of the polyhedra, whatever the number of work-items:
//   counts[brick * parts + part], scanned, is where a part's entries of a brick begin.

#include "blocks.h"

// An upper bound of the distance to the mesh for every sample of a coarse brick: the distance of its centre to the
// nearest of some of the surface's points (the feet of the altitudes), and the brick's radius. `stride` leaves most of
// them out; a coarse bound is enough here, the bricks find finer ones.
__kernel void coarse_caps(Layout layout, uint count, uint stride, __global const Polyhedron* polyhedra,
                          __global float* caps, uint first) {
    const int brick = first + get_global_id(0);
    const int nx = layout.coarse_bricks[0], ny = layout.coarse_bricks[1];
    const int x = layout.coarse_first[0] + brick % nx, y = layout.coarse_first[1] + brick / nx % ny,
              z = layout.coarse_first[2] + brick / (nx * ny);
    float least = INFINITY;
    for (uint i = 0; i < count; i += stride) {
        const float3 from_foot = from_foot_to(layout, polyhedra + i, x * CLSDF_COARSE, y * CLSDF_COARSE,
                                              z * CLSDF_COARSE, 0.5f * (CLSDF_COARSE - 1));
        const float squared = dot(from_foot, from_foot);
        least = LESSER(least, squared);
    }
    const float bound = sqrt(least) * (1.0f + 1.0e-5f) + layout.coarse_radius + layout.coarse_slack;
    caps[coarse_cap_place(layout, x, y, z)] = LESSER(bound, layout.half_width);
}

// origin + offset; far outside, where the sum is no longer an int, a number beyond all of the lattice's indices, which
// are below 2^30.
inline int index_near(int origin, float offset) {
    const float limit = 1.0737e9f;
    return fabs(offset) < 1.0e9f ? origin + (int)offset : (int)clamp((float)origin + offset, -limit, limit);
}

// The coarse bricks of the lattice that the box of the triangle, enlarged by the half width, overlaps on one axis;
// limits included. The answer does not depend on the part that is computed.
inline int2 box_range(__global const Polyhedron* p, __global const float* gradient, int origin, float reach) {
    // One axis of the metric position is spacing * (index - origin). Its unit vector in the frame is the axis' gradient
    // divided by the spacing, so that (gradient . frame point) / spacing^2 is an index.
    const float gx = gradient[0], gy = gradient[1], gz = gradient[2];
    const float squared = gx * gx + gy * gy + gz * gz;
    const float foot = -(gx * p->constant_at_origin[0] + gy * p->constant_at_origin[1] + gz * p->constant_at_origin[2]);
    const float right = gx * p->base[CLSDF_HALF_RIGHT], left = -gx * p->base[CLSDF_HALF_LEFT],
                apex = gy * (float)p->exact_altitude;
    const float margin = reach * sqrt(squared) + 1.0e-5f * (fabs(right) + fabs(left) + fabs(apex) + fabs(foot));
    const float low = (foot + LESSER(LESSER(right, left), apex) - margin) / squared;
    const float high = (foot + GREATER(GREATER(right, left), apex) + margin) / squared;
    return (int2)((index_near(origin, floor(low)) - (CLSDF_COARSE - 1)) >> 5, index_near(origin, ceil(high)) >> 5);
}

// Bits 0 to 3: which of four neighbours that start at `base` lie in [low, high].
inline uint four_in_range(int base, int low, int high) {
    const int begin = max(low - base, 0), end = min(high - base, 3);
    return begin > end ? 0u : (0xFu >> (3 - end)) & (0xFu << begin);
}

// The blocks of a group of 4 x 4 x 4 that starts at (x, y, z) that lie in [low, high], as touched_group numbers them.
inline ulong group_in_range(int x, int y, int z, int3 low, int3 high) {
    const uint in_x = four_in_range(x, low.x, high.x), in_y = four_in_range(y, low.y, high.y),
               in_z = four_in_range(z, low.z, high.z);
    const uint rows =
        (in_y & 1u) * 0xFu | (in_y >> 1 & 1u) * 0xF0u | (in_y >> 2 & 1u) * 0xF00u | (in_y >> 3 & 1u) * 0xF000u;
    const ulong slice = in_x * 0x1111u & rows;
    return (in_z & 1u) * slice | (in_z >> 1 & 1u) * (slice << 16) | (in_z >> 2 & 1u) * (slice << 32) |
           (in_z >> 3 & 1u) * (slice << 48);
}

inline uint pop_bit(__private ulong* bits) {
    const uint b = 63 - (uint)clz(*bits & (0 - *bits));
    *bits &= *bits - 1;
    return b;
}

// The number of block b of a group among the part's coarse bricks.
inline size_t coarse_brick_of(int x, int y, int z, uint b, int3 first, int3 size) {
    const int3 relative = (int3)(x + (int)(b & 3u), y + (int)((b >> 2) & 3u), z + (int)(b >> 4)) - first;
    return ((size_t)relative.z * size.y + relative.y) * size.x + relative.x;
}

// The coarse bricks of a group of 4 x 4 x 4, which starts at (x, y, z), that a polyhedron touches. [low, high] are
// those that its box overlaps.
inline ulong touched_coarse_bricks(Layout layout, __global const Polyhedron* p, __global const float* caps, int x,
                                   int y, int z, int3 low, int3 high) {
    float group_caps[64];
    floatL greatest_caps = 0.0f;
    __global const float* own_caps = caps + coarse_cap_place(layout, x, y, z);
    ulong near = 0;
    // First by distance alone, which most pairs of a wide band do not pass: no point of the triangle is farther from
    // the foot of its altitude than `extent`.
    const float extent = GREATER(GREATER(p->base[0], p->base[1]), (float)p->exact_altitude) * (1.0f + 1.0e-5f);
    const float3 from_foot =
        from_foot_to(layout, p, x * CLSDF_COARSE, y * CLSDF_COARSE, z * CLSDF_COARSE, 0.5f * (CLSDF_COARSE - 1));
    const float3 side = CLSDF_COARSE * vload3(0, layout.spacing);
    for (uint v = 0; v < 64 / LANES; ++v) {
        const floatL cap = load_lanes(v, own_caps);
        store_lanes(cap, v, group_caps);
        greatest_caps = GREATER(greatest_caps, cap);
        const uintL block = LANE_NUMBERS + v * LANES;
        const floatL i = convert_floatL(block & 3u) * side.x + from_foot.x,
                     j = convert_floatL((block >> 2) & 3u) * side.y + from_foot.y,
                     k = convert_floatL(block >> 4) * side.z + from_foot.z;
        const floatL reach = cap + (extent + layout.coarse_radius + layout.coarse_slack);
        near |= (ulong)lanes_to_bits((i * i + j * j + k * k) * (1.0f - 1.0e-5f) <= reach * reach) << (v * LANES);
    }
    const ulong wanted = near & group_in_range(x, y, z, low, high);
    if (wanted == 0) return 0;
    return touched_group(p, x * CLSDF_COARSE, y * CLSDF_COARSE, z * CLSDF_COARSE, CLSDF_COARSE, wanted, group_caps,
                         greatest_lane(greatest_caps) * layout.slack_rate + layout.coarse_slack);
}

// With `fill` 0 it counts the pairs of each part, and keeps the first `capacity` of them: (brick, polyhedron). With 1
// it writes the entries, `counts` being where each part's begin: from the pairs that were kept, or, where they were too
// many, from the test again. Launch `step` of `steps` takes its share of each part's polyhedra.
__kernel void coarse_lists(Layout layout, uint count, __global const Polyhedron* polyhedra, __global const float* caps,
                           __global uint* counts, __global uint* entries, uint capacity, __global uint2* pairs,
                           __global uint* pair_counts, int fill, uint step, uint steps) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    __global uint2* own = pairs + (size_t)part * capacity;
    if (fill && pair_counts[part] <= capacity) {
        if (step > 0) return;
        for (uint k = 0; k < pair_counts[part]; ++k) entries[counts[(size_t)own[k].x * parts + part]++] = own[k].y;
        return;
    }
    const uint part_begin = (uint)((ulong)count * part / parts), part_end = (uint)((ulong)count * (part + 1) / parts);
    const uint begin = part_begin + (uint)((ulong)(part_end - part_begin) * step / steps),
               end = part_begin + (uint)((ulong)(part_end - part_begin) * (step + 1) / steps);
    const int3 first = vload3(0, layout.coarse_first), size = vload3(0, layout.coarse_bricks);
    const float reach = layout.half_width + layout.slack_rate * layout.half_width + layout.coarse_slack;
    if (!fill && step == 0)
        for (size_t brick = 0; brick < (size_t)size.x * size.y * size.z; ++brick) counts[brick * parts + part] = 0;

    uint n = step == 0 ? 0 : pair_counts[part];
    for (uint i = begin; i < end; ++i) {
        __global const Polyhedron* p = polyhedra + i;
        const int2 rx = box_range(p, p->gradient_x, p->origin_x, reach);
        const int2 ry = box_range(p, p->gradient_y, p->origin_y, reach);
        const int2 rz = box_range(p, p->gradient_z, p->origin_z, reach);
        const int3 low = max((int3)(rx.x, ry.x, rz.x), first);
        const int3 high = min((int3)(rx.y, ry.y, rz.y), first + size - 1);
        // Groups of 4 x 4 x 4 start at multiples of four of the lattice, so that a pair is tested alike in every part.
        for (int z = low.z & ~3; z <= high.z; z += 4)
            for (int y = low.y & ~3; y <= high.y; y += 4)
                for (int x = low.x & ~3; x <= high.x; x += 4) {
                    ulong touched = touched_coarse_bricks(layout, p, caps, x, y, z, low, high);
                    while (touched) {
                        const uint b = pop_bit(&touched);
                        const size_t brick = coarse_brick_of(x, y, z, b, first, size);
                        const uint slot = counts[brick * parts + part]++;
                        if (fill)
                            entries[slot] = i;
                        else if (n < capacity)
                            own[n] = (uint2)((uint)brick, i);
                        ++n;
                    }
                }
    }
    if (!fill) pair_counts[part] = n;
}
