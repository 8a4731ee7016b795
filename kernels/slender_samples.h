// The samples of one slender polyhedron: their list, and its evaluation LANES samples at a time.
#ifndef CLSDF_SLENDER_SAMPLES_H
#define CLSDF_SLENDER_SAMPLES_H

#include "brick_lists.h"
#include "brick_minimum.h"
#include "edge_tables.h"
#include "polyhedron.h"
#ifdef COUNT
#include "blocks.h"
#endif

// Samples of a coarse brick: x + 32 y + 1024 z. With MOST_SAMPLES of them they are evaluated, before the next row;
// beyond those there is room for what a row of LANES layers adds, and for a vector.
#ifndef MOST_SAMPLES
#define MOST_SAMPLES 1024
#endif
typedef struct Samples {
    uint samples[MOST_SAMPLES + CLSDF_COARSE * LANES + LANES];
    uint count;
} Samples;

// The indices of samples (i, j, k) of a coarse brick among its bricks' minima.
INLINE uintL indices_of(uintL i, uintL j, uintL k) {
#if LANES == 16 && defined(__AVX512F__) && HAS_BUILTIN(__builtin_ia32_vpermi2vard512)
    // Looked up, by the five lowest bits, in tables of two vectors.
#define LOOK_UP(INDEX, indices)                                                               \
    as_uint16(__builtin_ia32_vpermi2vard512(as_int16(INDEX(LANE_NUMBERS)), as_int16(indices), \
                                            as_int16(INDEX(LANE_NUMBERS + 16u))))
    return LOOK_UP(INDEX_OF_X, i) | LOOK_UP(INDEX_OF_Y, j) | LOOK_UP(INDEX_OF_Z, k);
#undef LOOK_UP
#else
    return INDEX_OF_X(i) | INDEX_OF_Y(j) | INDEX_OF_Z(k);
#endif
}

// SCATTERED_ACCESS: instructions that gather and scatter are fast on this device. The list's first sample fills the
// last vector, so it may be listed twice. It gets the same distance twice: the scatter writes equal values to one
// address.
#if LANES == 16 && !defined(NEAREST) && defined(SCATTERED_ACCESS) && defined(__AVX512F__) && \
    HAS_BUILTIN(__builtin_ia32_gathersiv16sf) && HAS_BUILTIN(__builtin_ia32_scattersiv16sf)
#define ALL_LANES ((ushort)LANE_BITS)
INLINE void lower_minima(__global Minimum* minima, uintL indices, floatL squared, uint number,
                         __global const Polyhedron* polyhedra) {
    __private void* samples = (__private void*)(size_t)minima;
    const float16 least =
        __builtin_ia32_gathersiv16sf((float16)(0.0f), samples, as_intL(indices), ALL_LANES, sizeof(float));
    __builtin_ia32_scattersiv16sf(samples, ALL_LANES, as_intL(indices), LESSER(squared, least), sizeof(float));
}
#undef ALL_LANES
#else
INLINE void lower_minima(__global Minimum* minima, uintL indices, floatL squared, uint number,
                         __global const Polyhedron* polyhedra) {
#ifdef NEAREST
    const LeastL found = least_of(squared, number);
#else
    const LeastL found = squared;
#endif
    LeastL least;
    uint index[LANES];
    store_lanes(indices, 0, index);
#pragma unroll
    for (uint lane = 0; lane < LANES; ++lane) {
        __global Least* sample = (__global Least*)minima + index[lane];
        const Least of_lane = ((__private const Least*)&found)[lane], before = *sample;
        ((__private Least*)&least)[lane] = before;
        *sample = LESSER(of_lane, before);
    }
#ifdef NEAREST
    for (uint lanes = equally_near(found, least); lanes; lanes &= lanes - 1) {
        const uint lane = lowest_bit(lanes);
        ((__global ulong*)minima)[index[lane]] =
            first_of(((__private const ulong*)&found)[lane], ((__private const ulong*)&least)[lane], polyhedra);
    }
#endif
}
#endif

// Numbers in two parts: multiples of 2^-14 of the power of two below the spacing, and what they lack. Of the first,
// sums of products with integers are exact, as far as SLENDER_RANGE.
typedef struct Split {
    float4 high, low;
} Split;

