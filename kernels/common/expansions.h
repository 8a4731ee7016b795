// Signs of determinants of coordinates, exact for the doubles as given, by sums and products of doubles alone: without
// fused operations, integers or recursion. The host compiles this file, too (lib/engine/mesh/expansions.hpp).
//
// A plain determinant decides if it exceeds its rounding. Otherwise the sign is that of an expansion: a sum of doubles
// that do not overlap, so that the last one has the sign (J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic
// and Fast Robust Geometric Predicates", 1997).
//
// The range: coordinates are 0, or from 2^-300 to 2^300. Their last bits are then 2^-352 or above, so all numbers of an
// expansion, and all that its operations meet, are multiples of 2^-1056: a denormal double can hold each. The greatest
// number, a product of three differences times the splitter, is below 2^(3 * 301 + 28). Neither is rounded, but to 53
// bits, which the operations restore. The same holds while 2^m is the greatest and 2^-n the least coordinate that is
// not 0 with 3 m < 990 and 3 n < 916; and multiplying all coordinates by one power of two changes no sign.
#ifndef CLSDF_EXPANSIONS_H
#define CLSDF_EXPANSIONS_H

#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#endif

// For what is rarely called and has large arrays: inlined, each call would have its own. A file with one call defines
// it otherwise.
#if defined(RARELY_CALLED)
#elif defined(__OPENCL_VERSION__)
#define RARELY_CALLED static __attribute__((noinline))
#else
#define RARELY_CALLED static
#endif

#define LEAST_EXACT_COORDINATE 0x1p-300
#define GREATEST_EXACT_COORDINATE 0x1p+300

static inline bool is_in_exact_range(double coordinate) {
    const double size = fabs(coordinate);
    return size == 0.0 || (size >= LEAST_EXACT_COORDINATE && size <= GREATEST_EXACT_COORDINATE);
}

// The sum of both: `high` is that sum rounded, `low` the rest.
typedef struct TwoDoubles {
    double high, low;
} TwoDoubles;

static inline TwoDoubles exact_sum(double a, double b) {
    TwoDoubles sum;
    sum.high = a + b;
    const double of_b = sum.high - a, of_a = sum.high - of_b;
    sum.low = (a - of_a) + (b - of_b);
    return sum;
}

// Two numbers of 26 bits.
static inline TwoDoubles halves_of(double a) {
    const double splitter = 134217729.0;  // 2^27 + 1
    const double large = splitter * a;
    TwoDoubles halves;
    halves.high = large - (large - a);
    halves.low = a - halves.high;
    return halves;
}

static inline TwoDoubles exact_product(double a, double b) {
    const TwoDoubles of_a = halves_of(a), of_b = halves_of(b);
    TwoDoubles product;
    product.high = a * b;
    const double rest = ((product.high - of_a.high * of_b.high) - of_a.low * of_b.high) - of_a.high * of_b.low;
    product.low = of_a.low * of_b.low - rest;
    return product;
}

// A product of three numbers, each of which is two doubles, and a sum without gaps: each double of that is less than
// the last bit of the next one, so that exponents from -1074 to 1023 leave at most 40.
#define PRODUCT_DOUBLES 32
#define EXPANSION_DOUBLES (40 + PRODUCT_DOUBLES)

// Ascending in size, none is 0.
typedef struct Expansion {
    uint count;
    double doubles[EXPANSION_DOUBLES];
} Expansion;

static inline void add_double(__private Expansion* expansion, double x) {
    uint count = 0;
    for (uint i = 0; i < expansion->count; ++i) {
        const TwoDoubles sum = exact_sum(x, expansion->doubles[i]);
        if (sum.low != 0.0) expansion->doubles[count++] = sum.low;
        x = sum.high;
    }
    if (x != 0.0) expansion->doubles[count++] = x;
    expansion->count = count;
}

static inline void add_both(__private Expansion* expansion, TwoDoubles sum) {
    add_double(expansion, sum.low);
    add_double(expansion, sum.high);
}

// The same sum without gaps (Shewchuk, the first half of COMPRESS).
static inline void close_gaps(__private Expansion* expansion) {
    if (expansion->count == 0) return;
    uint first = expansion->count - 1;  // of the doubles without gaps, which end where the others do
    double high = expansion->doubles[first];
    for (uint i = first; i-- > 0;) {
        const TwoDoubles sum = exact_sum(high, expansion->doubles[i]);
        high = sum.high;
        if (sum.low == 0.0) continue;
        expansion->doubles[first--] = high;
        high = sum.low;
    }
    expansion->doubles[first] = high;
    expansion->count -= first;
    for (uint i = 0; first != 0 && i < expansion->count; ++i) expansion->doubles[i] = expansion->doubles[first + i];
}

