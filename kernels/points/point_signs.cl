// The signs of points that neither their nearest faces nor the mesh's box tell: whether they lie on the surface, and
// the crossings of a ray along x. The rules are those of the host (lib/points/signs_by_host.cpp). Every decision is
// exact (expansions.h), so the signs are the same; a point whose coordinates are out of range of that stays open.

#include "box_query.h"
#include "point_order.h"
#include "point_source.h"
#include "point_tree.h"
#include "ray_side.h"
#include "simd.h"
#include "solid_angle.h"
#include "tree_walk.h"

#pragma OPENCL FP_CONTRACT OFF

// The faces of the surface. Positions are in units, from the origin of the caller's coordinates.
typedef struct RayFaces {
    uint count;
    __global const uint* order;      // of the binary tree: the face of each place
    __global const uint* triangles;  // numbers of vertices
    __global const double* positions;
    uint are_counted;
    __global const char* counts;  // how often each face counts for the sign, if that is not always once
} RayFaces;

// A point, or the ray from it. `winding` and `crossings`: those of the ray.
typedef struct Ray {
    RayFaces faces;
    double3 from;
    PointBox box;     // around it, in units from the lattice's origin
    bool is_crossed;  // else the faces are looked for that have the point on them
    bool is_forward;  // towards +x
    int winding;
    uint crossings;
    __private uint* stack;  // of the binary walk
} Ray;

INLINE bool is_beyond(double a, double b, double c, double lower, double upper) {
    return (a < lower && b < lower && c < lower) || (a > upper && b > upper && c > upper);
}

// Whether a face has the point on it. If not, its crossing is added.
INLINE bool visit_face(uint face, __private Ray* ray) {
    __private const RayFaces* faces = &ray->faces;
    const double3 p = ray->from;
    const int counts = faces->are_counted && ray->is_crossed ? faces->counts[face] : 1;
    if (counts == 0) return false;
    const double3 a = vload3(faces->triangles[3 * (size_t)face], faces->positions),
                  b = vload3(faces->triangles[3 * (size_t)face + 1], faces->positions),
                  c = vload3(faces->triangles[3 * (size_t)face + 2], faces->positions);
    if (is_beyond(a.y, b.y, c.y, p.y, p.y) || is_beyond(a.z, b.z, c.z, p.z, p.z)) return false;
    const double lower_x = ray->is_crossed && !ray->is_forward ? -INFINITY : p.x,
                 upper_x = ray->is_crossed && ray->is_forward ? INFINITY : p.x;
    if (is_beyond(a.x, b.x, c.x, lower_x, upper_x)) return false;
    if (!ray->is_crossed) return is_on_face(a, b, c, p);
    const int crossing = crossing_of_ray(a, b, c, p, ray->is_forward);
    if (crossing == 0) return false;
    ray->winding += counts * crossing;
    ++ray->crossings;
    return false;
}

// visit_faces() visits the leaves that the ray's box overlaps, until one has the point on a face. GPUs have the binary
// tree, processors the wide one.
#if LANES == 1
typedef BinaryTree SignTree;
typedef BinaryNode SignNode;
#define SIGN_MARGIN CLSDF_BOX_MARGIN

#define BOX_OF_RAY(lower_x, lower_y, lower_z, upper_x, upper_y, upper_z, ray) \
    zero_if_overlapped(lower_x, lower_y, lower_z, upper_x, upper_y, upper_z, (ray)->box)
#define ZERO(ray) 0.0f

INLINE bool visit_leaf(uint place, __private Ray* ray) {
    uint entry;
    do {
        entry = ray->faces.order[place++];
        if (visit_face(entry & CLSDF_PLACE_FACE, ray)) return true;
    } while (entry >> CLSDF_PLACE_SHIFT != 0);
    return false;
}

OUT_OF_LINE DEFINE_BINARY_WALK(walk, Ray, __private, BOX_OF_RAY, ZERO, visit_leaf)

