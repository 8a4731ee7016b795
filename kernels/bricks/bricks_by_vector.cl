// The seven-site distance of every sample near the mesh: one work-item takes coarse bricks from a queue, the costliest
// first, and carries each through all finer levels, so that lists of (polyhedron, brick) pairs never leave the cache.
//
// * coarse brick: the distances of slender polyhedra (slender_scan.h), which no finer level sees; for each
//   brick an upper bound of the distance, and masks of the other polyhedra that overlap it;
// * brick: its list; of LANES polyhedra at a time, masks of the sub-blocks (16 samples each) that they overlap;
// * sub-block: the distance to the triangle of each polyhedron that overlaps it, into the minimum.
//
// A long list is divided in parts of CLSDF_LIST_PART polyhedra, as many as the cache of a core holds. Each part goes
// through all levels; the minima stay in memory in between.
//
// Compile-time options: LANES (simd.h). NEAREST keeps the nearest polyhedron and finishes other outputs (finish.h).
// LONG_BRICKS: spacing is so unequal that distances take double (distance.h); no polyhedron is slender.
// SCATTERED_ACCESS: gather and scatter are fast. COUNT counts work.

#include "brick_distance.h"
#include "brick_lists.h"
#include "lane_offsets.h"
#include "simd.h"
#include "slender_scan.h"
#include "write_bricks.h"

// The upper bounds of a brick are lowered after so many polyhedra of its list.
#define CHUNK 64

// Upper bounds of the distance for the samples of each of a brick's sub-blocks: the distance of its centre to the
// surface point nearest to the brick's centre, and its radius.
static inline void subblock_bounds(Layout layout, int3 first, __global const Polyhedron* nearest, float brick_bound,
                                   __private float* bounds) {
    const float3 spacing = vload3(0, layout.spacing);
    const float3 from_foot = from_foot_to(layout, nearest, first.x, first.y, first.z, BRICK_CENTRE);
    const float3 half_sides = 0.5f * (float3)(SUBBLOCK_X - 1, 1.0f, 1.0f) * spacing;
    const float radius = sqrt(dot(half_sides, half_sides)) * (1.0f + 1.0e-5f) + layout.brick_slack;
    for (uint v = 0; v < SUBBLOCK_PLANE / LANES; ++v) {
        const floatL y = subblocks_j(v) * spacing.y + from_foot.y;
        const floatL z = subblocks_k(v) * spacing.z + from_foot.z;
        const floatL squared = y * y + z * z;
        for (uint plane = 0; plane < SUBBLOCK_PLANES; ++plane) {
            const float x = subblock_i(plane) * spacing.x + from_foot.x;
            const floatL bound = sqrt(squared + x * x) * (1.0f + 1.0e-5f) + radius;
            store_lanes(LESSER(bound, brick_bound), v, bounds + plane * SUBBLOCK_PLANE);
        }
    }
}

// Polyhedra that overlap sub-blocks of a brick, collected until they fill a vector. Before enqueue() there are fewer
// than LANES; it stores a whole vector behind them.
typedef struct Queue {
    uint numbers[2 * LANES];
    SubblockMask masks[2 * LANES];
    uint count;
} Queue;

// Adds those of numbers[0, LANES) that overlap a sub-block and whose bit in `lanes` is set.
INLINE void enqueue(int3 first, __private const uint* numbers, uint lanes, __private const float* bounds, float slack,
                    __global const Polyhedron* polyhedra, __private Queue* queue) {
    const LanePolyhedra p = lane_polyhedra(polyhedra, numbers, first, BRICK_CENTRE);
    const uintL masks = overlapped_subblocks(&p, bounds, slack);
    const uint overlapping = lanes & lanes_to_bits(masks != 0);
    store_lanes(packed(load_lanes(0, numbers), overlapping), 0, queue->numbers + queue->count);
    store_lanes(packed(masks, overlapping), 0, queue->masks + queue->count);
    queue->count += popcount(overlapping);
}

