// Squared distances in double between points and the faces of a tree: each kernel has the same bits of the same pair.
//
// A kernel that takes one pair at a time defines REAL and TRUTH as double and long; the others take LANES pairs.
#ifndef CLSDF_POINT_DISTANCE_H
#define CLSDF_POINT_DISTANCE_H

#include "edge_offsets.h"
#include "point_tree.h"
#include "simd.h"

#ifndef REAL
#define REAL doubleL
#define TRUTH longL
#endif

DEFINE_EDGE_OFFSETS(PointEdgeOffsets, point_edge_offsets, REAL, TRUTH)
DEFINE_SQUARED_BY_OFFSETS(point_squared_by_offsets, PointEdgeOffsets, REAL)

// The face that stands for equal ones; CLSDF_NO_FACE for itself.
INLINE uint lowest_face(__global const FaceFrame* frames, uint face) {
    return face == CLSDF_NO_FACE ? face : frames[face].lowest;
}

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

// The squared distance of a point and a face, with the offsets that give it.
typedef struct FaceDistance {
    REAL squared;
    PointEdgeOffsets offsets;
} FaceDistance;

INLINE FaceDistance face_distance(const PlacedFrame f) {
    FaceDistance d;
    d.offsets =
        point_edge_offsets(f.x, f.y, f.base[CLSDF_HALF_RIGHT], f.base[CLSDF_HALF_LEFT], f.along[CLSDF_HALF_RIGHT],
                           f.along[CLSDF_HALF_LEFT], f.across[CLSDF_HALF_RIGHT], f.across[CLSDF_HALF_LEFT], f.altitude);
    d.squared = point_squared_by_offsets(d.offsets, f.z);
    return d;
}

#endif
