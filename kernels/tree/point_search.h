// The search in a tree for the nearest triangle of a point, which the host compiles, too, with one lane.
//
// A search keeps the least pair (squared distance in double, triangle in the caller's order). A child is left out only
// if its box is farther than that by more than all rounding, so the pair depends on the point alone: neither on the way
// through the tree nor on the pair that the search begins with. Distances in float only decide what is left out, so
// their multiply-adds may be fused.
#ifndef CLSDF_POINT_SEARCH_H
#define CLSDF_POINT_SEARCH_H

#include "edge_offsets.h"
#include "nearest_face.h"
#include "simd.h"

// A point as boxes are compared with it: floats on both sides of each coordinate.
typedef struct PointBox {
    float lower[3], upper[3];
} PointBox;

INLINE PointBox box_of_point(double3 p) {
    const double at[3] = {p.x, p.y, p.z};
    PointBox box;
    for (int axis = 0; axis < 3; ++axis) {
        const float nearest = (float)at[axis], rounding = fabs(nearest) * 2.4e-7f;
        box.lower[axis] = nearest - rounding;
        box.upper[axis] = nearest + rounding;
    }
    return box;
}

// All that a search reads of the mesh, beside the shape of the tree.
typedef struct PointMesh {
    __global const PointNode* nodes;  // from level 2 on
    __global const PointLeaf* leaves;
    __global const Polyhedron* polyhedra;
    __global const PointFace* faces;
} PointMesh;

DEFINE_EDGE_OFFSETS(LeafEdgeOffsets, leaf_edge_offsets, floatL, intL)
DEFINE_SQUARED_FROM_EDGE(squared_from_edge, floatL)

#ifndef __OPENCL_VERSION__
// Bits of CLSDF_TREE_WIDTH numbers that are not above `most`.
INLINE uint bits_not_above(const float* numbers, float most) {
    uint bits = 0;
    for (int i = 0; i < CLSDF_TREE_WIDTH; ++i) bits |= (uint)(numbers[i] <= most) << i;
    return bits;
}
#endif

// Squared distances of a leaf's faces in float, LANES from number `first` on, to a point displaced from its origin.
INLINE floatL squared_to_faces(__global const PointLeaf* leaf, float3 p, int first) {
#define OF_LEAF(member) load_lanes(0, leaf->member + first)
#define COORDINATE(column)                \
    (OF_LEAF(gradient[0][column]) * p.x + \
     (OF_LEAF(gradient[1][column]) * p.y + (OF_LEAF(gradient[2][column]) * p.z + OF_LEAF(offset[column]))))
    const LeafEdgeOffsets offsets = leaf_edge_offsets(
        COORDINATE(0), COORDINATE(1), OF_LEAF(base[CLSDF_HALF_RIGHT]), OF_LEAF(base[CLSDF_HALF_LEFT]),
        OF_LEAF(normal_along[CLSDF_HALF_RIGHT]), OF_LEAF(normal_along[CLSDF_HALF_LEFT]),
        OF_LEAF(normal_across[CLSDF_HALF_RIGHT]), OF_LEAF(normal_across[CLSDF_HALF_LEFT]), OF_LEAF(altitude));
    return squared_from_edge(EDGE_THAT_COUNTS(offsets, ), COORDINATE(2));
#undef COORDINATE
#undef OF_LEAF
}

// Bound of the error of distances in float, relative to the lengths that they follow from.
#define LEAF_DISTANCE_ERROR 4.0e-6f

// How many children are compared at once. The host's compiler makes vectors of the loops over them.
#ifdef __OPENCL_VERSION__
#define CHILDREN_AT_ONCE LANES
#else
#define CHILDREN_AT_ONCE CLSDF_TREE_WIDTH
#endif

// The greatest square of a face that may be the nearest. least: of the squares.
INLINE float most_of_faces(float least, float bound, float error) {
    const float nearest = sqrt(least) + error, farthest = sqrt(bound);
    const float most = LESSER(nearest, farthest) + error;
    return most * most * (1.0f + 1.0e-5f);
}

// Bits of the faces of a leaf, CHILDREN_AT_ONCE from number `first` on, that may be nearer than `bound`.
INLINE uint near_faces(__global const PointLeaf* leaf, float3 p, float error, float bound, int first) {
#ifdef __OPENCL_VERSION__
    const floatL squared = squared_to_faces(leaf, p, first);
    return lanes_to_bits(squared <= (floatL)most_of_faces(-greatest_lane(-squared), bound, error));
#else
    float squared[CHILDREN_AT_ONCE];
    for (int i = 0; i < CHILDREN_AT_ONCE; ++i) squared[i] = squared_to_faces(leaf, p, first + i);
    float least = squared[0];
    for (int i = 1; i < CHILDREN_AT_ONCE; ++i) least = LESSER(squared[i], least);
    return bits_not_above(squared, most_of_faces(least, bound, error));
#endif
}

