// The boxes of the wide tree that a ray meets. The host compiles this file.
//
// No box is missed that holds a point of the ray. Where the ray enters and leaves a slab is computed in float, from a
// coordinate of its begin below and one above the true one, so that differences are off by one rounding only. With the
// rounding of the reciprocal and of the product, a quotient is off by less than 2^-21 of itself, and has the sign of
// the true one or is 0. A ray that is nearly parallel to a slab, or parallel, gets a slope of 2^-100: it moves by less
// than the boxes' margin of 1e-6 units (lib/engine/tree/wide_tree.cpp) on its way through the mesh, so it enters the
// slab before its begin and leaves it later than 2^70, or misses it.
#ifndef CLSDF_RAY_BOXES_H
#define CLSDF_RAY_BOXES_H

#include "point_tree.h"
#include "simd.h"

// The slope of a ray that is parallel to a slab.
#define CLSDF_LEAST_SLOPE 0x1p-100f
// Shortens the distance to a box by more than all rounding of it and of the box's end.
#define CLSDF_NEARER (1.0f - 0x1p-19f)

// A ray in units from the lattice's origin; its begin is near the mesh. `is_forward`: the coordinate grows.
typedef struct BoxRay {
    float enters_from[3];  // of the begin: the bound that makes the way into a slab shorter
    float leaves_from[3];  // and the way out of it longer
    float per_slope[3];
    clsdf_uint32 is_forward[3];
} BoxRay;

// slope: at most 1 on each axis. margin: of the begin.
INLINE BoxRay box_ray(__private const double* begin, __private const double* slope, __private const double* margin) {
    BoxRay ray;
    for (int axis = 0; axis < 3; ++axis) {
        const float nearest = (float)begin[axis];
        const float rounding = fabs(nearest) * 2.4e-7f + (float)margin[axis] * 1.000001f;
        const float below = nearest - rounding, above = nearest + rounding;
        const bool is_forward = slope[axis] >= 0.0;
        const float size = (float)fabs(slope[axis]);
        const float per_size = 1.0f / (size < CLSDF_LEAST_SLOPE ? CLSDF_LEAST_SLOPE : size);
        ray.is_forward[axis] = is_forward;
        ray.enters_from[axis] = is_forward ? above : below;
        ray.leaves_from[axis] = is_forward ? below : above;
        ray.per_slope[axis] = is_forward ? per_size : -per_size;
    }
    return ray;
}

// Bits of a node's children whose boxes the ray may meet at most `end` from its begin. Sets the distances to all, never
// above the true ones.
INLINE uint children_on_ray(__global const PointNode* node, __private const BoxRay* ray, float end,
                            __private float* distances) {
    __global const float* entered[3];
    __global const float* left[3];
    for (int axis = 0; axis < 3; ++axis) {
        entered[axis] = ray->is_forward[axis] ? node->lower[axis] : node->upper[axis];
        left[axis] = ray->is_forward[axis] ? node->upper[axis] : node->lower[axis];
    }
    const BoxRay r = *ray;
    float first[CLSDF_TREE_WIDTH], last[CLSDF_TREE_WIDTH];
    for (int i = 0; i < CLSDF_TREE_WIDTH; ++i) {
        float enters = 0.0f, leaves = end;
        for (int axis = 0; axis < 3; ++axis) {
            const float into = (entered[axis][i] - r.enters_from[axis]) * r.per_slope[axis],
                        out = (left[axis][i] - r.leaves_from[axis]) * r.per_slope[axis];
            enters = GREATER(into, enters);
            leaves = LESSER(out, leaves);
        }
        first[i] = enters * CLSDF_NEARER;
        last[i] = leaves;
    }
    uint bits = 0;
    for (int i = 0; i < CLSDF_TREE_WIDTH; ++i) bits |= (uint)(first[i] <= last[i]) << i;
    for (int i = 0; i < CLSDF_TREE_WIDTH; ++i) distances[i] = first[i];
    return bits;
}

#endif
