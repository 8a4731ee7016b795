// Kernels that answer (CLSDF_VERTEX_...) at which vertices polyhedra may leave a gap, by the faces around them: on
// GPUs, with LANES 1, ring_fans and vertex_gaps; on processors vertex_fans.
#ifndef CLSDF_FAN_KERNELS_H
#define CLSDF_FAN_KERNELS_H

#include "face_frames.h"
#include "simd.h"
#include "vertex_fans.h"
#if LANES == 1
#include "vertex_gaps.h"
#endif

INLINE uint lane_bits(longL condition) {
    return lanes_to_bits(TO_INTS(condition));
}

#if LANES == 1
// The answer about a vertex that no closed fan is around. At an open edge there is no gap; with fewer than two edges of
// two faces it is no saddle vertex, either. Writes the corners of others that vertex_gaps can look at.
static inline uint border_answer(__global const uint* corners, uint begin, uint end, __global const uchar* marks,
                                 __global uint* words) {
    uint all_marks = 0, uses = 0;  // two for each edge with two faces
    for (uint i = begin; i < end; ++i) {
        const uint k = corners[i] & 3;
        for (uint which = 0; which < 2; ++which) {
            const uint edge = which == 0 ? k : PREVIOUS_OF_THREE(k);
            const uint mark = marks[16 * (size_t)(corners[i] >> 2) + 12 + edge];
            all_marks |= mark;
            uses += mark == 0 ? 1u : 0u;
        }
    }
    if (all_marks == CLSDF_MARK_OPEN && uses < 4) return 0u;
    if (all_marks != CLSDF_MARK_OPEN || end - begin > CLSDF_FAN_FACES)
        return CLSDF_VERTEX_IS_OPEN | CLSDF_VERTEX_IS_IRREGULAR;
    for (uint i = begin; i < end; ++i) words[i] = corners[i];
    return CLSDF_VERTEX_IS_OPEN;
}

// Writes the corners around a vertex, counter-clockwise; false unless its faces are one closed fan of one orientation.
static inline bool walk_fan(__global const uint* corners, uint begin, uint end, __global const uint* across,
                            __global const uchar* marks, __global uint* words) {
    const uint first = corners[begin];
    uint corner = first;
    for (uint i = begin; i < end; ++i) {
        const uint face = corner >> 2, arriving = PREVIOUS_OF_THREE(corner & 3);
        words[i] = corner;
        if (marks[16 * (size_t)face + 12 + arriving] != 0) return false;
        corner = across[4 * (size_t)face + arriving];
        if (corner >> 2 == first >> 2) return i + 1 == end;
    }
    return false;
}

// Answers (CLSDF_VERTEX_...) about the vertices [begin, end), from the topology of mesh_topology.cl. words: as many as
// corners.
__kernel void ring_fans(uint begin, uint end, double per_unit, __global const uint* starts,
                        __global const uint* corners, __global const uint* across, __global const uchar* marks,
                        __global const uint* triangles, __global const double* positions, __global const float* signs,
                        __global uint* words, __global uchar* answers) {
    const uint vertex = begin + (uint)get_global_id(0);
    if (vertex >= end) return;
    const uint place = starts[vertex], last = starts[vertex + 1], faces = last - place;
    if (faces < 3 || faces > CLSDF_FAN_FACES || !walk_fan(corners, place, last, across, marks, words)) {
        answers[vertex] = (uchar)border_answer(corners, place, last, marks, words);
        return;
    }
    Fans fans;
    load_fans(faces, words, &place, 1, triangles, positions, signs, per_unit, &fans);
    const EdgeKinds kinds = edge_kinds(&fans, faces);
    bool is_open = lane_bits(kinds.is_left_to_host);
    if (lane_bits(kinds.is_mixed && !kinds.is_left_to_host)) is_open = !lane_bits(are_covered(&fans, faces, true));
    answers[vertex] =
        (uchar)((lane_bits(kinds.is_saddle) ? CLSDF_VERTEX_IS_SADDLE : 0u) | (is_open ? CLSDF_VERTEX_IS_OPEN : 0u));
}

