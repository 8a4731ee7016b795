// Points anywhere: the nearest triangle of each by a search in a tree, and the outputs. The host computes few points by
// the same functions (lib/points/few_points.cpp). GPUs have another search (nearest_by_group.cl).

#define REAL double
#define TRUTH long

#include "finish_point.h"

#if LANES != 1
#include "point_search.h"

// A work-item takes `run` points that follow each other, and begins each search with the face of the one before.
// most: a squared distance, possibly infinite, beyond which nothing is looked for. points: in units.
__kernel void nearest_of_points(PointTree tree, __global const PointNode* nodes, __global const PointLeaf* leaves,
                                __global const Polyhedron* polyhedra, __global const PointFace* all_faces,
                                __global const double* points, uint begin, uint end, uint run, double most,
                                __global uint* faces, __global double* squared) {
    const PointMesh mesh = {nodes, leaves, polyhedra, all_faces};
    const uint first = begin + (uint)get_global_id(0) * run;
    const uint last = first < end ? min(end, first + run) : first;
    uint face = CLSDF_NO_FACE;
    for (uint i = first; i < last; ++i) {
        const NearestFace found = nearest_face(tree, mesh, vload3(i, points), most, face);
        faces[i] = lowest_face(all_faces, found.face);
        squared[i] = found.squared;
        if (found.face != CLSDF_NO_FACE) face = found.face;
    }
}
#endif

// The outputs of a point, a work-item each. places: where each point's results go. within: in the mesh's units. signs:
// of points that are not finished. by_sides: no sign is known, and the side of the nearest face decides it. Points that
// it does not decide stay undecided, for another launch.
__kernel void finish_points(__global const double* points, __global const uint* places, __global const uint* faces,
                            __global const ushort* sides_of_faces, uint by_sides, __global uchar* signs, uint begin,
                            uint end, double within, __global const Polyhedron* polyhedra, __global float* distance,
                            FINISHING_PARAMETERS) {
    const uint i = begin + (uint)get_global_id(0);
    if (i >= end) return;
    uint sign = by_sides ? CLSDF_POINT_UNDECIDED : signs[i];
    if (sign == CLSDF_POINT_FINISHED) return;
    SET_FINISHING(finishing)
    const uint place = places[i], face = faces[i], later = faces[min(i + 8u, end - 1u)];
    if (later != CLSDF_NO_FACE) {
        prefetch_line_to_l1(&polyhedra[later].exact_gradient_x);
        prefetch_line_to_l1(&polyhedra[later].exact_gradient_z[2]);
        prefetch_line_to_l1(&polyhedra[later].exact_altitude);
    }
    sign =
        finish_point(&finishing, distance, vload3(i, points), face, sign, by_sides ? sides_of_faces : 0, within, place);
    if (by_sides) signs[i] = sign == CLSDF_POINT_UNDECIDED ? CLSDF_POINT_UNDECIDED : CLSDF_POINT_FINISHED;
}