// Takes the first LANES polyhedra of the queue, or all if there are fewer, into a brick's minima.
static inline void evaluate_queue(Layout layout, int3 first, __private Queue* queue,
                                  __global const Polyhedron* polyhedra, __global Minimum* minimum,
                                  __private ulong* counters) {
    const uint count = min(queue->count, (uint)LANES);
    const double centre = 0.5 * (CLSDF_BRICK - 1);
#ifndef LONG_BRICKS
    for (uint n = count; n < LANES; ++n)
        queue->numbers[n] = queue->numbers[0];  // padding lanes; their results are discarded
    LaneOffsets offsets;
    set_offsets(layout, polyhedra, queue->numbers, first, centre, &offsets);
    Displacements displacements;
    set_displacements(&offsets, 0, displacements.x);
    set_displacements(&offsets, 1, displacements.y);
    set_displacements(&offsets, 2, displacements.z);
#endif
    for (uint n = 0; n < count; ++n) {
#if defined(LONG_BRICKS) || defined(COUNT)
        __global const Polyhedron* polyhedron = polyhedra + queue->numbers[n];
        const double3 at = convert_double3(first) + centre;
#endif
#ifdef LONG_BRICKS
        evaluate_long_brick(queue->numbers[n], frame_at(polyhedron, at.x, at.y, at.z), queue->masks[n], polyhedra,
                            minimum);
#else
        evaluate(&offsets, &displacements, n, queue->masks[n], queue->numbers[n], polyhedra, minimum);
#endif
#ifdef COUNT
        count_covered(polyhedron, offsets_at(polyhedron, at.x, at.y, at.z), queue->masks[n], layout, counters);
#endif
    }
    queue->count -= count;
    if (queue->count == 0) return;  // the second half may have no values
    store_lanes(load_lanes(0, queue->numbers + LANES), 0, queue->numbers);
    store_lanes(load_lanes(0, queue->masks + LANES), 0, queue->masks);
}

// Polyhedra of a brick's list into its minima. `bound`: an upper bound of the distances of its samples, or the band's
// half width; `nearest` is a polyhedron whose foot is near the brick.
static inline void evaluate_list(Layout layout, int3 brick, uint count, __global const uint* list, float bound,
                                 __global const Polyhedron* nearest, __global const Polyhedron* polyhedra,
                                 __global Minimum* minimum, __private ulong* counters) {
    const int3 first = brick * CLSDF_BRICK;
    float bounds[SUBBLOCKS];
    subblock_bounds(layout, first, nearest, bound, bounds);
    const float slack = bound * layout.slack_rate + layout.brick_slack;
    Queue queue;
    queue.count = 0;
    for (uint e = 0; e < count; e += LANES) {
        if (e % CHUNK == 0)
            for (uint b = 0; b < SUBBLOCKS; ++b) bounds[b] = bound_of_subblock(minimum, b, bounds[b]);
        uint numbers[LANES];
        load_numbers(list, e, count, numbers);
        enqueue(first, numbers, lanes_in_list(e, count), bounds, slack, polyhedra, &queue);
        const uint wanted = e + LANES < count ? LANES : 1;  // at the end all of them
        while (queue.count >= wanted) evaluate_queue(layout, first, &queue, polyhedra, minimum, counters);
    }
#ifdef COUNT
    counters[CLSDF_COUNT_BRICK_PAIRS] += count;
#endif
}

// One entry per brick of a coarse brick (64).
typedef struct BrickBounds {
    float bound[CLSDF_COARSE_BRICKS];   // an upper bound of the distance of its samples
    uint nearest[CLSDF_COARSE_BRICKS];  // the polyhedron whose foot gave it
} BrickBounds;

// Bounds the distances in each brick: the distance from its centre to the nearest foot of an altitude, a point of the
// surface, plus the brick's radius.
static inline void find_brick_bounds(Layout layout, int3 coarse, uint count, __global const uint* entries,
                                     __global const Polyhedron* polyhedra, float coarse_bound,
                                     __private BrickBounds* bounds) {
    floatL least[CLSDF_COARSE_BRICKS / LANES];
    uintL nearest[CLSDF_COARSE_BRICKS / LANES];
    for (uint v = 0; v < CLSDF_COARSE_BRICKS / LANES; ++v) {
        least[v] = INFINITY;
        nearest[v] = entries[0];
    }
    const int3 first = coarse * CLSDF_COARSE;
    // A vector is one or half a slice of 4 x 4 bricks.
    const floatL i = convert_floatL(LANE_NUMBERS & 3u) * (CLSDF_BRICK * layout.spacing[0]);
    const floatL j = convert_floatL(LANE_NUMBERS >> 2) * (CLSDF_BRICK * layout.spacing[1]);
    // Any of the points bound the distance; of a long list a part is enough.
    const uint stride = max(count > 256 ? 2u : 1u, count / 2048);
    for (uint e = 0; e < count; e += stride) {
        if (e + 16 * stride < count) prefetch_foot(polyhedra + entries[e + 16 * stride]);
        const float3 from_foot = from_foot_to(layout, polyhedra + entries[e], first.x, first.y, first.z, BRICK_CENTRE);
        const floatL x = i + from_foot.x;
        floatL of_slice[16 / LANES];
#pragma unroll
        for (uint v = 0; v < 16 / LANES; ++v) {
            const floatL y = j + (from_foot.y + (float)(v * LANES / 4) * (CLSDF_BRICK * layout.spacing[1]));
            of_slice[v] = x * x + y * y;
        }
#pragma unroll
        for (uint v = 0; v < CLSDF_COARSE_BRICKS / LANES; ++v) {
            const float z = from_foot.z + (float)(v * LANES / 16) * (CLSDF_BRICK * layout.spacing[2]);
            const floatL squared = of_slice[v % (16 / LANES)] + z * z;
            nearest[v] = squared < least[v] ? (uintL)entries[e] : nearest[v];
            least[v] = LESSER(squared, least[v]);
        }
    }
    for (uint v = 0; v < CLSDF_COARSE_BRICKS / LANES; ++v) {
        const floatL bound = sqrt(least[v]) * (1.0f + 1.0e-5f) + (layout.brick_radius + layout.brick_slack);
        store_lanes(LESSER(bound, coarse_bound), v, bounds->bound);
        store_lanes(nearest[v], v, bounds->nearest);
    }
}