INLINE bool visit_faces(SignTree tree, __global const SignNode* nodes, __private Ray* ray) {
    return walk(tree, nodes, ray->stack, 1, ray);
}
#else
typedef PointTree SignTree;
typedef PointNode SignNode;
#define SIGN_MARGIN 0.0f  // the boxes are wider

#define CHILDREN_OF_RAY(node, level, ray) overlapped_children(node, (ray)->box)
#define LOWEST(bits, level, ray) lowest_bit(bits)

INLINE bool visit_leaf(uint leaf, __private Ray* ray) {
    const uint first = leaf * CLSDF_TREE_WIDTH, end = min(first + CLSDF_TREE_WIDTH, ray->faces.count);
    for (uint face = first; face < end; ++face)
        if (visit_face(face, ray)) return true;
    return false;
}

OUT_OF_LINE DEFINE_WIDE_WALK(visit_faces, Ray, CHILDREN_OF_RAY, LOWEST, visit_leaf)
#endif

// The winding number, rounded to an integer, a half up, less the crossings towards -x. corners: of the loops of
// open edges, in units. begins: of each loop, and the end.
OUT_OF_LINE int rounded_part_of_film(double3 p, uint loops, __global const double* corners,
                                     __global const uint* begins) {
    Turns turns = no_turns();
    for (uint loop = 0; loop < loops; ++loop) {
        const uint begin = begins[loop], end = begins[loop + 1];
        double3 at = vload3(begin, corners);
        const SeenVertex first = seen_vertex(at.x - p.x, at.y - p.y, at.z - p.z, at.y - p.y, at.z - p.z);
        SeenVertex from = first;
        for (uint i = begin; i < end; ++i) {
            const double3 next = vload3(i + 1 < end ? i + 1 : begin, corners);
            const SeenVertex to =
                i + 1 < end ? seen_vertex(next.x - p.x, next.y - p.y, next.z - p.z, next.y - p.y, next.z - p.z) : first;
            const double re = edge_re(from, to), im = edge_im(from, to);
            const int side = re < 0.0 ? (displaced_side(at, next, p) > 0 ? 1 : -1) : 0;
            turns = turned(turns, re, im, side);
            from = to;
            at = next;
        }
    }
    return rounded_turns(turns);
}

// What the walls below the open edges add to the crossings towards -x.
OUT_OF_LINE int crossings_of_walls(double3 p, uint loops, double floor, __global const double* corners,
                                   __global const uint* begins) {
    int winding = 0;
    if (p.z < floor) return 0;
    for (uint loop = 0; loop < loops; ++loop) {
        const uint begin = begins[loop], end = begins[loop + 1];
        const double3 first = vload3(begin, corners);
        double3 from = first;
        for (uint i = begin; i < end; ++i) {
            const double3 to = i + 1 < end ? vload3(i + 1, corners) : first;
            winding += crossing_of_wall(from, to, floor, p);
            from = to;
        }
    }
    return winding;
}

