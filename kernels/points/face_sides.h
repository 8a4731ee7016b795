// The sides of faces (lib/points/face_sides.cpp, docs/method.md) by a GPU, for a mesh each of whose edges has one face,
// or two of one orientation, and which decides the sign itself. Lengths are in units. A result may differ from the
// host's if rounding decides about a limit; the proof holds for both.
//
// Faces that are found not to have known sides are marked in `met`. Roots are found as the parts of a mesh
// (kernels/topology/joined_vertices.h).
#ifndef CLSDF_FACE_SIDES_H
#define CLSDF_FACE_SIDES_H

#define GROUP 64
#include "face_edges.h"
#include "joined_vertices.h"
#include "side_shapes.h"

typedef struct SideCorners {
    double3 at[3];
} SideCorners;

INLINE double3 side_corner(PointUnits units, __global const double* positions, uint vertex) {
    const double3 p = vload3(vertex, positions);
    return (double3)((p.x - units.origin[0]) / units.unit, (p.y - units.origin[1]) / units.unit,
                     (p.z - units.origin[2]) / units.unit);
}

INLINE SideCorners side_corners(PointUnits units, __global const double* positions, __global const uint* triangles,
                                uint face) {
    SideCorners corners;
    for (uint k = 0; k < 3; ++k) corners.at[k] = side_corner(units, positions, triangles[3 * (size_t)face + k]);
    return corners;
}

INLINE uint after(uint k) {
    return k == 2 ? 0 : k + 1;
}
INLINE uint before(uint k) {
    return k == 0 ? 2 : k - 1;
}

INLINE double3 of_length_one(double3 v) {
    const double length = sqrt(dot(v, v));
    return length > 0.0 ? v / length : v;
}

INLINE float side_float_below(double x) {
    const float rounded = (float)x;
    return rounded - fabs(rounded) * 0x1.0p-23f;
}

// starts: of the corners at each vertex, and the end.
__kernel void side_shapes(uint count, PointUnits units, __global const double* positions,
                          __global const uint* triangles, __global const uint* starts, __global SideShape* shapes) {
    const uint face = get_global_id(0);
    if (face >= count) return;
    const SideCorners f = side_corners(units, positions, triangles, face);
    const double3 ab = f.at[1] - f.at[0], bc = f.at[2] - f.at[1], ca = f.at[0] - f.at[2];
    const double3 product = cross(ab, f.at[2] - f.at[0]);
    const double length = sqrt(dot(product, product)), of_ab = dot(ab, ab), of_bc = dot(bc, bc), of_ca = dot(ca, ca);
    const double two = GREATER(of_ab, of_bc), longest = sqrt(GREATER(two, of_ca));
    SideShape shape;
    shape.altitude = length > 0.0 ? length / longest : 0.0;
    const double3 normal = length > 0.0 ? product / length : (double3)(0.0, 0.0, 0.0);
    vstore3(normal, 0, shape.normal);
    const double x[3][3] = {
        {f.at[0].x, f.at[1].x, f.at[2].x}, {f.at[0].y, f.at[1].y, f.at[2].y}, {f.at[0].z, f.at[1].z, f.at[2].z}};
    for (uint axis = 0; axis < 3; ++axis) {
        const double least = LESSER(x[axis][0], x[axis][1]), most = GREATER(x[axis][0], x[axis][1]);
        shape.lower[axis] = side_float_below(LESSER(least, x[axis][2]) - LEAST_SIDE_GAP);
        shape.upper[axis] = -side_float_below(-(GREATER(most, x[axis][2]) + LEAST_SIDE_GAP));
    }
    const double by_sine = LEAST_SIDE_SINE * longest;
    bool is_excluded = !(shape.altitude > GREATER(by_sine, LEAST_SIDE_ALTITUDE));
    for (uint k = 0; k < 3; ++k) {
        const uint vertex = triangles[3 * (size_t)face + k];
        is_excluded = is_excluded || starts[vertex + 1] - starts[vertex] > MOST_SIDES_IN_FAN;
    }
    shape.is_excluded = is_excluded;
    shape.root = face;
    shapes[face] = shape;
}

