// Two kernels of the group body prepare the bricks of each coarse brick.
//
// brick_bounds: an upper bound of the distances in each of its 64 bricks.
//
// brick_masks: for each polyhedron of its list the bricks that it overlaps, 64 bits.
//
// Several work-groups share a coarse brick's list: there may be few coarse bricks, with long lists.
#ifndef CLSDF_BRICK_MASKS_H
#define CLSDF_BRICK_MASKS_H

#include "overlap.h"
#include "simd.h"

// Returns the square of the least distance from the feet of altitudes in the group's part of the list, points of the
// surface, to the centre of a brick. Work-item i takes brick i % CLSDF_COARSE_BRICKS and every
// (GROUP / CLSDF_COARSE_BRICKS)-th foot. feet: relative to the centre of the coarse brick.
static inline float least_square_of_feet(Layout layout, int3 coarse, uint part, uint parts, uint list_begin,
                                         uint list_end, __global const uint* entries,
                                         __global const Polyhedron* polyhedra, __local float3* feet) {
    const uint item = get_local_id(0);
    const int3 first = coarse * CLSDF_COARSE;
    const float3 centre =
        (convert_float3(four_cubed(item % CLSDF_COARSE_BRICKS)) - 1.5f) * CLSDF_BRICK * vload3(0, layout.spacing);
    float least = INFINITY;
    for (uint begin = list_begin + part * GROUP; begin < list_end; begin += parts * GROUP) {
        const uint count = min(list_end - begin, (uint)GROUP);
        if (item < count)
            feet[item] =
                from_foot_to(layout, polyhedra + entries[begin + item], first.x, first.y, first.z, COARSE_CENTRE);
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint n = item / CLSDF_COARSE_BRICKS; n < count; n += GROUP / CLSDF_COARSE_BRICKS) {
            const float3 from_foot = feet[n] + centre;
            const float square = dot(from_foot, from_foot);
            least = LESSER(square, least);
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    return least;
}

// The bricks of a coarse brick that a polyhedron overlaps, 64 bits.
static inline ulong brick_mask_of(__global const Polyhedron* p, int3 coarse, __local const float* bounds, float slack) {
    const int3 first = coarse * CLSDF_COARSE;
    const FramePosition position = frame_position_at(p, first.x, first.y, first.z, COARSE_CENTRE);
    const Extent extent = widened(extent_of_cube(p, BRICK_CENTRE), slack);
    ulong overlapped = 0;
    for (uint b = 0; b < CLSDF_COARSE_BRICKS; ++b) {
        const float3 centre = (convert_float3(four_cubed(b)) - 1.5f) * CLSDF_BRICK;
        overlapped |= (ulong)overlapped_blocks(p, position, centres_of(p, position, centre.x, centre.y, centre.z),
                                               extent, bounds[b])
                      << b;
    }
    return overlapped;
}

// Global size: `groups` groups for each coarse brick order[begin, ...) of the launch. bounds: CLSDF_COARSE_BRICKS for
// each of `order`, bits of floats, which begin as infinity. Those of positive floats have the order of the floats.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void brick_bounds(
    Layout layout, uint begin, __global const uint* restrict order, __global const uint* restrict starts, uint parts,
    __global const uint* restrict entries, __global const float* restrict coarse_bounds,
    __global const Polyhedron* restrict polyhedra, volatile __global uint* restrict bounds, uint groups) {
    __local float3 feet[GROUP];
    __local float least_squares[GROUP];
    const uint item = get_local_id(0), slot = begin + get_group_id(0) / groups, number = order[slot];
    const int3 coarse = coarse_brick_at(layout, number);
    least_squares[item] = least_square_of_feet(layout, coarse, get_group_id(0) % groups, groups, starts[number * parts],
                                               starts[(number + 1) * parts], entries, polyhedra, feet);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < CLSDF_COARSE_BRICKS) {
        float least = least_squares[item];
        for (uint other = item + CLSDF_COARSE_BRICKS; other < GROUP; other += CLSDF_COARSE_BRICKS)
            least = LESSER(least_squares[other], least);
        const float bound = sqrt(least) * (1.0f + 1.0e-5f) + (layout.brick_radius + layout.brick_slack);
        const float coarse_bound = coarse_bounds[coarse_bound_index(layout, coarse.x, coarse.y, coarse.z)];
        atomic_min(bounds + slot * CLSDF_COARSE_BRICKS + item, as_uint(LESSER(bound, coarse_bound)));
    }
}

// Global size: `groups` groups for each coarse brick order[begin, ...) of the launch. masks: as entries.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void brick_masks(
    Layout layout, uint begin, __global const uint* restrict order, __global const uint* restrict starts, uint parts,
    __global const uint* restrict entries, __global const float* restrict coarse_bounds,
    __global const Polyhedron* restrict polyhedra, __global const float* restrict bounds, uint groups,
    __global ulong* restrict masks) {
    __local float own_bounds[CLSDF_COARSE_BRICKS];
    const uint item = get_local_id(0), slot = begin + get_group_id(0) / groups, number = order[slot];
    if (item < CLSDF_COARSE_BRICKS) own_bounds[item] = bounds[slot * CLSDF_COARSE_BRICKS + item];
    barrier(CLK_LOCAL_MEM_FENCE);
    const int3 coarse = coarse_brick_at(layout, number);
    const float slack = coarse_bounds[coarse_bound_index(layout, coarse.x, coarse.y, coarse.z)] * layout.slack_rate +
                        layout.brick_slack;
    const uint list_end = starts[(number + 1) * parts];
    for (uint e = starts[number * parts] + get_group_id(0) % groups * GROUP + item; e < list_end; e += groups * GROUP)
        masks[e] = brick_mask_of(polyhedra + entries[e], coarse, own_bounds, slack);
}

#endif
