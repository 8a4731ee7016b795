// Tests vectors of polyhedra against the bricks of a coarse brick and the sub-blocks of a brick.
#ifndef CLSDF_BRICK_LISTS_H
#define CLSDF_BRICK_LISTS_H

#include "lane_polyhedra.h"
#include "overlap.h"
#include "subblocks.h"

// One bit per lane.
#if LANES == 16
typedef ushort LaneMask;
#else
typedef uchar LaneMask;
#endif

// Brick b of a coarse brick.
INLINE int3 brick_of_coarse(int3 coarse, uint b) {
    return coarse * CLSDF_BRICKS_PER_COARSE + four_cubed(b);
}

// The numbers list[e, e + LANES); beyond the list's end, its last.
INLINE void load_numbers(__global const uint* list, uint e, uint count, __private uint* numbers) {
    if (e + LANES <= count)
        store_lanes(load_lanes(0, list + e), 0, numbers);
    else
        for (uint lane = 0; lane < LANES; ++lane) numbers[lane] = list[min(e + lane, count - 1)];
}

INLINE uint lanes_in_list(uint e, uint count) {
    return e + LANES <= count ? LANE_BITS : (1u << (count - e)) - 1;
}

// For polyhedra e to e + LANES - 1 of a list: the bricks of a coarse brick that each overlaps. Brick b's mask of lanes
// goes to masks[b * stride]. Returns which bricks any of them overlaps.
INLINE ulong overlapped_bricks(const LanePolyhedra* p, __private const float* bounds, float slack, uint lanes,
                               __global LaneMask* masks, uint stride) {
    const float half_side = BRICK_CENTRE;
    const LaneExtent extent = extent_of_lanes(p, half_side, half_side, half_side, slack);
    const PlaneDistances step_x = plane_product(p->step_x, CLSDF_BRICK), step_y = plane_product(p->step_y, CLSDF_BRICK),
                         step_z = plane_product(p->step_z, CLSDF_BRICK);
    const PlaneDistances first =
        without_extent(plane_sum(plane_sum(p->at, plane_product(step_x, -1.5f)),
                                 plane_sum(plane_product(step_y, -1.5f), plane_product(step_z, -1.5f))),
                       &extent);
    const floatL half_row = 1.5f * fabs(step_x.z) + extent.z;
    ulong any = 0;
    for (uint b = 0; b < CLSDF_COARSE_BRICKS; b += 4) {
        const PlaneDistances row =
            plane_sum(first, plane_sum(plane_product(step_y, b / 4 % 4), plane_product(step_z, b / 16)));
        const floatL height = row.z + 1.5f * step_x.z;
        intL overlapped[4];
        floatL slopes[3];
        if (p->all_compact && lanes_to_bits(fabs(height) <= half_row) == 0) {
            const floatL side = height < 0.0f ? (floatL)-1.0f : (floatL)1.0f;
            slopes_at(p, height, half_row, slopes);
            const OneSide step = one_side(p, step_x, side, slopes, 0);
            OneSide at = one_side(p, row, side, slopes, &extent);
#pragma unroll
            for (uint x = 0; x < 4; ++x, at = one_side_sum(at, step))
                overlapped[x] = overlaps_one_side(at, bounds[b + x]);
        } else {
            PlaneDistances at = row;
#pragma unroll
            for (uint x = 0; x < 4; ++x, at = plane_sum(at, step_x)) {
                slopes_at(p, at.z, extent.z, slopes);
                overlapped[x] = overlaps(p, at, slopes, &extent, bounds[b + x]);
            }
        }
#pragma unroll
        for (uint x = 0; x < 4; ++x) {
            const uint bits = lanes & lanes_to_bits(overlapped[x]);
            masks[(size_t)(b + x) * stride] = (LaneMask)bits;
            any |= (ulong)(bits != 0) << (b + x);
        }
    }
    return any;
}

