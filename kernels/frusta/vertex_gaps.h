// The gap test of the host, of vertices at which vertex_fans.h is not sure (LANES 1). Faces are measured as the host
// does (lib/engine/frusta/slopes.cpp), so that the answer is the host's.
#ifndef CLSDF_VERTEX_GAPS_H
#define CLSDF_VERTEX_GAPS_H

// There is one call of it. Intel's runtime for processors (2026.2) overwrites its stack in a function that is not
// inlined.
#define RARELY_CALLED static inline
#include "expansions.h"
#include "gap_test.h"

// The arrays from which faces are measured.
typedef struct FaceArrays {
    FaceLattice lattice;
    double least_length;  // of a side that is not taken for a sliver's, in units
    __global const uint* triangles;
    __global const uint* opposite;
    __global const double* positions;
} FaceArrays;

// By edge of the face. The slopes are leaned.
typedef struct MeasuredFace {
    Vectors normal;
    Vectors inward[3];
    double above[3], below[3];
    uint marks[3];  // CLSDF_MARK_...
} MeasuredFace;

INLINE uint base_edge(__private const FaceFrames* f) {
    return f->base_edges.is_first ? 0u : f->base_edges.is_second ? 1u : 2u;
}

INLINE Vectors inward_at(__private const FaceFrames* f, uint edge) {
    const uint base = base_edge(f);
    return edge == base ? f->across : edge == NEXT_OF_THREE(base) ? inward_from_right(f) : inward_from_left(f);
}

INLINE void lean_by_edge(__private const FaceFrames* f, __private double* slopes) {
    const uint base = base_edge(f), right = NEXT_OF_THREE(base), left = PREVIOUS_OF_THREE(base);
    double by_edge[3];  // of the polyhedron
    by_edge[CLSDF_EDGE_BASE] = slopes[base];
    by_edge[CLSDF_EDGE_RIGHT] = slopes[right];
    by_edge[CLSDF_EDGE_LEFT] = slopes[left];
    lean(f, by_edge);
    slopes[right] = by_edge[CLSDF_EDGE_RIGHT];
    slopes[left] = by_edge[CLSDF_EDGE_LEFT];
}

INLINE FaceFrames frame_of(FaceArrays arrays, __private uint* corners) {
    return frames_of_faces(arrays.lattice, positions_of(arrays.positions, corners),
                           positions_of(arrays.positions, corners + 1), positions_of(arrays.positions, corners + 2));
}

// Whether the host has no special case for the frame.
INLINE bool is_plain_frame(FaceArrays arrays, __private const FaceFrames* f) {
    return f->height > THIN_FACE * f->length && f->length > arrays.least_length;
}

INLINE bool are_in_exact_range(double3 p) {
    return is_in_exact_range(p.x) && is_in_exact_range(p.y) && is_in_exact_range(p.z);
}

// False: the host measures the face.
INLINE bool measure_face(FaceArrays arrays, uint face, __private MeasuredFace* measured) {
    uint corners[3];
    for (uint k = 0; k < 3; ++k) corners[k] = arrays.triangles[3 * (size_t)face + k];
    const FaceFrames own = frame_of(arrays, corners);
    if (!is_plain_frame(arrays, &own)) return false;
    measured->normal = own.normal;
#pragma unroll 1
    for (uint k = 0; k < 3; ++k) {
        measured->inward[k] = inward_at(&own, k);
        const uint opposite = arrays.opposite[3 * (size_t)face + k], edge = opposite >> CLSDF_OPPOSITE_EDGE;
        if (opposite == CLSDF_UNPAIRED_EDGE) return false;
        if (opposite == CLSDF_NO_VERTEX) {
            measured->above[k] = measured->below[k] = (double)CLSDF_OPEN_SLOPE;
            measured->marks[k] = CLSDF_MARK_OPEN;
            continue;
        }
        uint others[3];  // the corners of the other face, which has the edge the other way round
        others[edge] = corners[NEXT_OF_THREE(k)];
        others[NEXT_OF_THREE(edge)] = corners[k];
        others[PREVIOUS_OF_THREE(edge)] = opposite & CLSDF_OPPOSITE_VERTEX;
        const FaceFrames across = frame_of(arrays, others);
        if (!is_plain_frame(arrays, &across)) return false;
        FacePair pair =
            face_pair(measured->inward[k], inward_at(&across, edge), own.normal, turn_of(&own) + turn_of(&across));
        if (pair.side == 0) {
            const double3 a = vload3(corners[0], arrays.positions), b = vload3(corners[1], arrays.positions),
                          c = vload3(corners[2], arrays.positions),
                          p = vload3(opposite & CLSDF_OPPOSITE_VERTEX, arrays.positions);
            if (!are_in_exact_range(a) || !are_in_exact_range(b) || !are_in_exact_range(c) || !are_in_exact_range(p))
                return false;
            pair.side = orientation_in_space(a, b, c, p);
        }
        measured->marks[k] = set_pair_slopes(pair, measured->above + k, measured->below + k);
    }
    lean_by_edge(&own, measured->above);
    lean_by_edge(&own, measured->below);
    return true;
}

// Answers (CLSDF_VERTEX_...) about a vertex with so many faces: the words of its fan begin at `words`. per_unit: of the
// lengths of spokes.
INLINE uint gap_answer(FaceArrays arrays, double per_unit, uint faces, __global const uint* words) {
    Vectors spokes[CLSDF_FAN_FACES], conditions[CLSDF_FAN_FACES * (1 + GAP_CONDITIONS)];
    FacePlanes planes[CLSDF_FAN_FACES];
    uint order[CLSDF_FAN_FACES], marks = 0;
    const uint starts[2] = {0, faces};
    for (uint f = 0; f < faces; ++f) {
        const uint corner = words[f], face = corner >> 2, leaving = corner & 3;
        MeasuredFace measured;
        if (!measure_face(arrays, face, &measured)) return CLSDF_VERTEX_IS_OPEN;
        planes[f].normal = measured.normal;
        for (uint i = 0; i < 2; ++i) {
            const uint edge = i == 0 ? leaving : PREVIOUS_OF_THREE(leaving);
            planes[f].inward[i] = measured.inward[edge];
            planes[f].above[i] = measured.above[edge];
            planes[f].below[i] = measured.below[edge];
            marks |= measured.marks[edge];
        }
        uint ends[2];
        ends[0] = arrays.triangles[3 * (size_t)face + leaving];
        ends[1] = arrays.triangles[3 * (size_t)face + NEXT_OF_THREE(leaving)];
        spokes[f] =
            direction_to(positions_of(arrays.positions, ends), positions_of(arrays.positions, ends + 1), per_unit);
    }
    const uint mixed = CLSDF_MARK_CONVEX | CLSDF_MARK_CONCAVE;
    if ((marks & mixed) != mixed) return 0;
    if (marks & CLSDF_MARK_OPEN) return CLSDF_VERTEX_IS_SADDLE;
    GapVertex gap;
    gap.fans = 1;
    gap.starts = starts;
    gap.faces = planes;
    gap.spoke_count = faces;
    gap.spokes = spokes;
    gap.normal = planes[0].normal;
    gap.order = order;
    gap.search.conditions = conditions;
    return CLSDF_VERTEX_IS_SADDLE | (leaves_directions_out(&gap) ? CLSDF_VERTEX_IS_OPEN | CLSDF_VERTEX_HAS_GAP : 0u);
}

#endif