// Adds a b c.
static inline void add_product(__private Expansion* expansion, TwoDoubles a, TwoDoubles b, TwoDoubles c) {
    close_gaps(expansion);
#pragma unroll 1
    for (uint i = 0; i < 8; ++i) {
        const double of_a = i & 1 ? a.high : a.low, of_b = i & 2 ? b.high : b.low, of_c = i & 4 ? c.high : c.low;
        if (of_a == 0.0 || of_b == 0.0 || of_c == 0.0) continue;
        const TwoDoubles product = exact_product(of_a, of_b);
        add_both(expansion, exact_product(product.low, of_c));
        add_both(expansion, exact_product(product.high, of_c));
    }
}

static inline int sign_of(__private const Expansion* expansion) {
    if (expansion->count == 0) return 0;
    return expansion->doubles[expansion->count - 1] > 0.0 ? 1 : -1;
}

typedef struct ExactVector {
    TwoDoubles x, y, z;
} ExactVector;

static inline ExactVector exact_difference(double3 a, double3 b) {
    ExactVector difference;
    difference.x = exact_sum(a.x, -b.x);
    difference.y = exact_sum(a.y, -b.y);
    difference.z = exact_sum(a.z, -b.z);
    return difference;
}

static inline TwoDoubles negative(TwoDoubles a) {
    a.high = -a.high;
    a.low = -a.low;
    return a;
}

static inline ExactVector rotated(ExactVector v) {
    const TwoDoubles x = v.x;
    v.x = v.y;
    v.y = v.z;
    v.z = x;
    return v;
}

// Adds the determinant.
static inline void add_determinant(__private Expansion* sum, ExactVector u, ExactVector v, ExactVector w) {
#pragma unroll 1
    for (uint term = 0; term < 6; ++term) {
        add_product(sum, u.x, v.y, w.z);
        const ExactVector other = u;
        u = v;
        v = other;
        w.z = negative(w.z);
        if ((term & 1) == 0) continue;
        u = rotated(u);
        v = rotated(v);
        w = rotated(w);
    }
}

RARELY_CALLED int exact_sign_of_determinant(ExactVector u, ExactVector v, ExactVector w) {
    Expansion sum;
    sum.count = 0;
    add_determinant(&sum, u, v, w);
    return sign_of(&sum);
}

RARELY_CALLED int exact_orientation_in_space(double3 a, double3 b, double3 c, double3 d) {
    return exact_sign_of_determinant(exact_difference(b, a), exact_difference(c, a), exact_difference(d, a));
}

// 1: d is on the side of a, b, c from which they run counterclockwise; -1: on the other side; 0: the four lie in a
// plane.
static inline int orientation_in_space(double3 a, double3 b, double3 c, double3 d) {
    const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z,
                 wx = d.x - a.x, wy = d.y - a.y, wz = d.z - a.z;
    const double first_x = uy * vz, second_x = uz * vy, first_y = uz * vx, second_y = ux * vz, first_z = ux * vy,
                 second_z = uy * vx;
    const double determinant = (first_x - second_x) * wx + (first_y - second_y) * wy + (first_z - second_z) * wz;
    const double size = (fabs(first_x) + fabs(second_x)) * fabs(wx) + (fabs(first_y) + fabs(second_y)) * fabs(wy) +
                        (fabs(first_z) + fabs(second_z)) * fabs(wz);
    const double rounding = 0x1p-50 * size;  // 8 u, where Shewchuk proves 7 u + 56 u^2, u = 2^-53
    if (determinant > rounding) return 1;
    if (determinant < -rounding) return -1;
    return size == 0.0 ? 0 : exact_orientation_in_space(a, b, c, d);
}

RARELY_CALLED int exact_orientation_in_plane(double ax, double ay, double bx, double by, double cx, double cy) {
    const TwoDoubles one = {1.0, 0.0};
    Expansion sum;
    sum.count = 0;
    add_product(&sum, exact_sum(bx, -ax), exact_sum(cy, -ay), one);
    add_product(&sum, exact_sum(by, -ay), exact_sum(ax, -cx), one);
    return sign_of(&sum);
}

// The same in a plane. 1: a, b, c run counterclockwise; 0: they lie on a line.
static inline int orientation_in_plane(double ax, double ay, double bx, double by, double cx, double cy) {
    const double first = (bx - ax) * (cy - ay), second = (by - ay) * (cx - ax);
    const double determinant = first - second, size = fabs(first) + fabs(second);
    const double rounding = 0x1p-51 * size;  // 4 u, where Shewchuk proves 3 u + 16 u^2
    if (determinant > rounding) return 1;
    if (determinant < -rounding) return -1;
    return size == 0.0 ? 0 : exact_orientation_in_plane(ax, ay, bx, by, cx, cy);
}

#endif
