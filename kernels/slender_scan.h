// The distances of slender polyhedra (slender_polyhedra.h), into the minima of a coarse brick.
//
// The samples within a polyhedron are listed, layer by layer, and then evaluated LANES at a time, so that no lane is
// spent on a sample outside. Each sample's minimum is read and written by itself.
#ifndef CLSDF_SLENDER_SCAN_H
#define CLSDF_SLENDER_SCAN_H

#include "brick_lists.h"
#include "brick_minimum.h"
#include "edge_tables.h"
#include "request.h"
#include "slender_polyhedra.h"
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

#define LANE_OF(vectors, lane) (((__private const float*)&(vectors))[lane])

// Where samples of a coarse brick are among its bricks' minima: bricks with x running fastest, then y, then z; there by
// sub-blocks (subblocks.h).
INLINE uintL places_of(uintL samples) {
    const uintL of_sample = (samples & 3u) | (samples >> 3 & 4u) | (samples >> 7 & 8u);
    const uintL of_subblock = (samples >> 2 & 0x30u) | (samples >> 5 & 0xC0u);
    return (samples & 0x6000u) | (samples << 3 & 0x1800u) | (samples << 6 & 0x700u) | of_subblock | of_sample;
}

INLINE void lower_minima(__global Minimum* minima, uintL samples, floatL squared, uint triangle) {
    uintL all_places = places_of(samples);
#ifdef NEAREST
    all_places += all_places & ~0x1FFu;  // each brick's triangles lie behind its distances
#endif
    uint places[LANES];
    float values[LANES];
    store_lanes(all_places, 0, places);
    store_lanes(squared, 0, values);
#pragma unroll
    for (uint lane = 0; lane < LANES; ++lane) {
        __global float* least = (__global float*)minima + places[lane];
#ifdef NEAREST
        __global uint* nearest = (__global uint*)least + CLSDF_BRICK * CLSDF_BRICK * CLSDF_BRICK;
        const bool better = values[lane] < *least || (values[lane] == *least && triangle < *nearest);
        *nearest = better ? triangle : *nearest;
        *least = better ? values[lane] : *least;
#else
        *least = LESSER(values[lane], *least);
#endif
    }
}

// Numbers in two parts: multiples of 2^-14 of the power of two below the spacing, and what they lack. Of the first,
// sums of products with integers are exact, as far as SLENDER_REACH.
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