// Pairs of faces. -----------------------------------------------------------------------------------------------------

// Whether a plane separates all corners of one face by more than the gap from those of the other one.
INLINE bool separates(double3 axis, SideCorners f, SideCorners g) {
    double least = INFINITY, most = -INFINITY, least_other = INFINITY, most_other = -INFINITY;
    for (uint k = 0; k < 3; ++k) {
        const double at = dot(axis, f.at[k]), other = dot(axis, g.at[k]);
        least = LESSER(at, least);
        most = GREATER(at, most);
        least_other = LESSER(other, least_other);
        most_other = GREATER(other, most_other);
    }
    const double one = least - most_other, two = least_other - most;
    return GREATER(one, two) > LEAST_SIDE_GAP * sqrt(dot(axis, axis));
}

OUT_OF_LINE bool are_apart(SideCorners f, double3 of_f, SideCorners g, double3 of_g) {
    if (separates(of_f, f, g) || separates(of_g, f, g)) return true;
    for (uint i = 0; i < 3; ++i)
        for (uint j = 0; j < 3; ++j) {
            const double3 axis = cross(f.at[after(i)] - f.at[i], g.at[after(j)] - g.at[j]);
            if (dot(axis, axis) > 1e-20 && separates(axis, f, g)) return true;
        }
    return false;
}

// Whether a plane through the common vertex with this normal separates the angles of two faces there.
INLINE bool divides(double3 axis, double3 first_of_f, double3 second_of_f, double3 first_of_g, double3 second_of_g) {
    const double least = LEAST_SIDE_ANGLE * sqrt(dot(axis, axis));
    return dot(first_of_f, axis) > least && dot(second_of_f, axis) > least && -dot(first_of_g, axis) > least &&
           -dot(second_of_g, axis) > least;
}

// The faces have their i-th and j-th vertex in common.
OUT_OF_LINE bool spread_apart(SideCorners f, uint i, SideCorners g, uint j) {
    const double3 of_f[2] = {of_length_one(f.at[after(i)] - f.at[i]), of_length_one(f.at[before(i)] - f.at[i])},
                  of_g[2] = {of_length_one(g.at[after(j)] - g.at[j]), of_length_one(g.at[before(j)] - g.at[j])};
    const double3 middle = of_length_one(of_f[0] + of_f[1]) - of_length_one(of_g[0] + of_g[1]);
    if (divides(middle, of_f[0], of_f[1], of_g[0], of_g[1])) return true;
    for (uint m = 0; m < 2; ++m)
        for (uint n = 0; n < 2; ++n) {
            const double3 axis = of_f[m] - of_g[n];
            if (divides(axis, of_f[0], of_f[1], of_g[0], of_g[1]) ||
                divides(middle + axis, of_f[0], of_f[1], of_g[0], of_g[1]))
                return true;
        }
    return false;
}

// Across the edge from `edge` on, a unit vector, the direction to a point.
INLINE double3 away_from_edge(double3 start, double3 edge, double3 p) {
    const double3 from = p - start;
    return of_length_one(from - edge * dot(edge, from));
}

// The common edge begins at vertex i of one; `apex` is the vertex of the other one that is not on it.
INLINE bool is_folded(SideCorners f, uint i, SideCorners g, uint apex) {
    const double3 edge = of_length_one(f.at[after(i)] - f.at[i]);
    return dot(away_from_edge(f.at[i], edge, f.at[before(i)]), away_from_edge(f.at[i], edge, g.at[apex])) >
           1.0 - LEAST_SIDE_ANGLE * LEAST_SIDE_ANGLE / 2.0;
}

