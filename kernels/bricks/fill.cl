// Bricks that no polyhedron overlaps: the band's limit with the sample's sign.

#include "field_lines.h"
#include "layout.h"
#include "sample_values.h"
#include "simd.h"

// A run of one value that is not stored yet. If the next run follows it in memory, both are stored as one.
typedef struct Run {
    __global uint* begin;
    __global uint* end;
    ulong value;  // of store_value()
} Run;

INLINE void add_run(__private Run* run, __global uint* begin, __global uint* end, ulong value) {
    if (begin == run->end && value == run->value) {
        run->end = end;
        return;
    }
    store_value(run->value, run->begin, run->end);
    run->begin = begin;
    run->end = end;
    run->value = value;
}

// The first bit of [first, end) that differs from bit `first`, or `end`.
INLINE int end_of_run(__global const uint* bits, int first, int end) {
    const uint like = bits[first >> 5] >> (first & 31) & 1u ? 0xFFFFFFFFu : 0u;
    uint differ = (bits[first >> 5] ^ like) >> (first & 31) << (first & 31);
    int word = first >> 5;
    while (differ == 0 && (word + 1) * 32 < end) differ = bits[++word] ^ like;
    return differ == 0 ? end : min(word * 32 + (int)lowest_bit(differ), end);
}

// Prefetches a row of bricks' sign bits in one slice of samples: a load among stores past the caches would wait for
// them. It may prefetch beyond the end.
INLINE void prefetch_signs(Layout layout, __global const uint* sign_bits, int brick_y, int from_z) {
    __global const uint* bits = sign_row(layout, sign_bits, brick_y * CLSDF_BRICK, from_z);
    for (int word = 0; word < CLSDF_BRICK * layout.sign_words; word += LINE_NUMBERS) prefetch_line_to_l1(bits + word);
}

// A row of bricks in one slice of samples.
typedef struct BrickRow {
    int shift_x, shift_y;  // of the part's first sample from the first brick's
    int from_z;            // the slice, counted from the first brick's
    int begin_y, end_y;    // rows of samples of the part
    __global const uchar* computed;
} BrickRow;

INLINE BrickRow brick_row(Layout layout, int brick_y, int z, __global const uchar* computed) {
    BrickRow row;
    row.shift_x = layout.first[0] - layout.brick_first[0] * CLSDF_BRICK;
    row.shift_y = layout.first[1] - layout.brick_first[1] * CLSDF_BRICK;
    row.from_z = z + layout.first[2] - layout.brick_first[2] * CLSDF_BRICK;
    row.begin_y = max(brick_y * CLSDF_BRICK - row.shift_y, 0);
    row.end_y = min((brick_y + 1) * CLSDF_BRICK - row.shift_y, layout.size[1]);
    row.computed = computed + ((size_t)(row.from_z / CLSDF_BRICK) * layout.bricks[1] + brick_y) * layout.bricks[0];
    return row;
}

// The next empty bricks from *brick on, as samples [*begin, *end) of each row; false if there are none before
// `end_brick`. *brick is then the first one behind them.
INLINE bool next_empty(Layout layout, BrickRow row, int end_brick, __private int* brick, __private int* begin,
                       __private int* end) {
    while (*brick < end_brick && row.computed[*brick]) ++*brick;
    if (*brick >= end_brick) return false;
    *begin = max(*brick * CLSDF_BRICK - row.shift_x, 0);
    while (*brick < end_brick && !row.computed[*brick]) ++*brick;
    *end = min(*brick * CLSDF_BRICK - row.shift_x, layout.size[0]);
    return true;
}

