// The samples of one slender polyhedron: their list, and its evaluation LANES samples at a time.
#ifndef CLSDF_SLENDER_SCAN_H
#define CLSDF_SLENDER_SCAN_H

#include "brick_lists.h"
#include "lane_offsets.h"
#include "polyhedron.h"
#include "simd.h"
#include "slender_polyhedra.h"
#include "subblocks.h"

#ifdef COUNT
#include "overlap.h"
#endif

// Samples of a coarse brick: x + 32 y + 1024 z. When a row begins with MOST_SAMPLES of them, they are evaluated.
// There is room for what one more row of LANES layers adds, and for a vector.
#ifndef MOST_SAMPLES
#define MOST_SAMPLES 1024
#endif
typedef struct Samples {
    uint samples[MOST_SAMPLES + CLSDF_COARSE * LANES + LANES];
    uint count;
} Samples;

// The indices of samples (i, j, k) of a coarse brick among its bricks' minima.
INLINE uintL indices_of(uintL i, uintL j, uintL k) {
    return INDEX_OF_X(i) | INDEX_OF_Y(j) | INDEX_OF_Z(k);
}

// SCATTERED_ACCESS: instructions that gather and scatter are fast on this device. The list's first sample fills the
// last vector, so it may be listed twice. It gets the same distance twice: the scatter writes equal values to one
// address.
#if !defined(NEAREST) && defined(SCATTERED_ACCESS) && defined(GATHERED)
INLINE void lower_minima(__global Minimum* minima, uintL indices, floatL squared, uint number,
                         __global const Polyhedron* polyhedra) {
    __private void* samples = (__private void*)(size_t)minima;
    const float16 least = GATHERED(samples, indices);
    SCATTER(samples, indices, LESSER(squared, least));
}
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

// Numbers in two parts: `high` is a multiple of 2^-14 of the power of two below the spacing, and `low` is the rest.
// Sums of products of `high` and integers are exact, as far as SLENDER_RANGE.
typedef struct Split {
    float4 high, low;
} Split;

// rounder: a number that is added and subtracted again leaves such a multiple.
INLINE Split split(double4 exact, double rounder) {
    const double4 high = (exact + rounder) - rounder;
    const Split parts = {convert_float4(high), convert_float4(exact - high)};
    return parts;
}
INLINE double splitting_rounder(float spacing) {
    return 0x1.8p52 * 0x1p-14 * (double)power_of_two_below(spacing);
}

// The table of a polyhedron, with the offsets at the frame's origin.
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
    const Split at_first = split(frame_at(p, first.x, first.y, first.z), rounder);
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
// (Samples within the slack of the face are listed for both sides.)
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

// The distances of slender polyhedra (slender_polyhedra.h), into the minima of a coarse brick.
//
// The samples within a polyhedron are listed, layer by layer, and then evaluated LANES at a time, so that no lane is
// spent on a sample outside.

// Values that all polyhedra of a coarse brick share.
typedef struct SlenderScan {
    Layout layout;
    int3 first;  // the coarse brick's first sample
    double rounder;
    float half_height;
    __global const Polyhedron* polyhedra;
    __global Minimum* minima;
} SlenderScan;

// Evaluates and empties the list of a polyhedron.
INLINE void evaluate_and_empty(const SlenderScan* scan, uint polyhedron, __private Samples* list,
                               __private ulong* counters) {
    if (list->count == 0) return;
#ifdef COUNT
    count_samples(scan->layout, scan->polyhedra + polyhedron, scan->first, list, counters);
#endif
    evaluate_samples(scan->polyhedra, polyhedron, scan->first, scan->rounder, list, scan->minima);
    list->count = 0;
}

#define LANE_OF(vectors, lane) (((__private const float*)&(vectors))[lane])

// An upper bound, up to one too large, of the width of a lane's boxes in samples. It follows from the lines' ends, so
// loops need not wait for the widest lane.
INLINE int widest(__private const Line* low, __private const Line* high, uint lane, float first, float last) {
    const float at = LANE_OF(high->at, lane) - LANE_OF(low->at, lane);
    const float step = LANE_OF(high->step, lane) - LANE_OF(low->step, lane);
    const float at_first = at + step * first, at_last = at + step * last;
    const float most = GREATER(at_first, at_last) + 1.0e-3f;  // beyond what it rounds
    return (int)LESSER(most, (float)(CLSDF_COARSE - 1));
}

// At most LANES layers: those above the face, then those below. If they are few, 2^columns_log neighbours along u share
// the vector.
typedef struct LayerRange {
    bool has_above, has_below;
    float first_above, last_above, first_below, last_below;
    int columns_log;
} LayerRange;

// Each lane's layer and its column along u, from LANES * columns_log on. If there are few layers, the free lanes take
// the neighbouring columns.
#if LANES == 16
__constant float layer_of_lane[3 * LANES] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15,
                                             0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5,  5,  6,  6,  7,  7,
                                             0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,  2,  3,  3,  3,  3};
__constant float column_of_lane[3 * LANES] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 1,
                                              0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
