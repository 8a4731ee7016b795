// A brick's 32 sub-blocks of 4 x 2 x 2 samples, each one or two vectors: x runs fastest over the samples, then y, then
// z.
//
// They are numbered with y running fastest and x slowest, so that those of one x, a plane of 4 x 4, are whole vectors
// of blocks. Sub-blocks of 2 x 2 x 2 would save distances, but double the tests.
#ifndef CLSDF_SUBBLOCKS_H
#define CLSDF_SUBBLOCKS_H

#include "layout.h"
#include "simd.h"

#define SUBBLOCK_X 4
#define SUBBLOCK_SAMPLES 16
#define SUBBLOCK_VECTORS (SUBBLOCK_SAMPLES / LANES)
#define SUBBLOCK_PLANES (CLSDF_BRICK / SUBBLOCK_X)
#define SUBBLOCK_PLANE 16
#define SUBBLOCKS (SUBBLOCK_PLANES * SUBBLOCK_PLANE)

// A bit a sub-block.
typedef uint SubblockMask;

// Positions of the samples of a sub-block's v-th vector, relative to its centre.
#define LANE_I (convert_floatL(LANE_NUMBERS % SUBBLOCK_X) - 0.5f * (SUBBLOCK_X - 1))
#define LANE_J (convert_floatL(LANE_NUMBERS / SUBBLOCK_X % 2) - 0.5f)
#define LANE_K(v) (convert_floatL((LANE_NUMBERS + (v)*LANES) / (2 * SUBBLOCK_X)) - 0.5f)