static inline void evaluate_samples(__global const Polyhedron* p, int3 first, double rounder, __private Samples* list,
                                    __global Minimum* minima) {
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
    const uint triangle = p->triangle;
    store_lanes((uintL)list->samples[0], 0, list->samples + list->count);  // the last vector is filled with the first
    for (uint n = 0; n < list->count; n += LANES) {
        const uintL samples = load_lanes(0, list->samples + n);
        const floatL i = convert_floatL(as_intL(samples & 31u)), j = convert_floatL(as_intL(samples >> 5 & 31u)),
                     k = convert_floatL(as_intL(samples >> 10));
#define SUM(part, axis) (i * along_x.part.axis + (j * along_y.part.axis + (k * along_z.part.axis + at_first.part.axis)))
        const floatL x = SUM(high, x) + SUM(low, x), y = SUM(high, y) + SUM(low, y), z = SUM(high, z) + SUM(low, z);
#undef SUM
        lower_minima(minima, samples, squared_distance_in_region(table, x, y, x, y, z), triangle);
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

// What all polyhedra of a coarse brick have in common.
typedef struct SlenderScan {
    Layout layout;
    int3 first;  // the coarse brick's first sample
    double rounder;
    float half_height;
    __global Minimum* minima;
} SlenderScan;

// Evaluates and empties the list.
INLINE void evaluate_and_empty(const SlenderScan* scan, __global const Polyhedron* p, __private Samples* list,
                               __private ulong* counters) {
    if (list->count == 0) return;
#ifdef COUNT
    count_samples(scan->layout, p, scan->first, list, counters);
#endif
    evaluate_samples(p, scan->first, scan->rounder, list, scan->minima);
    list->count = 0;
}

// By how many bits a sample's place along an axis of the layers is shifted.
typedef struct Shifts {
    uint a, u, v;
} Shifts;

// Lists the samples of one lane's frustum in LANES layers, from `layer` on. In each layer's box, all layers step along
// u and v at once.
INLINE void list_layers(const SlenderScan* scan, __global const Polyhedron* p, __private const Frustum* frustum,
                        uint lane, Shifts shifts, float layer, __private Samples* list, __private ulong* counters) {
    const floatL m = layer + convert_floatL(LANE_NUMBERS);
#define LINE_AT(line) (LANE_OF(frustum->line.at, lane) + LANE_OF(frustum->line.step, lane) * m)
    floatL u = ceil(LINE_AT(low_u)), v = ceil(LINE_AT(low_v));
    u = GREATER(u, 0.0f);
    v = GREATER(v, 0.0f);
    floatL more_u = floor(LINE_AT(high_u)), more_v = floor(LINE_AT(high_v));
#undef LINE_AT
    more_u = LESSER(more_u, (float)(CLSDF_COARSE - 1)) - u;
    more_v = LESSER(more_v, (float)(CLSDF_COARSE - 1)) - v;
    more_u = (m <= LANE_OF(frustum->last, lane)) & (more_v >= 0.0f) ? more_u : (floatL)-1.0f;
    more_v = more_u >= 0.0f ? more_v : (floatL)-1.0f;
    const int most_u = (int)greatest_lane(more_u), most_v = (int)greatest_lane(more_v);

    // Distances beyond the lateral planes, and from the middle one.
    floatL at_row[4];
    float step_u[4], step_v[4];
#pragma unroll
    for (uint n = 0; n < 4; ++n) {
        __private const Plane* plane = n == 3 ? &frustum->middle : frustum->lateral + n;
        step_u[n] = LANE_OF(plane->step_u, lane);
        step_v[n] = LANE_OF(plane->step_v, lane);
        at_row[n] = LANE_OF(plane->at, lane) + (LANE_OF(plane->step_a, lane) * m + (step_u[n] * u + step_v[n] * v));
    }
    uintL row = as_uintL(convert_intL(m)) << shifts.a | as_uintL(convert_intL(u)) << shifts.u |
                as_uintL(convert_intL(v)) << shifts.v;
    floatL past_v = -0.5f - more_v;
    for (int n_v = 0; n_v <= most_v; ++n_v) {
        if (list->count >= MOST_SAMPLES) evaluate_and_empty(scan, p, list, counters);
        uintL samples = row;
        floatL at[4], past_u = past_v < 0.0f ? -0.5f - more_u : (floatL)1.0f;
#pragma unroll
        for (uint n = 0; n < 4; ++n) at[n] = at_row[n];
        for (int n_u = 0; n_u <= most_u; ++n_u) {
            const uint within =
                lanes_to_bits(as_intL(at[0]) & as_intL(at[1]) & as_intL(at[2]) &
                              as_intL(fabs(at[3]) - scan->half_height) & as_intL(past_u));  // the sign bits
            store_lanes(packed(samples, within), 0, list->samples + list->count);
            list->count += popcount(within);
            samples += 1u << shifts.u;
            past_u += 1.0f;
#pragma unroll
            for (uint n = 0; n < 4; ++n) at[n] += step_u[n];
        }
        row += 1u << shifts.v;
        past_v += 1.0f;
#pragma unroll
        for (uint n = 0; n < 4; ++n) at_row[n] += step_v[n];
    }
}

// One lane's polyhedron.
INLINE void scan_slender(const SlenderScan* scan, __global const Polyhedron* p,
                         __private const SlenderPolyhedra* slender, uint lane, __private ulong* counters) {
    const uint axis = ((__private const uint*)&slender->axis)[lane];
    const Shifts shifts = {5 * axis, axis == 0 ? 5 : 0, axis == 2 ? 5 : 10};
    Samples list;
    list.count = 0;
    for (uint side = 0; side < 2; ++side) {
        __private const Frustum* frustum = slender->sides + side;
        const float last = LANE_OF(frustum->last, lane);
        for (float layer = LANE_OF(frustum->first, lane); layer <= last; layer += LANES)
            list_layers(scan, p, frustum, lane, shifts, layer, &list, counters);
    }
    evaluate_and_empty(scan, p, &list, counters);
}

// Polyhedra of a list until a vector is full.
typedef struct SlenderQueue {
    uint numbers[2 * LANES];
    uint count;
} SlenderQueue;

// Takes the first LANES polyhedra of the queue, or all where there are fewer.
static inline void scan_queue(const SlenderScan* scan, float cap, float slack, __private SlenderQueue* queue,
                              __global const Polyhedron* polyhedra, __private ulong* counters) {
    const uint count = min(queue->count, (uint)LANES);
    for (uint n = count; n < LANES; ++n) queue->numbers[n] = queue->numbers[0];  // lanes that nothing is made of
    SlenderPolyhedra slender;
    uint present = bound_slender(scan->layout, polyhedra, queue->numbers, scan->first, cap, slack, &slender);
    present &= (1u << count) - 1;
#ifdef COUNT
    counters[CLSDF_COUNT_BRICK_PAIRS] += popcount(present);
#endif
    for (; present; present &= present - 1) {
        const uint lane = lowest_bit(present);
        scan_slender(scan, polyhedra + queue->numbers[lane], &slender, lane, counters);
    }
    queue->count -= count;
    store_lanes(load_lanes(0, queue->numbers + LANES), 0, queue->numbers);
}

// The slender polyhedra of a coarse brick's list into its bricks' minima; of the others, the numbers into `others`,
// where there is room for a vector beyond them. Returns how many others there are.
static inline uint scan_slender_polyhedra(Layout layout, int3 coarse, uint count, __global const uint* entries,
                                          float cap, float slack, __global const Polyhedron* polyhedra,
                                          __global Minimum* minima, __global uint* others, __private ulong* counters) {
    const SlenderScan scan = {layout, coarse * CLSDF_COARSE, splitting_rounder(longest_spacing(layout)),
                              half_height(cap, margin_of(slack)), minima};
    SlenderQueue queue;
    queue.count = 0;
    uint other_count = 0;
    for (uint e = 0; e < count; e += LANES) {
        uint numbers[LANES];
        load_numbers(entries, e, count, numbers);
        for (uint ahead = e + LANES; ahead < min(count, e + 2 * LANES); ++ahead) request(polyhedra + entries[ahead]);
        const uint in_list = lanes_in_list(e, count);
        uint absent;
        const uint chosen = in_list & choose_slender(layout, polyhedra, numbers, scan.first, cap, slack, &absent);
        const uint other = in_list & ~(chosen | absent);
        const uintL all = load_lanes(0, numbers);
        store_lanes(packed(all, other), 0, others + other_count);
        store_lanes(packed(all, chosen), 0, queue.numbers + queue.count);
        other_count += popcount(other);
        queue.count += popcount(chosen);
        const uint wanted = e + LANES < count ? LANES : 1;  // at the end all of them
        while (queue.count >= wanted) scan_queue(&scan, cap, slack, &queue, polyhedra, counters);
    }
    return other_count;
}

#endif
