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
#ifdef LONG_BRICKS
    double4 frame;
#else
    Steps steps;
    // Displacements from the brick's centre along the frame, in two parts: of the lanes of a plane's sub-blocks, with
    // all of x; of the sub-blocks of any plane, by y and z, and in Z with what the offset lacks. (A third part, or x in
    // the second, would round more.)
    floatL lane_x[SUBBLOCKS_X], lane_y[SUBBLOCKS_X], lane_z[SUBBLOCKS_X];
    float x[SUBBLOCK_PLANE], y[SUBBLOCK_PLANE], z[SUBBLOCK_PLANE];
#endif
} AtBrick;

INLINE void set_at_brick(__global const Polyhedron* p, double3 centre, __private AtBrick* at) {
    const Offsets o = offsets_at(p, centre.x, centre.y, centre.z);
    at->offsets = o;
#ifdef LONG_BRICKS
    at->frame = frame_at(p, centre.x, centre.y, centre.z);
#else
    const Steps s = steps_of(p);
    at->steps = s;
    const floatL x = LANE_J * s.y[0] + LANE_K * s.z[0], y = LANE_J * s.y[1] + LANE_K * s.z[1],
                 z = LANE_J * s.y[2] + LANE_K * s.z[2];
#pragma unroll
    for (uint plane = 0; plane < SUBBLOCKS_X; ++plane) {
        const floatL i = LANE_I + subblock_i(plane);
        at->lane_x[plane] = i * s.x[0] + x;
        at->lane_y[plane] = i * s.x[1] + y;
        at->lane_z[plane] = i * s.x[2] + z;
    }
#pragma unroll
    for (uint v = 0; v < SUBBLOCK_PLANE / LANES; ++v) {
        const floatL j = subblocks_j(v), k = subblocks_k(v);
        store_lanes(j * s.y[0] + k * s.z[0], v, at->x);
        store_lanes(j * s.y[1] + k * s.z[1], v, at->y);
        store_lanes(j * s.y[2] + (k * s.z[2] + o.z_low), v, at->z);
    }
#endif
}

// Into the minimum.
static inline void evaluate(__global const Polyhedron* p, __private const AtBrick* at, SubblockMask touched,
                            __global Minimum* minimum, Layout layout, __private ulong* counters) {
    const uint triangle = p->triangle;
#ifndef LONG_BRICKS
    const Offsets o = at->offsets;
    const Steps s = at->steps;
#endif
    for (; touched; touched &= touched - 1) {
        const uint b = lowest_subblock(touched);
#ifdef LONG_BRICKS
        const floatL squared = squared_distance_long_brick(p, at->frame, samples_i(b), samples_j(b), samples_k(b));
#else
        const uint plane = b / SUBBLOCK_PLANE, n = b % SUBBLOCK_PLANE;
        const floatL squared = squared_distance_displaced(s, o, at->lane_x[plane] + at->x[n],
                                                          at->lane_y[plane] + at->y[n], at->lane_z[plane] + at->z[n]);
#endif
        lower_minimum(minimum, b, squared, triangle);
#ifdef COUNT
        const float slack = layout.half_width * layout.slack_rate + layout.brick_slack;
        counters[CLSDF_COUNT_LANES] += LANES;
        counters[CLSDF_COUNT_COVERED] += popcount(
            covered_samples(p, at->offsets, samples_i(b), samples_j(b), samples_k(b), layout.half_width, slack) &
            LANE_BITS);
#endif
    }
}

#endif