// A face, and what others are found by.
typedef struct SidePairs {
    uint face;
    SideCorners corners;
    PointBox box;
    PointUnits units;
    __global const uint* order;
    __global const double* positions;
    __global const uint* triangles;
    __global const SideShape* shapes;
    volatile __global uint* met;
} SidePairs;

// Whether the two come together in common vertices alone.
INLINE bool is_harmless(__private const SidePairs* pairs, uint other) {
    __global const SideShape *f = pairs->shapes + pairs->face, *g = pairs->shapes + other;
    if (!(f->altitude > LEAST_SIDE_ALTITUDE) || !(g->altitude > LEAST_SIDE_ALTITUDE)) return false;
    uint of_f[3] = {0, 0, 0}, of_g[3] = {0, 0, 0}, common = 0;
    for (uint i = 0; i < 3; ++i)
        for (uint j = 0; j < 3; ++j)
            if (pairs->triangles[3 * (size_t)pairs->face + i] == pairs->triangles[3 * (size_t)other + j] &&
                common < 3) {
                of_f[common] = i;
                of_g[common++] = j;
            }
    if (common > 2) return false;
    const SideCorners corners = side_corners(pairs->units, pairs->positions, pairs->triangles, other);
    if (common == 0) return are_apart(pairs->corners, vload3(0, f->normal), corners, vload3(0, g->normal));
    if (common == 1) return spread_apart(pairs->corners, of_f[0], corners, of_g[0]);
    const uint first = after(of_f[0]) == of_f[1] ? of_f[0] : of_f[1];
    return !is_folded(pairs->corners, first, corners, 3 - of_g[0] - of_g[1]);
}

INLINE bool visit_leaf_of_pairs(uint place, __private SidePairs* pairs) {
    uint entry;
    do {
        entry = pairs->order[place++];
        const uint other = entry & CLSDF_PLACE_FACE;
        __global const SideShape* g = pairs->shapes + other;
        const bool is_once = other > pairs->face || (other != pairs->face && g->is_excluded != 0);
        if (is_once &&
            zero_if_overlapped(g->lower[0], g->lower[1], g->lower[2], g->upper[0], g->upper[1], g->upper[2],
                               pairs->box) == 0.0f &&
            !is_harmless(pairs, other)) {
            atomic_or(pairs->met + pairs->face, 1u);
            atomic_or(pairs->met + other, 1u);
        }
    } while (entry >> CLSDF_PLACE_SHIFT != 0);
    return false;
}

OUT_OF_LINE DEFINE_BINARY_WALK(walk_pairs, SidePairs, __private, BOX_OF_RAY, ZERO, visit_leaf_of_pairs)

// Faces [begin, end), against all. met: zeros before.
__kernel void compare_faces(uint begin, uint end, PointUnits units, SignTree tree, __global const SignNode* nodes,
                            __global const uint* order, __global const double* positions,
                            __global const uint* triangles, __global const SideShape* shapes,
                            volatile __global uint* met) {
    const uint face = begin + (uint)get_global_id(0);
    if (face >= end || shapes[face].is_excluded) return;
    SidePairs pairs;
    pairs.face = face;
    pairs.corners = side_corners(units, positions, triangles, face);
    for (uint axis = 0; axis < 3; ++axis) {
        pairs.box.lower[axis] = shapes[face].lower[axis];
        pairs.box.upper[axis] = shapes[face].upper[axis];
    }
    pairs.units = units;
    pairs.order = order;
    pairs.positions = positions;
    pairs.triangles = triangles;
    pairs.shapes = shapes;
    pairs.met = met;
    uint stack[CLSDF_DEEPEST_TREE];
    walk_pairs(tree, nodes, stack, 1, &pairs);
}

// Roots. --------------------------------------------------------------------------------------------------------------

INLINE bool has_sides(__global const SideShape* shapes, __global const uint* met, uint face) {
    return shapes[face].is_excluded == 0 && met[face] == 0;
}

