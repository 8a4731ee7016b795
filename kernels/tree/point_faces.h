// One definition for the host and the kernels: what kernels find about the faces that points are looked up among.
#ifndef CLSDF_POINT_FACES_H
#define CLSDF_POINT_FACES_H

#include "polyhedron.h"

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// Counts of faces and vertices.
typedef struct PointFacesFound {
    clsdf_uint32 special;     // faces whose frame may be a special case of the host's
    clsdf_uint32 inexact;     // vertices with a coordinate that is not 0, and of no size from 2^-300 to 2^300 units
    clsdf_uint32 immoderate;  // the same, from 2^-60 to 2^40 units
} PointFacesFound;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(PointFacesFound) == 12);
}  // namespace clsdf
#endif

#endif