// Sets `at` to the point in units, or to another one that lies on the same side of all faces, edges and lines; false if
// exact arithmetic does not suffice.
//
// Coordinates that are too small for it are multiplied by one power of two. A predicate is f = f0 + n t, where t are
// these coordinates, and f0 and n follow from the others. If the others are 0 or at least 2^-60, and at most 2^40, they
// are multiples of 2^-112, and f0 is 0 or at least 2^-336. With |t| < 2^-424 the second part is less than that: so its
// size does not matter, only its sign, which the factor leaves as it is. The greatest one becomes 2^-511 or more.
INLINE bool find_decidable(double3 p, SignFaces faces, __private double3* at) {
    const double3 units = p * faces.per_unit;  // exact in the range of exact arithmetic
    *at = units;
#define IS_EXACT(axis) (p.axis == 0.0 || (units.axis != 0.0 && is_in_exact_range(units.axis)))
    if (IS_EXACT(x) && IS_EXACT(y) && IS_EXACT(z)) return true;
#undef IS_EXACT
    if (!faces.are_moderate || faces.loops != 0) return false;
    const double coordinates[3] = {units.x, units.y, units.z}, callers[3] = {p.x, p.y, p.z};
    double enlarged[3], least = INFINITY, most = 0.0;  // by 2^500: no bits are lost
    for (int axis = 0; axis < 3; ++axis) {
        const double size = fabs(coordinates[axis]);
        enlarged[axis] = 0.0;
        if (callers[axis] == 0.0 || (size >= 0x1p-60 && size <= 0x1p40)) continue;
        if (!(size < 0x1p-424)) return false;
        enlarged[axis] = callers[axis] * 0x1p500 * faces.per_unit;
        const double enlarged_size = fabs(enlarged[axis]);
        least = LESSER(enlarged_size, least);
        most = GREATER(enlarged_size, most);
    }
    if (most > least * 0x1p90) return false;
    // most 2^exponent is in [2^-511, 2^-510).
    const int exponent = 512 - (int)(as_ulong(most) >> 52);
    const double factor = as_double((ulong)(1023 + exponent) << 52);
    at->x = enlarged[0] != 0.0 ? enlarged[0] * factor : units.x;
    at->y = enlarged[1] != 0.0 ? enlarged[1] * factor : units.y;
    at->z = enlarged[2] != 0.0 ? enlarged[2] * factor : units.z;
    return true;
}

// Open points [begin, end) of a list of cells->open, which is in no order. in_units, places and squared: by the order
// of points. sign_positions: in place of `positions` for crossings. Points that stay open are listed in `left`.
__kernel void decide_open_points(PointSource source, __global const uchar* memory, uint begin, uint end, SignTree tree,
                                 __global const SignNode* nodes, __global const uint* order, SignFaces faces,
                                 __global const uint* triangles, __global const double* positions,
                                 __global const double* sign_positions, __global const char* counts,
                                 __global const double* corners, __global const uint* begins,
                                 __global const double* in_units, __global const uint* places,
                                 __global const double* squared, __global const uint* open,
                                 volatile __global PointCells* cells, __global uchar* signs, __global uint* left) {
    const uint k = begin + (uint)get_global_id(0);
    if (k >= end || k >= cells->open) return;
    const uint i = open[k];
    const double3 p = position_of(source, memory, places[i]);
    Ray ray = {{faces.count, order, triangles, positions, faces.has_counts, counts}};
    if (!find_decidable(p, faces, &ray.from)) {
        left[atomic_inc(&cells->left)] = i;
        return;
    }
#if LANES == 1
    uint stack[CLSDF_DEEPEST_TREE];
    ray.stack = stack;
#endif
    ray.box = box_of_point(vload3(i, in_units), SIGN_MARGIN);
    ray.is_forward = !faces.is_backward && p.x - faces.lower_x > faces.upper_x - p.x;
    if (sqrt(squared[i]) < CLSDF_NEARLY_ON_SURFACE && visit_faces(tree, nodes, &ray)) {
        signs[i] = CLSDF_POINT_ON_SURFACE;
        return;
    }
    signs[i] = CLSDF_POINT_OUTSIDE;
    if (!faces.has_sign) return;
    if (faces.has_sign_positions) ray.faces.positions = sign_positions;
    ray.is_crossed = true;
    if (ray.is_forward)
        ray.box.upper[0] = INFINITY;
    else
        ray.box.lower[0] = -INFINITY;
    visit_faces(tree, nodes, &ray);
    if (faces.has_floor)
        ray.winding += crossings_of_walls(ray.from, faces.loops, faces.floor, corners, begins);
    else if (faces.loops != 0)
        ray.winding += rounded_part_of_film(ray.from, faces.loops, corners, begins);
    if (faces.is_parity ? (ray.crossings & 1u) != 0 : ray.winding != 0) signs[i] = CLSDF_POINT_INSIDE;
}

#if LANES == 1
#include "face_sides.h"
#endif
