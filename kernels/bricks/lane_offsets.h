// The distance of distance.h where LANES polyhedra are prepared at once and evaluated one by one.
//
// Numbers that differ by a sample's region (right or left of the altitude, above or below the base) are in tables of
// four: one shuffle by lane replaces three selects.
#ifndef CLSDF_LANE_OFFSETS_H
#define CLSDF_LANE_OFFSETS_H

#include "distance.h"
#include "lane_records.h"
#include "polyhedron.h"
#include "simd.h"

// A table's numbers are those of the regions right above, right below, left below, left above: a region's index follows
// from the signs of X and Y by a shift each and an exclusive or.
//
// The tables of LANES polyhedra, by the region's edge: the components of its outward normal, away from the altitude and
// along Y; at the point of the offsets, the distance outward from it, and along it before its beginning and past its
// end.
typedef struct EdgeTables {
    float along[4 * LANES], across[4 * LANES], outward[4 * LANES], before[4 * LANES], past[4 * LANES];
} EdgeTables;

// The index of a lane's table: shuffles of parts of vectors leave the tables in this order.
INLINE uint table_of_lane(uint lane) {
    return lane / 8 * 8 + lane % 4 * 2 + lane / 4 % 2;
}

// The tables (a, b, c, d) of the group-th eight lanes.
INLINE void store_tables(float8 a, float8 b, float8 c, float8 d, uint group, __private float* tables) {
    float8 rows[4] = {a, b, c, d};
    transpose_halves(rows);
#pragma unroll
    for (uint n = 0; n < 4; ++n) store_eight_floats(rows[n], 4 * group + n, tables);
}

// The tables of one polyhedron, repeated in each four lanes.
typedef struct EdgeTable {
    floatL along, across, outward, before, past;
} EdgeTable;

INLINE floatL repeated(float4 table) {
#if LANES == 16
    return (float16)(table, table, table, table);
#else
    return (float8)(table, table);
#endif
}

INLINE EdgeTable table_at(__private const EdgeTables* all, uint lane) {
    const uint index = table_of_lane(lane);
    EdgeTable table;
    table.along = repeated(vload4(index, all->along));
    table.across = repeated(vload4(index, all->across));
    table.outward = repeated(vload4(index, all->outward));
    table.before = repeated(vload4(index, all->before));
    table.past = repeated(vload4(index, all->past));
    return table;
}

// As squared_distance in distance.h, of samples at (x, y) along X and Y, displaced by (dx, dy) from the point
// of the table's offsets, and at z along Z.
INLINE floatL squared_distance_in_region(EdgeTable table, floatL x, floatL y, floatL dx, floatL dy, floatL z) {
#ifdef SHUFFLED
    const uintL region = as_uintL(as_intL(x) >> 31) ^ (as_uintL(y) >> 31);
    const floatL away = as_floatL(as_uintL(dx) ^ (as_uintL(x) & 0x80000000u));
    const floatL along = SHUFFLED(table.along, region), across = SHUFFLED(table.across, region);
    const floatL dr = along * away + across * dy, dt = along * dy - across * away;
    return squared_from_edge(SHUFFLED(table.outward, region) + dr, SHUFFLED(table.before, region) - dt,
                             SHUFFLED(table.past, region) + dt, z);
#else
    const intL left = x < 0.0f, below = y < 0.0f;
    const floatL away = left ? -dx : dx;
#define OF_SLANTED_EDGE(numbers) (left ? (floatL)(numbers).s3 : (floatL)(numbers).s0)
    const floatL along = OF_SLANTED_EDGE(table.along), across = OF_SLANTED_EDGE(table.across);
    const floatL dr = along * away + across * dy, dt = along * dy - across * away;
    const floatL beyond = (left ? (floatL)table.past.s2 : (floatL)table.past.s1) + away;
    return squared_from_edge(below ? -y : OF_SLANTED_EDGE(table.outward) + dr,
                             below ? beyond : OF_SLANTED_EDGE(table.before) - dt,
                             below ? beyond : OF_SLANTED_EDGE(table.past) + dt, z);
#undef OF_SLANTED_EDGE
#endif
}

// The same, with displacements from (x, y, z), the point of the table's offsets.
INLINE floatL squared_distance_by_table(EdgeTable table, float x, float y, float z, floatL dx, floatL dy, floatL dz) {
    return squared_distance_in_region(table, x + dx, y + dy, dx, dy, z + dz);
}

// The offsets of LANES polyhedra at one point. The arithmetic in double takes eight polyhedra at a time: for a single
// polyhedron it would take as many operations on vectors of two and four.

