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
#include "tree_walk.h"

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

// Defines search(), the walk of a query that has a TreePoint `point`, a NearBound `bound` and PlacedFace `faces`:
// take(place, distance, query) takes a face that may be the nearest, end_leaf(end, query) follows the faces of a leaf,
// whose places end at `end`. The stack lies in local memory.
#define SQUARED_TO_BOX(lower_x, lower_y, lower_z, upper_x, upper_y, upper_z, query) \
    squared_to_box(lower_x, lower_y, lower_z, upper_x, upper_y, upper_z, (query)->point)
#define SQUARED_BOUND(query) ((query)->bound.squared)
#define DEFINE_SEARCH(search, Query, take, end_leaf)                                      \
    INLINE bool search##_in_leaf(uint place, __private Query* query) {                    \
        uint following = 0;                                                               \
        do {                                                                              \
            COUNTED(faces, 1);                                                            \
            const PlacedDistance d = placed_distance(query->faces + place, query->point); \
            following = d.following;                                                      \
            if (d.distance - d.error <= query->bound.distance) take(place, d, query);     \
            ++place;                                                                      \
        } while (following != 0);                                                         \
        end_leaf(place, query);                                                           \
        return false;                                                                     \
    }                                                                                     \
    INLINE DEFINE_BINARY_WALK(search, Query, __local, SQUARED_TO_BOX, SQUARED_BOUND, search##_in_leaf)

// Faces that may be the nearest, by floats: the last ones in a list, which others that are surely farther have left.
typedef struct ListedFaces {
    TreePoint point;
    __global const PlacedFace* faces;
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

#define NOTHING_IS_LEFT(end, query)
DEFINE_SEARCH(search_for_list, ListedFaces, list_face, NOTHING_IS_LEFT)

#endif