// Decides the vertices that ring_fans left open, but for irregular ones. Those that stay open have a gap, or a face
// that the host measures: one that is nearly degenerate, or shares an edge with such a face or with two others.
__kernel void vertex_gaps(FaceLattice lattice, double least_length, double per_unit, uint begin, uint end,
                          __global const uint* starts, __global const uint* words, __global const uint* triangles,
                          __global const uint* opposite, __global const double* positions, __global uchar* answers) {
    const uint vertex = begin + (uint)get_global_id(0);
    if (vertex >= end) return;
    if ((answers[vertex] & (CLSDF_VERTEX_IS_OPEN | CLSDF_VERTEX_IS_IRREGULAR)) != CLSDF_VERTEX_IS_OPEN) return;
    const FaceArrays arrays = {lattice, least_length, triangles, opposite, positions};
    const uint place = starts[vertex];
    answers[vertex] = (uchar)gap_answer(arrays, per_unit, starts[vertex + 1] - place, words + place);
}

#else

// Where the words of an item's vertex begin.
INLINE uint place_of_fan(FanItem item, uint number) {
    return item.offset + number / CLSDF_FAN_STRIDE * (CLSDF_FAN_STRIDE * item.faces) + number % CLSDF_FAN_STRIDE;
}

OUT_OF_LINE void load_item(FanItem item, __global const uint* words, __private const uint* numbers,
                           __global const uint* triangles, __global const double* positions,
                           __global const float* signs, double per_unit, __private Fans* fans) {
    uint places[LANES];
    for (uint lane = 0; lane < LANES; ++lane) places[lane] = place_of_fan(item, numbers[lane]);
    load_fans(item.faces, words, places, CLSDF_FAN_STRIDE, triangles, positions, signs, per_unit, fans);
}

// Clears CLSDF_VERTEX_IS_OPEN of the vertices numbers[0, valid) of an item that surely have no gap.
OUT_OF_LINE void try_all_conditions(FanItem item, __global const uint* words, __private const uint* numbers, uint valid,
                                    __global const uint* triangles, __global const double* positions,
                                    __global const float* signs, double per_unit, __global uchar* answers) {
    Fans fans;
    load_item(item, words, numbers, triangles, positions, signs, per_unit, &fans);
    const uint covered = lane_bits(are_covered(&fans, item.faces, true));
    for (uint lane = 0; lane < valid; ++lane)
        if (covered >> lane & 1u) answers[numbers[lane]] &= (uchar)~CLSDF_VERTEX_IS_OPEN;
}

// Answers (CLSDF_VERTEX_...) about the vertices of items, CLSDF_FAN_ITEM each.
__kernel void vertex_fans(uint begin, double per_unit, __global const FanItem* items, __global const uint* words,
                          __global const uint* triangles, __global const double* positions, __global const float* signs,
                          __global uchar* all_answers) {
    const uint number = begin + (uint)get_global_id(0);
    const FanItem item = items[number];
    __global uchar* const answers = all_answers + (size_t)number * CLSDF_FAN_ITEM;
    if (item.is_border) {  // they have no gap, but may be saddles by the exact kinds of their edges
        for (uint i = 0; i < item.count; ++i) answers[i] = CLSDF_VERTEX_IS_OPEN;
        return;
    }
    uint queue[2 * LANES], queued = 0;
    for (uint i = 0; i < item.count; i += LANES) {
        uint numbers[LANES];
        for (uint lane = 0; lane < LANES; ++lane) numbers[lane] = min(i + lane, item.count - 1);
        Fans fans;
        load_item(item, words, numbers, triangles, positions, signs, per_unit, &fans);
        const EdgeKinds kinds = edge_kinds(&fans, item.faces);
        const uint left = lane_bits(kinds.is_left_to_host), saddles = lane_bits(kinds.is_saddle);
        uint asked = lane_bits(kinds.is_mixed && !kinds.is_left_to_host);
        if (asked) asked &= ~lane_bits(are_covered(&fans, item.faces, false));
        for (uint lane = 0; lane < min((uint)LANES, item.count - i); ++lane) {
            const bool is_asked = asked >> lane & 1u;
            answers[i + lane] = (uchar)((saddles >> lane & 1u ? CLSDF_VERTEX_IS_SADDLE : 0u) |
                                        (is_asked || (left >> lane & 1u) ? CLSDF_VERTEX_IS_OPEN : 0u));
            queue[queued] = i + lane;
            queued += is_asked ? 1u : 0u;
        }
        if (queued < LANES) continue;
        try_all_conditions(item, words, queue, LANES, triangles, positions, signs, per_unit, answers);
        queued -= LANES;
        for (uint k = 0; k < queued; ++k) queue[k] = queue[LANES + k];
    }
    if (queued == 0) return;
    for (uint k = queued; k < LANES; ++k) queue[k] = queue[0];
    try_all_conditions(item, words, queue, queued, triangles, positions, signs, per_unit, answers);
}
#endif

#endif
