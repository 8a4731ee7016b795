// The caller's arrays of a mesh in memory of the device: floats or doubles, indices of 32 or 64 bits, at any distance
// from each other.
#ifndef CLSDF_GIVEN_TRIPLES_H
#define CLSDF_GIVEN_TRIPLES_H

#include "mesh_topology.h"

// Number k of item n: its lower and its upper word. The upper one is 0 if it has 32 bits.
static inline uint2 words_of(GivenTriples of_items, __global const uint* words, uint n, uint k) {
    const ulong at = of_items.first + (ulong)(of_items.triple * (long)n + of_items.number * (long)k);
    return (uint2)(words[at], of_items.is_long ? words[at + 1] : 0u);
}

// A float as a double, by integers: a device may take denormal floats for zeros.
static inline double widened(uint bits) {
    const uint exponent = bits >> 23 & 0xFFu, fraction = bits & 0x7FFFFFu;
    const ulong sign = (ulong)(bits >> 31) << 63;
    if (exponent == 0) return as_double(as_ulong((double)fraction * 0x1p-149) | sign);
    const ulong of_double = exponent == 0xFFu ? 0x7FFu : exponent + (1023u - 127u);
    return as_double(sign | of_double << 52 | (ulong)fraction << 29);
}

static inline double coordinate(GivenTriples of_positions, __global const uint* words, uint vertex, uint axis) {
    const uint2 both = words_of(of_positions, words, vertex, axis);
    return of_positions.is_long ? as_double((ulong)both.y << 32 | both.x) : widened(both.x);
}

#endif
