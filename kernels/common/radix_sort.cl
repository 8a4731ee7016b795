// A stable sort of indices by keys of 32 bits on a GPU, from the lowest eight bits of the keys up. A pass has three
// launches: each work-group counts the digits of its tile of the keys; a group for each digit sums its counts over the
// tiles; each group writes its tile in runs of equal digits. If tiles are few, each group of the last launch makes the
// sums itself, and the second launch is left out.
//
// Local memory: 17 bytes a key of a tile, at most 17 KiB. Atomics: those of 32 bits in local memory, whose sums do not
// depend on an order.

#include "group_sum.h"
#include "radix_sort.h"

// GROUP: work-items of a group, 64 or 128. A work-item has EACH keys of the tile, which follow one another.
#define EACH (CLSDF_RADIX_TILE / GROUP)
#define DIGITS CLSDF_RADIX_DIGITS
#define DIGITS_EACH (DIGITS / GROUP)
#define GROUP_OF_KERNEL __attribute__((reqd_work_group_size(GROUP, 1, 1)))

// A word of the tile is its key's digit and, in the bits below, the key's place in the tile. It is sorted in rounds of
// four bits.
#define DIGIT_SHIFT 16
#define ROUND_BITS 4
#define ROUND_DIGITS 16
// Places in local memory: neighbouring work-items use different banks.
#define SPREAD(index) ((index) + (index) / 16)
#define COUNTER(digit, item) ((digit)*GROUP + (item) + ((digit)*GROUP + (item)) / ROUND_DIGITS * 2)

static inline uint digit_of(uint key, uint shift) {
    return key >> shift & (DIGITS - 1u);
}

DEFINE_SUM_BEFORE(sum_before, uint, GROUP)

// counts: of each digit in each tile, by digits. A group a tile.
__kernel GROUP_OF_KERNEL void radix_count(uint count, uint shift, __global const uint* keys, __global uint* counts) {
    volatile __local uint digits[DIGITS];
    const uint item = get_local_id(0), tile = get_group_id(0), tiles = get_num_groups(0);
    for (uint i = 0; i < DIGITS_EACH; ++i) digits[i * GROUP + item] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint begin = tile * CLSDF_RADIX_TILE, end = min(count - begin, (uint)CLSDF_RADIX_TILE);
    for (uint i = item; i < end; i += GROUP) atomic_inc(&digits[digit_of(keys[begin + i], shift)]);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = 0; i < DIGITS_EACH; ++i) counts[(i * GROUP + item) * tiles + tile] = digits[i * GROUP + item];
}

// A count becomes the sum of the digit's counts in the tiles before. totals: of each digit. A group a digit.
__kernel GROUP_OF_KERNEL void radix_sums(uint tiles, __global uint* counts, __global uint* totals) {
    __local uint sums[GROUP];
    const uint item = get_local_id(0), digit = get_group_id(0);
    __global uint* of_digit = counts + digit * tiles;
    uint before = 0;
    for (uint begin = 0; begin < tiles; begin += GROUP) {
        const uint tile = begin + item;
        const uint sum = before + sum_before(tile < tiles ? of_digit[tile] : 0, sums);
        if (tile < tiles) of_digit[tile] = sum;
        before += sums[GROUP - 1];
    }
    if (item == 0) totals[digit] = before;
}

