// The minima of a brick's samples by one work-group: it chooses the polyhedra that overlap the brick, finds the
// sub-blocks that they overlap, a batch at a time, and evaluates them there (bricks_by_group.cl).
#ifndef CLSDF_GROUP_BATCHES_H
#define CLSDF_GROUP_BATCHES_H

#include "distance.h"
#include "overlap.h"
#include "simd.h"

// Sub-blocks of 2 x 2 x 2 samples; those of the body for processors are larger (subblocks.h).
#define SMALL_SUBBLOCKS 64
#define SMALL_SUBBLOCK_SAMPLES 8
#define SAMPLES_PER_ITEM (512 / GROUP)

#define BATCH 64                  // polyhedra that are evaluated together
#define BATCH_WORDS (BATCH / 32)  // with a bit for each
#define WINDOW CLSDF_WINDOW(GROUP)
#define WINDOW_WORDS (WINDOW / 32)
#define ROOM (WINDOW + 2 * GROUP)  // for chosen polyhedra
#define OCTANTS 8                  // 4 x 4 x 4 samples of a brick: eight sub-blocks
#define PAIRS (BATCH * OCTANTS)

// Sample `lane` of sub-block b, from the brick's first sample.
INLINE int3 sample_of(uint b, uint lane) {
    return 2 * four_cubed(b) + (int3)(lane & 1u, (lane >> 1) & 1u, lane >> 2);
}

// The centre of sub-block b, relative to the brick's.
INLINE float3 subblock_centre(uint b) {
    return convert_float3(four_cubed(b)) * 2.0f - 3.0f;
}
// An octant's first sub-block, and its n-th.
INLINE uint first_subblock(uint octant) {
    return (octant & 1u) * 2 + (octant >> 1 & 1u) * 8 + (octant >> 2) * 32;
}
INLINE uint subblock_of(uint octant, uint n) {
    return first_subblock(octant) + (n & 1u) + (n >> 1 & 1u) * 4 + (n >> 2) * 16;
}

// The number of bits set below bit n, and in all words.
INLINE uint bits_below(__local const uint* words, uint n) {
    uint count = popcount(words[n / 32] & ((1u << n % 32) - 1));
    for (uint w = 0; w < n / 32; ++w) count += popcount(words[w]);
    return count;
}
INLINE uint count_bits(__local const uint* words, uint word_count) {
    uint count = 0;
    for (uint w = 0; w < word_count; ++w) count += popcount(words[w]);
    return count;
}

// Polyhedra that are evaluated together, in local memory.
typedef struct Batch {
    float3 feet[BATCH];      // from the foot of the altitude to the brick's centre
    Offsets offsets[BATCH];  // at the brick's centre
    Steps steps[BATCH];
    Extent extent[BATCH];  // a sub-block's, without slack
} Batch;

#ifdef NEAREST
// The minimum of each sample. It is in local memory, because the loop that finishes samples is not unrolled: an index
// into private arrays would move them to memory.
typedef struct BrickMinima {
    float squared[512];
    uint polyhedron[512];
} BrickMinima;
#endif

// A brick's work in local memory.
typedef struct Work {
    uint chosen[ROOM];                               // polyhedra
    uint words[WINDOW_WORDS];                        // bits of a window's entries
    uint bounds[SMALL_SUBBLOCKS];                    // floats as bits, so that atomics know them
    uint overlapped[SMALL_SUBBLOCKS * BATCH_WORDS];  // by sub-block, bits of a batch's polyhedra
    union {
        Batch batch;
#ifdef NEAREST
        BrickMinima minima;  // when all batches have been evaluated
#endif
    } room;
    uint octants[PAIRS / 32];  // bits of a polyhedron and an octant that overlap
    ushort pairs[PAIRS];       // the same, listed
} Work;

// The properties of a brick that the functions below read.
typedef struct Brick {
    int3 first;  // sample
    float3 spacing;
    float bound, slack;
    float radius;  // a sub-block's, with slack
} Brick;

// Chooses those of entries [begin, end), a window at most, that overlap brick b; returns how many are chosen now. A
// window that follows may begin at once.
static inline uint choose_window(uint begin, uint end, uint b, __global const ulong* masks,
                                 __global const uint* entries, uint count, __local Work* work) {
    const uint item = get_local_id(0);
    if (item < WINDOW_WORDS) work->words[item] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint n = item; n < WINDOW; n += GROUP)
        if (begin + n < end && (masks[begin + n] >> b & 1u)) atomic_or(work->words + n / 32, 1u << n % 32);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint n = item; n < WINDOW; n += GROUP)
        if (work->words[n / 32] >> n % 32 & 1u) work->chosen[count + bits_below(work->words, n)] = entries[begin + n];
    const uint all = count + count_bits(work->words, WINDOW_WORDS);
    barrier(CLK_LOCAL_MEM_FENCE);
    return all;
}

