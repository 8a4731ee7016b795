// One definition for the host and the kernels: the tree in which points look for their nearest triangle.
//
// Faces are in Morton order. A node of level 1 is 16 consecutive faces, a node of the next level 16 consecutive nodes,
// up to one root. Lengths are in units of the points' lattice (lib/points/point_mesh.hpp).
#ifndef CLSDF_POINT_TREE_H
#define CLSDF_POINT_TREE_H

#include "polyhedron.h"

#define CLSDF_TREE_WIDTH 16
// Levels of nodes: enough for 2^30 faces.
#define CLSDF_TREE_LEVELS 8
// A node on the stack of a search: its level and its number there.
#define CLSDF_TREE_LEVEL_SHIFT 26
#define CLSDF_TREE_STACK (CLSDF_TREE_LEVELS * CLSDF_TREE_WIDTH)

// The sign of a point, as finishing is told.
#define CLSDF_POINT_OUTSIDE 0
#define CLSDF_POINT_INSIDE 1
#define CLSDF_POINT_ON_SURFACE 2
#define CLSDF_POINT_UNDECIDED 3
#define CLSDF_POINT_FINISHED 4

// Sides of a face, in 16 bits. Bits 0 to 5: the face's site of that number tells a point's side as the face does.
#define CLSDF_SIDES_KNOWN 0x40u
#define CLSDF_SIDES_FRONT_INSIDE 0x80u
#define CLSDF_SIDES_BACK_INSIDE 0x100u

// The nearest face of a point beyond the search's limit.
#define CLSDF_NO_FACE 0xFFFFFFFFu

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

typedef struct PointTree {
    clsdf_uint32 faces;                     // their number
    clsdf_uint32 levels;                    // of nodes; the last one has one node, the root
    clsdf_uint32 first[CLSDF_TREE_LEVELS];  // place of each level's first node
    clsdf_uint32 count[CLSDF_TREE_LEVELS];  // nodes of each level
} PointTree;

// Boxes of a node's children, by axis; wider than the faces by more than the rounding of frames. Missing children have
// boxes that hold nothing.
typedef struct PointNode {
    float lower[3][CLSDF_TREE_WIDTH];
    float upper[3][CLSDF_TREE_WIDTH];
} PointNode;

// The frame of a face (polyhedron.h), from the lattice's origin.
typedef struct FaceFrame {
    double gradient[3][3];  // by axis of the lattice, then X, Y, Z
    double offset[3];
    double base[2];
    double normal_along[2];
    double normal_across[2];
    double altitude;
    clsdf_uint32 triangle;  // in the caller's order
    // The lowest face, in the caller's order, with the same three vertices. Rounding decides which of them a search
    // finds, because frames depend on the order of corners; the outputs are those of the lowest one.
    clsdf_uint32 lowest;
} FaceFrame;

// Frames of the faces of a node of level 1, from an origin near them. The last face fills a leaf that is not full.
typedef struct PointLeaf {
    float gradient[3][3][CLSDF_TREE_WIDTH];
    float offset[3][CLSDF_TREE_WIDTH];
    float base[2][CLSDF_TREE_WIDTH];
    float normal_along[2][CLSDF_TREE_WIDTH];
    float normal_across[2][CLSDF_TREE_WIDTH];
    float altitude[CLSDF_TREE_WIDTH];
    float origin[3];
    float extent;  // of the greatest frame: the sum of its lengths
    float padding[12];
} PointLeaf;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(PointTree) == 72);
static_assert(sizeof(PointNode) == 384);
static_assert(sizeof(PointLeaf) == 1280 && offsetof(PointLeaf, origin) == 1216);
static_assert(sizeof(FaceFrame) == 160 && offsetof(FaceFrame, triangle) == 152);
}  // namespace clsdf
#endif

// One definition for the host and the kernels: points in groups, and what ties between faces are decided with.
//
// Points lie in the order of a curve. 16 that follow each other are a vector, 16 vectors a brick, 16 bricks a block, 16
// blocks a superblock.

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
    clsdf_uint32 vertex[CLSDF_POINTS_OF_BRICK];            // all whose faces have been looked at
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
