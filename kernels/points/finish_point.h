// The outputs of a point from its nearest face and its sign. The host compiles this file, too, and has the same bytes:
// multiply-adds are not fused, and quotients and roots of doubles are rounded correctly.
#ifndef CLSDF_FINISH_POINT_H
#define CLSDF_FINISH_POINT_H

#pragma OPENCL FP_CONTRACT OFF

#include "finish.h"
#include "point_tree.h"

// The distance of the closest point, which lies on the face or on one of its edges, from the lines of the other edges.
INLINE double distance_to_other_edges(__private const Nearest* nearest) {
    __global const Polyhedron* p = nearest->polyhedron;
    const double2 along = vload2(0, p->exact_normal_along), across = vload2(0, p->exact_normal_across);
    const double2 beyond = DOUBLE2(nearest->foot.x, -nearest->foot.x) - vload2(0, p->exact_base);
    const double2 inward = -(along * beyond + across * nearest->foot.y);  // from the right and the left edge
    const double base = nearest->frame_site == FRAME_BASE ? INFINITY : nearest->foot.y;
    const double right = nearest->frame_site == FRAME_RIGHT_EDGE ? INFINITY : inward.x;
    const double left = nearest->frame_site == FRAME_LEFT_EDGE ? INFINITY : inward.y;
    const double slanted = LESSER(right, left);
    return LESSER(base, slanted);
}

// The sign of a point by its side of the nearest face; CLSDF_POINT_UNDECIDED if it does not follow from that beyond all
// rounding (docs/method.md, 'Sides of faces'). Lengths are in units.
#define SQUARE_OF_LEAST_DISTANCE 1.0e-8
#define SQUARE_OF_MOST_DISTANCE 1.0e8  // farther away, distances are rounded by more than the proof allows
#define LEAST_INSIDE_FACE 1.0e-6       // of the closest point to the face's edges
#define LEAST_INSIDE_EDGE 1.0e-3       // the same on an edge, to the other two
#define LEAST_COSINE 1.0e-3            // between an edge's pseudonormal and the way to the point
#define LEAST_COSINE_AT_VERTEX 0.71    // the same of a vertex
INLINE uint sign_by_sides(__private const Finishing* finishing, __private const Nearest* nearest, uint sides) {
    const double squared = scalar_product(nearest->from, nearest->from);
    if (sides == 0 || squared <= SQUARE_OF_LEAST_DISTANCE || squared > SQUARE_OF_MOST_DISTANCE)
        return CLSDF_POINT_UNDECIDED;
    double outward = nearest->from.z, least = LEAST_COSINE;
    if (nearest->frame_site != CLSDF_SITE_OF_FACE) {
        if (!(sides >> site_of_triangle(nearest->polyhedron, nearest->frame_site) & 1u)) return CLSDF_POINT_UNDECIDED;
        outward = scalar_product(offset_of(nearest), pseudonormal_of(finishing, nearest));
    }
    if (nearest->frame_site < FRAME_BASE) {
        least = LEAST_COSINE_AT_VERTEX;
    } else {
        const bool is_face = nearest->frame_site == CLSDF_SITE_OF_FACE;
        if (!(distance_to_other_edges(nearest) > (is_face ? LEAST_INSIDE_FACE : LEAST_INSIDE_EDGE)))
            return CLSDF_POINT_UNDECIDED;
    }
    if (!(outward * outward > least * least * squared)) return CLSDF_POINT_UNDECIDED;
    return sides & (outward > 0.0 ? CLSDF_SIDES_FRONT_INSIDE : CLSDF_SIDES_BACK_INSIDE) ? CLSDF_POINT_INSIDE
                                                                                        : CLSDF_POINT_OUTSIDE;
}

// Stores the outputs of a point. place: where they go. sign: CLSDF_POINT_UNDECIDED if sides_of_faces decides it, which
// may be null. face: CLSDF_NO_FACE beyond the search's limit. within: in the mesh's units. Returns the sign; a point
// that stays undecided has no outputs.
INLINE uint finish_point(__private const Finishing* finishing, __global float* distance, double3 point, uint face,
                         uint sign, __global const ushort* sides_of_faces, double within, size_t place) {
    const bool is_double = IS_DOUBLE(finishing, distance);
    if (face != CLSDF_NO_FACE) {
        Nearest nearest;
        find_nearest_at(finishing, point, face, false, &nearest);
        if (sides_of_faces != 0) sign = sign_by_sides(finishing, &nearest, sides_of_faces[face]);
        if (sign == CLSDF_POINT_UNDECIDED) return sign;
        const bool is_on_surface = sign == CLSDF_POINT_ON_SURFACE, inside = sign == CLSDF_POINT_INSIDE;
        const double length =
            is_on_surface ? 0.0 : sqrt(scalar_product(nearest.from, nearest.from)) * finishing->how.unit;
        if (length <= within) {
            // Zero is for points on the surface: beside it, rounding may leave nothing of the length.
            if (is_double) {
                const double most = is_on_surface || length > 0.0 ? length : as_double((ulong)1);
                finishing->of_distance[place] = inside ? -most : most;
            } else {
                const float rounded = is_on_surface ? 0.0f : (float)length > 0.0f ? (float)length : as_float(1u);
                distance[place] = inside ? -rounded : rounded;
            }
            nearest.sign = inside ? -1.0 : 1.0;
            if (finishing->how.wanted != 0) store_outputs(finishing, &nearest, place);
            return sign;
        }
    }
    if (sign == CLSDF_POINT_UNDECIDED) return sign;
    const double limit = sign == CLSDF_POINT_INSIDE ? -within : within;
    if (is_double)
        finishing->of_distance[place] = limit;
    else
        distance[place] = (float)limit;
    leave_sample(finishing, place);
    return sign;
}

#pragma OPENCL FP_CONTRACT ON

#endif
