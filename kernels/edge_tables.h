// The distance of distance.h where LANES polyhedra are prepared at once and evaluated one by one.
//
// Numbers that differ by a sample's region (right or left of the altitude, above or below the base) are in tables of
// four: one shuffle by lane replaces three selects.
#ifndef CLSDF_EDGE_TABLES_H
#define CLSDF_EDGE_TABLES_H

#include "distance.h"
#include "transpose.h"

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

// Looks `indices` up in the table of each four lanes; only their lowest two bits are used.
#if LANES == 16 && defined(__AVX512F__) && HAS_BUILTIN(__builtin_ia32_vpermilvarps512)
#define SHUFFLED(table, indices) __builtin_ia32_vpermilvarps512(table, as_int16(indices))
#elif LANES == 8 && defined(__AVX__) && HAS_BUILTIN(__builtin_ia32_vpermilvarps256)
#define SHUFFLED(table, indices) __builtin_ia32_vpermilvarps256(table, as_int8(indices))
#endif

// As squared_distance_displaced in distance.h, of samples at (x, y) along X and Y, displaced by (dx, dy) from the point
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

// From the point (x, y, z), that of the table's offsets.
INLINE floatL squared_distance_by_table(EdgeTable table, float x, float y, float z, floatL dx, floatL dy, floatL dz) {
    return squared_distance_in_region(table, x + dx, y + dy, dx, dy, z + dz);
}

#endif
