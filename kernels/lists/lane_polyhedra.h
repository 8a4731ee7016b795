// LANES polyhedra of a list at once, one a lane: which of a group of blocks each of them overlaps.
//
// Blocks are tested one after the other, so a polyhedron's numbers stay in registers, and a step to the next block is
// one addition for each plane. Each test gives a mask of lanes. The mask selects the block's list. (A test of one
// polyhedron against LANES blocks would broadcast all numbers of the polyhedron first.)
//
// The test is that of overlap.h, except at the ends of the base: the planes of the corners replace the upper bound. For
// slivers they are almost as tight.
#ifndef CLSDF_LANE_POLYHEDRA_H
#define CLSDF_LANE_POLYHEDRA_H

#include "frame.h"
#include "lane_records.h"
#include "polyhedron.h"
#include "simd.h"

// The quantities that the tests limit, at one point: Z and the distances outward of the base (-Y) and of the slanted
// edges. All are affine in the sample, so the same struct holds a step.
typedef struct PlaneDistances {
    floatL z, base, right, left;
} PlaneDistances;

INLINE PlaneDistances plane_sum(PlaneDistances a, PlaneDistances b) {
    a.z += b.z;
    a.base += b.base;
    a.right += b.right;
    a.left += b.left;
    return a;
}

INLINE PlaneDistances plane_product(PlaneDistances a, float factor) {
    a.z *= factor;
    a.base *= factor;
    a.right *= factor;
    a.left *= factor;
    return a;
}

typedef struct LanePolyhedra {
    PlaneDistances at;                          // the centre of a group of blocks
    PlaneDistances step_x, step_y, step_z;      // of one sample
    floatL gradient_x, gradient_y, gradient_z;  // of X
    floatL along_right, along_left, across_right, across_left;
    floatL above[3], below[3], greater[3];  // slopes by edge
    bool all_compact;
} LanePolyhedra;

// The polyhedra numbers[0, LANES) at the point `centre` samples along each axis from sample `first`.
INLINE LanePolyhedra lane_polyhedra(__global const Polyhedron* polyhedra, __private const uint* numbers, int3 first,
                                    float centre) {
    floatL words[WORDS];
    load_words(polyhedra, numbers, words);
    const floatL along_right = words[NUMBER_NORMAL_ALONG], along_left = words[NUMBER_NORMAL_ALONG + 1];
    const floatL across_right = words[NUMBER_NORMAL_ACROSS], across_left = words[NUMBER_NORMAL_ACROSS + 1];
    LanePolyhedra p;
#define SET_STEP(step, gradient)                                   \
    {                                                              \
        const floatL x = words[gradient], y = words[gradient + 1]; \
        p.step.z = words[gradient + 2];                            \
        p.step.base = -y;                                          \
        p.step.right = along_right * x + across_right * y;         \
        p.step.left = across_left * y - along_left * x;            \
    }
    SET_STEP(step_x, NUMBER_GRADIENT_X)
    SET_STEP(step_y, NUMBER_GRADIENT_Y)
    SET_STEP(step_z, NUMBER_GRADIENT_Z)
#undef SET_STEP

    const floatL i = convert_floatL(first.x - as_intL(words[WORD_ORIGIN])) + centre,
                 j = convert_floatL(first.y - as_intL(words[WORD_ORIGIN + 1])) + centre,
                 k = convert_floatL(first.z - as_intL(words[WORD_ORIGIN + 2])) + centre;
    const floatL x = FRAME_AT(words, 0, i, j, k), y = FRAME_AT(words, 1, i, j, k);
    p.at.z = FRAME_AT(words, 2, i, j, k);
    p.at.base = -y;
    p.at.right = along_right * (x - words[NUMBER_BASE]) + across_right * y;
    p.at.left = along_left * (-x - words[NUMBER_BASE + 1]) + across_left * y;
    const intL flags = as_intL(words[WORD_FLAGS]);
    if (lanes_to_bits((flags & (int)CLSDF_POLYHEDRON_NEAR) == 0)) {  // sums in float round too coarsely
        float values[4][LANES];
        for (uint lane = 0; lane < LANES; ++lane) {
            const FramePosition position =
                frame_position_at(polyhedra + numbers[lane], first.x, first.y, first.z, centre);
            values[0][lane] = position.z;
            values[1][lane] = -position.y;
            values[2][lane] = position.outward_right;
            values[3][lane] = position.outward_left;
        }
        p.at.z = load_lanes(0, values[0]);
        p.at.base = load_lanes(0, values[1]);
        p.at.right = load_lanes(0, values[2]);
        p.at.left = load_lanes(0, values[3]);
    }
#pragma unroll
    for (uint edge = 0; edge < 3; ++edge) {
        p.above[edge] = words[WORD_SLOPE_ABOVE + edge];
        p.below[edge] = words[WORD_SLOPE_BELOW + edge];
        p.greater[edge] = GREATER(p.above[edge], p.below[edge]);
    }
    p.gradient_x = words[NUMBER_GRADIENT_X];
    p.gradient_y = words[NUMBER_GRADIENT_Y];
    p.gradient_z = words[NUMBER_GRADIENT_Z];
    p.along_right = along_right;
    p.along_left = along_left;
    p.across_right = across_right;
    p.across_left = across_left;
    p.all_compact = lanes_to_bits((flags & (int)CLSDF_POLYHEDRON_COMPACT) == 0) == 0;
    return p;
}

