// The seven-site distance of every sample near the mesh, for GPUs.
//
// brick_bounds and brick_masks (brick_masks.h) prepare the lists of coarse bricks.
//
// bricks_by_group, a work-group for each brick of 8 x 8 x 8 samples:
// 1. The polyhedra of the coarse brick's list that overlap the brick are chosen into local memory, in the order of the
//    list.
// 2. When that is full, or the list ends: a bound for each of the brick's 64 sub-blocks of 2 x 2 x 2 samples.
// 3. BATCH polyhedra at a time: which octants of the brick does each of them overlap, and which of their sub-blocks?
//    The answers are bits, by sub-block.
// 4. The eight work-items of a sub-block take its polyhedra one after the other, each at its own sample. If there are
//    more batches, the bounds are lowered to the distances that were found.
//
// Several groups share a long list (BrickTask): each stores its minima, and a group of the next launch joins them.
//
// Atomics in local memory only set bits and take minima and maxima, and every group keeps the order of its list. So the
// result does not depend on the order in which groups and work-items run.
//
// Compile-time options: GROUP, work-items a group, 64 or 128; NEAREST keeps the nearest polyhedron
// and finishes what else is asked for (finish.h); LONG_BRICKS if spacing is so unequal that distances take double
// (distance.h); COUNT counts work. LANES is 1: a work-item is a lane.

#include "brick_masks.h"
#include "group_batches.h"
#include "shared_minima.h"
#include "write_group.h"

// Global size: 64 groups for each task [begin, ...) of the launch. minima: of shares, by task and brick.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void bricks_by_group(
    Layout layout, uint begin, __global const BrickTask* restrict tasks, __global uint* restrict minima,
    __global const uint* restrict order, __global const uint* restrict starts, uint parts,
    __global const uint* restrict entries, __global const float* restrict brick_bounds,
    __global const ulong* restrict masks, __global const Polyhedron* restrict polyhedra,
    __global const uint* restrict sign_bits, __global uchar* restrict computed, __global uint* restrict listed,
    __global float* restrict distance
#ifdef NEAREST
    ,
    FINISHING_PARAMETERS
#endif
#ifdef COUNT
    ,
    __global ulong* all_counters  // a set for each group, numbered over all launches
#endif
) {
    __local Work work;
    const BrickTask task = tasks[begin + get_group_id(0) / CLSDF_COARSE_BRICKS];
    const uint item = get_local_id(0), slot = task.slot, b = get_group_id(0) % CLSDF_COARSE_BRICKS;
    const uint number = order[slot], list_end = starts[(number + 1) * parts];
    const int3 brick_first = vload3(0, layout.brick_first), bricks = vload3(0, layout.bricks);
    const int3 at = coarse_brick_at(layout, number) * CLSDF_BRICKS_PER_COARSE + four_cubed(b);
    const int3 relative_brick = at - brick_first;
    if (any(relative_brick < 0) || any(relative_brick >= bricks)) return;

    Brick brick;
    brick.first = at * CLSDF_BRICK;
    brick.spacing = vload3(0, layout.spacing);
    brick.bound = brick_bounds[slot * CLSDF_COARSE_BRICKS + b];
    brick.slack = brick.bound * layout.slack_rate + layout.brick_slack;
    brick.radius = 0.5f * sqrt(dot(brick.spacing, brick.spacing)) * (1.0f + 1.0e-5f) + layout.brick_slack;
    if (item < SMALL_SUBBLOCKS) work.bounds[item] = as_uint(brick.bound);
    ItemMinimum minimum;
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        minimum.squared[s] = INFINITY;
#ifdef NEAREST
        minimum.polyhedron[s] = CLSDF_NO_POLYHEDRON;
#endif
    }
    uint counters[CLSDF_COUNTERS] = {0, 0, 0, 0};
#ifdef COUNT
    __local uint group_counters[CLSDF_COUNTERS];
    if (item < CLSDF_COUNTERS) group_counters[item] = 0;
#endif
    const bool is_join = task.share == task.shares, is_share = !is_join && task.shares > 1;
    __global uint* const first_set = minima + ((size_t)task.minima * CLSDF_COARSE_BRICKS + b) * MINIMA_WORDS;
    const size_t set_words = CLSDF_COARSE_BRICKS * MINIMA_WORDS;  // from a share to the next one
    for (uint n = 0; is_join && n < task.shares; ++n) join_minima(&minimum, first_set + n * set_words, polyhedra);
    uint count = 0;
    const uint list_begin = is_join ? list_end : starts[number * parts] + task.share * task.window,
               step = task.shares * task.window;
    for (uint e = list_begin; e < list_end; e += step) {
        count = choose_window(e, min(list_end, e + task.window), b, masks, entries, count, &work);
        if (count == 0 || (count + WINDOW <= ROOM && e + step < list_end)) continue;
#ifdef COUNT
        counters[CLSDF_COUNT_BRICK_PAIRS] += item == 0 ? count : 0;
#endif
        evaluate_chosen(layout, brick, count, polyhedra, &work, &minimum, counters);
        count = 0;
    }
    if (is_share) {
        store_minima(&minimum, first_set + task.share * set_words);
    } else {
#ifdef NEAREST
        SET_FINISHING(finishing)
        keep_minima(&minimum, &work.room.minima);
#endif
        const size_t number_in_part =
            ((size_t)relative_brick.z * bricks.y + relative_brick.y) * bricks.x + relative_brick.x;
        uint at_in_list = CLSDF_NOT_STORED;
        if (listed != 0)
            at_in_list =
                list_brick(layout, relative_brick, number_in_part, sign_bits, &minimum, computed, listed, work.words);
        else if (item == 0)
            computed[number_in_part] = 1;
        if (listed == 0 || at_in_list != CLSDF_NOT_STORED)
            write_samples(layout, brick, relative_brick, at_in_list, sign_bits, &minimum, distance,
#ifdef NEAREST
                          &work.room.minima, &finishing,
#endif
                          counters);
    }
#ifdef COUNT
    barrier(CLK_LOCAL_MEM_FENCE);  // the counters are 0
    for (uint c = 0; c < CLSDF_COUNTERS; ++c) atomic_add(group_counters + c, counters[c]);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < CLSDF_COUNTERS)
        all_counters[(begin * CLSDF_COARSE_BRICKS + get_group_id(0)) * CLSDF_COUNTERS + item] = group_counters[item];
#endif
}
