// Points anywhere: the nearest triangle of each by a search in a tree, and the outputs.
//
// A search keeps the least pair (squared distance in double, triangle in the caller's order). A child is left out only
// if its box is farther than that by more than all rounding, so the pair depends on the point alone: neither on the way
// through the tree nor on the pair that the search begins with.

#define REAL double
#define TRUTH long

#include "edge_offsets.h"
#include "finish.h"
#include "point_distance.h"
#include "simd.h"

// The nearest face so far.
typedef struct NearestFace {
    double squared;  // in units
    uint triangle;   // in the caller's order
    uint face;       // in the tree's
    float bound;     // the squared distance as a float
} NearestFace;

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

// Takes a face if it is nearer.
INLINE void take_face(PointMesh mesh, uint face, double3 p, __private NearestFace* found) {
    const double squared = face_distance(mesh.polyhedra + face, mesh.faces + face, p.x, p.y, p.z).squared;
    const uint triangle = mesh.faces[face].triangle;
    if (squared < found->squared || (squared == found->squared && triangle < found->triangle)) {
        found->squared = squared;
        found->triangle = triangle;
        found->face = face;
        found->bound = (float)squared;
    }
}

DEFINE_EDGE_OFFSETS(LeafEdgeOffsets, leaf_edge_offsets, floatL, intL)
DEFINE_SQUARED_FROM_EDGE(squared_from_edge, floatL)

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

