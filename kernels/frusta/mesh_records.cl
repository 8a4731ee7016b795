// Kernels that take a mesh's positions and make slopes of its polyhedra, the vertices at which they may leave a gap,
// the records of a lattice, and the vertices of the sign's sweep.
//
// With LANES 8 a work-item takes one vector of faces or vertices after the other; with LANES 1 it is a face, a record
// or a vertex. The host writes the records of point sites, and decides what is nearly degenerate.

#include "face_frames.h"
#include "mesh_topology.h"
#include "simd.h"
#include "sweep.h"
#include "vertex_fans.h"
#if LANES == 1
#include "vertex_gaps.h"
#endif

// Loads the opposite vertices of edges, given as words. If there is none, sets *is_none and loads `other`, which may be
// any vertex.
INLINE Vectors opposite_of(__global const double* positions, __private uint* vertices, __private const uint* other,
                           __private longL* is_none) {
#define WORD_OF(lane) vertices[lane]
    *is_none = TO_LONGS((uintL)EACH_LANE(WORD_OF) >= CLSDF_FIRST_NO_VERTEX);
#undef WORD_OF
#pragma unroll
    for (uint lane = 0; lane < LANES; ++lane)
        vertices[lane] = vertices[lane] >= CLSDF_FIRST_NO_VERTEX ? other[lane] : vertices[lane] & CLSDF_OPPOSITE_VERTEX;
    return positions_of(positions, vertices);
}

INLINE void store_by_lanes(doubleL first, doubleL second, doubleL third, __private const uint* faces, uint valid,
                           __global float* values, uint stride) {
    float lanes[3][LANES];
    store_lanes(TO_FLOATS(first), 0, lanes[0]);
    store_lanes(TO_FLOATS(second), 0, lanes[1]);
    store_lanes(TO_FLOATS(third), 0, lanes[2]);
    for (uint lane = 0; lane < valid; ++lane) {
        __global float* const to = values + stride * (size_t)faces[lane];
        to[0] = lanes[0][lane];
        to[1] = lanes[1][lane];
        to[2] = lanes[2][lane];
    }
}

INLINE uintL names_of(__global const uint* names, __private const uint* faces) {
#define NAME_OF(lane) LOAD(uint, names + faces[lane])
    return (uintL)EACH_LANE(NAME_OF);
#undef NAME_OF
}

// Stores the slopes of faces[0, valid) (leaned; above, then below), signed slopes before the lean, and answers
// (CLSDF_FACE_...), by edge of the face. Returns the leaned slopes by edge of the polyhedron.
INLINE LaneSlopes find_slopes(FaceLattice lattice, double least_length, __private const FaceFrames* f,
                              __global const uint* opposite, __private const uint* faces, __private const uint* corners,
                              uint valid, __global const double* positions, __global float* slopes,
                              __global float* signs, __global uchar* answers) {
    uint vertices[3][LANES];
    load_corners(opposite, faces, vertices[0], vertices[1], vertices[2]);
    longL none[3];
    Vectors others[3];
    for (uint k = 0; k < 3; ++k) others[k] = opposite_of(positions, vertices[k], corners, none + k);
    const BaseEdges base = f->base_edges;
    const Vectors area = cross_product(f->base, f->to_apex);
    const Vectors bound = vectors(fabs(f->base.y * f->to_apex.z) + fabs(f->base.z * f->to_apex.y),
                                  fabs(f->base.z * f->to_apex.x) + fabs(f->base.x * f->to_apex.z),
                                  fabs(f->base.x * f->to_apex.y) + fabs(f->base.y * f->to_apex.x));
    LaneSlopes s;
    doubleL sign[3];
#define MEASURE(edge, start, inward, first, second, third)                                                             \
    measure_edge(start, from_base(base, others[first], others[second], others[third]), inward, f->normal, area, bound, \
                 lattice.per_unit,                                                                                     \
                 base.is_first    ? none[first]                                                                        \
                 : base.is_second ? none[second]                                                                       \
                                  : none[third],                                                                       \
                 s.above + edge, s.below + edge, sign + edge)
    const longL is_right = MEASURE(CLSDF_EDGE_RIGHT, f->end, inward_from_right(f), 1, 2, 0),
                is_left = MEASURE(CLSDF_EDGE_LEFT, f->apex, inward_from_left(f), 2, 0, 1),
                is_beside_none = MEASURE(CLSDF_EDGE_BASE, f->start, f->across, 0, 1, 2) && is_right && is_left;
#undef MEASURE
    const longL is_thick = f->height > THIN_FACE * f->length && f->length > least_length;
    const longL is_known = is_beside_none && is_thick;
    const doubleL answer = (is_thick ? (doubleL)0.0 : (doubleL)CLSDF_FACE_IS_SLIVER) +
                           (is_beside_none ? (doubleL)0.0 : (doubleL)CLSDF_FACE_AT_SLIVER);
    lean(f, s.above);
    lean(f, s.below);

    uint own[LANES];
    store_lanes(AS_UINTS(TO_INTS(answer)), 0, own);
    for (uint lane = 0; lane < valid; ++lane) answers[faces[lane]] = (uchar)own[lane];
    for (uint k = 0; k < 3; ++k) sign[k] = is_known ? sign[k] : (doubleL)NAN;
#define BY_OWN_EDGES(values)                                                                      \
    to_own(base, values[0], values[2], values[1]), to_own(base, values[1], values[0], values[2]), \
        to_own(base, values[2], values[1], values[0])
    store_by_lanes(BY_OWN_EDGES(sign), faces, valid, signs, 3);
    store_by_lanes(BY_OWN_EDGES(s.above), faces, valid, slopes, 6);
    store_by_lanes(BY_OWN_EDGES(s.below), faces, valid, slopes + 3, 6);
#undef BY_OWN_EDGES
    return s;
}

