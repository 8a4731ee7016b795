// A sparse field's bricks on their way into the order of the lattice. Kernels list the bricks of a part in the order in
// which they end them (layout.h); a brick's place in the caller's arrays is the number of bricks with values before it:
// those of earlier parts, of earlier ranges of this part, and of its own range. Runs of bricks inside are placed alike.

#include "brick_order.h"
#include "layout.h"
#include "simd.h"

#define NO_PLACE 0xFFFFFFFFu

INLINE bool has_values(uchar mark) {
    return mark == 1;
}

// Whether a run of bricks inside begins at brick n. row: bricks along x.
INLINE bool begins_run(__global const uchar* marks, uint n, uint row) {
    return marks[n] == CLSDF_INSIDE_BRICK && (n % row == 0 || marks[n - 1] != CLSDF_INSIDE_BRICK);
}

INLINE void store_first_sample(Layout layout, uint number, __global long* to) {
    const uint x = (uint)layout.bricks[0], y = (uint)layout.bricks[1];
    to[0] = ((long)layout.brick_first[0] + number % x) * CLSDF_BRICK;
    to[1] = ((long)layout.brick_first[1] + number / x % y) * CLSDF_BRICK;
    to[2] = ((long)layout.brick_first[2] + number / x / y) * CLSDF_BRICK;
}

// counts: of each range of the part's bricks, those with values; behind them, of each range, the runs that begin there.
// Global size: at least the ranges.
__kernel void count_marks(Layout layout, uint bricks, uint ranges, __global const uchar* marks, __global uint* counts) {
    const uint range = get_global_id(0), row = (uint)layout.bricks[0];
    if (range >= ranges) return;
    const uint begin = range * CLSDF_RANGE_BRICKS, end = min(bricks, begin + CLSDF_RANGE_BRICKS);
    uint with_values = 0, runs = 0;
    for (uint n = begin; n < end; ++n) {
        with_values += has_values(marks[n]);
        runs += begins_run(marks, n, row);
    }
    counts[range] = with_values;
    counts[ranges + range] = runs;
}

// How many bricks of the part are listed.
INLINE uint listed_count(__global const uint* listed) {
    return min(listed[CLSDF_STORED_COUNT], listed[CLSDF_STORED_ROOM]);
}

// Finds the place of each listed brick, and stores its first sample there. starts: the prefix sums of `counts`.
// totals: the bricks and the runs of earlier parts. Places from `room` on are NO_PLACE. from: a number of longs.
// Global size: at least the room of the list.
__kernel void place_bricks(Layout layout, __global const uchar* marks, __global const uint* starts,
                           __global const uint* listed, __global const ulong* totals, __global uint* places, ulong room,
                           ulong from, __global long* firsts) {
    const uint n = get_global_id(0);
    if (n >= listed_count(listed)) return;
    const uint number = listed[CLSDF_STORED + n], range = number / CLSDF_RANGE_BRICKS;
    uint before = starts[range];
    for (uint other = range * CLSDF_RANGE_BRICKS; other < number; ++other) before += has_values(marks[other]);
    const ulong place = totals[0] + before;
    places[n] = place < room ? (uint)place : NO_PLACE;
    if (place < room) store_first_sample(layout, number, firsts + from + 3 * place);
}

// One work-item a piece of a listed brick's values, of brick `first_brick` on. words: of 4 bytes that a brick takes.
// in_band: the output is computed for bricks with samples of the band alone; in others all its bits are set.
// Global size: (pieces, bricks).
#define STORE_BRICKS(Word, count, ones)                                                                   \
    const uint piece = get_global_id(0), pieces = get_global_size(0), n = first_brick + get_global_id(1); \
    if (n >= listed_count(listed) || places[n] == NO_PLACE) return;                                       \
    __global const Word* of_brick = (__global const Word*)values + (size_t)n * (count);                   \
    __global Word* place = (__global Word*)(to + from) + (size_t)places[n] * (count);                     \
    const bool is_left = in_band != 0 && n >= listed[CLSDF_STORED_IN_BAND];                               \
    for (uint i = piece; i < (count); i += pieces) place[i] = is_left ? (ones) : of_brick[i];

__kernel void store_bricks(__global const uint* listed, __global const uint* places, __global const uchar* values,
                           uint words, int in_band, uint first_brick, ulong from,
                           __global uchar* to){STORE_BRICKS(uint, words, 0xFFFFFFFFu)}

// The same if `from` is no multiple of 4.
__kernel void store_brick_bytes(__global const uint* listed, __global const uint* places, __global const uchar* values,
                                uint words, int in_band, uint first_brick, ulong from,
                                __global uchar* to){STORE_BRICKS(uchar, 4 * words, (uchar)0xFF)}

// Stores the runs of bricks inside: four longs each, from long `from` on. One work-item a range, with the runs that
// begin there. Global size: at least the ranges.
__kernel
    void store_runs(Layout layout, uint bricks, uint ranges, __global const uchar* marks, __global const uint* starts,
                    __global const ulong* totals, ulong room, ulong from, __global long* runs) {
    const uint range = get_global_id(0), row = (uint)layout.bricks[0];
    if (range >= ranges) return;
    const uint begin = range * CLSDF_RANGE_BRICKS, end = min(bricks, begin + CLSDF_RANGE_BRICKS);
    ulong place = totals[1] + (starts[ranges + range] - starts[ranges]);
    for (uint n = begin; n < end; ++n) {
        if (!begins_run(marks, n, row)) continue;
        if (place < room) {
            uint behind = n + 1;
            while (behind % row != 0 && marks[behind] == CLSDF_INSIDE_BRICK) ++behind;
            __global long* run = runs + from + 4 * place;
            store_first_sample(layout, n, run);
            run[3] = behind - n;
        }
        ++place;
    }
}

// Adds the part's bricks and runs to the totals, and states them: three numbers from ulong `from` on, as in
// DeviceSparseCounts. One work-item.
__kernel void add_counts(uint ranges, __global const uint* starts, __global ulong* totals, ulong brick_room,
                         ulong run_room, ulong from, __global ulong* counts) {
    if (get_global_id(0) != 0) return;
    totals[0] += starts[ranges];
    totals[1] += starts[2 * ranges] - starts[ranges];
    counts[from] = totals[0];
    counts[from + 1] = totals[1];
    counts[from + 2] = totals[0] <= brick_room && totals[1] <= run_room;
}