// The distances of the empty bricks [brick, end_brick) of a row of bricks, in one slice of samples. words: of a
// distance.
INLINE void fill_bricks(Layout layout, int brick, int end_brick, int brick_y, int z, __global const uchar* computed,
                        __global const uint* sign_bits, int words, ulong inside_fill, ulong outside_fill,
                        __global uint* distance) {
    const BrickRow row = brick_row(layout, brick_y, z, computed);
    prefetch_signs(layout, sign_bits, brick_y, row.from_z + 1);  // for the next work-item of the group
    Run distances = {distance, distance, 0ul};
    for (int begin, end; next_empty(layout, row, end_brick, &brick, &begin, &end);)
        for (int y = row.begin_y; y < row.end_y; ++y) {
            __global uint* to = distance + sample_offset(layout, 0, y, z) * words;
            __global const uint* bits = sign_row(layout, sign_bits, y + row.shift_y, row.from_z);
            for (int x = begin, next; x < end; x = next) {
                next = end_of_run(bits, x + row.shift_x, end + row.shift_x) - row.shift_x;
                const bool inside = is_inside(bits, x + row.shift_x);
                add_run(&distances, to + (size_t)x * words, to + (size_t)next * words,
                        inside ? inside_fill : outside_fill);
            }
        }
    store_value(distances.value, distances.begin, distances.end);
}

// Sets every bit of the other outputs of their samples, `sample_bytes` each.
INLINE void leave_bricks(Layout layout, int brick, int end_brick, int brick_y, int z, __global const uchar* computed,
                         __global uchar* output, int sample_bytes) {
    const BrickRow row = brick_row(layout, brick_y, z, computed);
    __global uchar *run_begin = output, *run_end = output;  // kept back, as long as rows follow each other
    for (int begin, end; next_empty(layout, row, end_brick, &brick, &begin, &end);)
        for (int y = row.begin_y; y < row.end_y; ++y) {
            __global uchar* to = output + sample_offset(layout, 0, y, z) * sample_bytes;
            if (to + (size_t)begin * sample_bytes != run_end) {
                store_ones(run_begin, run_end);
                run_begin = to + (size_t)begin * sample_bytes;
            }
            run_end = to + (size_t)end * sample_bytes;
        }
    store_ones(run_begin, run_end);
}

// One work-item a piece of a row of bricks in one slice, from slice `first_slice` on.
// Global size: (pieces of a row of bricks, rows of bricks, slices and what fills the last group).
#define PIECE_OF_ROW                                                                                     \
    const int piece = get_global_id(0), pieces = get_global_size(0), z = first_slice + get_global_id(2); \
    const int first_brick = (int)((long)layout.bricks[0] * piece / pieces);                              \
    const int end_brick = (int)((long)layout.bricks[0] * (piece + 1) / pieces);

// words: of a distance, 1 or 2. inside_fill, outside_fill: the distances of samples that are inside and outside, of
// store_value().
__kernel void fill_empty_bricks(Layout layout, __global const uchar* computed, __global const uint* sign_bits,
                                __global uint* distance, int words, ulong inside_fill, ulong outside_fill,
                                int first_slice) {
    PIECE_OF_ROW
    if (z < layout.size[2])
        fill_bricks(layout, first_brick, end_brick, get_global_id(1), z, computed, sign_bits, words, inside_fill,
                    outside_fill, distance);
    // Once per group, because one thread runs its work-items one after the other, and each wait for stores costs time.
    if (get_local_id(2) + 1 == get_local_size(2)) finish_lines();
}

// Another output than the distance, `sample_bytes` per sample.
__kernel void leave_empty_bricks(Layout layout, __global const uchar* computed, __global uchar* output,
                                 int sample_bytes, int first_slice) {
    PIECE_OF_ROW
    if (z < layout.size[2])
        leave_bricks(layout, first_brick, end_brick, get_global_id(1), z, computed, output, sample_bytes);
    if (get_local_id(2) + 1 == get_local_size(2)) finish_lines();
}

// Sparse fields: the bricks that are not listed yet.