// The half widths of blocks along the normal of each plane, with slack.
typedef struct LaneExtent {
    floatL z, base, right, left;
    // At a corner: the sum of the extents along its two planes, minus the corner's own extent.
    floatL past_right_end, past_left_end, past_apex;
} LaneExtent;

// The extent of blocks that extend half_x, half_y and half_z samples from their centres.
INLINE LaneExtent extent_of_lanes(const LanePolyhedra* p, float half_x, float half_y, float half_z, float slack) {
    LaneExtent extent;
#define EXTENT(x, y, z) ((fabs(x) * half_x + (fabs(y) * half_y + fabs(z) * half_z)) * (1.0f + 1.0e-6f))
#define EXTENT_OF(plane) EXTENT(p->step_x.plane, p->step_y.plane, p->step_z.plane)
    const floatL x = EXTENT(p->gradient_x, p->gradient_y, p->gradient_z), y = EXTENT_OF(base);
    extent.z = EXTENT_OF(z) + slack;
    extent.base = y + slack;
    extent.right = EXTENT_OF(right) + slack;
    extent.left = EXTENT_OF(left) + slack;
    // The slack of a sum of two bounds, with factors of at most one, is twice theirs.
    extent.past_right_end = extent.right + p->across_right * extent.base - (p->along_right * x + 2.0f * slack);
    extent.past_left_end = extent.left + p->across_left * extent.base - (p->along_left * x + 2.0f * slack);
    extent.past_apex = p->along_left * extent.right + p->along_right * extent.left -
                       ((p->along_left * p->across_right + p->along_right * p->across_left) * y + 2.0f * slack);
#undef EXTENT_OF
#undef EXTENT
    return extent;
}

INLINE PlaneDistances without_extent(PlaneDistances at, const LaneExtent* extent) {
    at.base -= extent->base;
    at.right -= extent->right;
    at.left -= extent->left;
    return at;
}

// Slopes of the lateral planes for blocks whose heights over the face differ by at most `extent` from z. If the blocks
// lie on one side, they are the slopes of that side, else the greater slopes, which bound both sides.
INLINE void slopes_at(const LanePolyhedra* p, floatL z, floatL extent, floatL* slopes) {
    const intL is_above = z > extent, is_below = -z > extent;
#pragma unroll
    for (uint edge = 0; edge < 3; ++edge)
        slopes[edge] = is_above ? p->above[edge] : is_below ? p->below[edge] : p->greater[edge];
}

