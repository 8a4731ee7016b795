// Records into lanes and back: 4 x 4 numbers in each half of a vector, 8 x 8 or 16 x 16.
#ifndef CLSDF_TRANSPOSE_H
#define CLSDF_TRANSPOSE_H

#include "lanes.h"

// A vector of eight numbers out of two, those of the second being 8 to 15. (Put together from parts, it would take
// several instructions.)
#if HAS_BUILTIN(__builtin_shufflevector)
#define EIGHT_OF(a, b, Order, n0, n1, n2, n3, n4, n5, n6, n7) \
    __builtin_shufflevector(a, b, n0, n1, n2, n3, n4, n5, n6, n7)
#else
#define EIGHT_OF(a, b, Order, n0, n1, n2, n3, n4, n5, n6, n7) shuffle2(a, b, (Order)(n0, n1, n2, n3, n4, n5, n6, n7))
#endif

// Rows and columns of 4 x 4 numbers exchanged, in each half of four vectors by itself: halves need no exchange where
// each is loaded from its own place.
#define DEFINE_TRANSPOSE_HALVES(name, Vector, Order)                             \
    INLINE void name(__private Vector* rows) {                                   \
        const Vector a = rows[0], b = rows[1], c = rows[2], d = rows[3];         \
        const Vector ab_even = EIGHT_OF(a, b, Order, 0, 8, 2, 10, 4, 12, 6, 14); \
        const Vector ab_odd = EIGHT_OF(a, b, Order, 1, 9, 3, 11, 5, 13, 7, 15);  \
        const Vector cd_even = EIGHT_OF(c, d, Order, 0, 8, 2, 10, 4, 12, 6, 14); \
        const Vector cd_odd = EIGHT_OF(c, d, Order, 1, 9, 3, 11, 5, 13, 7, 15);  \
        rows[0] = EIGHT_OF(ab_even, cd_even, Order, 0, 1, 8, 9, 4, 5, 12, 13);   \
        rows[1] = EIGHT_OF(ab_odd, cd_odd, Order, 0, 1, 8, 9, 4, 5, 12, 13);     \
        rows[2] = EIGHT_OF(ab_even, cd_even, Order, 2, 3, 10, 11, 6, 7, 14, 15); \
        rows[3] = EIGHT_OF(ab_odd, cd_odd, Order, 2, 3, 10, 11, 6, 7, 14, 15);   \
    }
DEFINE_TRANSPOSE_HALVES(transpose_halves, float8, uint8)
DEFINE_TRANSPOSE_HALVES(transpose_double_halves, double8, ulong8)
#undef DEFINE_TRANSPOSE_HALVES

// Rows and columns of size x size numbers exchanged. Each round shuffles the first half of the rows into the second.
#define DEFINE_TRANSPOSE(name, Vector, size, rounds)                               \
    INLINE void name(__private Vector* rows) {                                     \
        _Pragma("unroll") for (uint round = 0; round < rounds; ++round) {          \
            Vector zipped[size];                                                   \
            _Pragma("unroll") for (uint i = 0; i < size / 2; ++i) {                \
                const Vector a = rows[i], b = rows[i + size / 2];                  \
                zipped[2 * i] = ZIP_LOW_##size(Vector, a, b);                      \
                zipped[2 * i + 1] = ZIP_HIGH_##size(Vector, a, b);                 \
            }                                                                      \
            _Pragma("unroll") for (uint i = 0; i < size; ++i) rows[i] = zipped[i]; \
        }                                                                          \
    }
#if LANES == 16
#define ZIP_LOW_16(Vector, a, b) \
    (Vector)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7)
#define ZIP_HIGH_16(Vector, a, b) \
    (Vector)(a.s8, b.s8, a.s9, b.s9, a.sa, b.sa, a.sb, b.sb, a.sc, b.sc, a.sd, b.sd, a.se, b.se, a.sf, b.sf)
DEFINE_TRANSPOSE(transpose, float16, 16, 4)
#elif LANES == 8
#define ZIP_LOW_8(Vector, a, b) (Vector)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3)
#define ZIP_HIGH_8(Vector, a, b) (Vector)(a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7)
DEFINE_TRANSPOSE(transpose_doubles, double8, 8, 3)
#endif
#undef DEFINE_TRANSPOSE

#endif
