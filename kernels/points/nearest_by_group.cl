// The nearest triangles of points on a GPU, by a search in a binary tree (binary_search.h). The pair of squared
// distance and triangle is that of nearest_of_points (points.cl): the least one of all faces.
//
// list_faces lists the faces that may be the nearest, as floats tell; decide_faces decides among them in double. Points
// with more faces than the list holds are searched again, and decided at once.
//
// A work-item is a point, of [begin, end) in all, and has a stack in local memory. STACK: its entries.

#include "binary_search.h"
#include "nearest_face.h"

#define GROUP 64
#define SEARCHES __attribute__((reqd_work_group_size(GROUP, 1, 1)))

// places: of each point of this launch, entry by entry. counts: faces of each; more than CLSDF_LISTED_FACES if the list
// is not complete. most: a squared distance, possibly infinite, beyond which nothing is looked for. points: in units.
__kernel SEARCHES void list_faces(BinaryTree tree, __global const BinaryNode* nodes, __global const PlacedFace* faces,
                                  __global const double* points, uint begin, uint end, double most,
                                  __global uint* places, __global uint* counts) {
    __local uint stack[STACK * GROUP];
    const uint own = get_global_id(0), i = begin + own;
    if (i >= end) return;
    ListedFaces found;
    found.point = tree_point(vload3(i, points));
    found.faces = faces;
    found.bound = bound_of_squared(most);
    found.low = INFINITY;
    found.count = 0;
    found.places = places + own;
    found.stride = end - begin;
    search_for_list(tree, nodes, stack + get_local_id(0), GROUP, &found);
    counts[own] = found.count;
}

// order: the faces of the places.
__kernel void decide_faces(__global const uint* order, __global const Polyhedron* polyhedra,
                           __global const PointFace* all_faces, __global const double* points, uint begin, uint end,
                           double most, __global const uint* places, __global const uint* counts,
                           __global uint* nearest, __global double* squared) {
    const uint own = get_global_id(0), i = begin + own;
    if (i >= end) return;
    const double3 p = vload3(i, points);
    const uint count = min(counts[own], (uint)CLSDF_LISTED_FACES);
    NearestFace found = none_nearest(most);
    for (uint k = 0; k < count; ++k) {
        const uint place = places[k * (size_t)(end - begin) + own];
        take_if_nearer(polyhedra, all_faces, order[place] & CLSDF_PLACE_FACE, p, &found);
    }
    nearest[i] = lowest_face(all_faces, found.face);
    squared[i] = found.squared;
}

// The data with which a search decides at once, and the nearest face. A leaf's faces are decided when all of them have
// been compared in float: then fewer values are alive.
typedef struct DecidedFaces {
    TreePoint point;
    __global const PlacedFace* faces;
    NearBound bound;
    NearestFace nearest;
    uint waiting;  // faces of this leaf that may be the nearest: a bit for each, by the place modulo CLSDF_LEAF_PLACES
    double3 exact_point;
    __global const uint* order;
    __global const Polyhedron* polyhedra;
    __global const PointFace* all_faces;
} DecidedFaces;

INLINE void let_wait(uint place, PlacedDistance d, __private DecidedFaces* found) {
    found->waiting |= 1u << place % CLSDF_LEAF_PLACES;
}

INLINE void decide_waiting(uint end, __private DecidedFaces* found) {
    for (uint place = end - CLSDF_LEAF_PLACES; found->waiting != 0; ++place) {  // below 0 no bit is set
        const uint bit = 1u << place % CLSDF_LEAF_PLACES;
        if ((found->waiting & bit) == 0) continue;
        found->waiting &= ~bit;
        take_if_nearer(found->polyhedra, found->all_faces, found->order[place] & CLSDF_PLACE_FACE, found->exact_point,
                       &found->nearest);
    }
    found->bound = bound_of_squared(found->nearest.squared);
}

DEFINE_SEARCH(search_and_decide, DecidedFaces, let_wait, decide_waiting)

// The points whose list is not complete. squared: on entry the least one of the list, or the limit of the search.
__kernel SEARCHES void search_again(BinaryTree tree, __global const BinaryNode* nodes, __global const PlacedFace* faces,
                                    __global const uint* order, __global const Polyhedron* polyhedra,
                                    __global const PointFace* all_faces, __global const double* points, uint begin,
                                    uint end, __global const uint* counts, __global uint* nearest,
                                    __global double* squared) {
    __local uint stack[STACK * GROUP];
    const uint own = get_global_id(0), i = begin + own;
    if (i >= end || counts[own] <= CLSDF_LISTED_FACES) return;
    DecidedFaces found;
    found.bound = bound_of_squared(squared[i]);
    found.nearest = none_nearest(squared[i]);
    found.waiting = 0;
    found.exact_point = vload3(i, points);
    found.point = tree_point(found.exact_point);
    found.faces = faces;
    found.order = order;
    found.polyhedra = polyhedra;
    found.all_faces = all_faces;
    search_and_decide(tree, nodes, stack + get_local_id(0), GROUP, &found);
    nearest[i] = lowest_face(all_faces, found.nearest.face);
    squared[i] = found.nearest.squared;
}
