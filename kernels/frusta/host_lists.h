// One definition for the host and the kernels: the lists of faces that the host looks at (host_lists.cl).
#ifndef CLSDF_HOST_LISTS_H
#define CLSDF_HOST_LISTS_H

#include "polyhedron.h"

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// The lengths of the lists of faces that kernels leave to the host. They begin as zeros.
typedef struct ListCounts {
    clsdf_uint32 measured;    // faces left to the host, and those around such vertices
    clsdf_uint32 near;        // these and all faces at the edges of those that the host measures
    clsdf_uint32 saddles;     // saddle vertices beside those left to the host
    clsdf_uint32 is_refused;  // 1: a list is too long, or too many faces share a vertex; the host looks at all faces
} ListCounts;

// The sizes of a mesh, where the parts of an array of words begin, all of which begin as zeros, and the room of each
// list.
typedef struct ListSizes {
    clsdf_uint32 vertices;
    clsdf_uint32 faces;
    clsdf_uint32 measured;       // a bit for each face: it is in the list
    clsdf_uint32 near_vertices;  // a bit for each vertex: all faces around it are in the next list
    clsdf_uint32 near;           // a bit for each face: it is in the list
    clsdf_uint32 room;
} ListSizes;

// A face near what the host decides.
typedef struct ListedFace {
    double corners[3][3];
    clsdf_uint32 number;       // its place in the order
    clsdf_uint32 triangle;     // the caller's number
    clsdf_uint32 vertices[3];  // numbers in the order
    clsdf_uint32 given[3];     // the caller's numbers
    clsdf_uint32 left;         // bits: see below
    clsdf_uint32 unused;
} ListedFace;
// The host decides about vertex 0, 1, 2; about the slopes of the face; and vertex 0, 1, 2 has a gap, as the kernels
// know.
#define CLSDF_LEFT_VERTEX 1u
#define CLSDF_LEFT_FACE 8u
#define CLSDF_LEFT_GAP 16u

#ifndef __OPENCL_VERSION__
static_assert(sizeof(ListCounts) == 16);
static_assert(sizeof(ListSizes) == 24);
static_assert(sizeof(ListedFace) == 112);
}  // namespace clsdf
#endif

#endif