// Takes the faces of a leaf that may be nearer.
INLINE void visit_leaf(PointMesh mesh, uint number, uint faces, double3 p, __private NearestFace* found) {
    __global const PointLeaf* leaf = mesh.leaves + number;
    const float3 from_origin = convert_float3(p - convert_double3(vload3(0, leaf->origin)));
    const float error =
        LEAF_DISTANCE_ERROR * (fabs(from_origin.x) + fabs(from_origin.y) + fabs(from_origin.z) + leaf->extent);
    COUNTED(faces, CLSDF_TREE_WIDTH);
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += CHILDREN_AT_ONCE) {
        uint bits = near_faces(leaf, from_origin, error, found->bound, first);
        for (; bits != 0; bits &= bits - 1) {
            const uint face = number * CLSDF_TREE_WIDTH + first + lowest_bit(bits);
            if (face >= faces) break;
            COUNTED(decisions, 1);
            take_if_nearer(mesh.polyhedra, mesh.faces, face, p, found);
        }
    }
}

// Squared distances of a node's boxes, LANES from number `first` on: never more than the true ones, but for SHRINK.
INLINE floatL squared_to_boxes(__global const PointNode* node, PointBox p, int first) {
    const floatL zero = (floatL)0.0f;
    floatL sum = zero;
    for (int axis = 0; axis < 3; ++axis) {
        const floatL under = load_lanes(0, node->lower[axis] + first) - p.upper[axis];
        const floatL over = p.lower[axis] - load_lanes(0, node->upper[axis] + first);
        const floatL farther = GREATER(under, over);
        const floatL gap = GREATER(farther, zero);
        sum += gap * gap;
    }
    return sum;
}
#define SHRINK 0.99999f

// Bits of a node's boxes, CHILDREN_AT_ONCE from number `first` on, that may be nearer than `bound`. Sets their squares
// if there is one.
INLINE uint near_boxes(__global const PointNode* node, PointBox p, float bound, int first, __private float* squares) {
#ifdef __OPENCL_VERSION__
    const floatL squared = squared_to_boxes(node, p, first) * SHRINK;
    const uint bits = lanes_to_bits(squared <= (floatL)bound);
    if (bits != 0) store_lanes(squared, 0, squares);
    return bits;
#else
    for (int i = 0; i < CHILDREN_AT_ONCE; ++i) squares[i] = squared_to_boxes(node, p, first + i) * SHRINK;
    return bits_not_above(squares, bound);
#endif
}

// Puts a node's children that may be nearer on the stack, the nearest one on top. Returns the stack's new height.
// children: nodes of their level.
static inline int push_children(__global const PointNode* node, uint level, uint number, uint children, PointBox p,
                                float bound, __private uint* items, __private float* squares, int height) {
    COUNTED(boxes, CLSDF_TREE_WIDTH);
    float least = INFINITY;
    int nearest = height;
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += CHILDREN_AT_ONCE) {
        float of_child[CHILDREN_AT_ONCE];
        uint bits = near_boxes(node, p, bound, first, of_child);
        for (; bits != 0; bits &= bits - 1) {
            const uint number_at_once = lowest_bit(bits), child = number * CLSDF_TREE_WIDTH + first + number_at_once;
            if (child >= children) break;
            const float squared = of_child[number_at_once];
            const bool is_nearest = squared < least;
            least = is_nearest ? squared : least;
            nearest = is_nearest ? height : nearest;
            squares[height] = squared;
            items[height++] = (level - 1) << CLSDF_TREE_LEVEL_SHIFT | child;
        }
    }
    if (nearest < height) {
        const uint item = items[nearest];
        items[nearest] = items[height - 1];
        squares[nearest] = squares[height - 1];
        items[height - 1] = item;
        squares[height - 1] = least;
    }
    return height;
}

// Goes down the tree: inner nodes put their children on a stack, leaves visit their faces.
static inline void search(PointTree tree, PointMesh mesh, double3 p, __private NearestFace* found) {
    const PointBox box = box_of_point(p);
    uint items[CLSDF_TREE_STACK];
    float squares[CLSDF_TREE_STACK];
    items[0] = tree.levels << CLSDF_TREE_LEVEL_SHIFT;
    squares[0] = 0.0f;
    for (int height = 1; height > 0;) {
        --height;
        if (squares[height] > found->bound) continue;
        const uint level = items[height] >> CLSDF_TREE_LEVEL_SHIFT;
        const uint number = items[height] & ((1u << CLSDF_TREE_LEVEL_SHIFT) - 1u);
        if (level == 1)
            visit_leaf(mesh, number, tree.faces, p, found);
        else
            height = push_children(mesh.nodes + (tree.first[level - 1] - tree.count[0]) + number, level, number,
                                   tree.count[level - 2], box, found->bound, items, squares, height);
    }
}

// The nearest face of a point, at most at the squared distance `most`, which may be infinite. before: a face that is
// likely to be near, or CLSDF_NO_FACE.
static inline NearestFace nearest_face(PointTree tree, PointMesh mesh, double3 p, double most, uint before) {
    NearestFace found = none_nearest(most);
    if (before != CLSDF_NO_FACE) take_if_nearer(mesh.polyhedra, mesh.faces, before, p, &found);
    search(tree, mesh, p, &found);
    return found;
}

#endif