// Lowers the sub-blocks' bounds by the feet of the chosen polyhedra.
static inline void lower_bounds_by_feet(Layout layout, Brick brick, uint count, __global const Polyhedron* polyhedra,
                                        __local Work* work) {
    const uint item = get_local_id(0), b = item % SMALL_SUBBLOCKS;
    const float3 centre = subblock_centre(b) * brick.spacing;
    float least = INFINITY;
    for (uint begin = 0; begin < count; begin += BATCH) {
        const uint length = min(count - begin, (uint)BATCH);
        if (item < length)
            work->room.batch.feet[item] = from_foot_to(layout, polyhedra + work->chosen[begin + item], brick.first.x,
                                                       brick.first.y, brick.first.z, BRICK_CENTRE);
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint n = item / SMALL_SUBBLOCKS; n < length; n += GROUP / SMALL_SUBBLOCKS) {
            const float3 from_foot = work->room.batch.feet[n] + centre;
            const float square = dot(from_foot, from_foot);
            least = LESSER(square, least);
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    atomic_min(work->bounds + b, as_uint(sqrt(least) * (1.0f + 1.0e-5f) + brick.radius));
}

// Prepares `length` chosen polyhedra for tests and distances.
static inline void load_batch(Brick brick, __local const uint* chosen, uint length,
                              __global const Polyhedron* polyhedra, __local Work* work) {
    const uint item = get_local_id(0);
    const double centre = 0.5 * (CLSDF_BRICK - 1);
    if (item < length) {
        __global const Polyhedron* p = polyhedra + chosen[item];
        work->room.batch.offsets[item] =
            offsets_at(p, brick.first.x + centre, brick.first.y + centre, brick.first.z + centre);
        work->room.batch.steps[item] = steps_of(p);
        work->room.batch.extent[item] = extent_of_cube(p, 0.5f);
    }
    for (uint n = item; n < SMALL_SUBBLOCKS * BATCH_WORDS; n += GROUP) work->overlapped[n] = 0;
    for (uint n = item; n < PAIRS / 32; n += GROUP) work->octants[n] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
}

INLINE Extent scaled(Extent r, float factor) {
    const Extent product = {factor * r.x,    factor * r.y,         factor * r.z,        factor * r.right,
                            factor * r.left, factor * r.right_end, factor * r.left_end, factor * r.apex};
    return product;
}

// Lists the pairs of a polyhedron of the batch and an octant that overlap; returns how many. A work-item tests one pair
// at a time.
static inline uint list_octants(Brick brick, __local const uint* chosen, uint length,
                                __global const Polyhedron* polyhedra, __local Work* work) {
    const uint item = get_local_id(0);
    for (uint pair = item; pair < length * OCTANTS; pair += GROUP) {
        const uint n = pair / OCTANTS, octant = pair % OCTANTS;
        __global const Polyhedron* p = polyhedra + chosen[n];
        const FramePosition position = work->room.batch.offsets[n].at;
        const Extent extent = scaled(work->room.batch.extent[n], 3.0f);
        const float3 centre = subblock_centre(first_subblock(octant)) + 1.0f;
        const Centres c = centres_of(p, position, centre.x, centre.y, centre.z);
        float bound = 0.0f;
        for (uint b = 0; b < 8; ++b) bound = GREATER(as_float(work->bounds[subblock_of(octant, b)]), bound);
        if (overlapped_near_blocks(p, position, slopes_of(p, c.z, extent.z, brick.slack), c,
                                   widened(extent, brick.slack), bound))
            atomic_or(work->octants + pair / 32, 1u << pair % 32);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint pair = item; pair < length * OCTANTS; pair += GROUP)
        if (work->octants[pair / 32] >> pair % 32 & 1u) work->pairs[bits_below(work->octants, pair)] = (ushort)pair;
    barrier(CLK_LOCAL_MEM_FENCE);
    return count_bits(work->octants, PAIRS / 32);
}

// Sets the bits of the sub-blocks that the polyhedra overlap. A work-item takes one listed pair at a time.
static inline void find_subblocks(Brick brick, __local const uint* chosen, uint pairs,
                                  __global const Polyhedron* polyhedra, __local Work* work) {
    for (uint listed = get_local_id(0); listed < pairs; listed += GROUP) {
        const uint n = work->pairs[listed] / OCTANTS, octant = work->pairs[listed] % OCTANTS;
        __global const Polyhedron* p = polyhedra + chosen[n];
        const FramePosition position = work->room.batch.offsets[n].at;
        const Extent extent = work->room.batch.extent[n], wide = widened(extent, brick.slack);
        const float3 first = subblock_centre(first_subblock(octant));
        const Centres middle = centres_of(p, position, first.x + 1.0f, first.y + 1.0f, first.z + 1.0f);
        const Slopes slopes = slopes_of(p, middle.z, 3.0f * extent.z, brick.slack);
        for (uint i = 0; i < 8; ++i) {
            const uint b = subblock_of(octant, i);
            const float3 at = subblock_centre(b);
            if (overlapped_near_blocks(p, position, slopes, centres_of(p, position, at.x, at.y, at.z), wide,
                                       as_float(work->bounds[b])))
                atomic_or(work->overlapped + b * BATCH_WORDS + n / 32, 1u << n % 32);
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// A work-item's samples.
typedef struct ItemMinimum {
    float squared[SAMPLES_PER_ITEM];
#ifdef NEAREST
    uint polyhedron[SAMPLES_PER_ITEM];
#endif
} ItemMinimum;

#ifdef NEAREST
// Whether a polyhedron's triangle is the nearer one. If two are equally near, the first in the caller's order is taken.
static inline bool is_nearer(float squared, uint polyhedron, float least, uint nearest,
                             __global const Polyhedron* polyhedra) {
    if (squared != least || nearest == CLSDF_NO_POLYHEDRON) return squared < least;
    return polyhedra[polyhedron].triangle < polyhedra[nearest].triangle;
}
#endif

// The distances from the work-item's samples to a batch's polyhedra, in the sub-blocks that they overlap.
static inline void evaluate(Layout layout, Brick brick, __local const uint* chosen, __local const Work* work,
                            __global const Polyhedron* polyhedra, __private ItemMinimum* minimum,
                            __private uint* counters) {
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        const uint number = s * GROUP + get_local_id(0), b = number / SMALL_SUBBLOCK_SAMPLES;
        const float3 from_centre = convert_float3(sample_of(b, number % SMALL_SUBBLOCK_SAMPLES)) - BRICK_CENTRE;
        float least = minimum->squared[s];
#ifdef NEAREST
        uint nearest = minimum->polyhedron[s];
#endif
        for (uint w = 0; w < BATCH_WORDS; ++w)
            for (uint rest = work->overlapped[b * BATCH_WORDS + w]; rest; rest &= rest - 1) {
                const uint n = w * 32 + lowest_bit(rest);
                const Offsets o = work->room.batch.offsets[n];
#if defined(LONG_BRICKS) || defined(NEAREST) || defined(COUNT)
                __global const Polyhedron* p = polyhedra + chosen[n];
#endif
#ifdef LONG_BRICKS
                const double centre = 0.5 * (CLSDF_BRICK - 1);
                const double4 frame =
                    frame_at(p, brick.first.x + centre, brick.first.y + centre, brick.first.z + centre);
                const float squared =
                    squared_distance_long_brick(p, frame, from_centre.x, from_centre.y, from_centre.z);
#else
                const float squared =
                    squared_distance(work->room.batch.steps[n], o, from_centre.x, from_centre.y, from_centre.z);
#endif
#ifdef NEAREST
                const bool better = is_nearer(squared, chosen[n], least, nearest, polyhedra);
                nearest = better ? chosen[n] : nearest;
                least = better ? squared : least;
#else
                least = LESSER(squared, least);
#endif
#ifdef COUNT
                const float slack = layout.half_width * layout.slack_rate + layout.brick_slack;
                ++counters[CLSDF_COUNT_LANES];
                counters[CLSDF_COUNT_COVERED] +=
                    covered_samples(p, o, from_centre.x, from_centre.y, from_centre.z, layout.half_width, slack) & 1u;
#endif
            }
        minimum->squared[s] = least;
#ifdef NEAREST
        minimum->polyhedron[s] = nearest;
#endif
    }
}

// Lowers the sub-blocks' bounds to the distances that were found.
static inline void lower_bounds_by_minima(__private const ItemMinimum* minimum, __local Work* work) {
    const uint item = get_local_id(0);
    __local uint* greatest = work->overlapped;  // which has been evaluated
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < SMALL_SUBBLOCKS) greatest[item] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s)
        atomic_max(greatest + (s * GROUP + item) / SMALL_SUBBLOCK_SAMPLES, as_uint(minimum->squared[s]));
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < SMALL_SUBBLOCKS) {
        const float reached = sqrt(as_float(greatest[item])), bound = as_float(work->bounds[item]);
        work->bounds[item] = as_uint(LESSER(reached, bound));
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// Takes all chosen polyhedra into the minima.
static inline void evaluate_chosen(Layout layout, Brick brick, uint count, __global const Polyhedron* polyhedra,
                                   __local Work* work, __private ItemMinimum* minimum, __private uint* counters) {
    lower_bounds_by_feet(layout, brick, count, polyhedra, work);
    for (uint begin = 0; begin < count; begin += BATCH) {
        if (begin > 0) lower_bounds_by_minima(minimum, work);
        const uint length = min(count - begin, (uint)BATCH);
        load_batch(brick, work->chosen + begin, length, polyhedra, work);
        const uint pairs = list_octants(brick, work->chosen + begin, length, polyhedra, work);
        find_subblocks(brick, work->chosen + begin, pairs, polyhedra, work);
        evaluate(layout, brick, work->chosen + begin, work, polyhedra, minimum, counters);
    }
}

#ifdef NEAREST
static inline void keep_minima(__private const ItemMinimum* minimum, __local BrickMinima* minima) {
    barrier(CLK_LOCAL_MEM_FENCE);  // the batch that was there has been evaluated
#pragma unroll
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        minima->squared[s * GROUP + get_local_id(0)] = minimum->squared[s];
        minima->polyhedron[s * GROUP + get_local_id(0)] = minimum->polyhedron[s];
    }
}
#endif

#endif
