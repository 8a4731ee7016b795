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
#ifdef LONG_BRICKS
    double4 frame;
#else
    Steps steps;
    // Displacements along the frame: of a sub-block's samples from its centre, in Z with what the offset lacks; of the
    // sub-blocks' centres from the brick's. Each is rounded once.
    floatL lane_x[SUBBLOCK_VECTORS], lane_y[SUBBLOCK_VECTORS], lane_z[SUBBLOCK_VECTORS];
    float x[SUBBLOCKS], y[SUBBLOCKS], z[SUBBLOCKS];
#endif
} AtBrick;

#ifndef LONG_BRICKS
// Displacements along an axis of the frame with the gradients (x, y, z): of the first half of a sub-block's samples; of
// the sub-blocks of the first plane.
INLINE double8 of_samples(double x, double y, double z) {
    return FIRST_HALF_I * x + (FIRST_HALF_J * y + FIRST_HALF_K * z);
}
INLINE float16 of_subblocks(double x, double y, double z) {
    return convert_float16(FIRST_PLANE_J * y + (FIRST_PLANE_K * z + FIRST_PLANE_I * x));
}

// The displacements of all samples of a sub-block, from those of the first half and of their mirror images.
INLINE void set_samples(float8 first, float8 images, __private floatL* all) {
#if LANES == 16
    all[0] = (float16)(first, images.s76543210);
#else
    all[0] = first;
    all[1] = images.s76543210;
#endif
}

// Of all sub-blocks of a brick, from those of its first plane.
INLINE void set_subblocks(float16 plane, __private float* all) {
    store_sixteen(plane, 0, all);
    store_sixteen(-plane.sfedcba9876543210, 1, all);
}
#endif

// `centre` is for long bricks, z_low for all others.
INLINE void set_at_brick(__global const Polyhedron* p, double3 centre, double z_low, __private AtBrick* at) {
#ifdef LONG_BRICKS
    at->frame = frame_at(p, centre.x, centre.y, centre.z);
#else
    at->steps = steps_of(p);
    const double3 gx = vload3(0, p->exact_gradient_x), gy = vload3(0, p->exact_gradient_y),
                  gz = vload3(0, p->exact_gradient_z);
    const float8 x = convert_float8(of_samples(gx.x, gy.x, gz.x)), y = convert_float8(of_samples(gx.y, gy.y, gz.y));
    const double8 z = of_samples(gx.z, gy.z, gz.z);
    set_samples(x, -x, at->lane_x);
    set_samples(y, -y, at->lane_y);
    set_samples(convert_float8(z_low + z), convert_float8(z_low - z), at->lane_z);
    set_subblocks(of_subblocks(gx.x, gy.x, gz.x), at->x);
    set_subblocks(of_subblocks(gx.y, gy.y, gz.y), at->y);
    set_subblocks(of_subblocks(gx.z, gy.z, gz.z), at->z);
#endif
}

// Into the minimum.
static inline void evaluate(__global const Polyhedron* p, Offsets o, __private const AtBrick* at, SubblockMask touched,
                            __global Minimum* minimum, Layout layout, __private ulong* counters) {
    const uint triangle = p->triangle;
#ifndef LONG_BRICKS
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
            const floatL squared = squared_distance_displaced(s, o, at->lane_x[v] + at->x[b], at->lane_y[v] + at->y[b],
                                                              at->lane_z[v] + at->z[b]);
#endif
            lower_minimum(minimum, b * SUBBLOCK_VECTORS + v, squared, triangle);
#ifdef COUNT
            const float slack = layout.half_width * layout.slack_rate + layout.brick_slack;
            counters[CLSDF_COUNT_LANES] += LANES;
            counters[CLSDF_COUNT_COVERED] +=
                popcount(covered_samples(p, o, samples_i(b), samples_j(b), samples_k(b, v), layout.half_width, slack) &
                         LANE_BITS);
#endif
        }
    }
}

#endif