// A work-item's own memory.
typedef struct Scratch {
    LaneMask masks[CLSDF_COARSE_BRICKS * CLSDF_LIST_PART /
                   LANES];                 // from b * CLSDF_LIST_PART / LANES: of brick b, one for LANES polyhedra
    uint others[CLSDF_LIST_PART + LANES];  // that are not slender
    uint list[CLSDF_LIST_PART + LANES];    // of a brick
} Scratch;

// The host allocates CLSDF_SCRATCH_BYTES for it.
typedef char ScratchFits[sizeof(Scratch) <= CLSDF_SCRATCH_BYTES ? 1 : -1];

// When the bricks are written, it has the rows of a slice: the distances, then the outputs.
#define DISTANCE_BYTES (CLSDF_BRICK * CLSDF_COARSE * sizeof(float))
#ifdef NEAREST
typedef char SliceFits[DISTANCE_BYTES + SLICE_BYTES <= sizeof(Scratch) ? 1 : -1];
#endif

// A mask of the bricks of a coarse brick that lie in the part and are wanted.
static inline ulong bricks_of_part(Layout layout, int3 coarse, Output output) {
    const int3 brick_first = vload3(0, layout.brick_first), bricks = vload3(0, layout.bricks);
    ulong in_part = 0;
    for (uint b = 0; b < CLSDF_COARSE_BRICKS; ++b) {
        const int3 relative = brick_of_coarse(coarse, b) - brick_first;
        if (all(relative >= 0) && all(relative < bricks))
            in_part |= (ulong)(*mark_of(layout, brick_of_coarse(coarse, b), output) != CLSDF_UNWANTED_BRICK) << b;
    }
    return in_part;
}

// Returns a mask of the bricks that a chunk of the list's polyhedra overlaps. Stores a mask of these polyhedra for each
// brick.
static inline ulong list_bricks(Layout layout, int3 coarse, uint count, __global const uint* entries,
                                __private const float* bounds, float slack, __global const Polyhedron* polyhedra,
                                __global LaneMask* masks) {
    ulong any = 0;
    for (uint e = 0; e < count; e += LANES) {
        uint numbers[LANES];
        load_numbers(entries, e, count, numbers);
        for (uint ahead = e + LANES; ahead < min(count, e + 2 * LANES); ++ahead)
            prefetch_record(polyhedra + entries[ahead]);
        const LanePolyhedra p = lane_polyhedra(polyhedra, numbers, coarse * CLSDF_COARSE, COARSE_CENTRE);
        any |=
            overlapped_bricks(&p, bounds, slack, lanes_in_list(e, count), masks + e / LANES, CLSDF_LIST_PART / LANES);
    }
    return any;
}

// Polyhedra of a coarse brick's list into the minima of its bricks `in_part`.
static inline void evaluate_bricks(Layout layout, int3 coarse, ulong in_part, uint count, __global const uint* entries,
                                   float slack, __private BrickBounds* bounds, __global const Polyhedron* polyhedra,
                                   __global Scratch* scratch, __global Minimum* minima, __private ulong* counters) {
    for (uint b = 0; b < CLSDF_COARSE_BRICKS; ++b) bounds->bound[b] = bound_of_brick(minima + b, bounds->bound[b]);
    ulong rest = in_part & list_bricks(layout, coarse, count, entries, bounds->bound, slack, polyhedra, scratch->masks);
    for (; rest; rest &= rest - 1) {
        const uint b = lowest_bit_of_long(rest);
        const uint chosen =
            choose_masked(count, entries, scratch->masks + b * (CLSDF_LIST_PART / LANES), scratch->list);
        evaluate_list(layout, brick_of_coarse(coarse, b), chosen, scratch->list, bounds->bound[b],
                      polyhedra + bounds->nearest[b], polyhedra, minima + b, counters);
    }
}