// Takes the faces of a leaf that may be nearer.
INLINE void visit_leaf(PointMesh mesh, uint number, uint faces, double3 p, __private NearestFace* found) {
    __global const PointLeaf* leaf = mesh.leaves + number;
    const float3 from_origin = convert_float3(p - convert_double3(vload3(0, leaf->origin)));
    const float error =
        LEAF_DISTANCE_ERROR * (fabs(from_origin.x) + fabs(from_origin.y) + fabs(from_origin.z) + leaf->extent);
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += LANES) {
        const floatL squared = squared_to_faces(leaf, from_origin, first);
        const float nearest = sqrt(-greatest_lane(-squared)) + error, bound = sqrt(found->bound);
        const float most = LESSER(nearest, bound) + error;
        uint bits = lanes_to_bits(squared <= (floatL)(most * most * (1.0f + 1.0e-5f)));
        for (; bits != 0; bits &= bits - 1) {
            const uint face = number * CLSDF_TREE_WIDTH + first + lowest_bit(bits);
            if (face >= faces) break;
            take_face(mesh, face, p, found);
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

// Puts a node's children that may be nearer on the stack, the nearest one on top. Returns the stack's new height.
// children: nodes of their level.
static inline int push_children(__global const PointNode* node, uint level, uint number, uint children, PointBox p,
                                float bound, __private uint* items, __private float* squares, int height) {
    float least = INFINITY;
    int nearest = height;
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += LANES) {
        const floatL squared = squared_to_boxes(node, p, first) * SHRINK;
#if LANES == 1
        uint bits = squared <= bound;
        const float* of_lane = &squared;
#else
        uint bits = lanes_to_bits(squared <= (floatL)bound);
        if (bits == 0) continue;
        float of_lane[LANES];
        store_lanes(squared, 0, of_lane);
#endif
        for (; bits != 0; bits &= bits - 1) {
            const uint lane = lowest_bit(bits), child = number * CLSDF_TREE_WIDTH + first + lane;
            if (child >= children) break;
            const bool is_nearest = of_lane[lane] < least;
            least = is_nearest ? of_lane[lane] : least;
            nearest = is_nearest ? height : nearest;
            squares[height] = of_lane[lane];
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

// A work-item takes `run` points that follow each other, and begins each search with the face of the one before.
// most: a squared distance, possibly infinite, beyond which nothing is looked for. points: in units.
__kernel void nearest_of_points(PointTree tree, __global const PointNode* nodes, __global const PointLeaf* leaves,
                                __global const Polyhedron* polyhedra, __global const PointFace* all_faces,
                                __global const double* points, uint begin, uint end, uint run, double most,
                                __global uint* faces, __global double* squared) {
    const PointMesh mesh = {nodes, leaves, polyhedra, all_faces};
    const uint first = begin + (uint)get_global_id(0) * run;
    const uint last = first < end ? min(end, first + run) : first;
    uint face = CLSDF_NO_FACE;
    for (uint i = first; i < last; ++i) {
        const double3 p = vload3(i, points);
        NearestFace found = {most, 0xFFFFFFFFu, CLSDF_NO_FACE, (float)most};
        if (face != CLSDF_NO_FACE) take_face(mesh, face, p, &found);
        search(tree, mesh, p, &found);
        faces[i] = lowest_face(all_faces, found.face);
        squared[i] = found.squared;
        if (found.face != CLSDF_NO_FACE) face = found.face;
    }
}

// The distance of the closest point, which lies on the face or on one of its edges, from the lines of the other edges.
INLINE double distance_to_other_edges(__private const Nearest* nearest) {
    __global const Polyhedron* p = nearest->polyhedron;
    const double2 along = vload2(0, p->exact_normal_along), across = vload2(0, p->exact_normal_across);
    const double2 beyond = (double2)(nearest->foot.x, -nearest->foot.x) - vload2(0, p->exact_base);
    const double2 inward = -(along * beyond + across * nearest->foot.y);  // from the right and the left edge
    const double base = nearest->frame_site == FRAME_BASE ? INFINITY : nearest->foot.y;
    const double right = nearest->frame_site == FRAME_RIGHT_EDGE ? INFINITY : inward.x;
    const double left = nearest->frame_site == FRAME_LEFT_EDGE ? INFINITY : inward.y;
    const double slanted = LESSER(right, left);
    return LESSER(base, slanted);
}

// The sign of a point by its side of the nearest face; CLSDF_POINT_UNDECIDED if it does not follow from that beyond all
// rounding (docs/method.md, 'Sides of faces'). Lengths are in units.
#define SQUARE_OF_LEAST_DISTANCE 1.0e-8
#define LEAST_INSIDE_FACE 1.0e-6     // of the closest point to the face's edges
#define LEAST_INSIDE_EDGE 1.0e-3     // the same on an edge, to the other two
#define LEAST_COSINE 1.0e-3          // between an edge's pseudonormal and the way to the point
#define LEAST_COSINE_AT_VERTEX 0.71  // the same of a vertex
INLINE uint sign_by_sides(__private const Finishing* finishing, __private const Nearest* nearest, uint sides) {
    const double squared = dot(nearest->from, nearest->from);
    if (sides == 0 || squared <= SQUARE_OF_LEAST_DISTANCE) return CLSDF_POINT_UNDECIDED;
    double outward = nearest->from.z, least = LEAST_COSINE;
    if (nearest->frame_site != CLSDF_SITE_OF_FACE) {
        if (!(sides >> site_of_triangle(nearest->polyhedron, nearest->frame_site) & 1u)) return CLSDF_POINT_UNDECIDED;
        outward = dot(offset_of(nearest), pseudonormal_of(finishing, nearest));
    }
    if (nearest->frame_site < FRAME_BASE) {
        least = LEAST_COSINE_AT_VERTEX;
    } else {
        const bool is_face = nearest->frame_site == CLSDF_SITE_OF_FACE;
        if (!(distance_to_other_edges(nearest) > (is_face ? LEAST_INSIDE_FACE : LEAST_INSIDE_EDGE)))
            return CLSDF_POINT_UNDECIDED;
    }
    if (!(outward * outward > least * least * squared)) return CLSDF_POINT_UNDECIDED;
    return sides & (outward > 0.0 ? CLSDF_SIDES_FRONT_INSIDE : CLSDF_SIDES_BACK_INSIDE) ? CLSDF_POINT_INSIDE
                                                                                        : CLSDF_POINT_OUTSIDE;
}

// The outputs of a point, a work-item each. places: where each point's results go. within: in the mesh's units. signs:
// of points that are not finished. by_sides: no sign is known, and the side of the nearest face decides it. Points that
// it does not decide stay undecided, for another launch.
__kernel void finish_points(__global const double* points, __global const uint* places, __global const uint* faces,
                            __global const ushort* sides_of_faces, uint by_sides, __global uchar* signs, uint begin,
                            uint end, double within, __global const Polyhedron* polyhedra, __global float* distance,
                            FINISHING_PARAMETERS) {
    const uint i = begin + (uint)get_global_id(0);
    if (i >= end) return;
    uint sign = by_sides ? CLSDF_POINT_UNDECIDED : signs[i];
    if (sign == CLSDF_POINT_FINISHED) return;
    SET_FINISHING(finishing)
    const uint place = places[i], face = faces[i], later = faces[min(i + 8u, end - 1u)];
    if (later != CLSDF_NO_FACE) {
        prefetch_line_to_l1(&polyhedra[later].exact_gradient_x);
        prefetch_line_to_l1(&polyhedra[later].exact_gradient_z[2]);
        prefetch_line_to_l1(&polyhedra[later].exact_altitude);
    }
    const bool is_double = IS_DOUBLE(&finishing, distance);
    bool is_within = false;
    if (face != CLSDF_NO_FACE) {
        Nearest nearest;
        find_nearest_at(&finishing, vload3(i, points), face, false, &nearest);
        if (by_sides) sign = sign_by_sides(&finishing, &nearest, sides_of_faces[face]);
        const bool is_on_surface = sign == CLSDF_POINT_ON_SURFACE, inside = sign == CLSDF_POINT_INSIDE;
        const double length = is_on_surface ? 0.0 : sqrt(dot(nearest.from, nearest.from)) * how.unit;
        is_within = length <= within;
        if (is_within && sign != CLSDF_POINT_UNDECIDED) {
            // Zero is for points on the surface: beside it, rounding may leave nothing of the length.
            if (is_double) {
                const double most = is_on_surface || length > 0.0 ? length : as_double((ulong)1);
                finishing.of_distance[place] = inside ? -most : most;
            } else {
                const float rounded = is_on_surface ? 0.0f : (float)length > 0.0f ? (float)length : as_float(1u);
                distance[place] = inside ? -rounded : rounded;
            }
            nearest.sign = inside ? -1.0 : 1.0;
            if (how.wanted != 0) store_outputs(&finishing, &nearest, place);
        }
    }
    if (by_sides) signs[i] = sign == CLSDF_POINT_UNDECIDED ? CLSDF_POINT_UNDECIDED : CLSDF_POINT_FINISHED;
    if (is_within || sign == CLSDF_POINT_UNDECIDED) return;
    const double limit = sign == CLSDF_POINT_INSIDE ? -within : within;
    if (is_double)
        finishing.of_distance[place] = limit;
    else
        distance[place] = (float)limit;
    leave_sample(&finishing, place);
}
