// The least distance of each sample of a brick.
#ifndef CLSDF_BRICK_MINIMUM_H
#define CLSDF_BRICK_MINIMUM_H

#include "inline.h"
#include "layout.h"
#include "subblocks.h"

// The state of a brick's samples, sub-block by sub-block.
typedef struct Minimum {
    floatL squared[SUBBLOCKS * SUBBLOCK_VECTORS];
#ifdef NEAREST
    uintL polyhedron[SUBBLOCKS * SUBBLOCK_VECTORS];
#endif
} Minimum;

// The host allocates as many bytes for each.
#ifdef NEAREST
typedef char MinimumFits[sizeof(Minimum) == CLSDF_MINIMUM_BYTES(1) ? 1 : -1];
#else
typedef char MinimumFits[sizeof(Minimum) == CLSDF_MINIMUM_BYTES(0) ? 1 : -1];
#endif

// Where the samples of a coarse brick are among its bricks' minima, counted in numbers: bricks with x running fastest,
// then y, then z; there by sub-blocks. Each coordinate, from 0 to 31, adds its own. (Macros, for numbers and vectors.)
#define BRICK_PLACES ((uint)(sizeof(Minimum) / sizeof(float)))
#define PLACE_OF_X(x) ((x) % 4u | (x) / 4u % 2u * (SUBBLOCK_PLANE * SUBBLOCK_SAMPLES) | (x) / 8u * BRICK_PLACES)
#define PLACE_OF_Y(y) ((y) % 2u * 4u | (y) / 2u % 4u * SUBBLOCK_SAMPLES | (y) / 8u * (4 * BRICK_PLACES))
#define PLACE_OF_Z(z) ((z) % 2u * 8u | (z) / 2u % 4u * (4 * SUBBLOCK_SAMPLES) | (z) / 8u * (16 * BRICK_PLACES))

static inline void clear_minimum(__global Minimum* minimum) {
    for (uint n = 0; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) {
        minimum->squared[n] = INFINITY;
#ifdef NEAREST
        minimum->polyhedron[n] = CLSDF_NO_POLYHEDRON;
#endif
    }
}

#ifdef NEAREST
// Which lanes' polyhedra come after one in the caller's order of their triangles. lanes: those that matter.
static inline intL come_after(uint polyhedron, uintL others, uint lanes, __global const Polyhedron* polyhedra) {
    uint other[LANES], is_after[LANES];
    store_lanes(others, 0, other);
    store_lanes((uintL)0, 0, is_after);
    for (; lanes; lanes &= lanes - 1) {
        const uint lane = lowest_bit(lanes);
        if (polyhedra[polyhedron].triangle < polyhedra[other[lane]].triangle) is_after[lane] = 0xFFFFFFFFu;
    }
    return as_intL(load_lanes(0, is_after));
}

// Whether a polyhedron's triangle is the nearer one. Of those that are equally near the first in the caller's order is.
INLINE intL is_nearer(floatL squared, uint polyhedron, floatL least, uintL nearest,
                      __global const Polyhedron* polyhedra) {
    const intL equal = (squared == least) & (nearest != polyhedron) & (nearest != CLSDF_NO_POLYHEDRON);
    const uint lanes = lanes_to_bits(equal);
    if (lanes == 0) return squared < least;
    return (squared < least) | (equal & come_after(polyhedron, nearest, lanes, polyhedra));
}
#endif

// Vector n.
INLINE void lower_minimum(__global Minimum* minimum, uint n, floatL squared, uint polyhedron,
                          __global const Polyhedron* polyhedra) {
    const floatL least = minimum->squared[n];
#ifdef NEAREST
    const uintL nearest = minimum->polyhedron[n];
    const intL better = is_nearer(squared, polyhedron, least, nearest, polyhedra);
    minimum->polyhedron[n] = better ? (uintL)polyhedron : nearest;
    minimum->squared[n] = better ? squared : least;
#else
    minimum->squared[n] = LESSER(squared, least);
#endif
}

// Upper bounds of the distances in a sub-block and in a brick, as far as they are computed.
INLINE float cap_of_subblock(__global const Minimum* minimum, uint b, float cap) {
    floatL greatest = minimum->squared[b * SUBBLOCK_VECTORS];
    for (uint v = 1; v < SUBBLOCK_VECTORS; ++v)
        greatest = GREATER(greatest, minimum->squared[b * SUBBLOCK_VECTORS + v]);
    const float reached = sqrt(greatest_lane(greatest));
    return LESSER(reached, cap);
}
static inline float cap_of_brick(__global const Minimum* minimum, float cap) {
    floatL greatest = minimum->squared[0];
    for (uint n = 1; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) greatest = GREATER(greatest, minimum->squared[n]);
    const float reached = sqrt(greatest_lane(greatest));
    return LESSER(reached, cap);
}

// Whether any of a brick's samples has a distance.
static inline bool has_distances(__global const Minimum* minimum) {
    floatL least = minimum->squared[0];
    for (uint n = 1; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) least = LESSER(least, minimum->squared[n]);
    return -greatest_lane(-least) < INFINITY;
}

// Row (y, z) of a brick's samples, out of its sub-blocks.
INLINE uint8 row_of(__global const uint* samples, uint y, uint z) {
    __global const uint* half_row = samples + (PLACE_OF_Y(y) | PLACE_OF_Z(z));
    return (uint8)(vload4(0, half_row), vload4(0, half_row + PLACE_OF_X(4u)));
}

#endif