// One element per lane.
typedef struct LaneOffsets {
    float x[LANES], y[LANES], z[LANES];
    float z_low[LANES];  // what z lacks: most samples' nearest site is a face, and their distance is |z|
    EdgeTables edges;
    // The gradients in two numbers. The first are multiples of one power of two, so coarse that they have no rounding
    // in sums of multiples by up to half a brick; the second are what these lack.
    floatL gradient[9], gradient_low[9];
} LaneOffsets;

// Sets the offsets of eight polyhedra in the group-th eight lanes.
INLINE void set_eight_offsets(__global const Polyhedron* polyhedra, __private const uint* numbers, int3 first,
                              double centre, float rounder, uint group, __private LaneOffsets* o) {
    const FromOrigins from = from_origins(polyhedra, numbers, (double8)(first.x + centre), (double8)(first.y + centre),
                                          (double8)(first.z + centre));
    double8 exact[EXACT_NUMBERS];
    load_exact(polyhedra, numbers, exact);
    const double8 x = FRAME_AT(exact, 0, from.x, from.y, from.z), y = FRAME_AT(exact, 1, from.x, from.y, from.z),
                  z = FRAME_AT(exact, 2, from.x, from.y, from.z);
    const float8 rounded_y = convert_float8(y), rounded_z = convert_float8(z);
    store_eight_floats(convert_float8(x), group, o->x);
    store_eight_floats(rounded_y, group, o->y);
    store_eight_floats(rounded_z, group, o->z);
    store_eight_floats(convert_float8(z - convert_double8(rounded_z)), group, o->z_low);

    const double8 above_apex = y - exact[EXACT_ALTITUDE];
    float8 normal_along[2], normal_across[2], beyond_base[2], outward[2], before[2], past[2];
#pragma unroll
    for (uint side = 0; side < 2; ++side) {
        const double8 along = exact[NUMBER_NORMAL_ALONG + side], across = exact[NUMBER_NORMAL_ACROSS + side];
        const double8 away = side == CLSDF_HALF_RIGHT ? x : -x;
        const double8 beyond = away - exact[NUMBER_BASE + side];
        normal_along[side] = convert_float8(along);
        normal_across[side] = convert_float8(across);
        beyond_base[side] = convert_float8(beyond);
        outward[side] = convert_float8(along * beyond + across * y);
        before[side] = convert_float8(across * beyond - along * y);
        past[side] = convert_float8(along * above_apex - across * away);
    }
    // The base's outward normal is (0, -1); beyond the altitude the base goes on.
    const float8 base_along = 0.0f, base_across = -1.0f, endless = -INFINITY;
    store_tables(normal_along[CLSDF_HALF_RIGHT], base_along, base_along, normal_along[CLSDF_HALF_LEFT], group,
                 o->edges.along);
    store_tables(normal_across[CLSDF_HALF_RIGHT], base_across, base_across, normal_across[CLSDF_HALF_LEFT], group,
                 o->edges.across);
    store_tables(outward[CLSDF_HALF_RIGHT], -rounded_y, -rounded_y, outward[CLSDF_HALF_LEFT], group, o->edges.outward);
    store_tables(before[CLSDF_HALF_RIGHT], endless, endless, before[CLSDF_HALF_LEFT], group, o->edges.before);
    store_tables(past[CLSDF_HALF_RIGHT], beyond_base[CLSDF_HALF_RIGHT], beyond_base[CLSDF_HALF_LEFT],
                 past[CLSDF_HALF_LEFT], group, o->edges.past);

#pragma unroll
    for (uint n = 0; n < 9; ++n) {
        const double8 gradient = exact[NUMBER_GRADIENT_X + n];
        const float8 rounded = (convert_float8(gradient) + rounder) - rounder;
        store_eight_floats(rounded, group, (__private float*)(o->gradient + n));
        store_eight_floats(convert_float8(gradient - convert_double8(rounded)), group,
                           (__private float*)(o->gradient_low + n));
    }
}

// The offsets of the polyhedra numbers[0, LANES) at the point `centre` samples along each axis from sample `first`.
INLINE void set_offsets(Layout layout, __global const Polyhedron* polyhedra, __private const uint* numbers, int3 first,
                        double centre, __private LaneOffsets* o) {
    // Added to a number and taken away again, this leaves a multiple of 2^-20 of the power of two below the greatest
    // spacing: of a gradient 2^21 of them at most, of a sub-block's displacement 2^24.
    const float rounder = 12.0f * power_of_two_below(longest_spacing(layout));
#pragma unroll
    for (uint group = 0; group < LANES / 8; ++group)
        set_eight_offsets(polyhedra, numbers + 8 * group, first, centre, rounder, group, o);
}

#endif
