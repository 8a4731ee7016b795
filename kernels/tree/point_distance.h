// Squared distances in double between points and the faces of a tree: each kernel, and the host, has the same bits of
// the same pair. So multiply-adds are not fused here.
//
// A kernel of several lanes that takes one pair at a time defines REAL and TRUTH as double and long; the others take
// LANES pairs.
#ifndef CLSDF_POINT_DISTANCE_H
#define CLSDF_POINT_DISTANCE_H

#include "edge_offsets.h"
#include "point_tree.h"
#include "simd.h"

#ifndef REAL
#define REAL doubleL
#define TRUTH longL
#endif

#pragma OPENCL FP_CONTRACT OFF

DEFINE_EDGE_OFFSETS(PointEdgeOffsets, point_edge_offsets, REAL, TRUTH)
DEFINE_SQUARED_FROM_EDGE(point_squared_from_edge, REAL)

// The face that stands for equal ones; CLSDF_NO_FACE for itself.
INLINE uint lowest_face(__global const PointFace* faces, uint face) {
    return face == CLSDF_NO_FACE ? face : faces[face].lowest;
}

// The squared distance of a point and a face, with the offsets that give it.
typedef struct FaceDistance {
    REAL squared;
    PointEdgeOffsets offsets;
} FaceDistance;

// (x, y, z): the point, from the lattice's origin.
INLINE FaceDistance face_distance(__global const Polyhedron* record, __global const PointFace* face, REAL x, REAL y,
                                  REAL z) {
#define COORDINATE(n)                        \
    ((REAL)record->exact_gradient_x[n] * x + \
     ((REAL)record->exact_gradient_y[n] * y + ((REAL)record->exact_gradient_z[n] * z + (REAL)face->offset[n])))
    const double2 base = vload2(0, record->exact_base);
    const double4 normal = vload4(0, record->exact_normal_along);  // along right, left, across right, left
    FaceDistance d;
    d.offsets = point_edge_offsets(COORDINATE(0), COORDINATE(1), (REAL)base.x, (REAL)base.y, (REAL)normal.x,
                                   (REAL)normal.y, (REAL)normal.z, (REAL)normal.w, (REAL)record->exact_altitude);
    d.squared = point_squared_from_edge(EDGE_THAT_COUNTS(d.offsets, ), COORDINATE(2));
#undef COORDINATE
    return d;
}

#pragma OPENCL FP_CONTRACT ON

#endif
