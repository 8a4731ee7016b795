// Loads the records of several polyhedra into lanes, one polyhedron a lane: records are read as vectors and transposed.
#ifndef CLSDF_LANE_RECORDS_H
#define CLSDF_LANE_RECORDS_H

#include "polyhedron.h"
#include "simd.h"

// The words (polyhedron.h) of the polyhedra numbers[0, LANES).
INLINE void load_words(__global const Polyhedron* polyhedra, __private const uint* numbers, __private floatL* words) {
#define WORDS_OF(lane) ((__global const float*)(polyhedra + numbers[lane]))
#if LANES == 16
#pragma unroll
    for (uint part = 0; part < WORDS; part += 16) {
#pragma unroll
        for (uint lane = 0; lane < 16; ++lane) words[part + lane] = vload16(0, WORDS_OF(lane) + part);
        transpose(words + part);
    }
#else
#pragma unroll
    for (uint part = 0; part < WORDS; part += 4) {
#pragma unroll
        for (uint lane = 0; lane < 4; ++lane)
            words[part + lane] = (float8)(vload4(0, WORDS_OF(lane) + part), vload4(0, WORDS_OF(lane + 4) + part));
        transpose_halves(words + part);
    }
#endif
#undef WORDS_OF
}

// The exact numbers of eight polyhedra, one a lane.
INLINE void load_exact(__global const Polyhedron* polyhedra, __private const uint* numbers, __private double8* exact) {
#pragma unroll
    for (uint part = 0; part < EXACT_NUMBERS; part += 4) {
        const uint n = min(part, (uint)EXACT_NUMBERS - 4);  // the last four overlap those before them
#define FOUR_OF(lane) vload4(0, polyhedra[numbers[lane]].exact_gradient_x + n)
#pragma unroll
        for (uint lane = 0; lane < 4; ++lane) exact[n + lane] = (double8)(FOUR_OF(lane), FOUR_OF(lane + 4));
#undef FOUR_OF
        transpose_double_halves(exact + n);
    }
}

// A point relative to the integer origins of eight polyhedra: (x, y, z) in samples of the lattice.
typedef struct FromOrigins {
    double8 x, y, z;
} FromOrigins;

INLINE FromOrigins from_origins(__global const Polyhedron* polyhedra, __private const uint* numbers, double8 x,
                                double8 y, double8 z) {
    float8 origin[4];  // the fourth is not of use
#pragma unroll
    for (uint lane = 0; lane < 4; ++lane)
        origin[lane] = (float8)(vload4(0, (__global const float*)&polyhedra[numbers[lane]].origin_x),
                                vload4(0, (__global const float*)&polyhedra[numbers[lane + 4]].origin_x));
    transpose_halves(origin);
    const FromOrigins from = {x - convert_double8(as_int8(origin[0])), y - convert_double8(as_int8(origin[1])),
                              z - convert_double8(as_int8(origin[2]))};
    return from;
}

#endif
