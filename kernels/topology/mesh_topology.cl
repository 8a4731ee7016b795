// Makes the topology of a mesh on a GPU, from the caller's arrays to the pairs of edges: the bytes of MeshTopology,
// opposite_words() and encloses_negative_volume() of the host, whatever the order of the work-items.
//
// The vertices of equal coordinates share a slot of a hash table. Faces are sorted by their Morton codes, vertices are
// numbered in the order in which the faces name them, and corners are sorted by vertex. Corner 3 p + k is vertex k of
// the face at place p of the order. Values that begin as zeros and are joined by atomic_max are complements.

#include "face_edges.h"
#include "given_triples.h"
#include "joined_vertices.h"
#include "mesh_boxes.h"
#include "mesh_groups.h"
#include "mesh_topology.h"
#include "mesh_volume.h"
#include "paired_edges.h"
#include "simd.h"
#include "spread_bits.h"

#pragma OPENCL FP_CONTRACT OFF

// The caller's arrays. ------------------------------------------------------------------------------------------------

// Copies them: positions as doubles, indices of 32 bits. An index that is out of range becomes 0.
__kernel void copy_mesh(TopologySizes sizes, GivenTriples of_positions, __global const uint* given_positions,
                        GivenTriples of_triangles, __global const uint* given_triangles, __global double* positions,
                        __global uint* triangles, __global TopologyResults* results) {
    const uint n = get_global_id(0);
    if (n < sizes.vertices)
        for (uint axis = 0; axis < 3; ++axis)
            positions[3 * (size_t)n + axis] = coordinate(of_positions, given_positions, n, axis);
    if (n >= sizes.faces) return;
    bool are_in_range = true;
    for (uint k = 0; k < 3; ++k) {
        const uint2 index = words_of(of_triangles, given_triangles, n, k);
        const bool is_in_range = index.y == 0 && index.x < sizes.vertices;
        triangles[3 * (size_t)n + k] = is_in_range ? index.x : 0u;
        are_in_range = are_in_range && is_in_range;
    }
    if (!are_in_range) atomic_max((Atomic)&results->is_refused, 1u);
}

// Vertices of equal coordinates. --------------------------------------------------------------------------------------

// The coordinates as integers, which are equal if and only if the coordinates are.
static inline ulong3 key_of(__global const double* positions, uint vertex) {
    const double3 at = position(positions, vertex);
    return (ulong3)(bits_of(at.x), bits_of(at.y), bits_of(at.z));
}

