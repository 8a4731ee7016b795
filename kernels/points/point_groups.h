// One definition for the host and the kernels: points in groups, and what ties between faces are decided with.
//
// Points lie in the order of a curve. 16 that follow each other are a vector, 16 vectors a brick, 16 bricks a block, 16
// blocks a superblock.
#ifndef CLSDF_POINT_GROUPS_H
#define CLSDF_POINT_GROUPS_H

#include "polyhedron.h"

#define CLSDF_GROUP_WIDTH 16
#define CLSDF_POINTS_OF_BRICK 256
#define CLSDF_POINTS_OF_BLOCK 4096

// In place of the face across an edge: there is none, or there are several. Several are found among the faces at the
// edge's ends.
#define CLSDF_NONE_ACROSS 0xFFFFFFFFu
#define CLSDF_MANY_ACROSS 0xFFFFFFFEu

// Distances that wait for a decision in double, and how many of them a work-item keeps.
#define CLSDF_CANDIDATES 1024

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// Boxes of a group's children, in units from the integer origin.
typedef struct PointGroup {
    clsdf_int32 origin[3];
    clsdf_uint32 children;  // that there are
    float centre[3][CLSDF_GROUP_WIDTH];
    float half_side[3][CLSDF_GROUP_WIDTH];
} PointGroup;

// The vertices of a face, and the faces across its edges; edge k runs from vertex k to the next.
typedef struct FaceNeighbours {
    clsdf_uint32 vertex[3];
    clsdf_uint32 across[3];
} FaceNeighbours;

// The numbers of a polyhedron (polyhedron.h) that a scan reads, in two cache lines.
typedef struct ScanRecord {
    float gradient_x[3];
    float gradient_y[3];
    float gradient_z[3];
    float constant_at_origin[3];
    float base[2];
    float normal_along[2];
    float normal_across[2];
    float slope_above[3];
    float slope_below[3];
    float foot[3];
    clsdf_int32 origin_x;
    clsdf_int32 origin_y;
    clsdf_int32 origin_z;
    clsdf_uint32 flags;
    float altitude;
} ScanRecord;

// Records: those of faces come first, then those of point sites.
typedef struct ScanCounts {
    clsdf_uint32 faces;
    clsdf_uint32 records;
    float longest;  // side of a face, or more
} ScanCounts;

// A work-item's own memory for a brick of points, and for distances to them.
typedef struct PointBrick {
    double at[3][CLSDF_POINTS_OF_BRICK];                   // in units from the lattice's origin
    double squared[CLSDF_POINTS_OF_BRICK];                 // the least so far
    float from_origin[3][CLSDF_POINTS_OF_BRICK];           // from the brick's
    float bound[CLSDF_POINTS_OF_BRICK];                    // of the squared distance
    clsdf_uint32 triangle[CLSDF_POINTS_OF_BRICK];          // the nearest, in the caller's order
    clsdf_uint32 face[CLSDF_POINTS_OF_BRICK];              // in the tree's
    clsdf_uint32 vertex[CLSDF_POINTS_OF_BRICK];            // whose faces were taken last; see take_vertex()
    float candidate[CLSDF_CANDIDATES][CLSDF_GROUP_WIDTH];  // squared distances, less their error
    clsdf_uint32 record[CLSDF_CANDIDATES];
    clsdf_uint32 vector[CLSDF_CANDIDATES];
} PointBrick;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(PointGroup) == 400 && offsetof(PointGroup, centre) == 16);
static_assert(sizeof(FaceNeighbours) == 24);
static_assert(sizeof(ScanRecord) == 128 && offsetof(ScanRecord, origin_x) == offsetof(Polyhedron, origin_x));
static_assert(sizeof(ScanCounts) == 12);
static_assert(sizeof(PointBrick) == CLSDF_POINTS_OF_BRICK * 60 + CLSDF_CANDIDATES * 72);
}  // namespace clsdf
#endif

#endif
