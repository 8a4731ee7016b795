// How a segment, or a ray, crosses a face, exact for coordinates in the range of expansions.h.
//
// A segment is looked at eight times, moved as a whole by (+-e, +-e^2, +-e^3), e positive and arbitrarily small: then
// no predicate is 0, and what is crossed follows from signs of determinants. Look k moves by -e along x if bit 0 of k
// is set, along y for bit 1, along z for bit 2. Sets of looks are the bits of a mask. docs/method.md says why a segment
// between points of different sides then crosses the surface in every look.
#ifndef CLSDF_SEGMENT_CROSSINGS_H
#define CLSDF_SEGMENT_CROSSINGS_H

#include "expansions.h"

#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#endif

#define CLSDF_ALL_LOOKS 0xffu

// From `from` to `from` + `along`, or without an end. For a segment `along` is the exact difference of its ends.
typedef struct Segment {
    double3 from, to;  // `to`: of a segment
    ExactVector along;
    bool is_ray;
} Segment;

static inline Segment segment_between(double3 from, double3 to) {
    Segment segment;
    segment.from = from;
    segment.to = to;
    segment.along = exact_difference(to, from);
    segment.is_ray = false;
    return segment;
}

static inline Segment ray_from(double3 from, double3 direction) {
    Segment segment;
    segment.from = from;
    segment.to = from;
    segment.along.x.high = direction.x;
    segment.along.y.high = direction.y;
    segment.along.z.high = direction.z;
    segment.along.x.low = segment.along.y.low = segment.along.z.low = 0.0;
    segment.is_ray = true;
    return segment;
}

// looks: those in which the face is crossed; 0: none. side: 1 if the segment comes from the face's front, -1 from its
// back; the same in all of these looks.
typedef struct FaceCrossing {
    uint looks;
    int side;
} FaceCrossing;

// Whether all components are exact in one double each, and whole multiples of one power of two below 2^16 times it:
// then plain determinants of them are exact. Meshes whose vertices lie on a lattice have such differences where
// predicates are 0.
static inline bool are_coarse(ExactVector u, ExactVector v, ExactVector w) {
    const TwoDoubles all[9] = {u.x, u.y, u.z, v.x, v.y, v.z, w.x, w.y, w.z};
    double most = 0.0;
    for (uint i = 0; i < 9; ++i) {
        const double size = fabs(all[i].high);
        if (all[i].low != 0.0) return false;
        most = size > most ? size : most;
    }
    // Added, it rounds to multiples of 2^-15 times the power of two not above `most`, or of twice that.
    const double rounding = 0x1.8p37 * most;
    for (uint i = 0; i < 9; ++i)
        if ((all[i].high + rounding) - rounding != all[i].high) return false;
    return true;
}

static inline double plain_determinant(ExactVector u, ExactVector v, ExactVector w, __private double* size) {
    const double first_x = u.y.high * v.z.high, second_x = u.z.high * v.y.high, first_y = u.z.high * v.x.high,
                 second_y = u.x.high * v.z.high, first_z = u.x.high * v.y.high, second_z = u.y.high * v.x.high;
    *size = (fabs(first_x) + fabs(second_x)) * fabs(w.x.high) + (fabs(first_y) + fabs(second_y)) * fabs(w.y.high) +
            (fabs(first_z) + fabs(second_z)) * fabs(w.z.high);
    return (first_x - second_x) * w.x.high + (first_y - second_y) * w.y.high + (first_z - second_z) * w.z.high;
}

static inline int sign_of_determinant(ExactVector u, ExactVector v, ExactVector w) {
    double size;
    const double determinant = plain_determinant(u, v, w, &size);
    const double rounding = 0x1p-50 * size;  // as in orientation_in_space()
    if (determinant > rounding) return 1;
    if (determinant < -rounding) return -1;
    if (size == 0.0) return 0;
    if (are_coarse(u, v, w)) return determinant > 0.0 ? 1 : determinant < 0.0 ? -1 : 0;
    return exact_sign_of_determinant(u, v, w);
}

RARELY_CALLED int exact_sign_of_cross(TwoDoubles ax, TwoDoubles ay, TwoDoubles bx, TwoDoubles by) {
    const TwoDoubles one = {1.0, 0.0};
    Expansion sum;
    sum.count = 0;
    add_product(&sum, ax, by, one);
    add_product(&sum, negative(ay), bx, one);
    return sign_of(&sum);
}

// The sign of ax by - ay bx.
static inline int sign_of_cross(TwoDoubles ax, TwoDoubles ay, TwoDoubles bx, TwoDoubles by) {
    const double first = ax.high * by.high, second = ay.high * bx.high;
    const double cross = first - second, size = fabs(first) + fabs(second), rounding = 0x1p-51 * size;
    if (cross > rounding) return 1;
    if (cross < -rounding) return -1;
    return size == 0.0 ? 0 : exact_sign_of_cross(ax, ay, bx, by);
}

