// The seven-site distance of every sample near the mesh, for GPUs: a work-group computes a brick of 8 x 8 x 8 samples
// from the list of its coarse brick.
//
// 1. An upper bound of the brick's distances (cap), by a reduction over the list.
// 2. GROUP polyhedra of the list at a time, one a work-item: does it touch the brick, and which of its 16 sub-blocks of
//    4 x 4 x 2 samples? Those that do are compacted into local memory, in the order of the list.
// 3. When local memory is full, or the list ends: each work-item carries its samples through the compacted polyhedra.
//    The 32 work-items of a sub-block are neighbours, so that they take the same branches.
//
// Nothing is atomic, and every group's order is that of its list: the result does not depend on how groups are
// scheduled.
//
// Compile-time options: GROUP, work-items a group, a power of two from 64 to 256; NEAREST keeps the nearest polyhedron
// and finishes what else is asked for (finish.h); LONG_BRICKS where spacing is so unequal that distances take double
// (distance.h); COUNT counts work. LANES is 1: a work-item is a lane.

#include "blocks.h"
#include "distance.h"
#ifdef NEAREST
#include "finish.h"
#endif
#include "signed_distance.h"

#define SUBBLOCKS 16
#define SUBBLOCK_SAMPLES 32
#define SAMPLES_PER_ITEM (512 / GROUP)
#define CAPACITY (2 * GROUP)

// Sample `lane` of sub-block b, from the brick's first sample.
static inline int3 sample_of(uint b, uint lane) {
    return (int3)((b & 1u) * 4 + (lane & 3u), ((b >> 1) & 1u) * 4 + ((lane >> 2) & 3u), (b >> 2) * 2 + (lane >> 4));
}

// The sub-blocks that a polyhedron touches, 16 bits.
static inline uint touched_subblocks(__global const Polyhedron* p, Place place, Slopes slopes, float cap, float slack) {
    const Reach reach = widened(reach_of(p, 1.5f, 1.5f, 0.5f), slack);
    uint touched = 0;
    for (uint b = 0; b < SUBBLOCKS; ++b) {
        const float i = (float)((b & 1u) * 4) - 2.0f, j = (float)(((b >> 1) & 1u) * 4) - 2.0f,
                    k = (float)((b >> 2) * 2) - 3.0f;
        touched |= touched_near_blocks(p, place, slopes, centres_of(p, place, i, j, k), reach, cap) << b;
    }
    return touched;
}

// Exclusive prefix sum of one value a work-item, and the total. Each step reads one half of `sums`, of 2 GROUP values,
// and writes the other: no value read before a barrier is used after it. The next scan may begin after a barrier.
static inline uint group_scan(uint value, __local uint* sums, __private uint* total) {
    const uint item = get_local_id(0);
    uint from = 0;
    sums[item] = value;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint step = 1; step < GROUP; step *= 2) {
        const uint other = item >= step ? sums[from + item - step] : 0;
        sums[(GROUP - from) + item] = sums[from + item] + other;
        from = GROUP - from;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    *total = sums[from + GROUP - 1];
    return sums[from + item] - value;
}

// The least of one value a work-item.
static inline float group_least(float value, __local float* values) {
    const uint item = get_local_id(0);
    values[item] = value;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint half_size = GROUP / 2; half_size > 0; half_size /= 2) {
        if (item < half_size) values[item] = LESSER(values[item], values[item + half_size]);
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    const float least = values[0];
    barrier(CLK_LOCAL_MEM_FENCE);
    return least;
}

// Polyhedra of the brick, compacted.
typedef struct Compacted {
    Offsets offsets[CAPACITY];
    uint polyhedron[CAPACITY];
    uint subblocks[CAPACITY];
} Compacted;

// A work-item's samples.
typedef struct Minimum {
    float squared[SAMPLES_PER_ITEM];
#ifdef NEAREST
    uint polyhedron[SAMPLES_PER_ITEM];
#endif
} Minimum;

#ifdef NEAREST
// Whether a polyhedron's triangle is the nearer one. Of those that are equally near the first in the caller's order is.
static inline bool is_nearer(float squared, uint polyhedron, float least, uint nearest,
                             __global const Polyhedron* polyhedra) {
    if (squared != least || nearest == CLSDF_NO_POLYHEDRON) return squared < least;
    return polyhedra[polyhedron].triangle < polyhedra[nearest].triangle;
}
#endif

