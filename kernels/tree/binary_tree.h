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

// Boxes have their corners on a lattice, whose planes from 0 to 65,535 hold the mesh, which is less than 512 units
// long. The units of a plane are a float without rounding.
#define CLSDF_BOX_CELL (129.0f / 16384.0f)
// Boxes hold the corners of faces. A query allows for more than the rounding of a frame, which has the size of the
// mesh's box, and for what joining moves vertices by.
#define CLSDF_BOX_MARGIN 1.0e-6f

// The unit of a face's foot in fixed point, from the lattice's origin, and the low bits that make a float of their own.
#define CLSDF_FOOT_UNIT 0x1p23f
#define CLSDF_FOOT_LOW_BITS 8

// The size of the greatest number of a face's turn.
#define CLSDF_GREATEST_OF_TURN 32767

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

// Boxes of both children, a word for each axis: planes of the lower corner in the low half, of the upper one above.
typedef struct BinaryNode {
    clsdf_uint32 box[2][3];
    clsdf_uint32 link[2];
} BinaryNode;

// The places of a node: those of its first child are [first, middle), those of the second [middle, end).
typedef struct NodePlaces {
    clsdf_uint32 first, middle, end;
    clsdf_uint32 link[2];
} NodePlaces;

// The frame of a face (polyhedron.h), whose origin is the foot of the altitude. The quaternion (x, y, z, w) turns
// directions into those of the frame. The normals of the slanted edges follow from the lengths.
typedef struct PlacedFace {
    clsdf_uint32 foot[3];  // in fixed point
    float right;           // base[CLSDF_HALF_RIGHT]; its sign is set if the next place is of the same leaf
    float left;
    float altitude;
    clsdf_uint32 turn[2];  // x, and y in the high half; z and w
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
static_assert(sizeof(BinaryNode) == 32 && offsetof(BinaryNode, link) == 24);
static_assert(sizeof(PlacedFace) == 32 && offsetof(PlacedFace, left) == 16 && offsetof(PlacedFace, turn) == 24);
static_assert(sizeof(TreeLattice) == 48);
}  // namespace clsdf
#endif

#endif
