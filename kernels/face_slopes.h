// Slopes of the lateral planes at the edges of LANES faces, from the faces' corners and the vertices opposite to their
// edges (docs/method.md, 'Leaned frusta').
//
// A neighbour's frame is not needed: with w from a point of the edge to the opposite vertex, x = inward . w and
// y = normal . w, the half of the angle by which the wedge between the faces exceeds a straight one has the tangent
// (h + x) / |y| = |y| / (h - x), h the length of (x, y). Each edge is measured by both of its faces; the two results
// may round differently.
#ifndef CLSDF_FACE_SLOPES_H
#define CLSDF_FACE_SLOPES_H

#include "face_frames.h"

// Above the rounding of a determinant of three differences, beside its permanent: ten of 2^-53.
#define SURE_DETERMINANT 1.2e-15
// x as a float that is not below it, also after the roundings that led to it.
#define WIDENED(x) TO_DOUBLES(TO_FLOATS((x) * (1.0 + 1.0e-6)))
// Squares: an opposite vertex that is nearer to its edge, beside its distance from the edge's start, is a sliver's.
#define SLIVER_SQUARED 1.0e-8

// The slopes of one edge; `opposite` lies in the other face, and counts for nothing if the edge is open. Returns
// whether the other face is no sliver.
INLINE longL measure_edge(Vectors start, Vectors opposite, Vectors inward, Vectors normal, Vectors area, Vectors bound,
                          double per_unit, longL is_open, __private doubleL* above, __private doubleL* below,
                          __private doubleL* sign) {
    const Vectors w = product(per_unit, difference(opposite, start));
    const doubleL x = dot_in_order(inward, w), y = fabs(dot_in_order(normal, w));
    const doubleL squared = x * x + y * y, h = sqrt(squared);
    const longL is_sharp = x > 0.0;
    const doubleL exact = (is_sharp ? h + x : y) / (is_sharp ? y : h - x);
    const doubleL wide = WIDENED(exact);
    const double open = (double)CLSDF_OPEN_SLOPE;
    // Faces folded onto each other are open, too: their slope is beyond the greatest.
    const doubleL slope = is_open ? (doubleL)open : wide < open ? wide : (doubleL)open;
    const doubleL determinant = dot_in_order(area, w);
    const doubleL unsure = SURE_DETERMINANT * dot_in_order(bound, vectors(fabs(w.x), fabs(w.y), fabs(w.z)));
    const doubleL greater = slope > 1.0e-37 ? slope : (doubleL)1.0e-37;
    const doubleL by_sign = determinant > unsure ? -greater : determinant < -unsure ? greater : (doubleL)0.0;
    *sign = slope < open ? by_sign : (doubleL)INFINITY;
    // An edge that may be convex or concave is both; a convex one has no slope below the face.
    *above = by_sign < 0.0 && slope < open ? (doubleL)0.0 : slope;
    *below = by_sign > 0.0 && slope < open ? (doubleL)0.0 : slope;
    return is_open || squared > SLIVER_SQUARED * dot_in_order(w, w);
}

// As lean() of lib/polyhedra/slopes.cpp: at an obtuse apex the two planes lean outward.
INLINE void lean(doubleL cosine, __private doubleL* slopes) {
    const longL is_obtuse = cosine > 0.0;
    const doubleL from_right = WIDENED(cosine * slopes[CLSDF_EDGE_RIGHT]),
                  from_left = WIDENED(cosine * slopes[CLSDF_EDGE_LEFT]);
    const doubleL right = GREATER(slopes[CLSDF_EDGE_RIGHT], from_left),
                  left = GREATER(slopes[CLSDF_EDGE_LEFT], from_right);
    slopes[CLSDF_EDGE_RIGHT] = is_obtuse ? right : slopes[CLSDF_EDGE_RIGHT];
    slopes[CLSDF_EDGE_LEFT] = is_obtuse ? left : slopes[CLSDF_EDGE_LEFT];
}

#endif