static inline void evaluate(uint count, __local const Compacted* compacted, __global const Polyhedron* polyhedra,
                            double3 centre, __private Minimum* minimum
#ifdef COUNT
                            ,
                            float half_width, float slack, __private uint* counters
#endif
) {
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        const uint number = s * GROUP + get_local_id(0);
        const uint b = number / SUBBLOCK_SAMPLES;
        const float3 from_centre = convert_float3(sample_of(b, number % SUBBLOCK_SAMPLES)) - 3.5f;
        float least = minimum->squared[s];
#ifdef NEAREST
        uint nearest = minimum->polyhedron[s];
#endif
        for (uint n = 0; n < count; ++n) {
            if (!((compacted->subblocks[n] >> b) & 1u)) continue;
            const Offsets o = compacted->offsets[n];
            __global const Polyhedron* p = polyhedra + compacted->polyhedron[n];
#ifdef LONG_BRICKS
            const float squared = squared_distance_long_brick(p, frame_at(p, centre.x, centre.y, centre.z),
                                                              from_centre.x, from_centre.y, from_centre.z);
#else
            const float squared = squared_distance(steps_of(p), o, from_centre.x, from_centre.y, from_centre.z);
#endif
#ifdef NEAREST
            const bool better = is_nearer(squared, compacted->polyhedron[n], least, nearest, polyhedra);
            nearest = better ? compacted->polyhedron[n] : nearest;
            least = better ? squared : least;
#else
            least = LESSER(squared, least);
#endif
#ifdef COUNT
            ++counters[CLSDF_COUNT_LANES];
            counters[CLSDF_COUNT_COVERED] +=
                covered_samples(p, o, from_centre.x, from_centre.y, from_centre.z, half_width, slack) & 1u;
#endif
        }
        minimum->squared[s] = least;
#ifdef NEAREST
        minimum->polyhedron[s] = nearest;
#endif
    }
}

// Global size: 64 groups for each coarse brick order[begin, ...) of the launch.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void bricks_by_group(
    Layout layout, uint begin, __global const uint* order, __global const uint* starts, uint parts,
    __global const uint* entries, __global const float* coarse_caps, __global const Polyhedron* polyhedra,
    __global const uint* sign_bits, __global uchar* computed, __global float* distance
#ifdef NEAREST
    ,
    FINISHING_PARAMETERS
#endif
#ifdef COUNT
    ,
    __global ulong* all_counters  // a set for each group, numbered over all launches
#endif
) {
    __local Compacted compacted;
    __local uint sums[2 * GROUP];
    __local float least_values[GROUP];
    const uint item = get_local_id(0);
    const uint number = order[begin + get_group_id(0) / 64], b = get_group_id(0) % 64;
    const int3 first_coarse = vload3(0, layout.coarse_first), coarse_bricks = vload3(0, layout.coarse_bricks);
    const int3 brick_first = vload3(0, layout.brick_first), bricks = vload3(0, layout.bricks);
    const int3 coarse = first_coarse + (int3)(number % coarse_bricks.x, number / coarse_bricks.x % coarse_bricks.y,
                                              number / (coarse_bricks.x * coarse_bricks.y));
    const int3 brick = coarse * CLSDF_BRICKS_PER_COARSE + (int3)(b & 3u, (b >> 2) & 3u, b >> 4);
    const int3 relative_brick = brick - brick_first;
    if (any(relative_brick < 0) || any(relative_brick >= bricks)) return;

    const uint list_begin = starts[number * parts], list_end = starts[(number + 1) * parts];
    const int3 first = brick * CLSDF_BRICK;
    const double centre = 0.5 * (CLSDF_BRICK - 1);
    const double x = first.x + centre, y = first.y + centre, z = first.z + centre;

    // The nearest of the surface points that the brick knows: the feet of the altitudes.
    float least_square = INFINITY;
    for (uint e = list_begin + item; e < list_end; e += GROUP) {
        const float3 from_foot =
            from_foot_to(layout, polyhedra + entries[e], first.x, first.y, first.z, 0.5f * (CLSDF_BRICK - 1));
        const float square = dot(from_foot, from_foot);
        least_square = LESSER(square, least_square);
    }
    const float bound =
        sqrt(group_least(least_square, least_values)) * (1.0f + 1.0e-5f) + (layout.brick_radius + layout.brick_slack);
    const float coarse_cap = coarse_caps[coarse_cap_place(layout, coarse.x, coarse.y, coarse.z)];
    const float cap = LESSER(bound, coarse_cap);
    const float slack = cap * layout.slack_rate + layout.brick_slack;

    Minimum minimum;
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        minimum.squared[s] = INFINITY;
#ifdef NEAREST
        minimum.polyhedron[s] = CLSDF_NO_POLYHEDRON;
#endif
    }
