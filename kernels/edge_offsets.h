// A point's offsets from the edges of a triangle, in the triangle's frame, and the squared distance that follows from
// them: the formula of distance.h for any type of numbers.
#ifndef CLSDF_EDGE_OFFSETS_H
#define CLSDF_EDGE_OFFSETS_H

#include "simd.h"

// Defines the struct `EdgeOffsets` and the function edge_offsets(), for numbers of the type Real and comparisons of the
// type Mask. (x, y): the point, in the frame's plane. The offsets are from the edges of the half on the point's side.
#define DEFINE_EDGE_OFFSETS(EdgeOffsets, edge_offsets, Real, Mask)                                         \
    typedef struct EdgeOffsets {                                                                           \
        Real y;                                                                                            \
        Real away;          /* from the altitude */                                                        \
        Real along, across; /* normal of the slanted edge */                                               \
        Real beyond;        /* along the base, past its end */                                             \
        Real outward;       /* from the slanted edge */                                                    \
        Real before;        /* along the slanted edge, before its end at the base */                       \
        Real past;          /* and past the apex */                                                        \
        Mask left, below;   /* the half; below the base */                                                 \
    } EdgeOffsets;                                                                                         \
    INLINE EdgeOffsets edge_offsets(Real x, Real y, Real base_right, Real base_left, Real along_right,     \
                                    Real along_left, Real across_right, Real across_left, Real altitude) { \
        EdgeOffsets o;                                                                                     \
        o.left = x < (Real)0.0f;                                                                           \
        o.below = y < (Real)0.0f;                                                                          \
        o.y = y;                                                                                           \
        o.away = fabs(x);                                                                                  \
        o.along = select(along_right, along_left, o.left);                                                 \
        o.across = select(across_right, across_left, o.left);                                              \
        o.beyond = o.away - select(base_right, base_left, o.left);                                         \
        o.outward = o.along * o.beyond + o.across * y;                                                     \
        o.before = o.across * o.beyond - o.along * y;                                                      \
        o.past = o.along * (y - altitude) - o.across * o.away;                                             \
        return o;                                                                                          \
    }

// Defines a function that computes the squared distance. z: the point's height above the frame's plane.
#define DEFINE_SQUARED_BY_OFFSETS(squared_by_offsets, EdgeOffsets, Real)                                   \
    INLINE Real squared_by_offsets(EdgeOffsets o, Real z) {                                                \
        const Real r = select(o.outward, -o.y, o.below), zero = (Real)0.0f;                                \
        const Real before = select(o.before, o.beyond, o.below), past = select(o.past, o.beyond, o.below); \
        const Real farther = GREATER(past, before);                                                        \
        const Real along = GREATER(farther, zero), outward = GREATER(r, zero);                             \
        return along * along + (outward * outward + z * z);                                                \
    }

#endif