// Positions of the sub-blocks' centres relative to the brick's: x of those of a plane; y and z of sub-block b, and of
// the v-th vector of a plane.
static inline float subblock_i(uint plane) {
    return (float)(plane * SUBBLOCK_X) - 0.5f * (CLSDF_BRICK - SUBBLOCK_X);
}
static inline float subblock_j(uint b) {
    return (float)(b % 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}
static inline float subblock_k(uint b) {
    return (float)(b % SUBBLOCK_PLANE / 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}
static inline floatL subblocks_j(uint v) {
    return convert_floatL((LANE_NUMBERS + v * LANES) % 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}
static inline floatL subblocks_k(uint v) {
    return convert_floatL((LANE_NUMBERS + v * LANES) / 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}

// Positions of the samples of the v-th vector of sub-block b, relative to the brick's centre.
static inline floatL samples_i(uint b) {
    return LANE_I + subblock_i(b / SUBBLOCK_PLANE);
}
static inline floatL samples_j(uint b) {
    return LANE_J + subblock_j(b);
}
static inline floatL samples_k(uint b, uint v) {
    return LANE_K(v) + subblock_k(b);
}

// The least distance of each sample of a brick.

// A sample's minimum: the square of its least distance. If other outputs are asked for, the square is the high word of
// a number, and the low word is the nearest polyhedron. Floats that are not negative have the order of their bits, so
// the lesser number is the nearer polyhedron.
#ifdef NEAREST
typedef ulong Least;
typedef ulongL LeastL;
#define NO_LEAST ((ulong)as_uint(INFINITY) << 32 | CLSDF_NO_POLYHEDRON)
#else
typedef float Least;
typedef floatL LeastL;
#define NO_LEAST INFINITY
#endif

// The minima of a brick's samples, sub-block by sub-block.
typedef struct Minimum {
    LeastL least[SUBBLOCKS * SUBBLOCK_VECTORS];
} Minimum;

// The host allocates as many bytes for each.
typedef char MinimumFits[sizeof(Minimum) == CLSDF_MINIMUM_BYTES(sizeof(Least) == sizeof(ulong)) ? 1 : -1];

// The index of a sample of a coarse brick among its bricks' minima: bricks with x running fastest,
// then y, then z; there by sub-blocks. Each coordinate, from 0 to 31, adds its own. (Macros, for numbers and vectors.)
#define MINIMA_OF_BRICK ((uint)(sizeof(Minimum) / sizeof(Least)))
#define INDEX_OF_X(x) ((x) % 4u | (x) / 4u % 2u * (SUBBLOCK_PLANE * SUBBLOCK_SAMPLES) | (x) / 8u * MINIMA_OF_BRICK)
#define INDEX_OF_Y(y) ((y) % 2u * 4u | (y) / 2u % 4u * SUBBLOCK_SAMPLES | (y) / 8u * (4 * MINIMA_OF_BRICK))
#define INDEX_OF_Z(z) ((z) % 2u * 8u | (z) / 2u % 4u * (4 * SUBBLOCK_SAMPLES) | (z) / 8u * (16 * MINIMA_OF_BRICK))

static inline void clear_minimum(__global Minimum* minimum) {
    for (uint n = 0; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) minimum->least[n] = NO_LEAST;
}

#ifdef NEAREST
// The high words of a vector of numbers, and numbers of words.
INLINE uintL high_words(ulongL least) {
    return (uintL)(as_uintL(least.lo).odd, as_uintL(least.hi).odd);
}
INLINE ulongL least_of(floatL squared, uint polyhedron) {
    uintL low = polyhedron, high = polyhedron;
    low.odd = as_uintL(squared).lo;
    high.odd = as_uintL(squared).hi;
    return (ulongL)(as_ulong_halfL(low), as_ulong_halfL(high));
}

INLINE floatL squares_of(__global const Minimum* minimum, uint n) {
    return as_floatL(high_words(minimum->least[n]));
}

// Ties: two polyhedra are equally near.
INLINE uint equally_near(ulongL a, ulongL b) {
    return lanes_to_bits(convert_intL((a ^ b) - 1ul < (ulongL)0xFFFFFFFFul));
}

// From two numbers with equal squares, selects the one whose triangle comes first in the caller's order.
static inline ulong first_of(ulong a, ulong b, __global const Polyhedron* polyhedra) {
    if ((uint)a == CLSDF_NO_POLYHEDRON || (uint)b == CLSDF_NO_POLYHEDRON) return LESSER(a, b);
    const uint of_a = polyhedra[(uint)a].triangle, of_b = polyhedra[(uint)b].triangle;
    return of_a == of_b ? LESSER(a, b) : of_a < of_b ? a : b;
}
#else
INLINE floatL squares_of(__global const Minimum* minimum, uint n) {
    return minimum->least[n];
}
#endif

// Vector n.
INLINE void lower_minimum(__global Minimum* minimum, uint n, floatL squared, uint polyhedron,
                          __global const Polyhedron* polyhedra) {
    const LeastL least = minimum->least[n];
#ifdef NEAREST
    const ulongL found = least_of(squared, polyhedron);
    minimum->least[n] = LESSER(found, least);
    for (uint lanes = equally_near(found, least); lanes; lanes &= lanes - 1) {
        const uint lane = lowest_bit(lanes);
        ((__global ulong*)(minimum->least + n))[lane] =
            first_of(((__private const ulong*)&found)[lane], ((__private const ulong*)&least)[lane], polyhedra);
    }
#else
    minimum->least[n] = LESSER(squared, least);
#endif
}

// Upper bounds of the distances in a sub-block and in a brick, from the minima so far.
INLINE float bound_of_subblock(__global const Minimum* minimum, uint b, float bound) {
    floatL greatest = squares_of(minimum, b * SUBBLOCK_VECTORS);
    for (uint v = 1; v < SUBBLOCK_VECTORS; ++v) {
        const floatL squared = squares_of(minimum, b * SUBBLOCK_VECTORS + v);
        greatest = GREATER(greatest, squared);
    }
    const float reached = sqrt(greatest_lane(greatest));
    return LESSER(reached, bound);
}
static inline float bound_of_brick(__global const Minimum* minimum, float bound) {
    floatL greatest = squares_of(minimum, 0);
    for (uint n = 1; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) {
        const floatL squared = squares_of(minimum, n);
        greatest = GREATER(greatest, squared);
    }
    const float reached = sqrt(greatest_lane(greatest));
    return LESSER(reached, bound);
}

// Whether any of a brick's samples has a distance.
static inline bool has_distances(__global const Minimum* minimum) {
    floatL least = squares_of(minimum, 0);
    for (uint n = 1; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) {
        const floatL squared = squares_of(minimum, n);
        least = LESSER(least, squared);
    }
    return -greatest_lane(-least) < INFINITY;
}

// A vector of a brick's samples is one or two rows of a slice.
#define ROWS_PER_VECTOR (LANES / CLSDF_BRICK)
#if ROWS_PER_VECTOR == 1
#define ROW_OF_VECTOR(rows, n) (rows)
#else
#define ROW_OF_VECTOR(rows, n) ((n) == 0 ? (rows).lo : (rows).hi)
#endif
#if ROWS_PER_VECTOR == 1
#define ROWS_FROM(row_of, minimum, y, z) row_of(minimum, y, z)
#else
#define ROWS_FROM(row_of, minimum, y, z) ((uintL)(row_of(minimum, y, z), row_of(minimum, (y) + 1, z)))
#endif

// The first row of the vector that has row y.
INLINE int first_of_vector(int y) {
    return y / ROWS_PER_VECTOR * ROWS_PER_VECTOR;
}

// Row (y, z) of a brick's samples, out of its sub-blocks.
INLINE uint8 squares_of_row(__global const Minimum* minimum, uint y, uint z) {
    __global const Least* half_row = (__global const Least*)minimum->least + (INDEX_OF_Y(y) | INDEX_OF_Z(z));
#ifdef NEAREST
    return (uint8)(as_uint8(vload4(0, half_row)).odd, as_uint8(vload4(0, half_row + INDEX_OF_X(4u))).odd);
#else
    return as_uint8((float8)(vload4(0, half_row), vload4(0, half_row + INDEX_OF_X(4u))));
#endif
}
#ifdef NEAREST
INLINE uint8 polyhedra_of_row(__global const Minimum* minimum, uint y, uint z) {
    __global const Least* half_row = (__global const Least*)minimum->least + (INDEX_OF_Y(y) | INDEX_OF_Z(z));
    return (uint8)(as_uint8(vload4(0, half_row)).even, as_uint8(vload4(0, half_row + INDEX_OF_X(4u))).even);
}
#endif

#endif