// Sorts the tile's words by their digits, in stable rounds of a counting sort. A work-item has a counter of its own for
// each value of a round's bits. (Called once: PoCL 3.1 gets a second call wrong.)
static inline void sort_tile(__local uint* words, __local ushort* counters, __local uint* sums) {
    const uint item = get_local_id(0);
    uint own[EACH];
    for (uint shift = DIGIT_SHIFT; shift < DIGIT_SHIFT + CLSDF_RADIX_BITS; shift += ROUND_BITS) {
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint digit = 0; digit < ROUND_DIGITS; ++digit) counters[COUNTER(digit, item)] = 0;
#pragma unroll
        for (uint i = 0; i < EACH; ++i) {
            own[i] = words[SPREAD(item * EACH + i)];
            ++counters[COUNTER(own[i] >> shift & (ROUND_DIGITS - 1u), item)];
        }
        barrier(CLK_LOCAL_MEM_FENCE);
        // A work-item sums ROUND_DIGITS counters that follow one another.
        uint sum = 0;
        for (uint i = 0; i < ROUND_DIGITS; ++i) sum += counters[COUNTER(0, item * ROUND_DIGITS + i)];
        sum = sum_before(sum, sums);
        for (uint i = 0; i < ROUND_DIGITS; ++i) {
            const uint value = counters[COUNTER(0, item * ROUND_DIGITS + i)];
            counters[COUNTER(0, item * ROUND_DIGITS + i)] = (ushort)sum;
            sum += value;
        }
        barrier(CLK_LOCAL_MEM_FENCE);
#pragma unroll
        for (uint i = 0; i < EACH; ++i) {
            const uint place = counters[COUNTER(own[i] >> shift & (ROUND_DIGITS - 1u), item)]++;
            words[SPREAD(place)] = own[i];
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// counts, totals: of radix_sums(), if are_summed; else counts: of radix_count(). is_first: the values are the keys'
// indices, and values_in is not read. is_last: keys_out is not written. A group a tile.
__kernel GROUP_OF_KERNEL void radix_place(uint count, uint shift, uint is_first, uint is_last, uint are_summed,
                                          __global const uint* counts, __global const uint* totals,
                                          __global const uint* keys_in, __global const uint* values_in,
                                          __global uint* keys_out, __global uint* values_out) {
    __local uint words[SPREAD(CLSDF_RADIX_TILE)];  // digit << DIGIT_SHIFT | place in the tile
    __local ushort counters[COUNTER(ROUND_DIGITS, 0)];
    __local uint sums[GROUP];
    __local uint starts[DIGITS];  // of the digit among the tile's words
    __local uint places[DIGITS];  // of the digit's first word of this tile in the output
    const uint item = get_local_id(0), tile = get_group_id(0), tiles = get_num_groups(0);
    const uint begin = tile * CLSDF_RADIX_TILE, end = min(count - begin, (uint)CLSDF_RADIX_TILE);
    // Beyond the end: the greatest digit, which stays behind all others.
    for (uint i = item; i < CLSDF_RADIX_TILE; i += GROUP)
        words[SPREAD(i)] = (i < end ? digit_of(keys_in[begin + i], shift) : DIGITS - 1u) << DIGIT_SHIFT | i;
    sort_tile(words, counters, sums);
    uint before = 0, own[DIGITS_EACH], all[DIGITS_EACH];
#pragma unroll
    for (uint i = 0; i < DIGITS_EACH; ++i) {
        const uint digit = item * DIGITS_EACH + i;
        own[i] = are_summed ? counts[digit * tiles + tile] : 0;
        all[i] = are_summed ? totals[digit] : 0;
        for (uint other = 0; !are_summed && other < tiles; ++other) {
            const uint of_tile = counts[digit * tiles + other];
            own[i] += other < tile ? of_tile : 0;
            all[i] += of_tile;
        }
        before += all[i];
    }
    before = sum_before(before, sums);
#pragma unroll
    for (uint i = 0; i < DIGITS_EACH; ++i) {
        places[item * DIGITS_EACH + i] = before + own[i];
        before += all[i];
    }
    for (uint i = item; i < end; i += GROUP) {
        const uint digit = words[SPREAD(i)] >> DIGIT_SHIFT;
        if (i == 0 || words[SPREAD(i - 1)] >> DIGIT_SHIFT != digit) starts[digit] = i;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = item; i < end; i += GROUP) {
        const uint word = words[SPREAD(i)], digit = word >> DIGIT_SHIFT,
                   from = begin + (word & ((1u << DIGIT_SHIFT) - 1u));
        const uint to = places[digit] + (i - starts[digit]);
        values_out[to] = is_first ? from : values_in[from];
        if (!is_last) keys_out[to] = keys_in[from];
    }
}
