// Records into lanes: rows[i].s[j] <-> rows[j].s[i]. Each round shuffles the first half of the rows into the second.
#ifndef CLSDF_TRANSPOSE_H
#define CLSDF_TRANSPOSE_H

#include "lanes.h"

#define ZIP_LOW_8(Vector, a, b) (Vector)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3)
#define ZIP_HIGH_8(Vector, a, b) (Vector)(a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7)
#define ZIP_LOW_16(Vector, a, b) \
    (Vector)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7)
#define ZIP_HIGH_16(Vector, a, b) \
    (Vector)(a.s8, b.s8, a.s9, b.s9, a.sa, b.sa, a.sb, b.sb, a.sc, b.sc, a.sd, b.sd, a.se, b.se, a.sf, b.sf)

#define DEFINE_TRANSPOSE(name, Vector, count, rounds, zip_low, zip_high)            \
    INLINE void name(__private Vector* rows) {                                      \
        _Pragma("unroll") for (uint round = 0; round < rounds; ++round) {           \
            Vector zipped[count];                                                   \
            _Pragma("unroll") for (uint i = 0; i < count / 2; ++i) {                \
                zipped[2 * i] = zip_low(Vector, rows[i], rows[i + count / 2]);      \
                zipped[2 * i + 1] = zip_high(Vector, rows[i], rows[i + count / 2]); \
            }                                                                       \
            _Pragma("unroll") for (uint i = 0; i < count; ++i) rows[i] = zipped[i]; \
        }                                                                           \
    }
#if LANES == 16
DEFINE_TRANSPOSE(transpose, float16, 16, 4, ZIP_LOW_16, ZIP_HIGH_16)
#else
DEFINE_TRANSPOSE(transpose, float8, 8, 3, ZIP_LOW_8, ZIP_HIGH_8)
#endif
DEFINE_TRANSPOSE(transpose_doubles, double8, 8, 3, ZIP_LOW_8, ZIP_HIGH_8)
#undef DEFINE_TRANSPOSE
#undef ZIP_LOW_8
#undef ZIP_HIGH_8
#undef ZIP_LOW_16
#undef ZIP_HIGH_16

#endif