// The looks whose move m has (u x v) m > 0, for u and v that are not parallel; none otherwise.
static inline uint looks_in_front(ExactVector u, ExactVector v) {
    int sign = sign_of_cross(u.y, u.z, v.y, v.z);
    uint backward = 0xaau;  // looks that move by -e along x
    if (sign == 0) {
        sign = sign_of_cross(u.z, u.x, v.z, v.x);
        backward = 0xccu;
    }
    if (sign == 0) {
        sign = sign_of_cross(u.x, u.y, v.x, v.y);
        backward = 0xf0u;
    }
    if (sign == 0) return 0u;
    return sign > 0 ? CLSDF_ALL_LOOKS & ~backward : backward;
}

// The looks in which a predicate is positive: of a sign that is not 0 all or none, of 0 those whose move decides so.
static inline uint positive_looks(int sign, ExactVector u, ExactVector v) {
    return sign > 0 ? CLSDF_ALL_LOOKS : sign < 0 ? 0u : looks_in_front(u, v);
}

// The face a, b, c; its front is the side from which they run counterclockwise.
static inline FaceCrossing crossing_of(double3 a, double3 b, double3 c, Segment segment) {
    FaceCrossing none, crossing;
    none.looks = 0;
    none.side = 0;
    const ExactVector ab = exact_difference(b, a), ac = exact_difference(c, a), pa = exact_difference(a, segment.from);
    // The side of the begin is that of -pa.
    const int before = -sign_of_determinant(ab, ac, pa);
    int behind = 0;
    if (segment.is_ray) {
        behind = sign_of_determinant(ab, ac, segment.along);  // infinitely far away
        if (behind == 0) return none;
    } else {
        behind = sign_of_determinant(ab, ac, exact_difference(segment.to, a));
    }
    // Both 0: the segment is parallel to the face, or the face has no area.
    if (before == behind) return none;
    const uint crossed = positive_looks(before, ab, ac) ^ positive_looks(behind, ab, ac);
    if (crossed == 0) return none;

    const ExactVector pb = exact_difference(b, segment.from), pc = exact_difference(c, segment.from);
    const int of_first = sign_of_determinant(segment.along, pa, pb),
              of_second = sign_of_determinant(segment.along, pb, pc);
    if (of_first * of_second < 0) return none;
    const int of_third = sign_of_determinant(segment.along, pc, pa);
    if (of_first * of_third < 0 || of_second * of_third < 0) return none;
    const uint first = positive_looks(of_first, segment.along, ab),
               second = positive_looks(of_second, segment.along, exact_difference(c, b)),
               third = positive_looks(of_third, segment.along, exact_difference(a, c));
    crossing.looks = crossed & ((first & second & third) | ~(first | second | third));
    crossing.side = before != 0 ? before : -behind;
    return crossing;
}

static inline TwoDoubles sum_of(TwoDoubles a, TwoDoubles b) {
    const TwoDoubles high = exact_sum(a.high, b.high), low = exact_sum(a.low, b.low);
    const TwoDoubles middle = exact_sum(high.high, high.low + low.high);
    return exact_sum(middle.high, middle.low + low.low);
}

static inline TwoDoubles product_of(TwoDoubles a, TwoDoubles b) {
    const TwoDoubles product = exact_product(a.high, b.high);
    return exact_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

RARELY_CALLED TwoDoubles rounded_determinant(ExactVector u, ExactVector v, ExactVector w) {
    Expansion sum;
    sum.count = 0;
    add_determinant(&sum, u, v, w);
    close_gaps(&sum);
    const uint count = sum.count;
    TwoDoubles rounded = {0.0, 0.0};
    if (count > 0) rounded.high = sum.doubles[count - 1];
    if (count > 1) rounded.low = sum.doubles[count - 2];
    return rounded;
}

// To 2^-59 of itself.
static inline TwoDoubles determinant_of(ExactVector u, ExactVector v, ExactVector w) {
    double size;
    plain_determinant(u, v, w, &size);
    const TwoDoubles x = sum_of(product_of(u.y, v.z), negative(product_of(u.z, v.y))),
                     y = sum_of(product_of(u.z, v.x), negative(product_of(u.x, v.z))),
                     z = sum_of(product_of(u.x, v.y), negative(product_of(u.y, v.x)));
    const TwoDoubles determinant = sum_of(sum_of(product_of(x, w.x), product_of(y, w.y)), product_of(z, w.z));
    // Its error is below 2^-100 of `size`.
    if (fabs(determinant.high) >= 0x1p-40 * size) return determinant;
    return rounded_determinant(u, v, w);
}

static inline double rounded_quotient(TwoDoubles n, TwoDoubles d) {
    const double first = n.high / d.high;
    TwoDoubles quotient = {first, 0.0};
    const TwoDoubles rest = sum_of(n, negative(product_of(d, quotient)));
    return first + (rest.high + rest.low) / d.high;
}

// Where the segment meets the plane of a face that it crosses, in lengths of the segment: 0 to 1, of a ray 0 or more.
// Within 0.51 ulp; exactly 0 if the segment begins in the plane.
static inline double place_of(double3 a, double3 b, double3 c, Segment segment) {
    const ExactVector ab = exact_difference(b, a), ac = exact_difference(c, a);
    const TwoDoubles n = determinant_of(ab, ac, exact_difference(a, segment.from)),
                     d = determinant_of(ab, ac, segment.along);
    return n.high == 0.0 ? 0.0 : rounded_quotient(n, d);
}

#endif
