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
    float rounding;  // more than the low parts, and the boxes' margin
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
    point.rounding = 2.4e-7f * GREATER(two, z) + CLSDF_BOX_MARGIN;
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
    bool is_followed;
} PlacedDistance;

// The bound, in u = 2^-24. Let D be the sum of the coordinates' sizes from the foot, and R that of D and the lengths of
// the sides. The distance to the face is at most D.
// - The turn is rounded to a quaternion q of the integers x, y, z, w, of which one has 32767 as its size, and three are
//   off by 1/2 at most. So the face is turned about its foot by less than 2 * sqrt(3/4) / 32767 = 5.3e-5, and its
//   points move by less than that times the length of the base. Its other lengths are rounded by u: u R. What follows
//   is about the face of the rounded numbers.
// - Coordinates from the foot have 2 u D: both parts of the foot are floats, as are both of a point. The rest
//   is below 1e-11 unit, or below u^2 D.
// - The turn of d is d + 2 / |q|^2 (w t + v x t), with v = (x, y, z) and t = v x d. As vectors, t has an error of
//   2 sqrt(2) u |v| |d|. It becomes 6.9 u |d|, as 2 (|w| + |v|) |v| <= (1 + sqrt(2)) |q|^2. The sum in brackets has 3 u
//   of its parts' sizes, 9.5 u |d|. The factor has 9 u, of which 4 u are for squares and sums, and 2.5 ulp for the
//   quotient; it gives a vector of 2 |d| at most: 18 u |d|. The product has 2 u |d|, the last sum u |d|. With the
//   coordinates' own error this is less than 40 u D, and a distance changes by no more than the point moves. X and Y,
//   as rounded, tell the half and whether the base counts without error.
// - Normals of a slanted edge have 7 u: squares and their sum 2 u, which the root halves, the root of 2 ulp 4 u, the
//   product u. Offsets from an end of a side have u R. So the offsets from an edge have 7 u R + u R, and 2 u R for
//   products and the sum; a distance that follows from two of them has less than sqrt(2) * 10 u R < 15 u R.
// - Squares, sums and a root of 3 ulp have 8 u of the distance.
// In all less than 64 u R = 3.9e-6 R. A half whose sides are shorter than 1e-12 unit is taken for its box.
//
// A foot is rounded to fixed point, at the lattice's end downwards: sqrt(3) 2^-23 < 2.1e-7 unit. The frame in double is
// orthonormal, and the formula rounds with the mesh and with the point from the lattice's origin: less than 1e-9 unit
// within a thousand units of the mesh, and less than 1e-12 R farther away.
#define PLACED_ERROR 4.2e-6f
#define TURN_ERROR 5.4e-5f
#define LEAST_PLACED_ERROR 2.2e-7f

// A coordinate from the foot.
INLINE float from_foot(float at, float at_low, uint foot) {
    return (at - (float)(foot >> CLSDF_FOOT_LOW_BITS) * ((1 << CLSDF_FOOT_LOW_BITS) / CLSDF_FOOT_UNIT)) +
           (at_low - (float)(foot & ((1u << CLSDF_FOOT_LOW_BITS) - 1u)) * (1 / CLSDF_FOOT_UNIT));
}

// The integers in the halves of a word.
#define LOW_HALF(word) ((float)((int)((word) << 16) >> 16))
#define HIGH_HALF(word) ((float)((int)(word) >> 16))

INLINE PlacedDistance placed_distance(__global const PlacedFace* face, TreePoint p) {
    const uint4 first = FOUR_WORDS(face, 0), second = FOUR_WORDS(face, 1);
    const float x = from_foot(p.x, p.x_low, first.x), y = from_foot(p.y, p.y_low, first.y),
                z = from_foot(p.z, p.z_low, first.z);
    const float right = fabs(as_float(first.w)), left = as_float(second.x), altitude = as_float(second.y);
    const float turn_x = LOW_HALF(second.z), turn_y = HIGH_HALF(second.z), turn_z = LOW_HALF(second.w),
                turn_w = HIGH_HALF(second.w);
    const float factor = 2.0f / (turn_x * turn_x + turn_y * turn_y + turn_z * turn_z + turn_w * turn_w);
    const float t_x = turn_y * z - turn_z * y, t_y = turn_z * x - turn_x * z, t_z = turn_x * y - turn_y * x;
    const float along = x + factor * (turn_w * t_x + (turn_y * t_z - turn_z * t_y)),
                across = y + factor * (turn_w * t_y + (turn_z * t_x - turn_x * t_z)),
                away = z + factor * (turn_w * t_z + (turn_x * t_y - turn_y * t_x));
    const float base = along < 0.0f ? left : right, squared_edge = base * base + altitude * altitude;
    const bool has_edge = squared_edge > 1.0e-24f;
    const float per_edge = has_edge ? rsqrt(squared_edge) : 0.0f, normal_along = has_edge ? altitude * per_edge : 1.0f,
                normal_across = base * per_edge;
    const PlacedEdgeOffsets offsets = placed_edge_offsets(along, across, base, base, normal_along, normal_along,
                                                          normal_across, normal_across, altitude);
    const float longest = right + left, lengths = fabs(x) + fabs(y) + fabs(z) + (longest + altitude);
    PlacedDistance result;
    result.distance = sqrt(squared_from_placed_edge(EDGE_THAT_COUNTS(offsets, ), away));
    result.error = PLACED_ERROR * lengths + (TURN_ERROR * longest + LEAST_PLACED_ERROR);
    result.is_followed = first.w >> 31 != 0;
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
        bool is_followed = false;                                                         \
        do {                                                                              \
            COUNTED(faces, 1);                                                            \
            const PlacedDistance d = placed_distance(query->faces + place, query->point); \
            is_followed = d.is_followed;                                                  \
            if (d.distance - d.error <= query->bound.distance) take(place, d, query);     \
            ++place;                                                                      \
        } while (is_followed);                                                            \
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
