// Records into lanes: 4 x 4 numbers in each half of a vector, or 16 x 16.
#ifndef CLSDF_TRANSPOSE_H
#define CLSDF_TRANSPOSE_H

#include "lanes.h"

// Rows and columns of 4 x 4 numbers exchanged, in each half of four vectors by itself: halves need no exchange where
// each is loaded from its own place.
INLINE void transpose_halves(__private float8* rows) {
    const float8 a = rows[0], b = rows[1], c = rows[2], d = rows[3];
    const float8 ab_low = (float8)(a.s0, b.s0, a.s1, b.s1, a.s4, b.s4, a.s5, b.s5);
    const float8 ab_high = (float8)(a.s2, b.s2, a.s3, b.s3, a.s6, b.s6, a.s7, b.s7);
    const float8 cd_low = (float8)(c.s0, d.s0, c.s1, d.s1, c.s4, d.s4, c.s5, d.s5);
    const float8 cd_high = (float8)(c.s2, d.s2, c.s3, d.s3, c.s6, d.s6, c.s7, d.s7);
    rows[0] = (float8)(ab_low.s01, cd_low.s01, ab_low.s45, cd_low.s45);
    rows[1] = (float8)(ab_low.s23, cd_low.s23, ab_low.s67, cd_low.s67);
    rows[2] = (float8)(ab_high.s01, cd_high.s01, ab_high.s45, cd_high.s45);
    rows[3] = (float8)(ab_high.s23, cd_high.s23, ab_high.s67, cd_high.s67);
}

#if LANES == 16
// Each round shuffles the first half of the rows into the second.
INLINE void transpose(__private float16* rows) {
#pragma unroll
    for (uint round = 0; round < 4; ++round) {
        float16 zipped[16];
#pragma unroll
        for (uint i = 0; i < 8; ++i) {
            const float16 a = rows[i], b = rows[i + 8];
            zipped[2 * i] = (float16)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6,
                                      b.s6, a.s7, b.s7);
            zipped[2 * i + 1] = (float16)(a.s8, b.s8, a.s9, b.s9, a.sa, b.sa, a.sb, b.sb, a.sc, b.sc, a.sd, b.sd, a.se,
                                          b.se, a.sf, b.sf);
        }
#pragma unroll
        for (uint i = 0; i < 16; ++i) rows[i] = zipped[i];
    }
}
#endif

#endif
