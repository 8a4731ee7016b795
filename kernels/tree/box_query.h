// The boxes of both trees that a box overlaps: of a point, a ray or a segment. The host compiles this file, too, with
// one lane.
#ifndef CLSDF_BOX_QUERY_H
#define CLSDF_BOX_QUERY_H

#include "point_tree.h"
#include "simd.h"

// How many children are compared at once. The host's compiler makes vectors of the loops over them.
#ifdef __OPENCL_VERSION__
#define CHILDREN_AT_ONCE LANES
#else
#define CHILDREN_AT_ONCE CLSDF_TREE_WIDTH
#endif

// A point as boxes are compared with it: floats on both sides of each coordinate, by more than `margin` away.
INLINE PointBox box_of_point(double3 p, float margin) {
    const double at[3] = {p.x, p.y, p.z};
    PointBox box;
    for (int axis = 0; axis < 3; ++axis) {
        const float nearest = (float)at[axis], rounding = fabs(nearest) * 2.4e-7f + margin;
        box.lower[axis] = nearest - rounding;
        box.upper[axis] = nearest + rounding;
    }
    return box;
}

// 0 if a box overlaps the other one, else INFINITY: as a binary walk measures boxes.
INLINE float zero_if_overlapped(float lower_x, float lower_y, float lower_z, float upper_x, float upper_y,
                                float upper_z, PointBox box) {
    const bool is_overlapped = lower_x <= box.upper[0] && upper_x >= box.lower[0] && lower_y <= box.upper[1] &&
                               upper_y >= box.lower[1] && lower_z <= box.upper[2] && upper_z >= box.lower[2];
    return is_overlapped ? 0.0f : INFINITY;
}

// Bits of the children of a node whose boxes the box overlaps.
INLINE uint overlapped_children(__global const PointNode* node, PointBox box) {
    uint bits = 0;
#if LANES != 1
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += LANES) {
        intL is_met = (intL)(-1);
        for (int axis = 0; axis < 3; ++axis)
            is_met = is_met & (load_lanes(0, node->lower[axis] + first) <= (floatL)box.upper[axis]) &
                     (load_lanes(0, node->upper[axis] + first) >= (floatL)box.lower[axis]);
        bits |= lanes_to_bits(is_met) << first;
    }
#else
    uchar is_met[CLSDF_TREE_WIDTH];
    for (int i = 0; i < CLSDF_TREE_WIDTH; ++i) {
        uint is_met_on_axes = 1;
        for (int axis = 0; axis < 3; ++axis)
            is_met_on_axes &=
                (uint)(node->lower[axis][i] <= box.upper[axis]) & (uint)(node->upper[axis][i] >= box.lower[axis]);
        is_met[i] = (uchar)is_met_on_axes;
    }
    for (int i = 0; i < CLSDF_TREE_WIDTH; ++i) bits |= (uint)is_met[i] << i;
#endif
    return bits;
}

#endif