// Slopes of the faces; and, unless `records` is null, their records, which the last face fills up to whole groups
// (CLSDF_RECORD_GROUP). Work-items take `item_faces` faces each. A shorter side than least_length, in units, is a
// sliver's.
__kernel void face_slopes(FaceLattice lattice, double least_length, uint begin, uint end, uint face_count,
                          uint item_faces, __global const uint* triangles, __global const uint* opposite,
                          __global const double* positions, __global const uint* names, __global float* slopes,
                          __global float* signs, __global uchar* answers, __global Polyhedron* records) {
    const uint first = begin + (uint)get_global_id(0) * item_faces, last = min(end, first + item_faces);
    for (uint n = first; n < last; n += LANES) {
        uint faces[LANES], a[LANES], b[LANES], c[LANES];
        for (uint lane = 0; lane < LANES; ++lane) faces[lane] = min(n + lane, face_count - 1);
        load_corners(triangles, faces, a, b, c);
        const FaceFrames f = frames_of_faces(lattice, positions_of(positions, a), positions_of(positions, b),
                                             positions_of(positions, c));
        const uint valid = n < face_count ? min((uint)LANES, face_count - n) : 0;
        const LaneSlopes s =
            find_slopes(lattice, least_length, &f, opposite, faces, a, valid, positions, slopes, signs, answers);
        if (records == 0) continue;
        const Vectors origin = origins_of(lattice, f.foot), foot = feet_from_origins(lattice, f.foot, origin);
        LaneRecords r = records_of(lattice, &f, &s, names_of(names, faces), origin, foot);
        store_records(&r, records + n);
    }
}

// Records [begin, end): those of CLSDF_RECORD_GROUP faces for each of `groups`, which are numbers of such groups; the
// mesh's last face fills up the last one. Work-items take `item_records` records each.
__kernel void face_records(FaceLattice lattice, uint begin, uint end, uint face_count, uint item_records,
                           __global const uint* groups, __global const uint* triangles,
                           __global const double* positions, __global const float* slopes, __global const uint* names,
                           __global Polyhedron* records) {
    const uint first = begin + (uint)get_global_id(0) * item_records, last = min(end, first + item_records);
    for (uint n = first; n < last; n += LANES) {
        uint faces[LANES], a[LANES], b[LANES], c[LANES];
        const uint face = groups[n / CLSDF_RECORD_GROUP] * CLSDF_RECORD_GROUP + n % CLSDF_RECORD_GROUP;
        for (uint lane = 0; lane < LANES; ++lane) faces[lane] = min(face + lane, face_count - 1);
        load_corners(triangles, faces, a, b, c);
        const FaceFrames f = frames_of_faces(lattice, positions_of(positions, a), positions_of(positions, b),
                                             positions_of(positions, c));
        float own[6][LANES];
        for (uint lane = 0; lane < LANES; ++lane)
            for (uint k = 0; k < 6; ++k) own[k][lane] = slopes[6 * (size_t)faces[lane] + k];
        doubleL by_edge[6];
        for (uint k = 0; k < 6; ++k) by_edge[k] = TO_DOUBLES(load_lanes(0, own[k]));
        LaneSlopes s;
        for (uint edge = 0; edge < 3; ++edge) {
            const uint next = (edge + 1) % 3, previous = (edge + 2) % 3;
            s.above[edge] = to_own(f.base_edges, by_edge[edge], by_edge[next], by_edge[previous]);
            s.below[edge] = to_own(f.base_edges, by_edge[3 + edge], by_edge[3 + next], by_edge[3 + previous]);
        }
        const Vectors origin = origins_of(lattice, f.foot), foot = feet_from_origins(lattice, f.foot, origin);
        LaneRecords r = records_of(lattice, &f, &s, names_of(names, faces), origin, foot);
        store_records(&r, records + n);
    }
}

