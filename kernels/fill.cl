// Bricks that no polyhedron touches: the band's limit with the sample's sign.

#include "bits.h"
#include "field_lines.h"
#include "inline.h"
#include "layout.h"
#include "request.h"

// A run of one value, kept back: where the next one follows it, as rows follow each other, they are stored as one.
typedef struct Run {
    __global uint* begin;
    __global uint* end;
    uint value;
} Run;

INLINE void add_run(__private Run* run, __global uint* begin, __global uint* end, uint value) {
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

// Asks for a row of bricks' sign bits in one slice of samples, or for what lies behind them: what is loaded among
// stores past the caches waits for them. (Measured: 1% of a call.)
INLINE void request_signs(Layout layout, __global const uint* sign_bits, int brick_y, int from_z) {
    __global const uint* bits =
        sign_bits + ((size_t)from_z * layout.bricks[1] + brick_y) * CLSDF_BRICK * layout.sign_words;
    for (int word = 0; word < CLSDF_BRICK * layout.sign_words; word += LINE_NUMBERS) request_line_for_soon(bits + word);
}

// The empty bricks [first_brick, end_brick) of a row of bricks, in one slice of samples.
INLINE void fill_bricks(Layout layout, int first_brick, int end_brick, int brick_y, int z,
                        __global const uchar* computed, __global const uint* sign_bits, __global uint* distance,
                        __global uint* triangle, int with_triangle) {
    // Offsets from the first brick's first sample.
    const int shift_x = layout.first[0] - layout.brick_first[0] * CLSDF_BRICK;
    const int shift_y = layout.first[1] - layout.brick_first[1] * CLSDF_BRICK;
    const int from_z = z + layout.first[2] - layout.brick_first[2] * CLSDF_BRICK;
    request_signs(layout, sign_bits, brick_y, from_z + 1);  // for the next work-item of the group
    __global const uchar* row_computed =
        computed + ((size_t)(from_z / CLSDF_BRICK) * layout.bricks[1] + brick_y) * layout.bricks[0];
    const int begin_y = max(brick_y * CLSDF_BRICK - shift_y, 0),
              end_y = min((brick_y + 1) * CLSDF_BRICK - shift_y, layout.size[1]);
    Run distances = {distance, distance, 0}, triangles = {triangle, triangle, 0};
    for (int brick = first_brick; brick < end_brick; ++brick) {
        if (row_computed[brick]) continue;
        const int begin = max(brick * CLSDF_BRICK - shift_x, 0);
        while (brick < end_brick && !row_computed[brick]) ++brick;
        const int end = min(brick * CLSDF_BRICK - shift_x, layout.size[0]);
        for (int y = begin_y; y < end_y; ++y) {
            const size_t row = ((size_t)z * layout.size[1] + y) * layout.size[0];
            __global const uint* bits =
                sign_bits + ((size_t)from_z * (layout.bricks[1] * CLSDF_BRICK) + (y + shift_y)) * layout.sign_words;
            for (int x = begin, next; x < end; x = next) {
                next = end_of_run(bits, x + shift_x, end + shift_x) - shift_x;
                const bool inside = bits[(x + shift_x) >> 5] >> ((x + shift_x) & 31) & 1u;
                add_run(&distances, distance + row + x, distance + row + next,
                        as_uint(inside ? layout.inside_fill : layout.outside_fill));
            }
            if (with_triangle) add_run(&triangles, triangle + row + begin, triangle + row + end, CLSDF_NO_TRIANGLE);
        }
    }
    store_value(distances.value, distances.begin, distances.end);
    if (with_triangle) store_value(triangles.value, triangles.begin, triangles.end);
}

// One work-item a piece of a row of bricks in one slice, from slice `first_slice` on.
// Global size: (pieces of a row of bricks, rows of bricks, slices and what fills the last group).
__kernel void fill_empty_bricks(Layout layout, __global const uchar* computed, __global const uint* sign_bits,
                                __global uint* distance, __global uint* triangle, int with_triangle, int first_slice) {
    const int piece = get_global_id(0), pieces = get_global_size(0), z = first_slice + get_global_id(2);
    const int first_brick = (int)((long)layout.bricks[0] * piece / pieces);
    const int end_brick = (int)((long)layout.bricks[0] * (piece + 1) / pieces);
    if (z < layout.size[2])
        fill_bricks(layout, first_brick, end_brick, get_global_id(1), z, computed, sign_bits, distance, triangle,
                    with_triangle);
    // Once a group, whose work-items one thread takes one after the other: each by itself would wait for its stores.
    if (get_local_id(2) + 1 == get_local_size(2)) finish_lines();
}
