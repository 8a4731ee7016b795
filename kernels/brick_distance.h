// The distance from the samples of a brick to a triangle, of the sub-blocks that its polyhedron touches.
//
// One polyhedron is taken after the other, so that its numbers are fetched once and stay in registers; the minima of a
// brick are small enough for the innermost cache.
#ifndef CLSDF_BRICK_DISTANCE_H
#define CLSDF_BRICK_DISTANCE_H

#include "blocks.h"
#include "brick_minimum.h"
#include "distance.h"

// A polyhedron at a brick: what its distances take.
typedef struct AtBrick {
    Offsets offsets;
    Steps steps;
    // Displacements along its frame: of the samples of a sub-block from its centre, and of the centres of all
    // sub-blocks from the brick's; in Z with what the offset lacks.
    floatL lane_x, lane_y, lane_z;
    float x[SUBBLOCKS], y[SUBBLOCKS], z[SUBBLOCKS];
} AtBrick;

INLINE void set_at_brick(__global const Polyhedron* p, double3 centre, __private AtBrick* at) {
    const Offsets o = offsets_at(p, centre.x, centre.y, centre.z);
    const Steps s = steps_of(p);
    at->offsets = o;
    at->steps = s;
    at->lane_x = LANE_I * s.x[0] + (LANE_J * s.y[0] + LANE_K * s.z[0]);
    at->lane_y = LANE_I * s.x[1] + (LANE_J * s.y[1] + LANE_K * s.z[1]);
    at->lane_z = LANE_I * s.x[2] + (LANE_J * s.y[2] + LANE_K * s.z[2]);
#pragma unroll
    for (uint v = 0; v < SUBBLOCK_PLANE / LANES; ++v) {
        const floatL j = subblocks_j(v), k = subblocks_k(v);
        const floatL x = j * s.y[0] + k * s.z[0], y = j * s.y[1] + k * s.z[1], z = j * s.y[2] + (k * s.z[2] + o.z_low);
#pragma unroll
        for (uint plane = 0; plane < SUBBLOCKS_X; ++plane) {
            const float i = subblock_i(plane);
            store_lanes(x + i * s.x[0], v, at->x + plane * SUBBLOCK_PLANE);
            store_lanes(y + i * s.x[1], v, at->y + plane * SUBBLOCK_PLANE);
            store_lanes(z + i * s.x[2], v, at->z + plane * SUBBLOCK_PLANE);
        }
    }
}

// Into the minimum. `centre`: of the brick.
static inline void evaluate(__global const Polyhedron* p, __private const AtBrick* at, SubblockMask touched,
                            double3 centre, __global Minimum* minimum, Layout layout, __private ulong* counters) {
    const Offsets o = at->offsets;
    const Steps s = at->steps;
    const floatL lane_x = at->lane_x, lane_y = at->lane_y, lane_z = at->lane_z;
    const uint triangle = p->triangle;
    for (; touched; touched &= touched - 1) {
        const uint b = lowest_subblock(touched);
#ifdef LONG_BRICKS
        const floatL squared = squared_distance_long_brick(p, frame_at(p, centre.x, centre.y, centre.z), samples_i(b),
                                                           samples_j(b), samples_k(b));
#else
        const floatL squared =
            squared_distance_displaced(s, o, lane_x + at->x[b], lane_y + at->y[b], lane_z + at->z[b]);
#endif
        lower_minimum(minimum, b, squared, triangle);
#ifdef COUNT
        const float slack = layout.half_width * layout.slack_rate + layout.brick_slack;
        counters[CLSDF_COUNT_LANES] += LANES;
        counters[CLSDF_COUNT_COVERED] += popcount(
            covered_samples(p, o, samples_i(b), samples_j(b), samples_k(b), layout.half_width, slack) & LANE_BITS);
#endif
    }
}

#endif
