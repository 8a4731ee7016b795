// How a face lies to a point, exact for coordinates in the range of expansions.h: the rules of
// lib/engine/surface/ray_side.hpp and lib/points/signs_by_host.cpp.
#ifndef CLSDF_RAY_SIDE_H
#define CLSDF_RAY_SIDE_H

#include "expansions.h"

static inline bool are_collinear(double3 a, double3 b, double3 c) {
    return orientation_in_plane(a.x, a.y, b.x, b.y, c.x, c.y) == 0 &&
           orientation_in_plane(a.y, a.z, b.y, b.z, c.y, c.z) == 0 &&
           orientation_in_plane(a.z, a.x, b.z, b.x, c.z, c.x) == 0;
}

// On which side of a -> b, seen along x, the point lies that is displaced by (e, e^2) in (y, z), e positive and
// arbitrarily small; 0 only if a and b coincide there.
static inline int displaced_side(double3 a, double3 b, double3 p) {
    const int side = orientation_in_plane(a.y, a.z, b.y, b.z, p.y, p.z);
    if (side != 0) return side;
    if (a.z != b.z) return b.z < a.z ? 1 : -1;
    return a.y == b.y ? 0 : b.y > a.y ? 1 : -1;
}

// How the ray towards -x from a point crosses the wall below the edge a -> b of a rim, down to the floor.
static inline int crossing_of_wall(double3 a, double3 b, double floor, double3 p) {
    const bool is_ascending = b.y > p.y;
    if ((a.y > p.y) == is_ascending || p.z < floor) return 0;
    const int direction = is_ascending ? 1 : -1;
    if (displaced_side(a, b, p) == direction) return 0;
    // As displaced_side() in (y, x).
    const double3 a_across = (double3)(0.0, a.y, a.x), b_across = (double3)(0.0, b.y, b.x),
                  p_across = (double3)(0.0, p.y, p.x);
    return displaced_side(a_across, b_across, p_across) == direction ? -direction : 0;
}

// The side of all edges of the face a, b, c on which the displaced point lies: then the line along x through it meets
// the face. 0 if it does not.
static inline int side_of_edges(double3 a, double3 b, double3 c, double3 p) {
    const int side = displaced_side(a, b, p);
    return side != 0 && displaced_side(b, c, p) == side && displaced_side(c, a, p) == side ? side : 0;
}

// How the ray from the displaced point crosses the face, towards +x or -x: what a face that counts once adds to the
// winding number; 0 if the ray does not. The point is not on the face.
static inline int crossing_of_ray(double3 a, double3 b, double3 c, double3 p, bool is_forward) {
    const int side = side_of_edges(a, b, c, p);
    if (side == 0) return 0;
    // If the point is in front of the face for `side` = 1, or behind it for -1, the crossing has a smaller x.
    const bool is_backward = orientation_in_space(a, b, c, p) == side;
    if (is_backward == is_forward) return 0;
    return is_forward ? side : -side;
}

static inline bool is_between(double a, double b, double x) {
    return (a <= x && x <= b) || (b <= x && x <= a);
}

static inline bool is_on_segment(double3 a, double3 b, double3 p) {
    return is_between(a.x, b.x, p.x) && is_between(a.y, b.y, p.y) && is_between(a.z, b.z, p.z) &&
           are_collinear(a, b, p);
}

// In a projection in which the face turns by `turn`, 1 or -1: not beyond any of its edges.
static inline bool is_within_edges(int turn, int of_first, int of_second, int of_third) {
    return turn * of_first >= 0 && turn * of_second >= 0 && turn * of_third >= 0;
}

// Whether the point lies on the closed face, which may be degenerate.
static inline bool is_on_face(double3 a, double3 b, double3 c, double3 p) {
    if (orientation_in_space(a, b, c, p) != 0) return false;
#define WITHIN_EDGES_SEEN_ALONG(first, second)                                                                     \
    {                                                                                                              \
        const int turn = orientation_in_plane(a.first, a.second, b.first, b.second, c.first, c.second);            \
        if (turn != 0)                                                                                             \
            return is_within_edges(turn,                                                                           \
                                   orientation_in_plane(a.first, a.second, b.first, b.second, p.first, p.second),  \
                                   orientation_in_plane(b.first, b.second, c.first, c.second, p.first, p.second),  \
                                   orientation_in_plane(c.first, c.second, a.first, a.second, p.first, p.second)); \
    }
    WITHIN_EDGES_SEEN_ALONG(y, z)
    WITHIN_EDGES_SEEN_ALONG(z, x)
    WITHIN_EDGES_SEEN_ALONG(x, y)
#undef WITHIN_EDGES_SEEN_ALONG
    return is_on_segment(a, b, p) || is_on_segment(b, c, p) || is_on_segment(c, a, p);
}

#endif