// The minima are clear before and after.
static inline void compute_coarse_brick(Layout layout, int3 coarse, uint count, __global const uint* entries,
                                        float coarse_bound, __global const Polyhedron* polyhedra,
                                        __global Scratch* scratch, __global Minimum* minima, Output output,
                                        __private ulong* counters) {
    const ulong in_part = bricks_of_part(layout, coarse, output);
    const float slack = coarse_bound * layout.slack_rate + layout.brick_slack;
    BrickBounds bounds;
    bool has_bounds = false;
    for (uint begin = 0; begin < count; begin += CLSDF_LIST_PART) {
        __global const uint* list = entries + begin;
        uint length = min(count - begin, (uint)CLSDF_LIST_PART);
#ifndef LONG_BRICKS
        length = scan_slender_polyhedra(layout, coarse, length, list, coarse_bound, slack, polyhedra, minima,
                                        scratch->others, counters);
        list = scratch->others;
#endif
        if (length == 0) continue;
        if (!has_bounds) find_brick_bounds(layout, coarse, count, entries, polyhedra, coarse_bound, &bounds);
        has_bounds = true;
        evaluate_bricks(layout, coarse, in_part, length, list, slack, &bounds, polyhedra, scratch, minima, counters);
    }
    ulong used = 0;
    for (uint b = 0; b < CLSDF_COARSE_BRICKS; ++b) used |= (ulong)has_distances(minima + b) << b;
    const ulong written = write_used(layout, coarse, used, in_part, minima, output, counters);
    // Slender polyhedra may also have samples in bricks beyond the part.
    for (used &= ~written; used; used &= used - 1) clear_minimum(minima + lowest_bit_of_long(used));
}

// Global size: as many as there are scratch and minima for. Each work-item takes coarse brick order[begin +
// next_slot[launch]++] until `end`; the counters are 0 at first.
__kernel void bricks_by_vector(Layout layout, uint launch, uint begin, uint end, __global uint* next_slot,
                               __global const uint* order, __global const uint* starts, uint parts,
                               __global const uint* entries, __global const float* coarse_bounds,
                               __global const Polyhedron* polyhedra, __global const uint* sign_bits,
                               __global uchar* computed, __global Scratch* all_scratch, __global Minimum* all_minima,
                               __global uint* listed, __global float* distance
#ifdef NEAREST
                               ,
                               FINISHING_PARAMETERS
#endif
#ifdef COUNT
                               ,
                               __global ulong* all_counters
#endif
) {
    const size_t item = get_global_id(0);
    __global Scratch* scratch = all_scratch + item;
    __global Minimum* minima = all_minima + item * CLSDF_COARSE_BRICKS;
    for (uint b = 0; b < CLSDF_COARSE_BRICKS; ++b) clear_minimum(minima + b);
    ulong counters[CLSDF_COUNTERS] = {0};
    Output output;
    output.distance = distance;
#ifdef NEAREST
    SET_FINISHING(finishing)
    Slice slice;
    set_slice(&finishing, (__global uchar*)scratch + DISTANCE_BYTES, &slice);
    output.finishing = &finishing;
    output.slice = &slice;
#endif
    output.rows = (__global uint*)scratch;
    output.computed = computed;
    output.sign_bits = sign_bits;
    output.listed = listed;
    for (;;) {
        const uint slot = begin + atomic_inc(next_slot + launch);
        if (slot >= end) break;
        const uint number = order[slot];
        const uint list = starts[number * parts], count = starts[(number + 1) * parts] - list;
        const int3 coarse = coarse_brick_at(layout, number);
        compute_coarse_brick(layout, coarse, count, entries + list,
                             coarse_bounds[coarse_bound_index(layout, coarse.x, coarse.y, coarse.z)], polyhedra,
                             scratch, minima, output, counters);
    }
    finish_lines();
#ifdef COUNT
    for (uint c = 0; c < CLSDF_COUNTERS; ++c) all_counters[item * CLSDF_COUNTERS + c] += counters[c];
#endif
}
