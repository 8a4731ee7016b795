// One definition for the host and the kernels: how coarse bricks are grouped, and what is kept while their lists are
// made.
#ifndef CLSDF_COARSE_H
#define CLSDF_COARSE_H

#include "layout.h"

// Coarse bricks are taken by groups of 4 x 4 x 4, 64 bits, which tile the lattice from its sample (0, 0, 0) too: 16
// columns along z.
#define CLSDF_COARSE_GROUP 64
#define CLSDF_COARSE_COLUMNS 16

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// The first group that overlaps the part on an axis, and how many do.
static inline clsdf_int32 first_coarse_group(Layout layout, int axis) {
    return layout.coarse_first[axis] >> 2;
}

static inline clsdf_int32 coarse_groups(Layout layout, int axis) {
    return ((layout.coarse_first[axis] + layout.coarse_bricks[axis] - 1) >> 2) - first_coarse_group(layout, axis) + 1;
}

// A point of the surface: the foot of a polyhedron's altitude.
typedef struct SurfacePoint {
    clsdf_int32 origin[3];  // in samples of the lattice
    float foot[3];          // from there, in units
} SurfacePoint;

// A cluster and a coarse brick, with the polyhedra of the cluster that overlap it.
typedef struct ClusterPair {
    clsdf_uint32 cluster;
    clsdf_uint32 brick;  // its number among the part's coarse bricks
    clsdf_uint32 lanes;  // bit l: polyhedron l of the cluster
} ClusterPair;

// A polyhedron and a coarse brick that overlap, for the group body.
typedef struct CoarsePair {
    clsdf_uint32 brick;  // its number among the part's coarse bricks, or CLSDF_NO_BRICK
    clsdf_uint32 polyhedron;
    clsdf_uint32 index;  // among the pairs of the brick and of the polyhedron's segment, in no order
} CoarsePair;
// A work-item reserves room for so many pairs at a time. Pairs that it does not use get CLSDF_NO_BRICK.
#define CLSDF_PAIR_BLOCK 8
#define CLSDF_NO_BRICK 0xFFFFFFFFu

#ifndef __OPENCL_VERSION__
static_assert(sizeof(SurfacePoint) == 24 && sizeof(ClusterPair) == 12 && sizeof(CoarsePair) == 12);
}  // namespace clsdf
#endif

#endif
