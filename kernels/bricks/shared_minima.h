// The minima of groups that share a long list: each stores its own, and a later group joins them.
#ifndef CLSDF_SHARED_MINIMA_H
#define CLSDF_SHARED_MINIMA_H

#include "group_batches.h"

// The minima that a share stores for a brick: 512 squares, then with NEAREST 512 polyhedra.
#ifdef NEAREST
#define MINIMA_WORDS (CLSDF_MINIMUM_BYTES(1) / 4)
#else
#define MINIMA_WORDS (CLSDF_MINIMUM_BYTES(0) / 4)
#endif
INLINE void store_minima(__private const ItemMinimum* minimum, __global uint* set) {
#pragma unroll
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        set[s * GROUP + get_local_id(0)] = as_uint(minimum->squared[s]);
#ifdef NEAREST
        set[512 + s * GROUP + get_local_id(0)] = minimum->polyhedron[s];
#endif
    }
}
#ifdef NEAREST
// As is_nearer, of polyhedra in any order. A triangle may have two that are equally near, its own and that of a vertex
// that closes a gap: the first one is taken, as in a list.
static inline bool is_nearer_of_shares(float squared, uint polyhedron, float least, uint nearest,
                                       __global const Polyhedron* polyhedra) {
    if (polyhedron == CLSDF_NO_POLYHEDRON) return false;
    if (squared == least && nearest != CLSDF_NO_POLYHEDRON &&
        polyhedra[polyhedron].triangle == polyhedra[nearest].triangle)
        return polyhedron < nearest;
    return is_nearer(squared, polyhedron, least, nearest, polyhedra);
}
#endif
INLINE void join_minima(__private ItemMinimum* minimum, __global const uint* set,
                        __global const Polyhedron* polyhedra) {
#pragma unroll
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        const float squared = as_float(set[s * GROUP + get_local_id(0)]);
#ifdef NEAREST
        const uint polyhedron = set[512 + s * GROUP + get_local_id(0)];
        if (!is_nearer_of_shares(squared, polyhedron, minimum->squared[s], minimum->polyhedron[s], polyhedra)) continue;
        minimum->squared[s] = squared;
        minimum->polyhedron[s] = polyhedron;
#else
        minimum->squared[s] = LESSER(squared, minimum->squared[s]);
#endif
    }
}

#endif
