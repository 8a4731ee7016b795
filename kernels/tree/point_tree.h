// One definition for the host and the kernels: the tree in which points look for their nearest triangle.
//
// Faces are in Morton order. A node of level 1 is 16 consecutive faces, a node of the next level 16 consecutive nodes,
// up to one root. Lengths are in units of the points' lattice (lib/engine/tree/point_mesh.hpp).
#ifndef CLSDF_POINT_TREE_H
#define CLSDF_POINT_TREE_H

#include "polyhedron.h"

#define CLSDF_TREE_WIDTH 16
// Levels of nodes: enough for 2^30 faces.
#define CLSDF_TREE_LEVELS 8

// In place of a child: none is to be visited any more (tree_walk.h).
#define CLSDF_NO_CHILD 0xFFFFFFFFu

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

// A test counts the work of searches.
#ifndef COUNTED
#define COUNTED(what, number)
#endif

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

// A closed box in units.
typedef struct PointBox {
    float lower[3], upper[3];
} PointBox;

// Data of a face that a search reads beside its record (polyhedron.h).
typedef struct PointFace {
    double offset[3];       // X, Y, Z at the lattice's origin
    clsdf_uint32 triangle;  // in the caller's order
    // The lowest face, in the caller's order, with the same three vertices. Rounding decides which of them a search
    // finds, because frames depend on the order of corners; the outputs are those of the lowest one.
    clsdf_uint32 lowest;
} PointFace;

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
static_assert(sizeof(PointFace) == 32);
static_assert(sizeof(PointLeaf) == 1280 && offsetof(PointLeaf, origin) == 1216);
}  // namespace clsdf
#endif

#endif
