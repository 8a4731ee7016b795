// LANES polyhedra of a list at once, one a lane: which of a group of blocks each of them touches.
//
// The records are read as vectors and transposed. The blocks of a group are passed one after the other; a polyhedron's
// numbers then stay in registers, the step from block to block is one addition for each plane, and the answer is a mask
// of lanes, which picks the block's list out of a vector of numbers. Taking one polyhedron and LANES blocks at once
// instead broadcasts all numbers of the polyhedron for one or a few vectors of blocks: measured, over twice the work.
//
// The test is that of blocks.h.
#ifndef CLSDF_LANE_POLYHEDRA_H
#define CLSDF_LANE_POLYHEDRA_H

#include "frame.h"
#include "lanes.h"

// Words of a polyhedron.
#define WORD_GRADIENT_X 0
#define WORD_GRADIENT_Y 3
#define WORD_GRADIENT_Z 6
#define WORD_CONSTANT 9
#define WORD_BASE 12
#define WORD_NORMAL_ALONG 14
#define WORD_NORMAL_ACROSS 16
#define WORD_SLOPE_ABOVE 18
#define WORD_SLOPE_BELOW 21
#define WORD_ORIGIN 27
#define WORD_FLAGS 30
#define WORDS 32

// rows[i].s[j] <-> rows[j].s[i], for LANES rows: each round shuffles the first half of the rows into the second.
#if LANES == 16
#define ZIP_LOW(a, b) \
    (float16)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7)
#define ZIP_HIGH(a, b) \
    (float16)(a.s8, b.s8, a.s9, b.s9, a.sa, b.sa, a.sb, b.sb, a.sc, b.sc, a.sd, b.sd, a.se, b.se, a.sf, b.sf)
#define ZIP_ROUNDS 4
#else
#define ZIP_LOW(a, b) (float8)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3)
#define ZIP_HIGH(a, b) (float8)(a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7)
#define ZIP_ROUNDS 3
#endif
INLINE void transpose(__private floatL* rows) {
#pragma unroll
    for (uint round = 0; round < ZIP_ROUNDS; ++round) {
        floatL zipped[LANES];
#pragma unroll
        for (uint i = 0; i < LANES / 2; ++i) {
            zipped[2 * i] = ZIP_LOW(rows[i], rows[i + LANES / 2]);
            zipped[2 * i + 1] = ZIP_HIGH(rows[i], rows[i + LANES / 2]);
        }
#pragma unroll
        for (uint i = 0; i < LANES; ++i) rows[i] = zipped[i];
    }
}

// What bounds the polyhedra, at one point: Z, the distances outward of the base (-Y) and of the slanted edges, and of
// the ends of the base along X. All are affine in the sample: the same struct holds a step.
typedef struct Bounds {
    floatL z, base, right, left, beyond_right, beyond_left;
} Bounds;

INLINE Bounds bounds_sum(Bounds a, Bounds b) {
    a.z += b.z;
    a.base += b.base;
    a.right += b.right;
    a.left += b.left;
    a.beyond_right += b.beyond_right;
    a.beyond_left += b.beyond_left;
    return a;
}

INLINE Bounds bounds_product(Bounds a, float factor) {
    a.z *= factor;
    a.base *= factor;
    a.right *= factor;
    a.left *= factor;
    a.beyond_right *= factor;
    a.beyond_left *= factor;
    return a;
}

typedef struct LanePolyhedra {
    Bounds at;                      // the centre of a group of blocks
    Bounds step_x, step_y, step_z;  // of one sample
    floatL above[3], below[3];      // slopes by edge
    bool all_compact;
} LanePolyhedra;

