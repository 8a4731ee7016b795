// Makes the topology of a mesh on a GPU, from the caller's arrays to the pairs of edges: the bytes of MeshTopology,
// KernelTopology::opposite and encloses_negative_volume() of the host, whatever the order of the work-items.
//
// The vertices of equal coordinates share a slot of a hash table. Faces are sorted by their Morton codes, vertices are
// numbered in the order in which the faces name them, and corners are sorted by vertex. Corner 3 p + k is vertex k of
// the face at place p of the order. Values that begin as zeros and are joined by atomic_max are complements.

#include "face_sources.h"
#include "given_triples.h"
#include "joined_vertices.h"
#include "mesh_groups.h"
#include "mesh_topology.h"
#include "paired_edges.h"
#include "simd.h"
#include "spread_bits.h"

#pragma OPENCL FP_CONTRACT OFF

static inline double3 position(__global const double* positions, uint vertex) {
    return vload3(vertex, positions);
}

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

// The coordinates as integers, which are equal if and only if the coordinates are: adding 0.0 turns -0.0 into 0.0.
static inline ulong3 key_of(__global const double* positions, uint vertex) {
    return as_ulong3(position(positions, vertex) + 0.0);
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

// The order of the faces. ---------------------------------------------------------------------------------------------

// Joins boxes of the work-items of a group; the first one's becomes that of all. limits: 6 GROUP numbers.
static inline void join_boxes(__private double* box, __local double* limits) {
    const uint item = get_local_id(0);
    for (uint i = 0; i < 6; ++i) limits[i * GROUP + item] = box[i];
    for (uint apart = GROUP / 2; apart > 0; apart /= 2) {
        barrier(CLK_LOCAL_MEM_FENCE);
        if (item >= apart) continue;
        for (uint i = 0; i < 6; ++i) {
            const double own = limits[i * GROUP + item], other = limits[i * GROUP + item + apart];
            limits[i * GROUP + item] = i < 3 ? LESSER(other, own) : GREATER(other, own);
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = 0; i < 6; ++i) box[i] = limits[i * GROUP];
}

#define BOX_OF_NONE \
    { INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY }

// Adds a position to a box. Returns whether it is finite.
static inline bool add_position(double3 p, __private double* box) {
    const double at[3] = {p.x, p.y, p.z};
    bool is_finite = true;
    for (uint axis = 0; axis < 3; ++axis) {
        box[axis] = LESSER(at[axis], box[axis]);
        box[3 + axis] = GREATER(at[axis], box[3 + axis]);
        is_finite = is_finite && isfinite(at[axis]);
    }
    return is_finite;
}

// Writes a group's box.
static inline void store_box(__private double* box, __local double* limits, __global double* boxes) {
    join_boxes(box, limits);
    if (get_local_id(0) == 0)
        for (uint i = 0; i < 6; ++i) boxes[6 * get_group_id(0) + i] = box[i];
}

// Marks the vertices in use, and measures a box a group.
__kernel GROUP_OF_KERNEL void look_at_faces(TopologySizes sizes, __global const double* positions,
                                            __global const uint* triangles, Atomic words, __global double* boxes,
                                            __global TopologyResults* results) {
    __local double limits[6 * GROUP];
    double box[6] = BOX_OF_NONE;
    bool are_finite = true;
    for (uint face = get_global_id(0); face < sizes.faces; face += get_global_size(0))
        for (uint k = 0; k < 3; ++k) {
            const uint vertex = triangles[3 * (size_t)face + k];
            atomic_or(words + sizes.used + vertex / 32, 1u << vertex % 32);
            are_finite = add_position(position(positions, vertex), box) && are_finite;
        }
    if (!are_finite) atomic_max((Atomic)&results->is_refused, 1u);
    store_box(box, limits, boxes);
}

// One group.
__kernel GROUP_OF_KERNEL void join_group_boxes(uint count, __global const double* boxes,
                                               __global TopologyResults* results) {
    __local double limits[6 * GROUP];
    double box[6] = BOX_OF_NONE;
    for (uint n = get_local_id(0); n < count; n += GROUP)
        for (uint i = 0; i < 6; ++i) {
            const double other = boxes[6 * n + i];
            box[i] = i < 3 ? LESSER(other, box[i]) : GREATER(other, box[i]);
        }
    join_boxes(box, limits);
    if (get_local_id(0) == 0)
        for (uint i = 0; i < 6; ++i) results->box[i] = box[i] + 0.0;  // no negative zeros
}

// Vertices that have moved: takes their positions in the order, and measures a box a group, and whether all are finite.
// vertices: the caller's numbers.
__kernel GROUP_OF_KERNEL void move_vertices(uint count, __global const uint* vertices, GivenTriples of_positions,
                                            __global const uint* given, __global double* positions,
                                            __global double* boxes, __global TopologyResults* results) {
    __local double limits[6 * GROUP];
    double box[6] = BOX_OF_NONE;
    bool are_finite = true;
    for (uint vertex = get_global_id(0); vertex < count; vertex += get_global_size(0)) {
        double3 at;
        at.x = coordinate(of_positions, given, vertices[vertex], 0);
        at.y = coordinate(of_positions, given, vertices[vertex], 1);
        at.z = coordinate(of_positions, given, vertices[vertex], 2);
        vstore3(at, vertex, positions);
        are_finite = add_position(at, box) && are_finite;
    }
    if (!are_finite) atomic_max((Atomic)&results->is_refused, 1u);
    store_box(box, limits, boxes);
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

// Adds the box of a face: that of box_of() in lib/engine/frusta/cluster_index.cpp.
static inline void add_ball(double3 a, double3 b, double3 c, __private double* box) {
    const double3 sides[3] = {b - a, c - b, a - c};
    double squares[3];
    for (uint k = 0; k < 3; ++k)
        squares[k] = sides[k].x * sides[k].x + sides[k].y * sides[k].y + sides[k].z * sides[k].z;
    double3 start = a, edge = sides[0], to_apex = c - a;
    double squared = squares[0];
    if (squares[1] > squared) {
        start = b;
        edge = sides[1];
        to_apex = a - b;
        squared = squares[1];
    }
    if (squares[2] > squared) {
        start = c;
        edge = sides[2];
        to_apex = b - c;
        squared = squares[2];
    }
    const double product = to_apex.x * edge.x + to_apex.y * edge.y + to_apex.z * edge.z;
    double along = 0.0, extent = 2.0 * (fabs(edge.x) + fabs(edge.y) + fabs(edge.z));
    if (squared > 1e-280 && squared < 1e280) {
        const double ratio = product / squared, positive = GREATER(ratio, 0.0);
        along = LESSER(positive, 1.0);
        const double rest = 1.0 - along, farther = GREATER(along, rest), share = GREATER(farther, 0.8661);
        extent = sqrt(squared) * share * (1.0 + 1e-6);
    }
    const double3 foot = start + along * edge;
    const double feet[3] = {foot.x, foot.y, foot.z};
    for (uint axis = 0; axis < 3; ++axis) {
        const double rounding = 1e-15 * fabs(feet[axis]);
        const double lower = feet[axis] - extent - rounding, upper = feet[axis] + extent + rounding;
        box[axis] = LESSER(lower, box[axis]);
        box[3 + axis] = GREATER(upper, box[3 + axis]);
    }
    add_position(a, box);
    add_position(b, box);
    add_position(c, box);
}

// The boxes of clusters, without rounding. A group has a cluster.
__kernel GROUP_OF_KERNEL void cluster_boxes(uint faces, __global const uint* triangles,
                                            __global const double* positions, __global double* boxes) {
    __local double limits[6 * GROUP];
    double box[6] = BOX_OF_NONE;
    const uint begin = CLSDF_CLUSTER * (uint)get_group_id(0), end = min(faces, begin + CLSDF_CLUSTER);
    for (uint face = begin + (uint)get_local_id(0); face < end; face += GROUP) {
        __global const uint* const t = triangles + 3 * (size_t)face;
        add_ball(position(positions, t[0]), position(positions, t[1]), position(positions, t[2]), box);
    }
    store_box(box, limits, boxes);
}

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
// lib/engine/frusta/topology.hpp. opposite: see KernelTopology.
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
        const uint other = edge.across & 3;
        opposite[corner] = edge.mark == CLSDF_EDGE_OPEN ? CLSDF_NO_VERTEX
                           : edge.mark != 0             ? CLSDF_UNPAIRED_EDGE
                                            : triangles[3 * (size_t)(edge.across >> 2) + previous_of(other)] |
                                                  other << CLSDF_OPPOSITE_EDGE;
    }
    if (edge.is_too_long) atomic_max((Atomic)&results->is_refused, 1u);
    count_up(edge.mark != 0, &sum, (Atomic)&results->marked_edges);
}

// Parts. --------------------------------------------------------------------------------------------------------------

// Joins the vertices of each face, and writes its name (face_sources.h).
__kernel GROUP_OF_KERNEL void join_faces(TopologySizes sizes, __global const uint* order,
                                         __global const uint* triangles, __global const uchar* marks, Atomic words,
                                         __global uint* names, __global TopologyResults* results) {
    volatile __local uint sum;
    const uint face = get_global_id(0);
    uint joined = 0, all_marks = 0;
    if (face < sizes.faces) {
        for (uint k = 0; k < 3; ++k) all_marks |= marks[16 * (size_t)face + 12 + k];
        names[face] = order[face] | (all_marks & CLSDF_EDGE_NON_MANIFOLD ? CLSDF_NAME_NON_MANIFOLD : 0u);
        __global const uint* const t = triangles + 3 * (size_t)face;
        joined = join(words + sizes.above, t[0], t[1]) + join(words + sizes.above, t[1], t[2]);
    }
    count_up(joined, &sum, (Atomic)&results->joined_vertices);
    count_up((all_marks & ~CLSDF_EDGE_OPEN) != 0, &sum, (Atomic)&results->irregular_faces);
}

// The enclosed volume. ------------------------------------------------------------------------------------------------

// The sums of encloses_negative_volume(). The faces, in the caller's order, are divided by halves into leaves; a
// work-item has a leaf. sums: a sum and the sum of magnitudes of each of 2^levels leaves, zeros if a larger range is a
// leaf.
__kernel void sum_volumes(TopologySizes sizes, uint levels, __global const double* positions,
                          __global const uint* triangles, __global const TopologyResults* results,
                          __global double* sums) {
    const uint leaf = get_global_id(0);
    if (leaf >= 1u << levels) return;
    double centre[3], half_side = 0.0;
    for (uint axis = 0; axis < 3; ++axis) {
        const double lower = results->box[axis], upper = results->box[3 + axis];
        centre[axis] = 0.5 * lower + 0.5 * upper;
        const double half_of_axis = 0.5 * upper - 0.5 * lower;
        half_side = GREATER(half_of_axis, half_side);
    }
    const double inverse = 1.0 / half_side, scale = half_side > 0.0 ? LESSER(inverse, 1e300) : 0.0;
    uint begin = 0, end = sizes.faces;
    for (uint level = levels; level-- > 0;) {
        const bool is_second = leaf >> level & 1u;
        if (end - begin <= CLSDF_VOLUME_LEAF) {
            if (is_second) end = begin;
            continue;
        }
        const uint middle = begin + (end - begin) / 2;
        if (is_second)
            begin = middle;
        else
            end = middle;
    }
    double sum = 0.0, magnitude = 0.0;
    for (uint face = begin; face < end; ++face) {
        double at[3][3];
        for (uint corner = 0; corner < 3; ++corner) {
            const double3 p = position(positions, triangles[3 * (size_t)face + corner]);
            at[corner][0] = (p.x - centre[0]) * scale;
            at[corner][1] = (p.y - centre[1]) * scale;
            at[corner][2] = (p.z - centre[2]) * scale;
        }
        for (uint i = 0; i < 3; ++i) {
            const uint j = next_of(i), k = previous_of(i);
            const double first = at[1][j] * at[2][k], second = at[1][k] * at[2][j];
            sum += at[0][i] * (first - second);
            magnitude += fabs(at[0][i]) * (fabs(first) + fabs(second));
        }
    }
    sums[2 * (size_t)leaf] = sum;
    sums[2 * (size_t)leaf + 1] = magnitude;
}

// One group.
__kernel GROUP_OF_KERNEL void join_volumes(uint levels, __global double* sums, __global TopologyResults* results) {
    const uint leaves = 1u << levels;
    for (uint apart = 1; apart < leaves; apart *= 2) {
        for (uint leaf = get_local_id(0) * 2 * apart; leaf < leaves; leaf += GROUP * 2 * apart) {
            sums[2 * (size_t)leaf] += sums[2 * (size_t)(leaf + apart)];
            sums[2 * (size_t)leaf + 1] += sums[2 * (size_t)(leaf + apart) + 1];
        }
        barrier(CLK_GLOBAL_MEM_FENCE);
    }
    if (get_local_id(0) != 0) return;
    results->volume[0] = sums[0];
    results->volume[1] = sums[1];
}
