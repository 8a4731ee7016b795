// The offsets of a point from the outer edges of a triangle's half, and the squared distance that follows from offsets:
// the formula of distance.h for any type of numbers.
#ifndef CLSDF_EDGE_OFFSETS_H
#define CLSDF_EDGE_OFFSETS_H

#include "simd.h"

// Defines a function that evaluates the formula. r: outward from the edge that counts; before: -t; past: t minus the
// length of the edge. Only the greater of the two counts. The base continues in the other half, so its `before` may be
// any value that does not exceed `past`.
#define DEFINE_SQUARED_FROM_EDGE(squared_from_edge, Real)                      \
    INLINE Real squared_from_edge(Real r, Real before, Real past, Real z) {    \
        const Real zero = (Real)0.0f, farther = GREATER(past, before);         \
        const Real along = GREATER(farther, zero), outward = GREATER(r, zero); \
        /* What takes longest to find is added last. */                        \
        return along * along + (outward * outward + z * z);                    \
    }

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

// The arguments of squared_from_edge() but z, converted by `to`: below the base, the base is the edge that counts.
#define EDGE_THAT_COUNTS(o, to)                                                                \
    to(select((o).outward, -(o).y, (o).below)), to(select((o).before, (o).beyond, (o).below)), \
        to(select((o).past, (o).beyond, (o).below))

#endif
