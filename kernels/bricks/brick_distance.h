// Distances to a triangle from the samples of the sub-blocks that its polyhedron overlaps.
//
// One polyhedron is taken after the other, so that its numbers are fetched once and stay in registers; the minima of a
// brick are small enough for the innermost cache.
#ifndef CLSDF_BRICK_DISTANCE_H
#define CLSDF_BRICK_DISTANCE_H

#include "distance.h"
#include "lane_offsets.h"
#include "overlap.h"
#include "subblocks.h"

// Displacements of the centres of a brick's sub-blocks from its own, along the axes of LANES polyhedra's frames. Each
// is rounded once.
typedef struct Displacements {
    floatL x[SUBBLOCKS], y[SUBBLOCKS], z[SUBBLOCKS];
} Displacements;

// Along the axis-th axis of the frames.
INLINE void set_displacements(__private const LaneOffsets* o, uint axis, __private floatL* all) {
    const floatL x = o->gradient[axis], y = o->gradient[3 + axis], z = o->gradient[6 + axis];
    const floatL x_low = o->gradient_low[axis], y_low = o->gradient_low[3 + axis], z_low = o->gradient_low[6 + axis];
    // The sub-blocks of the first plane; those of the other are their mirror images.
#pragma unroll
    for (uint b = 0; b < SUBBLOCK_PLANE; ++b) {
        const float i = subblock_i(0), j = subblock_j(b), k = subblock_k(b);
        const floatL displacement = (i * x + j * y + k * z) + (i * x_low + j * y_low + k * z_low);
        all[b] = displacement;
        all[SUBBLOCKS - 1 - b] = -displacement;
    }
}

// Displacements of the samples of a sub-block's vectors from its centre, along the axis-th axis of one polyhedron's
// frame.
INLINE void set_sample_displacements(__private const LaneOffsets* o, uint lane, uint axis, float low,
                                     __private floatL* all) {
#define OF_LANE(vectors, n) ((__private const float*)(vectors + n))[lane]
    const float x = OF_LANE(o->gradient, axis), y = OF_LANE(o->gradient, 3 + axis), z = OF_LANE(o->gradient, 6 + axis);
    const float x_low = OF_LANE(o->gradient_low, axis), y_low = OF_LANE(o->gradient_low, 3 + axis),
                z_low = OF_LANE(o->gradient_low, 6 + axis);
#undef OF_LANE
    floatL sum = LANE_I * x + (LANE_J * y + LANE_K(0) * z);
    floatL sum_low = LANE_I * x_low + (LANE_J * y_low + (LANE_K(0) * z_low + low));
    all[0] = sum + sum_low;
#pragma unroll
    for (uint v = 1; v < SUBBLOCK_VECTORS; ++v) {
        sum += z;
        sum_low += z_low;
        all[v] = sum + sum_low;
    }
}

// Takes the distances of the polyhedron `number`, which is in one lane, into the minimum.
static inline void evaluate(__private const LaneOffsets* o, __private const Displacements* displacements, uint lane,
                            SubblockMask overlapped, uint number, __global const Polyhedron* polyhedra,
                            __global Minimum* minimum) {
    const EdgeTable table = table_at(&o->edges, lane);
    const float x = o->x[lane], y = o->y[lane], z = o->z[lane];
    floatL samples_x[SUBBLOCK_VECTORS], samples_y[SUBBLOCK_VECTORS], samples_z[SUBBLOCK_VECTORS];
    set_sample_displacements(o, lane, 0, 0.0f, samples_x);
    set_sample_displacements(o, lane, 1, 0.0f, samples_y);
    set_sample_displacements(o, lane, 2, o->z_low[lane], samples_z);
    __private const float* to_subblock_x = (__private const float*)displacements->x + lane;
    __private const float* to_subblock_y = (__private const float*)displacements->y + lane;
    __private const float* to_subblock_z = (__private const float*)displacements->z + lane;
    for (; overlapped; overlapped &= overlapped - 1) {
        const uint b = lowest_bit(overlapped);
#pragma unroll
        for (uint v = 0; v < SUBBLOCK_VECTORS; ++v) {
            const floatL squared = squared_distance_by_table(table, x, y, z, samples_x[v] + to_subblock_x[b * LANES],
                                                             samples_y[v] + to_subblock_y[b * LANES],
                                                             samples_z[v] + to_subblock_z[b * LANES]);
            lower_minimum(minimum, b * SUBBLOCK_VECTORS + v, squared, number, polyhedra);
        }
    }
}

// The same for LONG_BRICKS.
static inline void evaluate_long_brick(uint number, double4 frame, SubblockMask overlapped,
                                       __global const Polyhedron* polyhedra, __global Minimum* minimum) {
    __global const Polyhedron* p = polyhedra + number;
    for (; overlapped; overlapped &= overlapped - 1) {
        const uint b = lowest_bit(overlapped);
        for (uint v = 0; v < SUBBLOCK_VECTORS; ++v)
            lower_minimum(minimum, b * SUBBLOCK_VECTORS + v,
                          squared_distance_long_brick(p, frame, samples_i(b), samples_j(b), samples_k(b, v)), number,
                          polyhedra);
    }
}

#ifdef COUNT
static inline void count_covered(__global const Polyhedron* p, Offsets o, SubblockMask overlapped, Layout layout,
                                 __private ulong* counters) {
    const float slack = layout.half_width * layout.slack_rate + layout.brick_slack;
    for (; overlapped; overlapped &= overlapped - 1) {
        const uint b = lowest_bit(overlapped);
        for (uint v = 0; v < SUBBLOCK_VECTORS; ++v) {
            counters[CLSDF_COUNT_LANES] += LANES;
            counters[CLSDF_COUNT_COVERED] +=
                popcount(covered_samples(p, o, samples_i(b), samples_j(b), samples_k(b, v), layout.half_width, slack) &
                         LANE_BITS);
        }
    }
}
#endif

#endif
