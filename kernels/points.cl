// Points anywhere: the nearest triangle of each by a search in a tree, and the outputs.
//
// A search keeps the least pair (squared distance in double, triangle in the caller's order). A child is left out only
// if its box is farther than that by more than all rounding, so the pair depends on the point alone: neither on the way
// through the tree nor on the pair that the search begins with.

#include "finish.h"
#include "point_distance.h"
#include "request.h"

// The nearest face so far.
typedef struct Found {
    double squared;  // in units
    uint triangle;   // in the caller's order
    uint face;       // in the tree's
    float bound;     // the squared distance as a float
} Found;

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

// Squared distances of a leaf's faces, LANES from number `first` on.
INLINE doubleL squared_distances(__global const PointLeaf* leaf, double3 p, int first) {
#define OF_LEAF(member) load_lanes(0, leaf->member + first)
    LeafFrame frame;
    SET_LEAF_FRAME(OF_LEAF, p, frame)
#undef OF_LEAF
    return leaf_distance(frame).squared;
}

INLINE void take_if_nearer(__private Found* found, double squared, __global const PointLeaf* leaf, uint number,
                           uint lane) {
    const uint triangle = leaf->triangle[lane];
    if (squared < found->squared || (squared == found->squared && triangle < found->triangle)) {
        found->squared = squared;
        found->triangle = triangle;
        found->face = number * CLSDF_TREE_WIDTH + lane;
        found->bound = (float)squared;
    }
}

static inline void visit_leaf(__global const PointLeaf* leaves, uint number, double3 p, __private Found* found) {
    __global const PointLeaf* leaf = leaves + number;
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += LANES) {
        const doubleL squared = squared_distances(leaf, p, first);
#if LANES == 1
        take_if_nearer(found, squared, leaf, number, first);
#else
        // Rounding is monotonic: what is nearer in double is not farther in float.
        uint bits = lanes_to_bits(convert_floatL(squared) <= (floatL)found->bound);
        if (bits == 0) continue;
        double of_lane[LANES];
        store_doubles(squared, of_lane);
        for (; bits != 0; bits &= bits - 1)
            take_if_nearer(found, of_lane[lowest_bit(bits)], leaf, number, first + lowest_bit(bits));
#endif
    }
}

// Squared distances of a node's boxes, LANES from number `first` on: never more than the true ones, but for `shrink`.
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
static inline int push_children(__global const PointNode* node, uint level, uint number, uint children, PointBox p,
                                float bound, __private uint* items, __private float* squares, int height) {
    const int bottom = height;
    for (int first = 0; first < CLSDF_TREE_WIDTH; first += LANES) {
        const floatL squared = squared_to_boxes(node, p, first) * SHRINK;
#if LANES == 1
        uint bits = squared <= bound;
#else
        uint bits = lanes_to_bits(squared <= (floatL)bound);
        if (bits == 0) continue;
        float of_lane[LANES];
        store_lanes(squared, 0, of_lane);
#endif
        for (; bits != 0; bits &= bits - 1) {
#if LANES == 1
            const uint lane = first;
            const float at = squared;
#else
            const uint lane = first + lowest_bit(bits);
            const float at = of_lane[lane - first];
#endif
            if (number * CLSDF_TREE_WIDTH + lane >= children) break;
            int place = height++;
            for (; place > bottom && squares[place - 1] < at; --place) {
                squares[place] = squares[place - 1];
                items[place] = items[place - 1];
            }
            squares[place] = at;
            items[place] = (level - 1) << CLSDF_TREE_LEVEL_SHIFT | (number * CLSDF_TREE_WIDTH + lane);
        }
    }
    return height;
}

static inline void search(PointTree tree, __global const PointNode* nodes, __global const PointLeaf* leaves, double3 p,
                          __private Found* found) {
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
        if (level == 0) {
            visit_leaf(leaves, number, p, found);
            continue;
        }
        const uint children = level == 1 ? tree.leaves : tree.count[level - 2];
        height = push_children(nodes + tree.first[level - 1] + number, level, number, children, box, found->bound,
                               items, squares, height);
    }
}

