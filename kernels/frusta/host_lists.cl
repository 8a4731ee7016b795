// Lists the faces of a mesh that the host looks at: those that kernels leave to it (face_records.cl), and all faces at
// their edges.

#include "face_sources.h"
#include "host_lists.h"
#include "mesh_groups.h"
#include "mesh_topology.h"

// Adds a number to a list, unless its bit is set; then it is there. Returns whether the list has room for it.
static inline bool add_once(uint number, Atomic bits, Atomic count, uint room, __global uint* list) {
    const uint bit = 1u << number % 32;
    if (atomic_or(bits + number / 32, bit) & bit) return true;
    const uint place = atomic_inc(count);
    if (place < room) list[place] = number;
    return place < room;
}

// Whether the host finds the slopes of a face: by the kernel's answer, or because of an edge of three faces or more, of
// two of different orientations, or from a vertex to itself.
static inline bool is_left_face(uint face, __global const uchar* answers, __global const uchar* marks) {
    uint all_marks = 0;
    for (uint k = 0; k < 3; ++k) all_marks |= marks[16 * (size_t)face + 12 + k];
    return answers[face] != 0 || (all_marks & ~CLSDF_MARK_OPEN) != 0;
}

// Lists, in any order, the faces that the host measures, and those around vertices with a gap. face_answers,
// vertex_answers: see face_sources.h. marks: as pair_edges() of mesh_topology.cl wrote them.
__kernel GROUP_OF_KERNEL void list_measured(ListSizes sizes, __global const uchar* face_answers,
                                            __global const uchar* vertex_answers, __global const uchar* marks,
                                            __global const uint* starts, __global const uint* corners, Atomic words,
                                            __global uint* measured, __global ListCounts* counts) {
    volatile __local uint sum;
    const uint n = get_global_id(0);
    uint is_saddle = 0;
    bool has_room = true;
    if (n < sizes.vertices) {
        is_saddle = vertex_answers[n] == CLSDF_VERTEX_IS_SADDLE;
        if (vertex_answers[n] & CLSDF_VERTEX_IS_OPEN) {
            const uint begin = starts[n], end = starts[n + 1];
            has_room = end - begin <= CLSDF_MOST_RING;
            for (uint i = begin; i < end && has_room; ++i)
                has_room =
                    add_once(corners[i] >> 2, words + sizes.measured, (Atomic)&counts->measured, sizes.room, measured);
        }
    }
    if (n < sizes.faces && is_left_face(n, face_answers, marks) &&
        !add_once(n, words + sizes.measured, (Atomic)&counts->measured, sizes.room, measured))
        has_room = false;
    if (!has_room) atomic_max((Atomic)&counts->is_refused, 1u);
    count_up(is_saddle, &sum, (Atomic)&counts->saddles);
}

// The arrays from which a face for the host is made. given: the caller's numbers of the vertices.
typedef struct FaceData {
    __global const uchar* face_answers;
    __global const uchar* vertex_answers;
    __global const uchar* marks;
    __global const uint* triangles;
    __global const uint* order;
    __global const uint* given;
    __global const double* positions;
} FaceData;

// Lists a face once. Returns whether the list has room for it.
static inline bool add_near(FaceData data, uint face, Atomic bits, Atomic count, uint room, __global ListedFace* near) {
    const uint bit = 1u << face % 32;
    if (atomic_or(bits + face / 32, bit) & bit) return true;
    const uint place = atomic_inc(count);
    if (place >= room) return false;
    uint left = is_left_face(face, data.face_answers, data.marks) ? CLSDF_LEFT_FACE : 0u;
    for (uint k = 0; k < 3; ++k) {
        const uint vertex = data.triangles[3 * (size_t)face + k];
        if (data.vertex_answers[vertex] & CLSDF_VERTEX_IS_OPEN) left |= CLSDF_LEFT_VERTEX << k;
        if (data.vertex_answers[vertex] & CLSDF_VERTEX_HAS_GAP) left |= CLSDF_LEFT_GAP << k;
        near[place].vertices[k] = vertex;
        near[place].given[k] = data.given[vertex];
        vstore3(vload3(vertex, data.positions), 0, near[place].corners[k]);
    }
    near[place].left = left;
    near[place].number = face;
    near[place].triangle = data.order[face];
    return true;
}

// Whether the host measures a face.
static inline bool is_measured(FaceData data, uint face) {
    bool is_asked = is_left_face(face, data.face_answers, data.marks);
    for (uint k = 0; k < 3; ++k) {
        const uint answer = data.vertex_answers[data.triangles[3 * (size_t)face + k]];
        is_asked = is_asked || (answer & (CLSDF_VERTEX_IS_OPEN | CLSDF_VERTEX_HAS_GAP)) == CLSDF_VERTEX_IS_OPEN;
    }
    return is_asked;
}

// Lists, in any order, the faces of list_measured() and all faces at the edges of those that the host measures. across,
// marks: as pair_edges() wrote them.
__kernel void list_near(ListSizes sizes, __global const uchar* face_answers, __global const uchar* vertex_answers,
                        __global const uint* across, __global const uchar* marks, __global const uint* starts,
                        __global const uint* corners, Atomic words, __global const uint* measured,
                        __global ListCounts* counts, __global const uint* triangles, __global const uint* order,
                        __global const uint* given, __global const double* positions, __global ListedFace* near) {
    const FaceData data = {face_answers, vertex_answers, marks, triangles, order, given, positions};
    const uint count = min(counts->measured, sizes.room);
    const Atomic bits = words + sizes.near, near_count = (Atomic)&counts->near;
    bool has_room = true;
    for (uint n = get_global_id(0); n < count && has_room; n += get_global_size(0)) {
        const uint face = measured[n];
        has_room = add_near(data, face, bits, near_count, sizes.room, near);
        if (!is_measured(data, face)) continue;
        for (uint k = 0; k < 3 && has_room; ++k) {
            const uint mark = marks[16 * (size_t)face + 12 + k];
            if (mark == 0 || mark == CLSDF_MARK_UNORIENTED)
                has_room = add_near(data, across[4 * (size_t)face + k] >> 2, bits, near_count, sizes.room, near);
            if (mark != CLSDF_MARK_NON_MANIFOLD) continue;
            const uint vertex = triangles[3 * (size_t)face + k], bit = 1u << vertex % 32;
            if (atomic_or(words + sizes.near_vertices + vertex / 32, bit) & bit) continue;
            has_room = starts[vertex + 1] - starts[vertex] <= CLSDF_MOST_RING;
            for (uint i = starts[vertex]; i < starts[vertex + 1] && has_room; ++i)
                has_room = add_near(data, corners[i] >> 2, bits, near_count, sizes.room, near);
        }
    }
    if (!has_room) atomic_max((Atomic)&counts->is_refused, 1u);
}
