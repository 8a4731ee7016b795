// Squared distances in double between points and the faces of a tree: each kernel has the same bits of the same pair.
//
// A kernel that takes one pair at a time defines REAL and TRUTH as double and int; the others take LANES pairs.
#ifndef CLSDF_POINT_DISTANCE_H
#define CLSDF_POINT_DISTANCE_H

#include "lanes.h"
#include "point_tree.h"

#ifndef REAL
#define REAL doubleL
#define TRUTH longL
#endif

// A face's frame (point_tree.h) and a point's place in it.
typedef struct PlacedFrame {
    REAL x, y, z;  // of the point
    REAL base[2], along[2], across[2], altitude;
} PlacedFrame;

// Sets a PlacedFrame for the point `p`. GET(member): of the face's frame.
#define PLACED_COORDINATE(GET, column, p) \
    (GET(gradient[0][column]) * (p).x +   \
     (GET(gradient[1][column]) * (p).y + (GET(gradient[2][column]) * (p).z + GET(offset[column]))))

#define SET_PLACED_FRAME(GET, p, frame)                                  \
    {                                                                    \
        (frame).x = PLACED_COORDINATE(GET, 0, p);                        \
        (frame).y = PLACED_COORDINATE(GET, 1, p);                        \
        (frame).z = PLACED_COORDINATE(GET, 2, p);                        \
        for (int half_index = 0; half_index < 2; ++half_index) {         \
            (frame).base[half_index] = GET(base[half_index]);            \
            (frame).along[half_index] = GET(normal_along[half_index]);   \
            (frame).across[half_index] = GET(normal_across[half_index]); \
        }                                                                \
        (frame).altitude = GET(altitude);                                \
    }

// The nearest point of a triangle in its frame; see distance.h.
typedef struct FaceDistance {
    REAL squared;
    REAL y;
    REAL beyond;   // along the base past its end
    REAL outward;  // from the slanted edge
    REAL before;   // along the slanted edge before its end at the base
    REAL past;     // and past the apex
    TRUTH left;    // the half
} FaceDistance;

INLINE FaceDistance face_distance(const PlacedFrame f) {
    FaceDistance d;
    d.left = f.x < 0.0;
    d.y = f.y;
    const TRUTH below = f.y < 0.0;
    const REAL away = d.left ? -f.x : f.x;
    const REAL along = d.left ? f.along[CLSDF_HALF_LEFT] : f.along[CLSDF_HALF_RIGHT];
    const REAL across = d.left ? f.across[CLSDF_HALF_LEFT] : f.across[CLSDF_HALF_RIGHT];
    const REAL above_apex = f.y - f.altitude;
    d.beyond = away - (d.left ? f.base[CLSDF_HALF_LEFT] : f.base[CLSDF_HALF_RIGHT]);
    d.outward = along * d.beyond + across * f.y;
    d.before = across * d.beyond - along * f.y;
    d.past = along * above_apex - across * away;
    const REAL r = below ? -f.y : d.outward;
    const REAL before = below ? d.beyond : d.before, past = below ? d.beyond : d.past;
    const REAL farther = GREATER(past, before), zero = (REAL)0.0;
    const REAL end = GREATER(farther, zero), outside = GREATER(r, zero);
    d.squared = end * end + (outside * outside + f.z * f.z);
    return d;
}

#endif