#ifdef COUNT
    uint counters[CLSDF_COUNTERS] = {0, 0, 0, 0};
    __local uint group_counters[CLSDF_COUNTERS];
    if (item < CLSDF_COUNTERS) group_counters[item] = 0;
#endif
    uint count = 0;
    for (uint e = list_begin; e < list_end; e += GROUP) {
        uint subblocks = 0;
        uint polyhedron = 0;
        if (e + item < list_end) {
            polyhedron = entries[e + item];
            __global const Polyhedron* p = polyhedra + polyhedron;
            const Place place = place_at(p, first.x, first.y, first.z, 0.5f * (CLSDF_BRICK - 1));
            const Reach reach = reach_of_cube(p, 0.5f * (CLSDF_BRICK - 1));
            if (touched_blocks(p, place, centres_of(p, place, 0.0f, 0.0f, 0.0f), widened(reach, slack), cap))
                subblocks = touched_subblocks(p, place, slopes_of(p, place.z, reach.z, slack), cap, slack);
        }
        uint total;
        const uint slot = count + group_scan(subblocks != 0, sums, &total);
        if (subblocks != 0) {
            compacted.offsets[slot] = offsets_at(polyhedra + polyhedron, x, y, z);
            compacted.polyhedron[slot] = polyhedron;
            compacted.subblocks[slot] = subblocks;
        }
        count += total;
        barrier(CLK_LOCAL_MEM_FENCE);
        if (count + GROUP > CAPACITY || e + GROUP >= list_end) {
#ifdef COUNT
            if (item == 0) counters[CLSDF_COUNT_BRICK_PAIRS] += count;
#endif
            evaluate(count, &compacted, polyhedra, (double3)(x, y, z), &minimum
#ifdef COUNT
                     ,
                     layout.half_width, layout.half_width * layout.slack_rate + layout.brick_slack, counters
#endif
            );
            count = 0;  // the next scan's barriers come before what is compacted next
        }
    }

#ifdef NEAREST
    SET_FINISHING(finishing)
#endif
    const int3 part_first = vload3(0, layout.first), size = vload3(0, layout.size);
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        const uint sample = s * GROUP + item;
        const int3 in_brick = sample_of(sample / SUBBLOCK_SAMPLES, sample % SUBBLOCK_SAMPLES);
        const int3 at = brick * CLSDF_BRICK + in_brick - part_first;
        if (any(at < 0) || any(at >= size)) continue;
        const size_t bit_row = (size_t)(relative_brick.z * CLSDF_BRICK + in_brick.z) * (bricks.y * CLSDF_BRICK) +
                               (relative_brick.y * CLSDF_BRICK + in_brick.y);
        const uint bit = relative_brick.x * CLSDF_BRICK + in_brick.x;
        const bool negative = (sign_bits[bit_row * layout.sign_words + bit / 32] >> (bit % 32)) & 1u;
        const size_t offset = ((size_t)at.z * size.y + at.y) * size.x + at.x;
        bool in_band;
        distance[offset] = signed_distance(layout, negative, minimum.squared[s], &in_band);
#ifdef NEAREST
        if (in_band && minimum.polyhedron[s] != CLSDF_NO_POLYHEDRON)
            finish_sample(&finishing, at + part_first, minimum.polyhedron[s], negative, offset);
        else
            leave_sample(&finishing, offset);
#endif
#ifdef COUNT
        counters[CLSDF_COUNT_BAND] += in_band;
#endif
    }
    if (item == 0) computed[((size_t)relative_brick.z * bricks.y + relative_brick.y) * bricks.x + relative_brick.x] = 1;
#ifdef COUNT
    for (uint c = 0; c < CLSDF_COUNTERS; ++c) atomic_add(group_counters + c, counters[c]);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < CLSDF_COUNTERS)
        all_counters[(begin * 64 + get_group_id(0)) * CLSDF_COUNTERS + item] = group_counters[item];
#endif
}
