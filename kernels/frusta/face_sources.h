// One definition for the host and the kernels: what polyhedra and their records are made from.
#ifndef CLSDF_FACE_SOURCES_H
#define CLSDF_FACE_SOURCES_H

#include "face_edges.h"
#include "polyhedron.h"

// Two faces whose inward directions differ by less than this angle are folded onto each other.
#define CLSDF_FOLD_ANGLE 1.0e-6
// Answers about a face that the kernels leave to the host.
#define CLSDF_FACE_IS_SLIVER 1u  // so thin, or so small, that its frame may be a special case
#define CLSDF_FACE_AT_SLIVER 2u  // the other face at an edge is
// Answers about a vertex.
#define CLSDF_VERTEX_IS_SADDLE 1u  // with convex and concave edges
#define CLSDF_VERTEX_IS_OPEN 2u    // its faces may leave directions out: the host decides
#define CLSDF_VERTEX_HAS_GAP 8u    // and open, and a saddle vertex: they do, by the host's own test
// A direction that a face rejects by less lies within a quarter of the slack of its polyhedron (docs/method.md, 'Gaps
// at saddle vertices'): 1e-3 + 2e-5 d is four times d times this or more, for every distance d in units.
#define CLSDF_REJECTION_MARGIN 5.0e-6
#define CLSDF_VERTEX_IS_IRREGULAR 4u  // and open: no fan or border of few faces, which kernels do not look at
// Vertices of a fan item, the stride of their numbers, and the most faces around one.
#define CLSDF_FAN_ITEM 256
#define CLSDF_FAN_STRIDE 32
#define CLSDF_FAN_FACES 12

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// A lattice (lattice/lattice_view.hpp).
typedef struct FaceLattice {
    double origin[3];   // in the mesh's units
    double spacing[3];  // in units
    double per_unit;    // 1 / unit
} FaceLattice;

// Up to CLSDF_FAN_ITEM vertices with equally many faces. These are one closed fan of one orientation, in
// counter-clockwise order; or, at a border, they have open edges and edges of two faces of one orientation. Blocks of
// CLSDF_FAN_STRIDE vertices follow each other. A block holds a corner of all its vertices at a time: the faces of each
// vertex, and which of its three corners lies there (4 face + corner).
typedef struct FanItem {
    clsdf_uint32 offset;  // of the first block, in words
    clsdf_uint32 count;
    clsdf_uint32 faces;  // around each vertex
    clsdf_uint32 is_border;
} FanItem;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(FaceLattice) == 56);
}  // namespace clsdf
#endif

#endif