// The mark of an edge of a face, and the face across it if that is 0. edges: FaceEdges, in words.
INLINE uint mark_of_edge(__global const uint* edges, uint face, uint k) {
    return edges[4 * (size_t)face + 3] >> (8 * k) & 0xFFu;
}

// Joins faces whose fronts are one place. above: zeros before.
__kernel void join_fronts(uint count, __global const uint* edges, __global const SideShape* shapes,
                          __global const uint* met, Atomic above) {
    const uint face = get_global_id(0);
    if (face >= count || !has_sides(shapes, met, face)) return;
    for (uint k = 0; k < 3; ++k) {
        const uint other = edges[4 * (size_t)face + k] >> 2;
        if (mark_of_edge(edges, face, k) == 0 && other < face && has_sides(shapes, met, other))
            join(above, face, other);
    }
}

// The greatest altitude of each root's faces, rounded to a float, as bits. best: zeros before.
__kernel void find_best_fronts(uint count, __global SideShape* shapes, __global const uint* met, Atomic above,
                               volatile __global uint* best) {
    const uint face = get_global_id(0);
    if (face >= count || !has_sides(shapes, met, face)) return;
    const uint root = root_of(above, face);
    shapes[face].root = root;
    atomic_max(best + root, as_uint((float)shapes[face].altitude));
}

// The first face that has it; ~ of its number. chosen: zeros before.
__kernel void choose_fronts(uint count, __global const SideShape* shapes, __global const uint* met,
                            __global const uint* best, volatile __global uint* chosen) {
    const uint face = get_global_id(0);
    if (face >= count || !has_sides(shapes, met, face)) return;
    const uint root = shapes[face].root;
    if (as_uint((float)shapes[face].altitude) == best[root]) atomic_max(chosen + root, ~face);
}

// CLSDF_SIDES_KNOWN and which sides are inside, of each root; or nothing. in_units: positions from the origin of the
// caller's coordinates.
__kernel void cross_fronts(uint begin, uint end, PointUnits units, SignTree tree, __global const SignNode* nodes,
                           __global const uint* order, SignFaces faces, __global const double* positions,
                           __global const double* in_units, __global const uint* triangles,
                           __global const SideShape* shapes, __global const uint* chosen, __global uint* sides) {
    const uint root = begin + (uint)get_global_id(0);
    if (root >= end) return;
    sides[root] = 0;
    if (chosen[root] == 0) return;
    const uint face = ~chosen[root];
    if (!(shapes[face].altitude > LEAST_ALTITUDE_IN_FRONT)) return;
    const SideCorners f = side_corners(units, positions, triangles, face);
    const double3 aim = (f.at[0] + f.at[1] + f.at[2]) / 3.0 + OFFSET_IN_FRONT * vload3(0, shapes[face].normal);
    const double3 origin = (double3)(units.origin[0], units.origin[1], units.origin[2]), p = origin + aim * units.unit,
                  from_origin = (p - origin) / units.unit, off = from_origin - aim;
    // Coordinates far from zero are too coarse.
    if (!(sqrt(dot(off, off)) < 0.5 * OFFSET_IN_FRONT)) return;
    Ray ray = {{faces.count, order, triangles, in_units, 0, 0}};
    if (!find_decidable(p, faces, &ray.from)) return;
    uint stack[CLSDF_DEEPEST_TREE];
    ray.stack = stack;
    ray.box = box_of_point(from_origin, SIGN_MARGIN);
    ray.is_crossed = true;
    ray.is_forward = p.x - faces.lower_x > faces.upper_x - p.x;
    if (ray.is_forward)
        ray.box.upper[0] = INFINITY;
    else
        ray.box.lower[0] = -INFINITY;
    visit_faces(tree, nodes, &ray);
    const bool is_front = faces.is_parity ? (ray.crossings & 1u) != 0 : ray.winding != 0,
               is_back = faces.is_parity ? (ray.crossings & 1u) == 0 : ray.winding + 1 != 0;
    sides[root] =
        CLSDF_SIDES_KNOWN | (is_front ? CLSDF_SIDES_FRONT_INSIDE : 0) | (is_back ? CLSDF_SIDES_BACK_INSIDE : 0);
}