static inline bool are_equal(ulong3 a, ulong3 b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static inline ulong mixed(ulong value) {
    value = (value ^ value >> 32) * 0x9E3779B97F4A7C15ul;
    return value ^ value >> 29;
}

// Files each vertex in the hash table. A slot belongs to the coordinates of the first vertex that takes it for ever,
// and keeps the least vertex that has them.
__kernel void file_vertices(TopologySizes sizes, __global const double* positions, Atomic words, __global uint* slots,
                            __global TopologyResults* results) {
    const uint vertex = get_global_id(0);
    if (vertex >= sizes.vertices) return;
    const ulong3 key = key_of(positions, vertex);
    uint slot = (uint)mixed(mixed(mixed(key.x) ^ key.y) ^ key.z);
    for (uint probe = 0; probe < CLSDF_MOST_PROBES; ++probe, ++slot) {
        slot &= sizes.slots - 1u;
        const Atomic entry = words + sizes.table + slot;
        const uint before = atomic_cmpxchg(entry, 0u, ~vertex);
        if (before != 0 && !are_equal(key, key_of(positions, ~before))) continue;
        if (before != 0) atomic_max(entry, ~vertex);
        slots[vertex] = slot;
        return;
    }
    slots[vertex] = slot & (sizes.slots - 1u);
    atomic_max((Atomic)&results->is_refused, 1u);
}

// The first equal vertex of each, with CLSDF_IN_USE; counts those in use, and their classes.
__kernel GROUP_OF_KERNEL void count_vertices(TopologySizes sizes, Atomic words, __global const uint* slots,
                                             __global uint* first_equal, __global TopologyResults* results) {
    volatile __local uint sum;
    const uint vertex = get_global_id(0);
    uint is_used = 0, is_first = 0;
    if (vertex < sizes.vertices) {
        const uint equal = ~words[sizes.table + slots[vertex]];
        is_used = words[sizes.used + vertex / 32] >> vertex % 32 & 1u;
        first_equal[vertex] = equal | (is_used ? CLSDF_IN_USE : 0u);
        const uint bit = 1u << equal % 32;
        if (is_used) is_first = (atomic_or(words + sizes.classes + equal / 32, bit) & bit) == 0;
    }
    count_up(is_used, &sum, (Atomic)&results->used_vertices);
    count_up(is_first, &sum, (Atomic)&results->different_vertices);
}

// Whether vertices that have moved and had equal coordinates have them still; if not, or if the first of those that
// are equal is not in use, the host looks at them. first_equal: of count_vertices().
__kernel void compare_equal_vertices(uint count, __global const uint* first_equal, GivenTriples of_positions,
                                     __global const uint* given, __global TopologyResults* results) {
    const uint vertex = get_global_id(0);
    if (vertex >= count || !(first_equal[vertex] & CLSDF_IN_USE)) return;
    const uint first = first_equal[vertex] & ~CLSDF_IN_USE;
    if (first == vertex) return;
    bool are_equal = (first_equal[first] & CLSDF_IN_USE) != 0;
    for (uint axis = 0; axis < 3; ++axis)
        are_equal =
            are_equal && coordinate(of_positions, given, vertex, axis) == coordinate(of_positions, given, first, axis);
    if (!are_equal) atomic_max((Atomic)&results->is_refused, 1u);
}

// The order of the faces. ---------------------------------------------------------------------------------------------

static inline uint cell_of(double place, double last) {
    const double positive = place > 0.0 ? place : 0.0;
    return spread_bits((uint)(int)LESSER(positive, last));
}

// The codes of morton_order().
__kernel void face_codes(TopologySizes sizes, __global const double* positions, __global const uint* triangles,
                         __global const TopologyResults* results, __global uint* codes) {
    const uint face = get_global_id(0);
    if (face >= sizes.faces) return;
    double longest = 0.0;
    for (uint axis = 0; axis < 3; ++axis) {
        const double side = results->box[3 + axis] - results->box[axis];
        longest = GREATER(side, longest);
    }
    const double cells = (double)sizes.cells, scale = longest > 0.0 ? cells / (3.0 * longest) : 0.0;
    const double3 a = position(positions, triangles[3 * (size_t)face]),
                  b = position(positions, triangles[3 * (size_t)face + 1]),
                  c = position(positions, triangles[3 * (size_t)face + 2]);
    const double3 lower = (double3)(3.0 * results->box[0], 3.0 * results->box[1], 3.0 * results->box[2]);
    const double3 place = scale * (((a + b) + c) - lower);
    codes[face] =
        cell_of(place.x, cells - 1.0) | cell_of(place.y, cells - 1.0) << 1 | cell_of(place.z, cells - 1.0) << 2;
}

// The vertices of the faces in their order, by the caller's numbers, and the first corner at each vertex. Vertices of
// equal coordinates count as one if two of them are in use.
__kernel void order_faces(TopologySizes sizes, __global const uint* order, __global const uint* triangles,
                          __global const uint* first_equal, __global const TopologyResults* results,
                          __global uint* named, Atomic words) {
    const uint place = get_global_id(0);
    if (place >= sizes.faces) return;
    const bool are_merged = results->used_vertices != results->different_vertices;
    for (uint k = 0; k < 3; ++k) {
        const uint vertex = triangles[3 * (size_t)order[place] + k],
                   name = are_merged ? first_equal[vertex] & ~CLSDF_IN_USE : vertex;
        named[3 * (size_t)place + k] = name;
        atomic_max(words + sizes.first_corners + name, ~(3 * place + k));
    }
}

// Numbers of vertices. ------------------------------------------------------------------------------------------------

// first_corners: of the caller's vertices.
static inline uint is_first(uint corner, uint corners, __global const uint* named, __global const uint* first_corners) {
    return corner < corners && first_corners[named[corner]] == ~corner ? 1u : 0u;
}

// How many corners of each tile are the first ones at their vertices. A group a tile.
__kernel GROUP_OF_KERNEL void count_first_corners(TopologySizes sizes, __global const uint* named,
                                                  __global const uint* words, __global uint* counts) {
    __local uint sums[GROUP];
    const uint begin = (uint)get_group_id(0) * CLSDF_CORNER_TILE;
    uint count = 0;
    for (uint i = get_local_id(0); i < CLSDF_CORNER_TILE; i += GROUP)
        count += is_first(begin + i, 3 * sizes.faces, named, words + sizes.first_corners);
    sum_before(count, sums);
    if (get_local_id(0) == 0) counts[get_group_id(0)] = sums[GROUP - 1];
}

// counts: of count_first_corners(). numbers: by the caller's numbers. vertices: the caller's numbers. A group a tile.
__kernel GROUP_OF_KERNEL void number_vertices(TopologySizes sizes, __global const uint* named,
                                              __global const uint* words, __global const uint* counts,
                                              __global const double* positions, __global uint* numbers,
                                              __global uint* vertices, __global double* ordered,
                                              __global TopologyResults* results) {
    __local uint sums[GROUP];
    const uint tile = get_group_id(0), begin = tile * CLSDF_CORNER_TILE;
    uint before = 0;
    for (uint i = get_local_id(0); i < tile; i += GROUP) before += counts[i];
    sum_before(before, sums);
    uint next = sums[GROUP - 1];
    for (uint i = 0; i < CLSDF_CORNER_TILE; i += GROUP) {
        const uint corner = begin + i + get_local_id(0);
        const uint is_new = is_first(corner, 3 * sizes.faces, named, words + sizes.first_corners);
        const uint number = next + sum_before(is_new, sums);
        next += sums[GROUP - 1];
        if (!is_new) continue;
        const uint vertex = named[corner];
        numbers[vertex] = number;
        vertices[number] = vertex;
        vstore3(position(positions, vertex), number, ordered);
    }
    if (tile + 1u == get_num_groups(0) && get_local_id(0) == 0) results->vertex_count = next;
}

// The triangles by the new numbers, twice: as keys of their corners, too.
__kernel void name_corners(TopologySizes sizes, __global const uint* named, __global const uint* numbers,
                           __global uint* triangles, __global uint* keys) {
    const uint corner = get_global_id(0);
    if (corner >= 3 * sizes.faces) return;
    triangles[corner] = keys[corner] = numbers[named[corner]];
}

// The corners at each vertex, from their numbers in the order of their vertices. A vertex begins where its first corner
// is.
__kernel void order_corners(TopologySizes sizes, __global const uint* sorted, __global const uint* named,
                            __global const uint* words, __global const uint* triangles,
                            __global const TopologyResults* results, __global uint* starts, __global uint* corners) {
    const uint place = get_global_id(0), count = 3 * sizes.faces;
    if (place == 0) starts[results->vertex_count] = count;
    if (place >= count) return;
    const uint corner = sorted[place];
    corners[place] = corner / 3 << 2 | corner % 3;
    if (is_first(corner, count, named, words + sizes.first_corners)) starts[triangles[corner]] = place;
}

// Pairs of edges. -----------------------------------------------------------------------------------------------------

// across: four words a face, of which the fourth one holds the marks of its edges, a byte each: FaceEdges of
// lib/engine/topology/topology.hpp. opposite: opposite_words().
__kernel GROUP_OF_KERNEL void pair_edges(TopologySizes sizes, __global const uint* triangles,
                                         __global const uint* starts, __global const uint* corners,
                                         __global uint* across, __global uchar* marks, __global uint* opposite,
                                         __global TopologyResults* results) {
    volatile __local uint sum;
    const uint corner = get_global_id(0);
    PairedEdge edge = {0u, 0u, false};
    if (corner < 3 * sizes.faces) {
        const uint face = corner / 3, k = corner % 3;
        edge = paired_edge(face, k, triangles, starts, corners);
        across[4 * (size_t)face + k] = edge.across;
        marks[16 * (size_t)face + 12 + k] = (uchar)edge.mark;
        if (k == 0) marks[16 * (size_t)face + 15] = 0;  // FaceEdges::unused
        const uint other = edge.across & 3;
        opposite[corner] = edge.mark == CLSDF_MARK_OPEN ? CLSDF_NO_VERTEX
                           : edge.mark != 0             ? CLSDF_UNPAIRED_EDGE
                                            : triangles[3 * (size_t)(edge.across >> 2) + previous_of(other)] |
                                                  other << CLSDF_OPPOSITE_EDGE;
    }
    if (edge.is_too_long) atomic_max((Atomic)&results->is_refused, 1u);
    count_up(edge.mark != 0, &sum, (Atomic)&results->marked_edges);
}

// Parts. --------------------------------------------------------------------------------------------------------------

// Joins the vertices of each face, and writes its name (face_edges.h).
__kernel GROUP_OF_KERNEL void join_faces(TopologySizes sizes, __global const uint* order,
                                         __global const uint* triangles, __global const uchar* marks, Atomic words,
                                         __global uint* names, __global TopologyResults* results) {
    volatile __local uint sum;
    const uint face = get_global_id(0);
    uint joined = 0, all_marks = 0;
    if (face < sizes.faces) {
        for (uint k = 0; k < 3; ++k) all_marks |= marks[16 * (size_t)face + 12 + k];
        names[face] = order[face] | (all_marks & CLSDF_MARK_NON_MANIFOLD ? CLSDF_NAME_NON_MANIFOLD : 0u);
        __global const uint* const t = triangles + 3 * (size_t)face;
        joined = join(words + sizes.above, t[0], t[1]) + join(words + sizes.above, t[1], t[2]);
    }
    count_up(joined, &sum, (Atomic)&results->joined_vertices);
    count_up((all_marks & ~CLSDF_MARK_OPEN) != 0, &sum, (Atomic)&results->irregular_faces);
}