// rounder: added and taken away again, leaves such a multiple.
INLINE Split split(double4 exact, double rounder) {
    const double4 high = (exact + rounder) - rounder;
    const Split parts = {convert_float4(high), convert_float4(exact - high)};
    return parts;
}
INLINE double splitting_rounder(float spacing) {
    return 0x1.8p52 * 0x1p-14 * (double)power_of_two_below(spacing);
}

// Its offsets are those of the frame's origin.
INLINE EdgeTable table_of(__global const Polyhedron* p) {
    const double2 base = vload2(0, p->exact_base);
    const double2 along = vload2(0, p->exact_normal_along), across = vload2(0, p->exact_normal_across);
    const float2 a = convert_float2(along), b = convert_float2(across), end = convert_float2(-base);
    const float2 outward = convert_float2(-along * base), before = convert_float2(-across * base);
    const float2 past = convert_float2(-along * p->exact_altitude);
    EdgeTable table;
    table.along = repeated((float4)(a.x, 0.0f, 0.0f, a.y));
    table.across = repeated((float4)(b.x, -1.0f, -1.0f, b.y));
    table.outward = repeated((float4)(outward.x, 0.0f, 0.0f, outward.y));
    table.before = repeated((float4)(before.x, -INFINITY, -INFINITY, before.y));
    table.past = repeated((float4)(past.x, end.x, end.y, past.y));
    return table;
}

static inline void evaluate_samples(__global const Polyhedron* polyhedra, uint number, int3 first, double rounder,
                                    __private Samples* list, __global Minimum* minima) {
    __global const Polyhedron* p = polyhedra + number;
    const double4 gradient_x = vload4(0, p->exact_gradient_x), gradient_y = vload4(0, p->exact_gradient_y),
                  gradient_z = vload4(0, p->exact_gradient_z);
    const Split along_x = split(gradient_x, rounder), along_y = split(gradient_y, rounder),
                along_z = split(gradient_z, rounder);
    const Split at_first =
        split(gradient_x * (double)(first.x - p->origin_x) +
                  (gradient_y * (double)(first.y - p->origin_y) +
                   (gradient_z * (double)(first.z - p->origin_z) + vload4(0, p->exact_constant_at_origin))),
              rounder);
    const EdgeTable table = table_of(p);
    store_lanes((uintL)list->samples[0], 0, list->samples + list->count);  // the last vector is filled with the first
    for (uint n = 0; n < list->count; n += LANES) {
        const uintL samples = load_lanes(0, list->samples + n);
        const uintL sample_i = samples & 31u, sample_j = samples >> 5 & 31u, sample_k = samples >> 10;
        const floatL i = convert_floatL(as_intL(sample_i)), j = convert_floatL(as_intL(sample_j)),
                     k = convert_floatL(as_intL(sample_k));
#define SUM(part, axis) (i * along_x.part.axis + (j * along_y.part.axis + (k * along_z.part.axis + at_first.part.axis)))
        const floatL x = SUM(high, x) + SUM(low, x), y = SUM(high, y) + SUM(low, y), z = SUM(high, z) + SUM(low, z);
#undef SUM
        lower_minima(minima, indices_of(sample_i, sample_j, sample_k), squared_distance_in_region(table, x, y, x, y, z),
                     number, polyhedra);
    }
}

#ifdef COUNT
// (Those within the slack of the face are listed for either side.)
static inline void count_samples(Layout layout, __global const Polyhedron* p, int3 first, __private const Samples* list,
                                 __private ulong* counters) {
    const float slack = layout.half_width * layout.slack_rate + layout.brick_slack;
    const Offsets offsets = offsets_at(p, first.x, first.y, first.z);
    for (uint n = 0; n < list->count; n += LANES) {
        const uintL samples = load_lanes(0, list->samples + n);
        const uint in_polyhedron = covered_samples(p, offsets, convert_floatL(as_intL(samples & 31u)),
                                                   convert_floatL(as_intL(samples >> 5 & 31u)),
                                                   convert_floatL(as_intL(samples >> 10)), layout.half_width, slack);
        counters[CLSDF_COUNT_LANES] += LANES;
        counters[CLSDF_COUNT_COVERED] += popcount(in_polyhedron & lanes_in_list(n, list->count));
    }
}
#endif

#endif
