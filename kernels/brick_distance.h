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
    // all of x; of the sub-blocks of any plane, by y and z, and in Z with what the offset lacks. Each is rounded once.
    floatL lane_x[SUBBLOCK_PLANES][SUBBLOCK_VECTORS], lane_y[SUBBLOCK_PLANES][SUBBLOCK_VECTORS],
        lane_z[SUBBLOCK_PLANES][SUBBLOCK_VECTORS];
    float x[SUBBLOCK_PLANE], y[SUBBLOCK_PLANE], z[SUBBLOCK_PLANE];
#endif
} AtBrick;

INLINE void set_at_brick(__global const Polyhedron* p, double3 centre, __private AtBrick* at) {
    const Offsets o = offsets_at(p, centre.x, centre.y, centre.z);
    at->offsets = o;
#ifdef LONG_BRICKS
    at->frame = frame_at(p, centre.x, centre.y, centre.z);
#else
    at->steps = steps_of(p);
    const double3 gx = vload3(0, p->exact_gradient_x), gy = vload3(0, p->exact_gradient_y),
                  gz = vload3(0, p->exact_gradient_z);
#pragma unroll
    for (uint v = 0; v < SUBBLOCK_VECTORS; ++v) {
        const doubleL lane_j = convert_doubleL(LANE_J), lane_k = convert_doubleL(LANE_K(v));
        const doubleL x = lane_j * gy.x + lane_k * gz.x, y = lane_j * gy.y + lane_k * gz.y,
                      z = lane_j * gy.z + lane_k * gz.z;
#pragma unroll
        for (uint plane = 0; plane < SUBBLOCK_PLANES; ++plane) {
            const doubleL i = convert_doubleL(LANE_I + subblock_i(plane));
            at->lane_x[plane][v] = convert_floatL(i * gx.x + x);
            at->lane_y[plane][v] = convert_floatL(i * gx.y + y);
            at->lane_z[plane][v] = convert_floatL(i * gx.z + z);
        }
    }
#pragma unroll
    for (uint v = 0; v < SUBBLOCK_PLANE / LANES; ++v) {
        const doubleL j = convert_doubleL(subblocks_j(v)), k = convert_doubleL(subblocks_k(v));
        store_lanes(convert_floatL(j * gy.x + k * gz.x), v, at->x);
        store_lanes(convert_floatL(j * gy.y + k * gz.y), v, at->y);
        store_lanes(convert_floatL(j * gy.z + (k * gz.z + (double)o.z_low)), v, at->z);
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
        const uint b = lowest_bit(touched);
#pragma unroll
        for (uint v = 0; v < SUBBLOCK_VECTORS; ++v) {
#ifdef LONG_BRICKS
            const floatL squared =
                squared_distance_long_brick(p, at->frame, samples_i(b), samples_j(b), samples_k(b, v));
#else
            const uint plane = b / SUBBLOCK_PLANE, n = b % SUBBLOCK_PLANE;
            const floatL squared =
                squared_distance_displaced(s, o, at->lane_x[plane][v] + at->x[n], at->lane_y[plane][v] + at->y[n],
                                           at->lane_z[plane][v] + at->z[n]);
#endif
            lower_minimum(minimum, b * SUBBLOCK_VECTORS + v, squared, triangle);
#ifdef COUNT
            const float slack = layout.half_width * layout.slack_rate + layout.brick_slack;
            counters[CLSDF_COUNT_LANES] += LANES;
            counters[CLSDF_COUNT_COVERED] += popcount(
                covered_samples(p, at->offsets, samples_i(b), samples_j(b), samples_k(b, v), layout.half_width, slack) &
                LANE_BITS);
#endif
        }
    }
}

#endif
