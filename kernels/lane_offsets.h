// The offsets (frame.h) of LANES polyhedra at one point. What takes double numbers is done for eight at a time: of a
// single polyhedron they would be as many operations on vectors of two and four.
#ifndef CLSDF_LANE_OFFSETS_H
#define CLSDF_LANE_OFFSETS_H

#include "lane_polyhedra.h"

// As Offsets, by lane. z_low is kept in double, in which it is added to displacements.
typedef struct LaneOffsets {
    float x[LANES], y[LANES], z[LANES];
    double z_low[LANES];
    float beyond_right[LANES], beyond_left[LANES];
    float outward_right[LANES], outward_left[LANES];
    float before_right[LANES], before_left[LANES];
    float past_right[LANES], past_left[LANES];
} LaneOffsets;

// Exact numbers of a polyhedron, in the order of polyhedron.h.
#define EXACT_GRADIENT_X 0
#define EXACT_GRADIENT_Y 3
#define EXACT_GRADIENT_Z 6
#define EXACT_CONSTANT 9
#define EXACT_BASE 12
#define EXACT_NORMAL_ALONG 14
#define EXACT_NORMAL_ACROSS 16
#define EXACT_ALTITUDE 18
#define EXACT_NUMBERS 19

// The exact numbers of eight polyhedra, one a lane.
INLINE void load_exact(__global const Polyhedron* polyhedra, __private const uint* numbers, __private double8* exact) {
    // The last eight overlap the ones before them: they end with the record.
#pragma unroll
    for (uint part = 0; part < 3; ++part) {
        const uint begin = part < 2 ? part * 8 : EXACT_NUMBERS - 8;
        double8 rows[8];
#pragma unroll
        for (uint lane = 0; lane < 8; ++lane) rows[lane] = vload8(0, polyhedra[numbers[lane]].exact_gradient_x + begin);
        transpose_doubles(rows);
#pragma unroll
        for (uint n = 0; n < 8; ++n) exact[begin + n] = rows[n];
    }
}

// Of eight polyhedra, at the point (i, j, k) samples from their integer origins, into the group-th eight lanes.
INLINE void set_eight_offsets(__global const Polyhedron* polyhedra, __private const uint* numbers, double8 i, double8 j,
                              double8 k, uint group, __private LaneOffsets* o) {
    double8 exact[EXACT_NUMBERS];
    load_exact(polyhedra, numbers, exact);
#define FRAME(n)                       \
    (exact[EXACT_GRADIENT_X + n] * i + \
     (exact[EXACT_GRADIENT_Y + n] * j + (exact[EXACT_GRADIENT_Z + n] * k + exact[EXACT_CONSTANT + n])))
    const double8 x = FRAME(0), y = FRAME(1), z = FRAME(2);
#undef FRAME
    const double8 above_apex = y - exact[EXACT_ALTITUDE];
    const float8 rounded_z = convert_float8(z);
#define STORE(value, member) store_eight_floats(convert_float8(value), group, o->member)
    STORE(x, x);
    STORE(y, y);
    store_eight_floats(rounded_z, group, o->z);
    store_eight_doubles(z - convert_double8(rounded_z), group, o->z_low);
#define STORE_HALF(away, half, side)                                                                        \
    {                                                                                                       \
        const double8 along = exact[EXACT_NORMAL_ALONG + half], across = exact[EXACT_NORMAL_ACROSS + half]; \
        const double8 beyond = away - exact[EXACT_BASE + half];                                             \
        const double8 outward = along * beyond + across * y, before = across * beyond - along * y;          \
        const double8 past = along * above_apex - across * away;                                            \
        STORE(beyond, beyond_##side);                                                                       \
        STORE(outward, outward_##side);                                                                     \
        STORE(before, before_##side);                                                                       \
        STORE(past, past_##side);                                                                           \
    }
    const double8 minus_x = -x;
    STORE_HALF(x, CLSDF_HALF_RIGHT, right)
    STORE_HALF(minus_x, CLSDF_HALF_LEFT, left)
#undef STORE_HALF
#undef STORE
}

// At the point `centre` samples along each axis from the sample `first` that `p` was made with.
INLINE void set_offsets(__global const Polyhedron* polyhedra, __private const uint* numbers, const LanePolyhedra* p,
                        double centre, __private LaneOffsets* o) {
#if LANES == 16
    set_eight_offsets(polyhedra, numbers, convert_double8(p->first_i.lo) + centre,
                      convert_double8(p->first_j.lo) + centre, convert_double8(p->first_k.lo) + centre, 0, o);
    set_eight_offsets(polyhedra, numbers + 8, convert_double8(p->first_i.hi) + centre,
                      convert_double8(p->first_j.hi) + centre, convert_double8(p->first_k.hi) + centre, 1, o);
#else
    set_eight_offsets(polyhedra, numbers, convert_double8(p->first_i) + centre, convert_double8(p->first_j) + centre,
                      convert_double8(p->first_k) + centre, 0, o);
#endif
}

INLINE Offsets offsets_of_lane(__private const LaneOffsets* o, uint lane) {
    Offsets of_lane;
    of_lane.x = o->x[lane];
    of_lane.y = o->y[lane];
    of_lane.z = o->z[lane];
    of_lane.z_low = (float)o->z_low[lane];
    of_lane.beyond_right = o->beyond_right[lane];
    of_lane.beyond_left = o->beyond_left[lane];
    of_lane.outward_right = o->outward_right[lane];
    of_lane.outward_left = o->outward_left[lane];
    of_lane.before_right = o->before_right[lane];
    of_lane.before_left = o->before_left[lane];
    of_lane.past_right = o->past_right[lane];
    of_lane.past_left = o->past_left[lane];
    return of_lane;
}

#endif