INLINE uint lane_bits(longL condition) {
    return lanes_to_bits(TO_INTS(condition));
}

#if LANES == 1
// The answer about a vertex that no closed fan is around. At an open edge there is no gap; with fewer than two edges of
// two faces it is no saddle vertex, either. Writes the corners of others that vertex_gaps can look at.
static inline uint border_answer(__global const uint* corners, uint begin, uint end, __global const uchar* marks,
                                 __global uint* words) {
    uint all_marks = 0, uses = 0;  // of edges with two faces: two each
    for (uint i = begin; i < end; ++i) {
        const uint k = corners[i] & 3;
        for (uint which = 0; which < 2; ++which) {
            const uint edge = which == 0 ? k : PREVIOUS_OF_THREE(k);
            const uint mark = marks[16 * (size_t)(corners[i] >> 2) + 12 + edge];
            all_marks |= mark;
            uses += mark == 0 ? 1u : 0u;
        }
    }
    if (all_marks == CLSDF_EDGE_OPEN && uses < 4) return 0u;
    if (all_marks != CLSDF_EDGE_OPEN || end - begin > CLSDF_FAN_FACES)
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

// Moves `count` items of so many words, which the host wrote, to their places in an array of such items.
__kernel void place_items(uint count, uint words, __global const uint* written, __global const uint* places,
                          __global uint* items) {
    const uint n = get_global_id(0);
    if (n >= count) return;
    for (uint i = 0; i < words; ++i) items[(size_t)places[n] * words + i] = written[(size_t)n * words + i];
}

// The vertex of the sign's sweep, as lib/engine/sign/sweep_mesh.cpp snaps it to multiples of 1 / scale samples. It is
// not far from the lattice's sample (0, 0, 0).
INLINE SweepVertex sweep_vertex(FaceLattice lattice, double scale_y, double scale_z, double3 position) {
    const double3 spacing = vload3(0, lattice.spacing) / lattice.per_unit;  // exact: a unit is a power of two
    const double3 samples = (position - vload3(0, lattice.origin)) / spacing;
    const SweepVertex vertex = {(long)rint(samples.y * scale_y), (long)rint(samples.z * scale_z), samples.x};
    return vertex;
}

__kernel void sweep_vertices(FaceLattice lattice, double scale_y, double scale_z, uint begin, uint end,
                             __global const double* positions, __global SweepVertex* vertices) {
    const uint n = begin + get_global_id(0);
    if (n < end) vertices[n] = sweep_vertex(lattice, scale_y, scale_z, vload3(n, positions));
}

// Makes the sweep's vertices and triangles of some clusters' faces: three vertices a face, none shared. A work-item has
// a corner; the mesh's last cluster may have fewer faces.
__kernel void sweep_clusters(FaceLattice lattice, double scale_y, double scale_z, uint begin, uint end,
                             __global const uint* clusters, __global const uint* triangles,
                             __global const double* positions, __global uint* corners, __global SweepVertex* vertices) {
    const uint n = begin + get_global_id(0);
    if (n >= end) return;
    const uint of_cluster = 3 * CLSDF_CLUSTER, corner = clusters[n / of_cluster] * of_cluster + n % of_cluster;
    corners[n] = n;
    vertices[n] = sweep_vertex(lattice, scale_y, scale_z, vload3(triangles[corner], positions));
}
