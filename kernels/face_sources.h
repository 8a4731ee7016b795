// One definition for the host and the kernels: what records are made from on a device with memory of its own.
#ifndef CLSDF_FACE_SOURCES_H
#define CLSDF_FACE_SOURCES_H

#include "polyhedron.h"

// Records are selected and made in groups of so many (polyhedra/records.hpp).
#define CLSDF_RECORD_GROUP 16
// A face's name is its triangle's index in the caller's order, with this bit if three faces or more meet at an edge.
#define CLSDF_NAME_NON_MANIFOLD 0x80000000u

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// A lattice (polyhedra/lattice_view.hpp).
typedef struct FaceLattice {
    double origin[3];   // in the mesh's units
    double spacing[3];  // in units
    double sample[3];   // spacing in the mesh's units
    double per_unit;    // 1 / unit
} FaceLattice;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(FaceLattice) == 80);
}  // namespace clsdf
#endif

#endif