#else
__constant float layer_of_lane[3 * LANES] = {0, 1, 2, 3, 4, 5, 6, 7, 0, 0, 1, 1, 2, 2, 3, 3, 0, 0, 0, 0, 1, 1, 1, 1};
__constant float column_of_lane[3 * LANES] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 2, 3, 0, 1, 2, 3};
#endif

// Lists the samples of one lane's polyhedron in some layers. In each layer's box, all layers step along u and v at
// once. (The sides are constants in each call. If one is absent, OF_SIDE takes the value of the other.)
INLINE void list_layers(const SlenderScan* scan, uint polyhedron, __private const SlenderPolyhedra* slender, uint lane,
                        LayerRange range, __private Samples* list, __private ulong* counters) {
    __private const SideLayers* above = slender->sides;
    __private const SideLayers* below = slender->sides + 1;
    const floatL number = load_lanes(range.columns_log, layer_of_lane);
    const uint columns = 1u << range.columns_log;
    const float count_above = range.has_above ? range.last_above - range.first_above + 1.0f : 0.0f;
    const intL is_above = number < count_above;
#define OF_SIDE(of_above, of_below)          \
    (!range.has_below   ? (floatL)(of_above) \
     : !range.has_above ? (floatL)(of_below) \
                        : (is_above ? (floatL)(of_above) : (floatL)(of_below)))
#define OF_LANE(member) OF_SIDE(LANE_OF(above->member, lane), LANE_OF(below->member, lane))
    const floatL m = number + OF_SIDE(range.first_above, range.first_below - count_above);
#define LINE_AT(line) (OF_LANE(line.at) + OF_LANE(line.step) * m)
    floatL u = CEIL(LINE_AT(low_u)), v = CEIL(LINE_AT(low_v));
    u = GREATER(u, 0.0f) + load_lanes(range.columns_log, column_of_lane);
    v = GREATER(v, 0.0f);
    floatL more_u = FLOOR(LINE_AT(high_u)), more_v = FLOOR(LINE_AT(high_v));
#undef LINE_AT
    more_u = LESSER(more_u, (float)(CLSDF_COARSE - 1)) - u;
    more_v = LESSER(more_v, (float)(CLSDF_COARSE - 1)) - v;
    more_v = m <= OF_SIDE(range.last_above, range.last_below) ? more_v : (floatL)-1.0f;
    int most_u = -1, most_v = -1;
    if (range.has_above) {
        most_u = widest(&above->low_u, &above->high_u, lane, range.first_above, range.last_above);
        most_v = widest(&above->low_v, &above->high_v, lane, range.first_above, range.last_above);
    }
    if (range.has_below) {
        most_u = max(most_u, widest(&below->low_u, &below->high_u, lane, range.first_below, range.last_below));
        most_v = max(most_v, widest(&below->low_v, &below->high_v, lane, range.first_below, range.last_below));
    }

    // Distances beyond the lateral planes, and from the middle one.
    floatL at_row[4], step_u[4], step_v[4];
#pragma unroll
    for (uint n = 0; n < 4; ++n) {
        step_u[n] = OF_LANE(planes[n].step_u);
        step_v[n] = OF_LANE(planes[n].step_v);
        at_row[n] = OF_LANE(planes[n].at) + (OF_LANE(planes[n].step_a) * m + (step_u[n] * u + step_v[n] * v));
        step_u[n] *= (float)columns;
    }
#undef OF_LANE
#undef OF_SIDE
    // The index of a sample along each axis is shifted by so many bits.
    const uint axis = ((__private const uint*)&slender->axis)[lane];
    const uint shift_a = 5 * axis, shift_u = axis == 0 ? 5 : 0, shift_v = axis == 2 ? 5 : 10;
    uintL row = as_uintL(convert_intL(m)) << shift_a | as_uintL(convert_intL(u)) << shift_u |
                as_uintL(convert_intL(v)) << shift_v;
    floatL past_v = -0.5f - more_v;
    for (int n_v = 0; n_v <= most_v; ++n_v) {
        if (list->count >= MOST_SAMPLES) evaluate_and_empty(scan, polyhedron, list, counters);
        uint count = list->count;
        uintL samples = row;
        floatL at[4], past_u = past_v < 0.0f ? -0.5f - more_u : (floatL)1.0f;
#pragma unroll
        for (uint n = 0; n < 4; ++n) at[n] = at_row[n];
        for (int n_u = 0; n_u <= most_u; n_u += columns) {
            const uint within =
                lanes_to_bits(as_intL(at[0]) & as_intL(at[1]) & as_intL(at[2]) &
                              as_intL(fabs(at[3]) - scan->half_height) & as_intL(past_u));  // the sign bits
            store_lanes(packed(samples, within), 0, list->samples + count);
            count += popcount(within);
            samples += columns << shift_u;
            past_u += (float)columns;
#pragma unroll
            for (uint n = 0; n < 4; ++n) at[n] += step_u[n];
        }
        list->count = count;
        row += 1u << shift_v;
        past_v += 1.0f;
#pragma unroll
        for (uint n = 0; n < 4; ++n) at_row[n] += step_v[n];
    }
}