// Each lane's SubblockMask. `at`: the first sub-block's centre, without extent; x, y, z: the steps to the next ones;
// bounds: in the order of the sub-blocks.
INLINE uintL subblocks_of_both_sides(const LanePolyhedra* p, PlaneDistances at, PlaneDistances x, PlaneDistances y,
                                     PlaneDistances z, const floatL* slopes, const LaneExtent* extent,
                                     __private const float* bounds) {
    uintL bits = 0;
    for (uint i = 0; i < SUBBLOCK_PLANES; ++i, at = plane_sum(at, x)) {
        PlaneDistances row = at;
        for (uint k = 0; k < 4; ++k, row = plane_sum(row, z)) {
            PlaneDistances block = row;
#pragma unroll
            for (uint j = 0; j < 4; ++j, block = plane_sum(block, y))
                bits = bits >> 1 | (as_uintL(overlaps(p, block, slopes, extent, *bounds++)) & 0x80000000u);
        }
    }
    return bits;
}

// The same for a brick that lies on one side of all faces.
INLINE uintL subblocks_of_one_side(OneSide at, OneSide x, OneSide y, OneSide z, __private const float* bounds) {
    uintL bits = 0;
    for (uint i = 0; i < SUBBLOCK_PLANES; ++i, at = one_side_sum(at, x)) {
        OneSide row = at;
        for (uint k = 0; k < 4; ++k, row = one_side_sum(row, z)) {
            OneSide block = row;
#pragma unroll
            for (uint j = 0; j < 4; ++j, block = one_side_sum(block, y))
                bits = bits >> 1 | (as_uintL(overlaps_one_side(block, *bounds++)) & 0x80000000u);
        }
    }
    return bits;
}

// Returns a SubblockMask per lane: the sub-blocks that the lane's polyhedron overlaps.
INLINE uintL overlapped_subblocks(const LanePolyhedra* p, __private const float* bounds, float slack) {
    const float half_x = 0.5f * (SUBBLOCK_X - 1);
    const LaneExtent extent = extent_of_lanes(p, half_x, 0.5f, 0.5f, slack);
    const PlaneDistances x = plane_product(p->step_x, SUBBLOCK_X), y = plane_product(p->step_y, 2.0f),
                         z = plane_product(p->step_z, 2.0f);
    PlaneDistances at = plane_sum(plane_sum(p->at, plane_product(p->step_x, half_x - 3.5f)),
                                  plane_sum(plane_product(p->step_y, -3.0f), plane_product(p->step_z, -3.0f)));
    at = without_extent(at, &extent);
    const floatL brick_extent = (fabs(p->step_x.z) + fabs(p->step_y.z) + fabs(p->step_z.z)) * BRICK_CENTRE;
    floatL slopes[3];
    slopes_at(p, p->at.z, brick_extent + slack, slopes);
    if (p->all_compact && lanes_to_bits(fabs(p->at.z) <= brick_extent + slack) == 0) {
        const floatL side = p->at.z < 0.0f ? (floatL)-1.0f : (floatL)1.0f;
        return subblocks_of_one_side(one_side(p, at, side, slopes, &extent), one_side(p, x, side, slopes, 0),
                                     one_side(p, y, side, slopes, 0), one_side(p, z, side, slopes, 0), bounds);
    }
    return subblocks_of_both_sides(p, at, x, y, z, slopes, &extent, bounds);
}

// Stores the entries of a list that the masks choose, and returns their number. `chosen` has room for a vector more.
INLINE uint choose_masked(uint count, __global const uint* entries, __global const LaneMask* masks,
                          __global uint* chosen) {
    uint length = 0;
    for (uint e = 0; e < count; e += LANES) {
        const uint bits = masks[e / LANES];
        store_lanes(packed(load_lanes(0, entries + e), bits), 0, chosen + length);
        length += popcount(bits);
    }
    return length;
}

#endif