// The sign bit of each lane tells whether the lane's polyhedron overlaps a block; other bits have no meaning. (Sign
// bits are combined by logical operations, without comparisons.) at: distances at the block's centre, without extent;
// slopes: of the lateral planes there.
//
// Between two lateral planes that meet at a sharp angle a block can lie far from the triangle and yet overlap both. The
// polyhedron ends there at its corner: along X at the ends of the base, along Y above the apex. That bound is a sum of
// the planes' own, each times a normal's component.
INLINE intL overlaps(const LanePolyhedra* p, PlaneDistances at, const floatL* slopes, const LaneExtent* extent,
                     float bound) {
    const floatL height = fabs(at.z), wide = height + extent->z;
    floatL past_base, past_right, past_left;
    intL in = as_intL(height - extent->z - bound);
    if (p->all_compact) {
        past_base = at.base - slopes[CLSDF_EDGE_BASE] * wide;
        past_right = at.right - slopes[CLSDF_EDGE_RIGHT] * wide;
        past_left = at.left - slopes[CLSDF_EDGE_LEFT] * wide;
    } else {
        past_base = at.base - LESSER(slopes[CLSDF_EDGE_BASE] * wide, bound);
        past_right = at.right - LESSER(slopes[CLSDF_EDGE_RIGHT] * wide, bound);
        past_left = at.left - LESSER(slopes[CLSDF_EDGE_LEFT] * wide, bound);
        in &= as_intL(at.right + (p->across_right * at.base + (extent->past_right_end - p->along_right * bound))) &
              as_intL(at.left + (p->across_left * at.base + (extent->past_left_end - p->along_left * bound)));
    }
    return in & as_intL(past_base) & as_intL(past_right) & as_intL(past_left) &
           as_intL(past_right + (p->across_right * past_base + extent->past_right_end)) &
           as_intL(past_left + (p->across_left * past_base + extent->past_left_end)) &
           as_intL(p->along_left * past_right + (p->along_right * past_left + extent->past_apex));
}

// If all blocks of a group lie on one side of all faces, all values that overlaps() compares are affine. A step to the
// next block is then seven additions. Only for compact polyhedra.
typedef struct OneSide {
    floatL height, base, right, left;  // without extent
    floatL right_end, left_end, apex;  // the corners
} OneSide;

// If `extent` is null, returns the values of a step, else those at a point; there no extent is subtracted from at.z
// yet. side: 1 above the face, -1 below it.
INLINE OneSide one_side(const LanePolyhedra* p, PlaneDistances at, floatL side, const floatL* slopes,
                        const LaneExtent* extent) {
    OneSide one;
    const floatL height = side * at.z, wide = extent ? height + extent->z : height;
    one.height = extent ? height - extent->z : height;
    one.base = at.base - slopes[CLSDF_EDGE_BASE] * wide;
    one.right = at.right - slopes[CLSDF_EDGE_RIGHT] * wide;
    one.left = at.left - slopes[CLSDF_EDGE_LEFT] * wide;
    one.right_end = one.right + p->across_right * one.base;
    one.left_end = one.left + p->across_left * one.base;
    one.apex = p->along_left * one.right + p->along_right * one.left;
    if (extent) {
        one.right_end += extent->past_right_end;
        one.left_end += extent->past_left_end;
        one.apex += extent->past_apex;
    }
    return one;
}

INLINE OneSide one_side_sum(OneSide a, OneSide b) {
    a.height += b.height;
    a.base += b.base;
    a.right += b.right;
    a.left += b.left;
    a.right_end += b.right_end;
    a.left_end += b.left_end;
    a.apex += b.apex;
    return a;
}

// As overlaps().
INLINE intL overlaps_one_side(OneSide at, float bound) {
    return as_intL(at.height - bound) & as_intL(at.base) & as_intL(at.right) & as_intL(at.left) &
           as_intL(at.right_end) & as_intL(at.left_end) & as_intL(at.apex);
}

#endif