// A work-item takes `run` points that follow each other, and begins each search at the leaf of the one before.
// most: a squared distance, possibly infinite, beyond which nothing is looked for. points: in units.
__kernel void nearest_of_points(PointTree tree, __global const PointNode* nodes, __global const PointLeaf* leaves,
                                __global const double* points, uint begin, uint end, uint run, double most,
                                __global uint* faces, __global double* squared) {
    const uint first = begin + (uint)get_global_id(0) * run;
    const uint last = first < end ? min(end, first + run) : first;
    uint leaf = CLSDF_NO_FACE;
    for (uint i = first; i < last; ++i) {
        const double3 p = vload3(i, points);
        Found found = {most, 0xFFFFFFFFu, CLSDF_NO_FACE, (float)most};
        if (leaf != CLSDF_NO_FACE) visit_leaf(leaves, leaf, p, &found);
        search(tree, nodes, leaves, p, &found);
        faces[i] = found.face;
        squared[i] = found.squared;
        if (found.face != CLSDF_NO_FACE) leaf = found.face / CLSDF_TREE_WIDTH;
    }
}

// The sign of a point by its side of the nearest face; CLSDF_POINT_UNDECIDED if it does not follow from that beyond all
// rounding.
#define SQUARE_OF_LEAST_DISTANCE 1.0e-12  // in units: rounding is far below the distance
#define LEAST_COSINE 1.0e-3               // between a site's pseudonormal and the way to the point
INLINE uint sign_by_sides(__private const Finishing* finishing, __private const Nearest* nearest, uint sides) {
    const double squared = dot(nearest->from, nearest->from);
    double outward = nearest->from.z;
    if (sides == 0 || squared <= SQUARE_OF_LEAST_DISTANCE) return CLSDF_POINT_UNDECIDED;
    if (nearest->frame_site != CLSDF_SITE_OF_FACE) {
        if (!(sides >> nearest->normal % 6u & 1u)) return CLSDF_POINT_UNDECIDED;
        outward = dot(offset_of(nearest), convert_double3(vload3(nearest->normal, finishing->normals)));
    }
    if (!(outward * outward > LEAST_COSINE * LEAST_COSINE * squared)) return CLSDF_POINT_UNDECIDED;
    return sides & (outward > 0.0 ? CLSDF_SIDES_FRONT_INSIDE : CLSDF_SIDES_BACK_INSIDE) ? CLSDF_POINT_INSIDE
                                                                                        : CLSDF_POINT_OUTSIDE;
}

// The outputs of a point, a work-item each. places: where each point's results go. within: in the mesh's units. signs:
// those of points that are not finished. by_sides: they are all undecided, and the sides of faces tell; points that
// they do not tell stay undecided, and are left to another launch.
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
        request_line_for_soon(&polyhedra[later].exact_gradient_x);
        request_line_for_soon(&polyhedra[later].exact_gradient_z[2]);
        request_line_for_soon(&polyhedra[later].exact_altitude);
    }
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
            const float rounded = is_on_surface ? 0.0f : GREATER((float)length, FLT_MIN);
            distance[place] = inside ? -rounded : rounded;
            nearest.sign = inside ? -1.0 : 1.0;
            if (how.wanted != 0) store_outputs(&finishing, &nearest, place);
        }
    }
    if (by_sides) signs[i] = sign == CLSDF_POINT_UNDECIDED ? CLSDF_POINT_UNDECIDED : CLSDF_POINT_FINISHED;
    if (is_within || sign == CLSDF_POINT_UNDECIDED) return;
    distance[place] = (float)(sign == CLSDF_POINT_INSIDE ? -within : within);
    leave_sample(&finishing, place);
}
