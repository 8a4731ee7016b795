// The search in a tree for the nearest triangle of a point, which the host compiles, too, with one lane.
//
// A search keeps the least pair (squared distance in double, triangle in the caller's order). A child is left out only
// if its box is farther than that by more than all rounding, so the pair depends on the point alone: neither on the way
// through the tree nor on the pair that the search begins with. Distances in float only decide what is left out, so
// their multiply-adds may be fused.
#ifndef CLSDF_POINT_SEARCH_H
#define CLSDF_POINT_SEARCH_H

#include "box_query.h"
#include "edge_offsets.h"
#include "nearest_face.h"
#include "simd.h"
#include "tree_walk.h"

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

// A search on its way.
typedef struct NearestSearch {
    PointMesh mesh;
    uint faces;  // their number
    double3 point;
    PointBox box;
    NearestFace found;
    // Of the present node of each level, from level 2 on: the squared distances of its children, and the nearest one.
    __private float* squares;
    __private uint* nearest;
} NearestSearch;

#define SQUARES_OF(level, search) ((search)->squares + ((level)-2) * CLSDF_TREE_WIDTH)

INLINE uint near_children(__global const PointNode* node, uint level, __private NearestSearch* search) {
    COUNTED(boxes, CLSDF_TREE_WIDTH);
    __private float* squares = SQUARES_OF(level, search);
    uint bits = 0;
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += CHILDREN_AT_ONCE)
        bits |= near_boxes(node, search->box, search->found.bound, first, squares + first) << first;
    float least = INFINITY;
    uint nearest = 0;
    for (uint left = bits; left != 0; left &= left - 1) {
        const uint child = lowest_bit(left);
        const bool is_nearest = squares[child] < least;
        least = is_nearest ? squares[child] : least;
        nearest = is_nearest ? child : nearest;
    }
    search->nearest[level - 2] = nearest;
    return bits;
}

// The nearest child first, then the others in their order: to look for the nearest one each time takes longer than the
// visits that it saves.
INLINE uint next_child(uint bits, uint level, __private NearestSearch* search) {
    __private const float* squares = SQUARES_OF(level, search);
    const uint nearest = search->nearest[level - 2];
    if (bits >> nearest & 1u) return squares[nearest] <= search->found.bound ? nearest : CLSDF_NO_CHILD;
    for (; bits != 0; bits &= bits - 1) {
        const uint child = lowest_bit(bits);
        if (squares[child] <= search->found.bound) return child;
    }
    return CLSDF_NO_CHILD;
}

// Takes the faces of a leaf that may be nearer.
INLINE bool take_faces_of_leaf(uint number, __private NearestSearch* search) {
    __global const PointLeaf* leaf = search->mesh.leaves + number;
    const double3 p = search->point;
    const float3 from_origin = convert_float3(p - convert_double3(vload3(0, leaf->origin)));
    const float error =
        LEAF_DISTANCE_ERROR * (fabs(from_origin.x) + fabs(from_origin.y) + fabs(from_origin.z) + leaf->extent);
    COUNTED(faces, CLSDF_TREE_WIDTH);
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += CHILDREN_AT_ONCE) {
        uint bits = near_faces(leaf, from_origin, error, search->found.bound, first);
        for (; bits != 0; bits &= bits - 1) {
            const uint face = number * CLSDF_TREE_WIDTH + first + lowest_bit(bits);
            if (face >= search->faces) break;
            COUNTED(decisions, 1);
            take_if_nearer(search->mesh.polyhedra, search->mesh.faces, face, p, &search->found);
        }
    }
    return false;
}

INLINE DEFINE_WIDE_WALK(search, NearestSearch, near_children, next_child, take_faces_of_leaf)

    // The nearest face of a point, at most at the squared distance `most`, which may be infinite. before: a face that
    // is likely to be near, or CLSDF_NO_FACE.
    static inline NearestFace nearest_face(PointTree tree, PointMesh mesh, double3 p, double most, uint before) {
    float squares[(CLSDF_TREE_LEVELS - 1) * CLSDF_TREE_WIDTH];
    uint nearest[CLSDF_TREE_LEVELS - 1];
    NearestSearch own;
    own.mesh = mesh;
    own.faces = tree.faces;
    own.point = p;
    own.box = box_of_point(p, 0.0f);
    own.found = none_nearest(most);
    own.squares = squares;
    own.nearest = nearest;
    if (before != CLSDF_NO_FACE) take_if_nearer(mesh.polyhedra, mesh.faces, before, p, &own.found);
    search(tree, mesh.nodes, &own);
    return own.found;
}

#endif