// The polyhedra numbers[0, LANES) at the point `centre` samples along each axis from sample `first`.
INLINE LanePolyhedra lane_polyhedra(__global const Polyhedron* polyhedra, __private const uint* numbers, int3 first,
                                    float centre) {
    floatL words[WORDS];
#pragma unroll
    for (uint part = 0; part < WORDS; part += LANES) {
#pragma unroll
        for (uint lane = 0; lane < LANES; ++lane)
            words[part + lane] = load_lanes(0, (__global const float*)(polyhedra + numbers[lane]) + part);
        transpose(words + part);
    }
    const floatL along_right = words[WORD_NORMAL_ALONG], along_left = words[WORD_NORMAL_ALONG + 1];
    const floatL across_right = words[WORD_NORMAL_ACROSS], across_left = words[WORD_NORMAL_ACROSS + 1];
    LanePolyhedra p;
#define SET_STEP(step, gradient)                                   \
    {                                                              \
        const floatL x = words[gradient], y = words[gradient + 1]; \
        p.step.z = words[gradient + 2];                            \
        p.step.base = -y;                                          \
        p.step.right = along_right * x + across_right * y;         \
        p.step.left = across_left * y - along_left * x;            \
        p.step.beyond_right = x;                                   \
        p.step.beyond_left = -x;                                   \
    }
    SET_STEP(step_x, WORD_GRADIENT_X)
    SET_STEP(step_y, WORD_GRADIENT_Y)
    SET_STEP(step_z, WORD_GRADIENT_Z)
#undef SET_STEP

    const floatL i = convert_floatL(first.x - as_intL(words[WORD_ORIGIN])) + centre;
    const floatL j = convert_floatL(first.y - as_intL(words[WORD_ORIGIN + 1])) + centre;
    const floatL k = convert_floatL(first.z - as_intL(words[WORD_ORIGIN + 2])) + centre;
#define FRAME(n)                      \
    (words[WORD_GRADIENT_X + n] * i + \
     (words[WORD_GRADIENT_Y + n] * j + (words[WORD_GRADIENT_Z + n] * k + words[WORD_CONSTANT + n])))
    const floatL x = FRAME(0), y = FRAME(1);
    p.at.z = FRAME(2);
#undef FRAME
    p.at.base = -y;
    p.at.beyond_right = x - words[WORD_BASE];
    p.at.beyond_left = -x - words[WORD_BASE + 1];
    p.at.right = along_right * p.at.beyond_right + across_right * y;
    p.at.left = along_left * p.at.beyond_left + across_left * y;
    const intL flags = as_intL(words[WORD_FLAGS]);
    if (lanes_to_bits((flags & (int)CLSDF_POLYHEDRON_NEAR) == 0)) {  // where sums in float round too coarsely
        float values[6][LANES];
        for (uint lane = 0; lane < LANES; ++lane) {
            const Place place = place_at(polyhedra + numbers[lane], first.x, first.y, first.z, centre);
            values[0][lane] = place.z;
            values[1][lane] = -place.y;
            values[2][lane] = place.outward_right;
            values[3][lane] = place.outward_left;
            values[4][lane] = place.beyond_right;
            values[5][lane] = place.beyond_left;
        }
        p.at.z = load_lanes(0, values[0]);
        p.at.base = load_lanes(0, values[1]);
        p.at.right = load_lanes(0, values[2]);
        p.at.left = load_lanes(0, values[3]);
        p.at.beyond_right = load_lanes(0, values[4]);
        p.at.beyond_left = load_lanes(0, values[5]);
    }
#pragma unroll
    for (uint edge = 0; edge < 3; ++edge) {
        p.above[edge] = words[WORD_SLOPE_ABOVE + edge];
        p.below[edge] = words[WORD_SLOPE_BELOW + edge];
    }
    p.all_compact = lanes_to_bits((flags & (int)CLSDF_POLYHEDRON_COMPACT) == 0) == 0;
    return p;
}

// How far blocks that extend half_x, half_y and half_z samples from their centres reach along each bound.
INLINE Bounds reach_of_lanes(const LanePolyhedra* p, float half_x, float half_y, float half_z) {
    Bounds reach;
#define REACH(bound)                                                                                           \
    reach.bound =                                                                                              \
        (fabs(p->step_x.bound) * half_x + (fabs(p->step_y.bound) * half_y + fabs(p->step_z.bound) * half_z)) * \
        (1.0f + 1.0e-6f)
    REACH(z);
    REACH(base);
    REACH(right);
    REACH(left);
    REACH(beyond_right);
    reach.beyond_left = reach.beyond_right;
#undef REACH
    return reach;
}

INLINE Bounds without_reach(Bounds at, Bounds reach, float slack) {
    at.base -= reach.base + slack;
    at.right -= reach.right + slack;
    at.left -= reach.left + slack;
    at.beyond_right -= reach.beyond_right + slack;
    at.beyond_left -= reach.beyond_left + slack;
    return at;
}

// Whether a block is touched, by lane. at: at its centre, less the reach and the slack but for z; wide: widths of the
// lateral planes there.
INLINE intL touches(Bounds at, floatL height, floatL base, floatL right, floatL left, floatL reach_z, floatL cap,
                    bool compact) {
    intL in = height <= cap + reach_z;
    if (!compact) {
        base = LESSER(base, cap);
        right = LESSER(right, cap);
        left = LESSER(left, cap);
        in &= (at.beyond_right <= cap) & (at.beyond_left <= cap);
    }
    return in & (at.base <= base) & (at.right <= right) & (at.left <= left);
}

#endif
