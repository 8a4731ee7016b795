// The boxes of a mesh on a GPU: that of the vertices in use, at the first positions and after they have moved, and
// those of the clusters of faces. A group measures its part; join_group_boxes joins the parts.
#ifndef CLSDF_MESH_BOXES_H
#define CLSDF_MESH_BOXES_H

#include "given_triples.h"
#include "mesh_groups.h"
#include "mesh_topology.h"
#include "simd.h"

#pragma OPENCL FP_CONTRACT OFF

static inline double3 position(__global const double* positions, uint vertex) {
    return vload3(vertex, positions);
}

// As an integer, of which equal numbers have one: -0.0 becomes 0.0. Compilers have taken x + 0.0 for x.
static inline ulong bits_of(double x) {
    const ulong bits = as_ulong(x);
    return bits == 1ul << 63 ? 0 : bits;
}

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
        for (uint i = 0; i < 6; ++i) results->box[i] = as_double(bits_of(box[i]));  // no negative zeros
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

#endif
