// The search in a binary tree for the faces of a point that may be the nearest, which the host compiles, too.
//
// Boxes and faces are compared in float, and no face is left out that may have the least squared distance in double
// (point_distance.h). So the result depends on the point alone, not on the tree. Multiply-adds may be fused.
#ifndef CLSDF_BINARY_SEARCH_H
#define CLSDF_BINARY_SEARCH_H

#include "binary_tree.h"
#include "edge_offsets.h"
#include "point_tree.h"
#include "simd.h"

// Four numbers of an array of structs, in one load.
#define FOUR_OF(at, number) (((__global const float4*)(at))[number])

// A point as two floats on each axis.
typedef struct TreePoint {
    float x, y, z;
    float x_low, y_low, z_low;
    float rounding;  // more than the low parts
} TreePoint;

INLINE TreePoint tree_point(double3 p) {
    TreePoint point;
    point.x = (float)p.x;
    point.y = (float)p.y;
    point.z = (float)p.z;
    point.x_low = (float)(p.x - (double)point.x);
    point.y_low = (float)(p.y - (double)point.y);
    point.z_low = (float)(p.z - (double)point.z);
    const float x = fabs(point.x), y = fabs(point.y), z = fabs(point.z);
    const float two = GREATER(x, y);
    point.rounding = 2.4e-7f * GREATER(two, z);
    return point;
}

INLINE float gap_to_range(float lower, float upper, float x, float rounding) {
    const float under = lower - x, over = x - upper;
    const float gap = GREATER(under, over) - rounding;
    return GREATER(gap, 0.0f);
}

// The squared distance of a box, or less. The gaps are never too great by more than 2^-22 of themselves; the factor is
// for that and for the rounding of squares.
INLINE float squared_to_box(float lower_x, float lower_y, float lower_z, float upper_x, float upper_y, float upper_z,
                            TreePoint p) {
    const float x = gap_to_range(lower_x, upper_x, p.x, p.rounding),
                y = gap_to_range(lower_y, upper_y, p.y, p.rounding),
                z = gap_to_range(lower_z, upper_z, p.z, p.rounding);
    return (x * x + y * y + z * z) * 0.99999f;
}

DEFINE_EDGE_OFFSETS(PlacedEdgeOffsets, placed_edge_offsets, float, int)
DEFINE_SQUARED_FROM_EDGE(squared_from_placed_edge, float)

// The distance of a face in float, and the bound of its difference from the square root of face_distance().
typedef struct PlacedDistance {
    float distance, error;
    uint following;  // places of the leaf
} PlacedDistance;

// The bound, in u = 2^-24. Let R be the sum of the lengths that a distance follows from: the coordinates from the
// origin (which the sums of two floats give with 2 u), the frame's values there, and the lengths of its sides.
// - X, Y, Z have 7 u R: numbers of the frame u, coordinates 2 u, products u, sums 3 u.
// - Offsets from an edge add at most 5 u R to two of them: normals u, differences u, products u, sums 2 u. So each of
//   the three offsets has less than 2 * 7 u R + 5 u R = 19 u R, as a normal turns two errors into at most their sum.
// - A half, or an edge, that rounding takes for the other one gives the distance of a point that is no farther away
//   than the rounding of X or Y, so this adds at most 2 * 7 u R.
// - The distance has sqrt(3) * 19 u R + 14 u R, and 4 u of itself for squares, sums and a root of 3 ulp: at most
//   51 u R = 3.1e-6 R.
// The formula in double rounds with the mesh and with the point from the lattice's origin: less than 1e-11 unit within
// a thousand units of the mesh, and less than 1e-13 R farther away.
#define PLACED_ERROR 4.0e-6f
#define LEAST_PLACED_ERROR 1.0e-10f

INLINE PlacedDistance placed_distance(__global const PlacedFace* face, TreePoint p) {
    const float4 sides = FOUR_OF(face, 3), rest = FOUR_OF(face, 4);
    const uint origin = as_uint(rest.w);
    const float x = (p.x - (float)(origin & 1023u)) + p.x_low, y = (p.y - (float)(origin >> 10 & 1023u)) + p.y_low,
                z = (p.z - (float)(origin >> 20 & 1023u)) + p.z_low;
    const float4 frame_x = FOUR_OF(face, 0), frame_y = FOUR_OF(face, 1), frame_z = FOUR_OF(face, 2);
#define COORDINATE(frame) (frame.x * x + (frame.y * y + (frame.z * z + frame.w)))
    const PlacedEdgeOffsets offsets = placed_edge_offsets(COORDINATE(frame_x), COORDINATE(frame_y), sides.x, sides.y,
                                                          sides.z, sides.w, rest.x, rest.y, rest.z);
    const float squared = squared_from_placed_edge(EDGE_THAT_COUNTS(offsets, ), COORDINATE(frame_z));
#undef COORDINATE
    const float lengths = fabs(x) + fabs(y) + fabs(z) + fabs(frame_x.w) + fabs(frame_y.w) + fabs(frame_z.w) +
                          (sides.x + sides.y + rest.z);
    PlacedDistance result;
    result.distance = sqrt(squared);
    result.error = PLACED_ERROR * lengths + LEAST_PLACED_ERROR;
    result.following = origin >> CLSDF_PLACE_SHIFT;
    return result;
}

