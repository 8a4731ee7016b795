// One definition for the host and the kernels: what is kept while the coarse bricks' lists are made.
#ifndef CLSDF_COARSE_H
#define CLSDF_COARSE_H

#ifdef __OPENCL_VERSION__
typedef ulong clsdf_uint64;
#else
#include "polyhedron.h"
namespace clsdf {
using clsdf_uint64 = std::uint64_t;
#endif

// A point of the surface: the foot of a polyhedron's altitude.
typedef struct SurfacePoint {
    clsdf_int32 origin[3];  // in samples of the lattice
    float foot[3];          // from there, in units
} SurfacePoint;

// What a polyhedron touches of a group of 4 x 4 x 4 coarse bricks.
typedef struct Touch {
    clsdf_uint32 polyhedron;
    clsdf_int32 base;  // the number, among the part's coarse bricks, of the group's first; negative if it lies before
    clsdf_uint64 bricks;  // bit b: x = b & 3, y = b >> 2 & 3, z = b >> 4 of the group
} Touch;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(SurfacePoint) == 24 && sizeof(Touch) == 16);
}  // namespace clsdf
#endif

#endif
