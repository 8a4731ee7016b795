// Squared distances in double between points and the faces of a tree: each kernel has the same bits of the same pair.
#ifndef CLSDF_POINT_DISTANCE_H
#define CLSDF_POINT_DISTANCE_H

#include "lanes.h"
#include "point_tree.h"

// Numbers of a leaf's faces (point_tree.h), and points: of LANES pairs of a face and a point.
typedef struct LeafFrame {
    doubleL x, y, z;  // of the point
    doubleL base[2], along[2], across[2], altitude;
} LeafFrame;

// Sets LeafFrame's member, a coordinate of the frame, at the point `p`. GET(member): of the leaf.
#define LEAF_COORDINATE(GET, column, p) \
    (GET(gradient[0][column]) * (p).x + \
     (GET(gradient[1][column]) * (p).y + (GET(gradient[2][column]) * (p).z + GET(offset[column]))))

#define SET_LEAF_FRAME(GET, p, frame)                                    \
    {                                                                    \
        (frame).x = LEAF_COORDINATE(GET, 0, p);                          \
        (frame).y = LEAF_COORDINATE(GET, 1, p);                          \
        (frame).z = LEAF_COORDINATE(GET, 2, p);                          \
        for (int half_index = 0; half_index < 2; ++half_index) {         \
            (frame).base[half_index] = GET(base[half_index]);            \
            (frame).along[half_index] = GET(normal_along[half_index]);   \
            (frame).across[half_index] = GET(normal_across[half_index]); \
        }                                                                \
        (frame).altitude = GET(altitude);                                \
    }

// Where the nearest point of a triangle lies: see distance.h.
typedef struct LeafDistance {
    doubleL squared;
    doubleL y;
    doubleL beyond;   // along the base past its end
    doubleL outward;  // from the slanted edge
    doubleL before;   // along the slanted edge before its end at the base
    doubleL past;     // and past the apex
    longL left;       // the half
} LeafDistance;

INLINE LeafDistance leaf_distance(const LeafFrame f) {
    LeafDistance d;
    d.left = f.x < 0.0;
    d.y = f.y;
    const longL below = f.y < 0.0;
    const doubleL away = d.left ? -f.x : f.x;
    const doubleL along = d.left ? f.along[CLSDF_HALF_LEFT] : f.along[CLSDF_HALF_RIGHT];
    const doubleL across = d.left ? f.across[CLSDF_HALF_LEFT] : f.across[CLSDF_HALF_RIGHT];
    const doubleL above_apex = f.y - f.altitude;
    d.beyond = away - (d.left ? f.base[CLSDF_HALF_LEFT] : f.base[CLSDF_HALF_RIGHT]);
    d.outward = along * d.beyond + across * f.y;
    d.before = across * d.beyond - along * f.y;
    d.past = along * above_apex - across * away;
    const doubleL r = below ? -f.y : d.outward;
    const doubleL before = below ? d.beyond : d.before, past = below ? d.beyond : d.past;
    const doubleL farther = GREATER(past, before), zero = (doubleL)0.0;
    const doubleL end = GREATER(farther, zero), outside = GREATER(r, zero);
    d.squared = end * end + (outside * outside + f.z * f.z);
    return d;
}

#endif
