// One definition for the host and the kernels: the tree in which GPUs look for the nearest triangle of a point.
//
// The faces lie in places, by the Morton codes of their centroids; equal codes keep the order of the faces. A node is a
// range of places. It is divided where the highest bit changes in which the keys (code, place) of its ends differ. At
// most CLSDF_LEAF_PLACES places are a leaf. Lengths are in units of the points' lattice.
#ifndef CLSDF_BINARY_TREE_H
#define CLSDF_BINARY_TREE_H

#include "polyhedron.h"

#define CLSDF_LEAF_PLACES 4

// The face of a place. In the two bits above: how many places of its leaf follow.
#define CLSDF_PLACE_SHIFT 30
#define CLSDF_PLACE_FACE 0x3FFFFFFFu

// Nodes between the root and a leaf, both ends included, at most: a bit of a key, of 30 bits of each part, divides
// each.
#define CLSDF_DEEPEST_TREE 64

// Faces of a point that the search lists, so that they are decided in double.
#define CLSDF_LISTED_FACES 16

// Boxes are joined by so many.
#define CLSDF_JOINED_BOXES 8

// Groups that sum the areas of boxes.
#define CLSDF_AREA_GROUPS 512

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// A link leads to a node or, with the bit `leaf`, to the first place of a leaf. An entry of the stack has a link and,
// in the bits above, those of a squared distance, rounded down: the more faces, the fewer bits.
typedef struct BinaryTree {
    clsdf_uint32 root;      // a link
    clsdf_uint32 leaf;      // a power of two above the number of places
    clsdf_uint32 distance;  // the bits of an entry above the link
} BinaryTree;

// Boxes of both children: lower and upper corner. They are wider than the faces by more than the rounding of frames.
typedef struct BinaryNode {
    float box[2][6];
    clsdf_uint32 link[2];
    clsdf_uint32 padding[2];
} BinaryNode;

// The places of a node: those of its first child are [first, middle), those of the second [middle, end).
typedef struct NodePlaces {
    clsdf_uint32 first, middle, end;
    clsdf_uint32 link[2];
} NodePlaces;

// The frame of a face (polyhedron.h) in float, from an origin near it.
typedef struct PlacedFace {
    float frame[3][4];  // of X, Y, Z: the gradient, and the value at the origin
    float base[2];
    float normal_along[2];
    float normal_across[2];
    float altitude;
    // Whole units of the origin's x, y, z, ten bits each. In the two bits above: how many places of the leaf follow.
    clsdf_uint32 origin;
} PlacedFace;

typedef struct FaceBox {
    float lower[3];
    float upper[3];
} FaceBox;

// The lattice that points are measured in, and the cells of the curve.
typedef struct TreeLattice {
    double origin[3];
    double unit;
    double cells_per_unit;  // of the sum of three corners; 0 if the mesh has no extent
    double last_cell;
} TreeLattice;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(BinaryTree) == 12 && sizeof(NodePlaces) == 20 && sizeof(FaceBox) == 24);
static_assert(sizeof(BinaryNode) == 64 && offsetof(BinaryNode, link) == 48);
static_assert(sizeof(PlacedFace) == 80 && offsetof(PlacedFace, base) == 48 && offsetof(PlacedFace, origin) == 76);
static_assert(sizeof(TreeLattice) == 48);
}  // namespace clsdf
#endif

#endif
