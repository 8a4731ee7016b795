// Kernels that take a mesh's positions and make the slopes of its polyhedra and the records of a lattice. The program
// also has the kernels of its vertices: those at which polyhedra may leave a gap (fan_kernels.h), and those of the
// sign's sweep (sweep_vertices.h).
//
// With LANES 8 a work-item takes one vector of faces or vertices after the other; with LANES 1 it is a face, a record
// or a vertex. The host writes the records of point sites, and decides what is nearly degenerate.

#include "face_frames.h"
#include "fan_kernels.h"
#include "simd.h"
#include "sweep_vertices.h"

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

// Moves `count` items of so many words, which the host wrote, to their places in an array of such items.
__kernel void place_items(uint count, uint words, __global const uint* written, __global const uint* places,
                          __global uint* items) {
    const uint n = get_global_id(0);
    if (n >= count) return;
    for (uint i = 0; i < words; ++i) items[(size_t)places[n] * words + i] = written[(size_t)n * words + i];
}
