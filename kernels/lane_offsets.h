// What the distances of LANES polyhedra around one point take. What takes double numbers is done for eight at a time: of
// a single polyhedron they would be as many operations on vectors of two and four.
#ifndef CLSDF_LANE_OFFSETS_H
#define CLSDF_LANE_OFFSETS_H

#include "edge_tables.h"
#include "lane_polyhedra.h"

// By lane.
typedef struct LaneOffsets {
    float x[LANES], y[LANES], z[LANES];
    float z_low[LANES];  // what z lacks: most samples' nearest site is a face, and their distance is |z|
    EdgeTables edges;
    // The gradients in two numbers. The first are multiples of one power of two, so coarse that they have no rounding
    // in sums of multiples by up to half a brick; the second are what these lack.
    floatL gradient[9], gradient_low[9];
} LaneOffsets;

// The group-th eight lanes.
#if LANES == 16
#define EIGHT(lanes, group) ((group) == 0 ? (lanes).lo : (lanes).hi)
#else
#define EIGHT(lanes, group) (lanes)
#endif

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
#pragma unroll
    for (uint pair = 0; pair < EXACT_NUMBERS; pair += 2) {
        const uint n = min(pair, (uint)EXACT_NUMBERS - 2);
#define PAIR_OF(lane) vload2(0, polyhedra[numbers[lane]].exact_gradient_x + n)
        const double8 even = (double8)(PAIR_OF(0), PAIR_OF(2), PAIR_OF(4), PAIR_OF(6));
        const double8 odd = (double8)(PAIR_OF(1), PAIR_OF(3), PAIR_OF(5), PAIR_OF(7));
#undef PAIR_OF
        exact[n] = (double8)(even.s0, odd.s0, even.s2, odd.s2, even.s4, odd.s4, even.s6, odd.s6);
        exact[n + 1] = (double8)(even.s1, odd.s1, even.s3, odd.s3, even.s5, odd.s5, even.s7, odd.s7);
    }
}

// Of eight polyhedra, at the point (i, j, k) samples from their integer origins, into the group-th eight lanes.
INLINE void set_eight_offsets(__global const Polyhedron* polyhedra, __private const uint* numbers,
                              const LanePolyhedra* p, uint group, double centre, __private LaneOffsets* o) {
    const double8 i = convert_double8(EIGHT(p->first_i, group)) + centre,
                  j = convert_double8(EIGHT(p->first_j, group)) + centre,
                  k = convert_double8(EIGHT(p->first_k, group)) + centre;
    double8 exact[EXACT_NUMBERS];
    load_exact(polyhedra, numbers, exact);
#define FRAME(n)                       \
    (exact[EXACT_GRADIENT_X + n] * i + \
     (exact[EXACT_GRADIENT_Y + n] * j + (exact[EXACT_GRADIENT_Z + n] * k + exact[EXACT_CONSTANT + n])))
    const double8 x = FRAME(0), y = FRAME(1), z = FRAME(2);
#undef FRAME
    const float8 rounded_y = convert_float8(y), rounded_z = convert_float8(z);
    store_eight_floats(convert_float8(x), group, o->x);
    store_eight_floats(rounded_y, group, o->y);
    store_eight_floats(rounded_z, group, o->z);
    store_eight_floats(convert_float8(z - convert_double8(rounded_z)), group, o->z_low);

    const double8 above_apex = y - exact[EXACT_ALTITUDE];
    float8 beyond_base[2], outward[2], before[2], past[2];
#pragma unroll
    for (uint half_number = 0; half_number < 2; ++half_number) {
        const double8 along = exact[EXACT_NORMAL_ALONG + half_number],
                      across = exact[EXACT_NORMAL_ACROSS + half_number];
        const double8 away = half_number == CLSDF_HALF_RIGHT ? x : -x;
        const double8 beyond = away - exact[EXACT_BASE + half_number];
        beyond_base[half_number] = convert_float8(beyond);
        outward[half_number] = convert_float8(along * beyond + across * y);
        before[half_number] = convert_float8(across * beyond - along * y);
        past[half_number] = convert_float8(along * above_apex - across * away);
    }
    // The base's outward normal is (0, -1); beyond the altitude the base goes on.
    const float8 none = 0.0f;
    store_tables(EIGHT(p->along_right, group), none, none, EIGHT(p->along_left, group), group, o->edges.along);
    store_tables(EIGHT(p->across_right, group), none - 1.0f, none - 1.0f,
                 EIGHT(p->across_left, group), group, o->edges.across);
    store_tables(outward[0], -rounded_y, -rounded_y, outward[1], group, o->edges.outward);
    store_tables(before[0], none - INFINITY, none - INFINITY, before[1], group, o->edges.before);
    store_tables(past[0], beyond_base[0], beyond_base[1], past[1], group, o->edges.past);

#pragma unroll
    for (uint n = 0; n < 9; ++n) {
        const double8 low = exact[EXACT_GRADIENT_X + n] - convert_double8(EIGHT(o->gradient[n], group));
        store_eight_floats(convert_float8(low), group,
                           (__private float*)(o->gradient_low + n));
    }
}

// At the point `centre` samples along each axis from the sample `first` that `p` was made with.
INLINE void set_offsets(Layout layout, __global const Polyhedron* polyhedra, __private const uint* numbers,
                        const LanePolyhedra* p, double centre, __private LaneOffsets* o) {
    // Added to a number and taken away again, this leaves 20 binary places of it, counted from the axis' largest
    // spacing.
    const float spacing = GREATER(GREATER(layout.spacing[0], layout.spacing[1]), layout.spacing[2]);
    const float rounder = 12.0f * as_float(as_uint(spacing) & 0x7F800000u);
#pragma unroll
    for (uint n = 0; n < 9; ++n) o->gradient[n] = (p->gradient[n] + rounder) - rounder;
#pragma unroll
    for (uint group = 0; group < LANES / 8; ++group) set_eight_offsets(polyhedra, numbers + 8 * group, p, group, centre, o);
}

#endif
