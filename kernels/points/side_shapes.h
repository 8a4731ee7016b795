// One definition for the host and the kernels: a face while kernels look for the sides of faces (face_sides.h).
#ifndef CLSDF_SIDE_SHAPES_H
#define CLSDF_SIDE_SHAPES_H

#include "polyhedron.h"

// In units, far above the rounding of distances, 1e-10 (docs/method.md, 'Sides of faces').
#define LEAST_SIDE_GAP 1.0e-6       // between faces without a common vertex
#define LEAST_SIDE_ALTITUDE 1.0e-5  // of a face
#define LEAST_SIDE_SINE 1.0e-3      // of a face's angles
// Sine of an angle between faces with a common vertex or edge.
#define LEAST_SIDE_ANGLE 1.0e-2
// Faces at a vertex: all pairs of them are compared.
#define MOST_SIDES_IN_FAN 256
// Cosine between a vertex' pseudonormal and the normals of its faces: 44 degrees.
#define LEAST_COSINE_OF_VERTEX 0.7193
// A point in front of a face whose crossings are counted: nearer than other faces are.
#define OFFSET_IN_FRONT (0.5 * LEAST_SIDE_GAP)
#define LEAST_ALTITUDE_IN_FRONT (3 * 1.01 * LEAST_SIDE_GAP / LEAST_SIDE_ANGLE)

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

typedef struct SideShape {
    double normal[3];  // of length 1, or 0
    double altitude;   // the least, in units; 0: no normal
    float lower[3];    // a box around the face, in units
    float upper[3];
    clsdf_uint32 is_excluded;  // by its own shape or its vertices
    clsdf_uint32 root;         // the lowest face of those whose fronts are one place
} SideShape;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(SideShape) == 64 && offsetof(SideShape, lower) == 32 && offsetof(SideShape, is_excluded) == 56);
}  // namespace clsdf
#endif

#endif
