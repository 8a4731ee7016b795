// One definition for the host and the kernels: what kernels find when they make the faces that points are looked up
// among, and their tree.
#ifndef CLSDF_POINT_FACES_H
#define CLSDF_POINT_FACES_H

#include "polyhedron.h"

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

typedef struct PointFacesFound {
    double area;              // half of the areas of the tree's boxes; 0: one leaf
    clsdf_uint32 special;     // faces whose frame may be a special case of the host's
    clsdf_uint32 inexact;     // vertices with a coordinate that is not 0, and of no size from 2^-300 to 2^300 units
    clsdf_uint32 immoderate;  // the same, from 2^-60 to 2^40 units
    clsdf_uint32 padding;
} PointFacesFound;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(PointFacesFound) == 24 && offsetof(PointFacesFound, special) == 8);
}  // namespace clsdf
#endif

#endif