// One lane's polyhedron: both sides at once if they have few layers, else one after the other.
INLINE void scan_slender(const SlenderScan* scan, uint polyhedron, __private const SlenderPolyhedra* slender, uint lane,
                         __private ulong* counters) {
    __private const SideLayers* above = slender->sides;
    __private const SideLayers* below = slender->sides + 1;
    const float first_above = LANE_OF(above->first, lane), last_above = LANE_OF(above->last, lane);
    const float first_below = LANE_OF(below->first, lane), last_below = LANE_OF(below->last, lane);
    const int of_both = ((__private const int*)&slender->columns_log_of_both)[lane];
    Samples list;
    list.count = 0;
    if (of_both >= 0) {
        const LayerRange all = {true, true, first_above, last_above, first_below, last_below, of_both};
        list_layers(scan, polyhedron, slender, lane, all, &list, counters);
    } else {
        int columns_log = ((__private const int*)&above->columns_log)[lane];
        for (float first = first_above; first <= last_above; first += LANES) {
            const float last = first + (LANES - 1);
            const LayerRange range = {true, false, first, LESSER(last, last_above), 0.0f, 0.0f, columns_log};
            list_layers(scan, polyhedron, slender, lane, range, &list, counters);
            columns_log = columns_log_of(last_above - last);
        }
        columns_log = ((__private const int*)&below->columns_log)[lane];
        for (float first = first_below; first <= last_below; first += LANES) {
            const float last = first + (LANES - 1);
            const LayerRange range = {false, true, 0.0f, 0.0f, first, LESSER(last, last_below), columns_log};
            list_layers(scan, polyhedron, slender, lane, range, &list, counters);
            columns_log = columns_log_of(last_below - last);
        }
    }
    evaluate_and_empty(scan, polyhedron, &list, counters);
}

// Polyhedra of a list until a vector is full.
typedef struct SlenderQueue {
    uint numbers[2 * LANES];
    uint count;
} SlenderQueue;

// Takes the first LANES polyhedra of the queue, or all if there are fewer.
static inline void scan_queue(const SlenderScan* scan, float bound, float slack, __private SlenderQueue* queue,
                              __global const Polyhedron* polyhedra, __private ulong* counters) {
    const uint count = min(queue->count, (uint)LANES);
    for (uint n = count; n < LANES; ++n)
        queue->numbers[n] = queue->numbers[0];  // padding lanes; their results are discarded
    SlenderPolyhedra slender;
    uint present = bound_slender(scan->layout, polyhedra, queue->numbers, scan->first, bound, slack, &slender);
    present &= (1u << count) - 1;
#ifdef COUNT
    counters[CLSDF_COUNT_BRICK_PAIRS] += popcount(present);
#endif
    for (; present; present &= present - 1) {
        const uint lane = lowest_bit(present);
        scan_slender(scan, queue->numbers[lane], &slender, lane, counters);
    }
    queue->count -= count;
    store_lanes(load_lanes(0, queue->numbers + LANES), 0, queue->numbers);
}

// Lowers the minima of a coarse brick's samples to the distances of the slender polyhedra in its list. Writes the
// numbers of the other polyhedra to `others`, which has room for one more vector, and returns their count.
static inline uint scan_slender_polyhedra(Layout layout, int3 coarse, uint count, __global const uint* entries,
                                          float bound, float slack, __global const Polyhedron* polyhedra,
                                          __global Minimum* minima, __global uint* others, __private ulong* counters) {
    const SlenderScan scan = {layout,
                              coarse * CLSDF_COARSE,
                              splitting_rounder(longest_spacing(layout)),
                              half_height(bound, margin_of(slack)),
                              polyhedra,
                              minima};
    const PartOfCoarse part = part_of_coarse(layout, coarse);
    SlenderQueue queue;
    queue.count = 0;
    uint other_count = 0;
    for (uint e = 0; e < count; e += LANES) {
        uint numbers[LANES];
        load_numbers(entries, e, count, numbers);
        for (uint ahead = e + LANES; ahead < min(count, e + 2 * LANES); ++ahead)
            prefetch_record(polyhedra + entries[ahead]);
        const uint in_list = lanes_in_list(e, count);
        uint absent;
        const uint chosen =
            in_list & choose_slender(layout, polyhedra, numbers, scan.first, &part, bound, slack, &absent);
        const uint other = in_list & ~(chosen | absent);
        const uintL all = load_lanes(0, numbers);
        store_lanes(packed(all, other), 0, others + other_count);
        store_lanes(packed(all, chosen), 0, queue.numbers + queue.count);
        other_count += popcount(other);
        queue.count += popcount(chosen);
        const uint wanted = e + LANES < count ? LANES : 1;  // at the end all of them
        while (queue.count >= wanted) scan_queue(&scan, bound, slack, &queue, polyhedra, counters);
    }
    return other_count;
}

#endif
