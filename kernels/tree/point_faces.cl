// Makes the frames of the faces that points are looked up among from a mesh in memory of a GPU, with the bytes of the
// host (lib/engine/tree/point_mesh.cpp), which does the special cases.

#include "expansions.h"
#include "face_frames.h"
#include "point_faces.h"
#include "point_tree.h"

#pragma OPENCL FP_CONTRACT OFF

// Whether the host takes a frame as it is (lib/engine/frusta/frames.cpp), with room for rounding.
static inline bool is_plain(__private const FaceFrames* f) {
    return f->length > 1.0e-99 && f->height > 0.0 && dot_in_order(f->across, f->across) > 0.75 &&
           fabs(dot_in_order(f->across, f->along)) < 0.5e-12;
}

// The lower, in the caller's order, of a face and of the one across its first edge if they have the same three
// vertices. No edge has three faces.
static inline uint lower_of_two(uint face, __global const uint* order, __global const uint* triangles,
                                __global const uint* edges) {
    const uint mark = edges[4 * (size_t)face + 3] & 0xFFu, across = edges[4 * (size_t)face];
    if (mark & (CLSDF_MARK_OPEN | CLSDF_MARK_AT_BOX)) return face;
    const uint other = across >> 2;
    const bool is_equal =
        triangles[3 * (size_t)other + PREVIOUS_OF_THREE(across & 3u)] == triangles[3 * (size_t)face + 2];
    return is_equal && order[other] < order[face] ? other : face;
}

// The values of a record's frame at the lattice's origin.
static inline PointFace face_of(__global const Polyhedron* p, uint triangle, uint lowest) {
    PointFace face;
    for (int n = 0; n < 3; ++n)
        face.offset[n] = p->exact_constant_at_origin[n] - p->exact_gradient_x[n] * (double)p->origin_x -
                         p->exact_gradient_y[n] * (double)p->origin_y - p->exact_gradient_z[n] * (double)p->origin_z;
    face.triangle = triangle;
    face.lowest = lowest;
    return face;
}

static inline bool is_moderate(double size) {
    return size == 0.0 || (size >= 0x1p-60 && size <= 0x1p40);
}

// Work-item i has face i and vertex i. order: the caller's number of each face. edges: FaceEdges of each face
// (lib/engine/topology/topology.hpp), in words. found: zeros before.
__kernel void make_point_faces(uint face_count, uint vertex_count, FaceLattice lattice, double unit,
                               __global const double* positions, __global const uint* triangles,
                               __global const uint* order, __global const uint* edges, __global Polyhedron* polyhedra,
                               __global PointFace* faces, volatile __global PointFacesFound* found) {
    const uint i = get_global_id(0);
    if (i < vertex_count) {
        const double3 given = vload3(i, positions);
        const double coordinates[3] = {given.x, given.y, given.z};
        bool is_exact = true, are_moderate = true;
        for (int axis = 0; axis < 3; ++axis) {
            const double size = fabs(coordinates[axis] / unit);
            is_exact = is_exact && (coordinates[axis] == 0.0 || (size != 0.0 && is_in_exact_range(size)));
            are_moderate = are_moderate && (coordinates[axis] == 0.0 || (size != 0.0 && is_moderate(size)));
        }
        if (!is_exact) atomic_inc(&found->inexact);
        if (!are_moderate) atomic_inc(&found->immoderate);
    }
    if (i >= face_count) return;
    const uint corners[3] = {triangles[3 * (size_t)i], triangles[3 * (size_t)i + 1], triangles[3 * (size_t)i + 2]};
    const FaceFrames f = frames_of_faces(lattice, positions_of(positions, corners),
                                         positions_of(positions, corners + 1), positions_of(positions, corners + 2));
    if (!is_plain(&f)) atomic_inc(&found->special);
    const LaneSlopes none = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    const Vectors origin = origins_of(lattice, f.foot), foot = feet_from_origins(lattice, f.foot, origin);
    LaneRecords r = records_of(lattice, &f, &none, order[i], origin, foot);
    store_records(&r, polyhedra + i);
    faces[i] = face_of(polyhedra + i, order[i], lower_of_two(i, order, triangles, edges));
}

// The positions of vertices, whose division by a power of two rounds none that is in the range of exact predicates.
__kernel void positions_in_units(uint count, double unit, __global const double* positions, __global double* in_units) {
    const uint i = get_global_id(0);
    if (i < count) vstore3(vload3(i, positions) / unit, i, in_units);
}