// Lists brick `number` of the part, which has samples of both signs and none in the band, and writes its distances.
// bits: of its first row.
INLINE void list_mixed_brick(Layout layout, uint number, __global const uint* bits, uint shift, __global uint* listed,
                             __global float* distance) {
    const uint at = atomic_inc(listed + CLSDF_STORED_COUNT);
    if (at >= listed[CLSDF_STORED_ROOM]) return;
    listed[CLSDF_STORED + at] = number;
    __global float* to = distance + (size_t)at * CLSDF_BRICK_SAMPLES;
    for (int z = 0; z < CLSDF_BRICK; ++z)
        for (int y = 0; y < CLSDF_BRICK; ++y) {
            const uint row = sign_row(layout, bits, y, z)[0] >> shift;
            for (int x = 0; x < CLSDF_BRICK; ++x) *to++ = row >> x & 1u ? layout.inside_fill : layout.outside_fill;
        }
}

// The four bricks of a word of sign bits. all, any: of the bricks' rows, joined by AND and by OR.
INLINE void mark_word(Layout layout, int3 first_brick, uint all, uint any, __global const uint* bits,
                      __global uchar* computed, __global uint* listed, __global float* distance) {
    const size_t first = ((size_t)first_brick.z * layout.bricks[1] + first_brick.y) * layout.bricks[0] + first_brick.x;
    const int count = min(layout.bricks[0] - first_brick.x, 4);
    for (int n = 0; n < count; ++n, all >>= CLSDF_BRICK, any >>= CLSDF_BRICK) {
        if (computed[first + n] != 0 || (any & 0xFFu) == 0) continue;
        const bool is_mixed = (all & 0xFFu) != 0xFFu;
        computed[first + n] = is_mixed ? 1 : CLSDF_INSIDE_BRICK;
        if (is_mixed) list_mixed_brick(layout, (uint)(first + n), bits, (uint)(n * CLSDF_BRICK), listed, distance);
    }
}

#define WORDS_AT_ONCE 16

// Marks the bricks that have no sample in the band: inside and outside ones, and lists those with both signs. One
// work-item a piece of a row of bricks.
// Global size: (pieces of a row of bricks, rows of bricks, layers of bricks from `first_layer` on).
__kernel void mark_other_bricks(Layout layout, __global uchar* computed, __global const uint* sign_bits,
                                __global uint* listed, __global float* distance, int first_layer) {
    const int piece = get_global_id(0), pieces = get_global_size(0), y = get_global_id(1),
              z = first_layer + get_global_id(2);
    const int begin = (int)((long)layout.sign_words * piece / pieces);
    const int end = (int)((long)layout.sign_words * (piece + 1) / pieces);
    __global const uint* bits = sign_row(layout, sign_bits, y * CLSDF_BRICK, z * CLSDF_BRICK);
    int word = begin;
    for (; word + WORDS_AT_ONCE <= end; word += WORDS_AT_ONCE) {
        uint16 all = 0xFFFFFFFFu, any = 0;
        for (int row = 0; row < CLSDF_BRICK * CLSDF_BRICK; ++row) {
            const uint16 words = vload16(0, sign_row(layout, bits, row % CLSDF_BRICK, row / CLSDF_BRICK) + word);
            all &= words;
            any |= words;
        }
        uint each_all[WORDS_AT_ONCE], each_any[WORDS_AT_ONCE];
        vstore16(all, 0, each_all);
        vstore16(any, 0, each_any);
        for (int n = 0; n < WORDS_AT_ONCE; ++n)
            if (each_any[n] != 0)
                mark_word(layout, (int3)(4 * (word + n), y, z), each_all[n], each_any[n], bits + word + n, computed,
                          listed, distance);
    }
    for (; word < end; ++word) {
        uint all = 0xFFFFFFFFu, any = 0;
        for (int row = 0; row < CLSDF_BRICK * CLSDF_BRICK; ++row) {
            const uint words = sign_row(layout, bits, row % CLSDF_BRICK, row / CLSDF_BRICK)[word];
            all &= words;
            any |= words;
        }
        if (any != 0) mark_word(layout, (int3)(4 * word, y, z), all, any, bits + word, computed, listed, distance);
    }
}