// Sites. --------------------------------------------------------------------------------------------------------------

// The pseudonormals of vertices that tell the side: their faces go once around them, have one root, and are flat
// enough. Zeros for the others.
__kernel void tell_by_vertices(uint count, PointUnits units, __global const double* positions,
                               __global const uint* triangles, __global const uint* starts,
                               __global const uint* corners, __global const uint* edges,
                               __global const SideShape* shapes, __global const uint* met,
                               __global float* of_vertices) {
    const uint vertex = get_global_id(0);
    if (vertex >= count) return;
    vstore3((float3)(0.0f, 0.0f, 0.0f), vertex, of_vertices);
    const uint begin = starts[vertex], end = starts[vertex + 1];
    if (begin == end || end - begin > MOST_SIDES_IN_FAN) return;
    const uint first = corners[begin];
    bool is_closed = false;
    double3 sum = (double3)(0.0, 0.0, 0.0);
    uint corner = first;
    for (uint i = begin; i < end && !is_closed; ++i) {
        const uint face = corner >> 2, k = corner & 3u;
        if (!has_sides(shapes, met, face) || shapes[face].root != shapes[first >> 2].root) return;
        const SideCorners f = side_corners(units, positions, triangles, face);
        const double3 one = f.at[after(k)] - f.at[k], other = f.at[before(k)] - f.at[k], product = cross(one, other);
        sum += atan2(sqrt(dot(product, product)), dot(one, other)) * vload3(0, shapes[face].normal);
        const uint arriving = before(k);
        if (mark_of_edge(edges, face, arriving) != 0) return;
        corner = edges[4 * (size_t)face + arriving];
        if (corner >> 2 != first >> 2) continue;
        if (i + 1 != end) return;
        is_closed = true;
    }
    const double length = sqrt(dot(sum, sum));
    if (!is_closed || !(length > 0.0)) return;
    for (uint i = begin; i < end; ++i)
        if (!(dot(vload3(0, shapes[corners[i] >> 2].normal), sum) > LEAST_COSINE_OF_VERTEX * length)) return;
    const double3 unit = sum / length;
    vstore3((float3)((float)unit.x, (float)unit.y, (float)unit.z), vertex, of_vertices);
}

// order: the caller's number of each face. normals: of the sites that tell the side, as make_pseudonormals()
// (lib/engine/finish/sites.hpp).
__kernel void write_sides(uint count, __global const uint* order, __global const uint* triangles,
                          __global const uint* edges, __global const SideShape* shapes, __global const uint* met,
                          __global const uint* of_roots, __global const float* of_vertices, __global ushort* sides,
                          __global float* normals) {
    const uint face = get_global_id(0);
    if (face >= count) return;
    uint own = has_sides(shapes, met, face) ? of_roots[shapes[face].root] : 0u;
    for (uint k = 0; k < 3 && own != 0; ++k) {
        const uint other = edges[4 * (size_t)face + k] >> 2, site = 6 * order[face] + k;
        if (mark_of_edge(edges, face, k) == 0 && other != face && has_sides(shapes, met, other) &&
            shapes[other].root == shapes[face].root) {
            const double3 unit = of_length_one(vload3(0, shapes[face].normal) + vload3(0, shapes[other].normal));
            vstore3((float3)((float)unit.x, (float)unit.y, (float)unit.z), site + 3, normals);
            own |= 1u << (3 + k);
        }
        const float3 of_vertex = vload3(triangles[3 * (size_t)face + k], of_vertices);
        if (of_vertex.x == 0.0f && of_vertex.y == 0.0f && of_vertex.z == 0.0f) continue;
        vstore3(of_vertex, site, normals);
        own |= 1u << k;
    }
    sides[face] = (ushort)own;
}

#endif