// Upper bounds of the least distance. Farther faces and boxes are left out.
typedef struct NearBound {
    float distance;
    float squared;
} NearBound;

INLINE NearBound bound_of_distance(float distance) {
    NearBound bound;
    bound.distance = distance;
    bound.squared = distance * distance * 1.000001f;
    return bound;
}

INLINE NearBound bound_of_squared(double squared) {
    NearBound bound;
    bound.squared = (float)squared * 1.000001f;
    bound.distance = sqrt(bound.squared) * 1.000001f;
    return bound;
}

// Defines search(): the nearer child first, the other one on the stack with its distance. take(place, distance, found)
// takes a face; found->bound is the bound. end_leaf(end, found) follows the faces of a leaf, whose places end at `end`.
// stack: local memory, an entry in each `stride` words.
#define DEFINE_SEARCH(search, Found, take, end_leaf)                                                         \
    INLINE void search(BinaryTree tree, __global const BinaryNode* nodes, __global const PlacedFace* faces,  \
                       TreePoint p, __local uint* stack, uint stride, __private Found* found) {              \
        uint link = tree.root, height = 0;                                                                   \
        for (;;) {                                                                                           \
            bool goes_on = false;                                                                            \
            if (link & tree.leaf) {                                                                          \
                uint place = link & ~tree.leaf, following = 0;                                               \
                do {                                                                                         \
                    COUNTED(faces, 1);                                                                       \
                    const PlacedDistance d = placed_distance(faces + place, p);                              \
                    following = d.following;                                                                 \
                    if (d.distance - d.error <= found->bound.distance) take(place, d, found);                \
                    ++place;                                                                                 \
                } while (following != 0);                                                                    \
                end_leaf(place, found);                                                                      \
            } else {                                                                                         \
                COUNTED(boxes, 2);                                                                           \
                __global const BinaryNode* node = nodes + link;                                              \
                const float4 a = FOUR_OF(node, 0), b = FOUR_OF(node, 1), c = FOUR_OF(node, 2);               \
                const uint first_link = node->link[0], second_link = node->link[1];                          \
                const float first = squared_to_box(a.x, a.y, a.z, a.w, b.x, b.y, p),                         \
                            second = squared_to_box(b.z, b.w, c.x, c.y, c.z, c.w, p);                        \
                const bool is_first = first <= second;                                                       \
                const float nearer = is_first ? first : second, farther = is_first ? second : first;         \
                if (nearer <= found->bound.squared) {                                                        \
                    goes_on = true;                                                                          \
                    link = is_first ? first_link : second_link;                                              \
                    if (farther <= found->bound.squared)                                                     \
                        stack[height++ * stride] =                                                           \
                            (is_first ? second_link : first_link) | (as_uint(farther) << 1 & tree.distance); \
                }                                                                                            \
            }                                                                                                \
            while (!goes_on) {                                                                               \
                if (height == 0) return;                                                                     \
                link = stack[--height * stride];                                                             \
                goes_on = as_float((link & tree.distance) >> 1) <= found->bound.squared;                     \
            }                                                                                                \
            link &= ~tree.distance;                                                                          \
        }                                                                                                    \
    }

// Faces that may be the nearest, by floats: the last ones in a list, which others that are surely farther have left.
typedef struct ListedFaces {
    NearBound bound;
    float low;              // below all distances of the list
    uint count;             // of the list, which holds the first CLSDF_LISTED_FACES
    __global uint* places;  // the list, an entry in each `stride` words
    uint stride;
} ListedFaces;

INLINE void list_face(uint place, PlacedDistance d, __private ListedFaces* found) {
    const float lower = d.distance - d.error, upper = d.distance + d.error;
    if (upper < found->low) {
        found->count = 0;
        found->low = INFINITY;
    }
    found->low = LESSER(lower, found->low);
    if (upper < found->bound.distance) found->bound = bound_of_distance(upper);
    if (found->count < CLSDF_LISTED_FACES) found->places[found->count * (size_t)found->stride] = place;
    ++found->count;
}

#define NOTHING_IS_LEFT(end, found)
DEFINE_SEARCH(search_for_list, ListedFaces, list_face, NOTHING_IS_LEFT)

#endif
