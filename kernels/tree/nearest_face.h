// The nearest face of a point so far: the least pair (squared distance in double, triangle in the caller's order).
#ifndef CLSDF_NEAREST_FACE_H
#define CLSDF_NEAREST_FACE_H

#include "point_distance.h"
#include "point_tree.h"
#include "simd.h"

typedef struct NearestFace {
    double squared;  // in units
    uint triangle;   // in the caller's order
    uint face;       // in the tree's
    float bound;     // the squared distance as a float
} NearestFace;

// Before the search. most: a squared distance beyond which nothing is looked for; it may be infinite.
INLINE NearestFace none_nearest(double most) {
    const NearestFace none = {most, 0xFFFFFFFFu, CLSDF_NO_FACE, (float)most};
    return none;
}

// Takes a face if it is nearer.
INLINE void take_if_nearer(__global const Polyhedron* polyhedra, __global const PointFace* faces, uint face, double3 p,
                           __private NearestFace* found) {
    const double squared = face_distance(polyhedra + face, faces + face, p.x, p.y, p.z).squared;
    const uint triangle = faces[face].triangle;
    if (squared < found->squared || (squared == found->squared && triangle < found->triangle)) {
        found->squared = squared;
        found->triangle = triangle;
        found->face = face;
        found->bound = (float)squared;
    }
}

#endif
