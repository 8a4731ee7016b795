// Frames of LANES faces at once, one a lane (the frame is that of polyhedron.h, in double), and records of them.
//
// The host compiles this file with one lane (lib/engine/frusta/one_lane.hpp) and adds special cases. Records have
// the same bytes on every device: quotients and roots of doubles are rounded correctly by all, and nothing is
// contracted.
#ifndef CLSDF_FACE_FRAMES_H
#define CLSDF_FACE_FRAMES_H

#include "face_sources.h"
#include "simd.h"

#include "lane_frames.h"

#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#endif

#define NEXT_OF_THREE(k) ((0x9u >> (2 * (k))) & 3u)
#define PREVIOUS_OF_THREE(k) ((0x12u >> (2 * (k))) & 3u)

// The altitude of a face that is not taken for a sliver, beside its longest side.
#define THIN_FACE 2.0e-4

INLINE Vectors vectors(doubleL x, doubleL y, doubleL z) {
    const Vectors v = {x, y, z};
    return v;
}
INLINE Vectors sum(Vectors a, Vectors b) {
    return vectors(a.x + b.x, a.y + b.y, a.z + b.z);
}
INLINE Vectors difference(Vectors a, Vectors b) {
    return vectors(a.x - b.x, a.y - b.y, a.z - b.z);
}
INLINE Vectors product(doubleL factor, Vectors a) {
    return vectors(factor * a.x, factor * a.y, factor * a.z);
}
// A number that is not negative, with 1 in place of 0: programs may trap divisions by zero.
INLINE doubleL divisor_of(doubleL x) {
    return x > 0.0 ? x : (doubleL)1.0;
}
INLINE Vectors quotient(Vectors a, doubleL divisor) {
    const doubleL d = divisor_of(divisor);
    return vectors(a.x / d, a.y / d, a.z / d);
}
INLINE Vectors cross_product(Vectors a, Vectors b) {
    return vectors(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
INLINE doubleL dot_in_order(Vectors a, Vectors b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
INLINE Vectors chosen(longL condition, Vectors a, Vectors b) {
    return vectors(condition ? a.x : b.x, condition ? a.y : b.y, condition ? a.z : b.z);
}

#ifdef __OPENCL_VERSION__
// The positions of vertices[0, LANES).
INLINE Vectors positions_of(__global const double* positions, __private const uint* vertices) {
#define PLACE(lane) (positions + 3 * (size_t)vertices[lane])
#define X_OF(lane) xy[lane].x
#define Y_OF(lane) xy[lane].y
#define Z_OF(lane) z[lane]
    double2 xy[LANES];
    double z[LANES];
#pragma unroll
    for (uint lane = 0; lane < LANES; ++lane) {
        xy[lane] = vload2(0, PLACE(lane));
        z[lane] = LOAD(double, PLACE(lane) + 2);
    }
    return vectors((doubleL)EACH_LANE(X_OF), (doubleL)EACH_LANE(Y_OF), (doubleL)EACH_LANE(Z_OF));
#undef Z_OF
#undef Y_OF
#undef X_OF
#undef PLACE
}
#endif

// Three values by edge of the face become values by edge of the polyhedron, and the other way round.
INLINE Vectors from_base(BaseEdges base, Vectors first, Vectors second, Vectors third) {
    return chosen(base.is_first, first, chosen(base.is_second, second, third));
}
INLINE doubleL to_own(BaseEdges base, doubleL if_first, doubleL if_second, doubleL if_third) {
    return base.is_first ? if_first : base.is_second ? if_second : if_third;
}

// a, b, c: the corners. The special cases of degenerate faces are the host's.
INLINE FaceFrames frames_of_faces(FaceLattice lattice, Vectors a, Vectors b, Vectors c) {
    const Vectors first = product(lattice.per_unit, difference(b, a)),
                  second = product(lattice.per_unit, difference(c, b)),
                  third = product(lattice.per_unit, difference(a, c));
    const doubleL squared_first = dot_in_order(first, first), squared_second = dot_in_order(second, second),
                  squared_third = dot_in_order(third, third);
    const doubleL longer = squared_first >= squared_second ? squared_first : squared_second;
    const longL is_third = squared_third > longer;
    FaceFrames f;
    f.base_edges.is_first = !is_third && squared_first >= squared_second;
    f.base_edges.is_second = !is_third && !f.base_edges.is_first;
    f.start = from_base(f.base_edges, a, b, c);
    f.end = from_base(f.base_edges, b, c, a);
    f.apex = from_base(f.base_edges, c, a, b);
    f.base = from_base(f.base_edges, first, second, third);
    f.to_apex = from_base(f.base_edges, second, third, first);
    const Vectors from_apex = from_base(f.base_edges, third, first, second);
    const longL is_right = to_own(f.base_edges, squared_second, squared_third, squared_first) <=
                           to_own(f.base_edges, squared_third, squared_first, squared_second);
    f.length = sqrt(to_own(f.base_edges, squared_first, squared_second, squared_third));
    f.along = quotient(f.base, f.length);
    const doubleL right = -dot_in_order(f.to_apex, f.along), left = -dot_in_order(from_apex, f.along);
    f.right = right > 0.0 ? right : 0.0;
    f.left = left > 0.0 ? left : 0.0;

    Vectors across = chosen(is_right, f.to_apex, vectors(-from_apex.x, -from_apex.y, -from_apex.z));
    across = difference(across, product(dot_in_order(across, f.along), f.along));
    across = difference(across, product(dot_in_order(across, f.along), f.along));
    f.height = sqrt(dot_in_order(across, across));
    across = quotient(across, f.height);
    across = difference(across, product(dot_in_order(across, f.along), f.along));
    f.across = quotient(across, sqrt(dot_in_order(across, across)));
    f.normal = cross_product(f.along, f.across);

    const doubleL squared_height = f.height * f.height;
    const doubleL slanted_right = sqrt(f.right * f.right + squared_height),
                  slanted_left = sqrt(f.left * f.left + squared_height);
    const doubleL to_right = divisor_of(slanted_right), to_left = divisor_of(slanted_left);
    f.along_right = f.height / to_right;
    f.along_left = f.height / to_left;
    f.across_right = f.right / to_right;
    f.across_left = f.left / to_left;
    f.altitude = slanted_right * f.along_right;

    const Vectors near_end = chosen(is_right, f.end, f.start);
    const Vectors origin = vectors(lattice.origin[0], lattice.origin[1], lattice.origin[2]);
    const doubleL to_foot = is_right ? f.right : -f.left;
    f.foot = difference(product(lattice.per_unit, difference(near_end, origin)), product(to_foot, f.along));
    return f;
}

// Unit vectors in the faces' planes, perpendicular to their slanted edges.
INLINE Vectors inward_from_right(__private const FaceFrames* f) {
    return difference(product(-f->along_right, f->along), product(f->across_right, f->across));
}
INLINE Vectors inward_from_left(__private const FaceFrames* f) {
    return difference(product(f->along_left, f->along), product(f->across_left, f->across));
}

// By edge of the polyhedra; doubles that are floats.
typedef struct LaneSlopes {
    doubleL above[3], below[3];
} LaneSlopes;

// The 35 doubles of a record, in which pairs of words are one.
#define RECORD_DOUBLES 35
typedef struct LaneRecords {
    doubleL doubles[RECORD_DOUBLES];
} LaneRecords;

INLINE doubleL word_pairs(floatL a, floatL b) {
#if LANES == 1
    return as_double((ulong)as_uint(b) << 32 | as_uint(a));
#else
    return as_double8(
        (float16)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7));
#endif
}

// A number below 2^51, to the nearest integer: the ties go to the even one, as by lrint().
INLINE doubleL rounded(doubleL x) {
    const double shift = 6755399441055744.0;  // 1.5 * 2^52
    return (x + shift) - shift;
}

INLINE doubleL limited(doubleL x, double limit) {
    return LESSER(GREATER(x, -limit), limit);
}

// The samples nearest to the feet. Beyond the limit the offset in the constants does the rest.
INLINE Vectors origins_of(FaceLattice lattice, Vectors foot) {
    const double limit = (double)(1 << 30);
    return vectors(rounded(limited(foot.x / lattice.spacing[0], limit)),
                   rounded(limited(foot.y / lattice.spacing[1], limit)),
                   rounded(limited(foot.z / lattice.spacing[2], limit)));
}

INLINE Vectors feet_from_origins(FaceLattice lattice, Vectors foot, Vectors origin) {
    return vectors(foot.x - origin.x * lattice.spacing[0], foot.y - origin.y * lattice.spacing[1],
                   foot.z - origin.z * lattice.spacing[2]);
}

// origin: of origins_of(); foot: from there. names: see CLSDF_NAME_NON_MANIFOLD.
INLINE LaneRecords records_of(FaceLattice lattice, __private const FaceFrames* f, __private const LaneSlopes* slopes,
                              uintL names, Vectors origin, Vectors foot) {
    LaneRecords r;
    const Vectors spacing = vectors(lattice.spacing[0], lattice.spacing[1], lattice.spacing[2]);
    __private doubleL* const numbers = r.doubles + 16;
    numbers[0] = f->along.x * spacing.x;
    numbers[1] = f->across.x * spacing.x;
    numbers[2] = f->normal.x * spacing.x;
    numbers[3] = f->along.y * spacing.y;
    numbers[4] = f->across.y * spacing.y;
    numbers[5] = f->normal.y * spacing.y;
    numbers[6] = f->along.z * spacing.z;
    numbers[7] = f->across.z * spacing.z;
    numbers[8] = f->normal.z * spacing.z;
    numbers[9] = -dot_in_order(f->along, foot);
    numbers[10] = -dot_in_order(f->across, foot);
    numbers[11] = -dot_in_order(f->normal, foot);
    numbers[12] = f->right;
    numbers[13] = f->left;
    numbers[14] = f->along_right;
    numbers[15] = f->along_left;
    numbers[16] = f->across_right;
    numbers[17] = f->across_left;
    numbers[18] = f->altitude;
#pragma unroll
    for (uint i = 0; i < 9; ++i) r.doubles[i] = word_pairs(TO_FLOATS(numbers[2 * i]), TO_FLOATS(numbers[2 * i + 1]));
    r.doubles[9] = word_pairs(TO_FLOATS(slopes->above[0]), TO_FLOATS(slopes->above[1]));
    r.doubles[10] = word_pairs(TO_FLOATS(slopes->above[2]), TO_FLOATS(slopes->below[0]));
    r.doubles[11] = word_pairs(TO_FLOATS(slopes->below[1]), TO_FLOATS(slopes->below[2]));
    const floatL foot_x = TO_FLOATS(foot.x), foot_y = TO_FLOATS(foot.y), foot_z = TO_FLOATS(foot.z);
    r.doubles[12] = word_pairs(foot_x, foot_y);
    r.doubles[13] = word_pairs(foot_z, AS_FLOATS(TO_INTS(origin.x)));
    r.doubles[14] = word_pairs(AS_FLOATS(TO_INTS(origin.y)), AS_FLOATS(TO_INTS(origin.z)));

    const doubleL steepest =
        GREATER(GREATER(GREATER(slopes->above[0], slopes->above[1]), GREATER(slopes->above[2], slopes->below[0])),
                GREATER(slopes->below[1], slopes->below[2]));
    const floatL farthest = GREATER(GREATER(fabs(foot_x), fabs(foot_y)), fabs(foot_z));
    const doubleL longest = GREATER(GREATER(f->right, f->left), GREATER(f->altitude, TO_DOUBLES(farthest)));
    // Flags as whole numbers, which a double holds.
    const doubleL compact = steepest <= 1.0 ? (doubleL)CLSDF_POLYHEDRON_COMPACT : (doubleL)0.0;
    const doubleL flags = (LESSER(f->along_right, f->along_left) > 0.15 ? compact : (doubleL)0.0) +
                          (longest <= (double)CLSDF_NEAR_LENGTH ? (doubleL)CLSDF_POLYHEDRON_NEAR : (doubleL)0.0) +
                          to_own(f->base_edges, (doubleL)0.0, (doubleL)(1 << CLSDF_POLYHEDRON_VERTEX_SHIFT),
                                 (doubleL)(2 << CLSDF_POLYHEDRON_VERTEX_SHIFT));
    const uintL non_manifold = (names >> 31) * CLSDF_POLYHEDRON_NON_MANIFOLD;
    r.doubles[15] =
        word_pairs(AS_FLOATS(AS_UINTS(TO_INTS(flags)) | non_manifold), AS_FLOATS(names & ~CLSDF_NAME_NON_MANIFOLD));
    return r;
}

#ifdef __OPENCL_VERSION__
// Writes LANES records that follow each other, from a multiple of LANES on: whole cache lines, which the processor need
// not read before.
INLINE void store_records(__private LaneRecords* r, __global Polyhedron* records) {
    __global double* const to = (__global double*)records;
#if LANES == 1
    for (uint i = 0; i < RECORD_DOUBLES; ++i) to[i] = r->doubles[i];
#else
    double8 lines[RECORD_DOUBLES];
    __private double* const doubles = (__private double*)lines;
#pragma unroll
    for (uint part = 0; part < 32; part += 8) {
        transpose_doubles(r->doubles + part);
#pragma unroll
        for (uint lane = 0; lane < LANES; ++lane)
            STORE_DOUBLES(r->doubles[part + lane], __private, doubles + lane * RECORD_DOUBLES + part);
    }
#pragma unroll
    for (uint i = 32; i < RECORD_DOUBLES; ++i) {
        double lanes[LANES];
        STORE_DOUBLES(r->doubles[i], __private, lanes);
#pragma unroll
        for (uint lane = 0; lane < LANES; ++lane) doubles[lane * RECORD_DOUBLES + i] = lanes[lane];
    }
#pragma unroll
    for (uint line = 0; line < RECORD_DOUBLES; ++line) STREAM_DOUBLES(lines[line], to + 8 * line);
#endif
}
#endif

// Slopes of the lateral planes at the edges of LANES faces, from the faces' corners and the vertices opposite to their
// edges (docs/method.md, 'Leaned frusta').
//
// A neighbour's frame is not needed: with w from a point of the edge to the opposite vertex, x = inward . w and
// y = normal . w, the half of the angle by which the wedge between the faces exceeds a straight one has the tangent
// (h + x) / |y| = |y| / (h - x), h the length of (x, y). Each edge is measured by both of its faces; the two results
// may round differently.

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

// If the corner opposite the base is obtuse, its two planes lean outward until each contains the wedge of the other;
// otherwise they would cut it off. No other corner of a triangle is obtuse.
INLINE void lean(__private const FaceFrames* f, __private doubleL* slopes) {
    // Of that corner, negated.
    const doubleL cosine = f->across_right * f->across_left - f->along_right * f->along_left;
    const longL is_obtuse = cosine > 0.0;
    const doubleL from_right = WIDENED(cosine * slopes[CLSDF_EDGE_RIGHT]),
                  from_left = WIDENED(cosine * slopes[CLSDF_EDGE_LEFT]);
    const doubleL right = GREATER(slopes[CLSDF_EDGE_RIGHT], from_left),
                  left = GREATER(slopes[CLSDF_EDGE_LEFT], from_right);
    slopes[CLSDF_EDGE_RIGHT] = is_obtuse ? right : slopes[CLSDF_EDGE_RIGHT];
    slopes[CLSDF_EDGE_LEFT] = is_obtuse ? left : slopes[CLSDF_EDGE_LEFT];
}

#endif
