// Writes the samples of bricks into the field.
#ifndef CLSDF_WRITE_BRICKS_H
#define CLSDF_WRITE_BRICKS_H

#include "brick_lists.h"
#include "field_lines.h"
#include "sample_values.h"
#include "simd.h"
#include "subblocks.h"
#ifdef NEAREST
#include "finish_rows.h"
#endif
#include "layout.h"

// The outputs, and the sign bits, one per sample.
typedef struct Output {
    __global float* distance;
#ifdef NEAREST
    __private const Finishing* finishing;
    __private Slice* slice;
#endif
    __global uint* rows;       // room for the distances of a slice, before they are stored
    __global uchar* computed;  // of each brick, whether it was written
    __global const uint* sign_bits;
    __global uint* listed;  // of a sparse field; else null
} Output;

// Finishing stores the distances, in double.
INLINE bool is_finished(Output output) {
#ifdef NEAREST
    return IS_DOUBLE(output.finishing, distance);
#else
    return false;
#endif
}

// The number of a brick in the part.
INLINE size_t number_of_brick(Layout layout, int3 brick) {
    const int3 at = brick - vload3(0, layout.brick_first);
    return ((size_t)at.z * layout.bricks[1] + at.y) * layout.bricks[0] + at.x;
}

// The mark of a brick that is computed.
INLINE __global uchar* mark_of(Layout layout, int3 brick, Output output) {
    return output.computed + number_of_brick(layout, brick);
}

// The first word of the sign bits of a brick's slice z, whose rows are layout.sign_words apart; and the first bit
// there.
INLINE __global const uint* sign_bits_of(Layout layout, int3 brick, int z, Output output) {
    const int3 at = brick - vload3(0, layout.brick_first);
    return sign_row(layout, output.sign_bits, at.y * CLSDF_BRICK, at.z * CLSDF_BRICK + z) + at.x / 4;
}
INLINE uint sign_shift_of(Layout layout, int3 brick) {
    return (uint)(brick.x - layout.brick_first[0]) % 4 * CLSDF_BRICK;
}

#ifdef COUNT
// A bit per lane: the sample, of the rows from y on, belongs to the part.
static inline uint lanes_in_part(Layout layout, int3 brick, int y) {
    const int3 first = brick * CLSDF_BRICK - vload3(0, layout.first), size = vload3(0, layout.size);
    const int3 begin = max(-first, (int3)(0)), end = min(size - first, (int3)(CLSDF_BRICK));
    const uint of_row = (1u << end.x) - (1u << begin.x);
    uint lanes = 0;
    for (int n = 0; n < ROWS_PER_VECTOR; ++n)
        if (y + n >= begin.y && y + n < end.y) lanes |= of_row << (n * CLSDF_BRICK);
    return lanes;
}
#endif

// A bit for each sample of a vector, of slice z of a brick from row y on: it is inside.
INLINE uint inside_of_rows(Layout layout, int3 brick, int y, int z, Output output) {
    __global const uint* sign_bits = sign_bits_of(layout, brick, z, output);
    const uint shift = sign_shift_of(layout, brick);
    uint inside = 0;
#pragma unroll
    for (int r = 0; r < ROWS_PER_VECTOR; ++r)
        inside |= (sign_bits[(y + r) * layout.sign_words] >> shift & 0xFFu) << (r * CLSDF_BRICK);
    return inside;
}

// A vector's samples of slice z of a brick, from row y on: returns their distances. If more is asked for, their nearest
// polyhedra are kept, for the n-th brick of the slice's rows.
INLINE uintL finished_rows(Layout layout, int3 brick, __global const Minimum* minimum, uint n, int y, int z,
                           Output output, __private ulong* counters) {
    const uint inside = inside_of_rows(layout, brick, y, z, output);
    intL in_band;
    const floatL squared = as_floatL(ROWS_FROM(squares_of_row, minimum, y, z));
    const uintL distances = as_uintL(signed_distances(layout, bits_to_lanes(inside), squared, &in_band));
#ifdef NEAREST
    const uintL polyhedra = ROWS_FROM(polyhedra_of_row, minimum, y, z);
    const intL has_polyhedron = in_band & (polyhedra != CLSDF_NO_POLYHEDRON);
    __private Rows* rows = &output.slice->rows[y / ROWS_PER_VECTOR][n];
    rows->first = brick * CLSDF_BRICK + (int3)(0, y, z);
    rows->found = lanes_to_bits(has_polyhedron);
    rows->inside = inside;
    store_lanes(select((uintL)0, polyhedra, has_polyhedron), 0, rows->polyhedra);
#endif
#ifdef COUNT
    counters[CLSDF_COUNT_BAND] += popcount(lanes_to_bits(in_band) & lanes_in_part(layout, brick, y));
#endif
    return distances;
}

// Writes the samples of `count` bricks that follow each other along x, as far as they belong to the part, and clears
// their minima.
static inline void write_run(Layout layout, int3 brick, int count, __global Minimum* minima, Output output,
                             __private ulong* counters) {
    const int3 size = vload3(0, layout.size);
    const int3 first = brick * CLSDF_BRICK - vload3(0, layout.first);  // may be negative
    const int3 begin = max(-first, (int3)(0)), end = min(size - first, (int3)(count, 1, 1) * CLSDF_BRICK);
    for (int n = 0; n < count; ++n) mark_of(layout, brick, output)[n] = 1;
    for (int z = begin.z; z < end.z; ++z) {
        for (int n = 0; n < count; ++n)
            for (int y = first_of_vector(begin.y); y < end.y; y += ROWS_PER_VECTOR) {
                const uintL rows =
                    finished_rows(layout, brick + (int3)(n, 0, 0), minima + n, n, y, z, output, counters);
#pragma unroll
                for (int r = 0; r < ROWS_PER_VECTOR; ++r)
                    store_eight(ROW_OF_VECTOR(rows, r), n, output.rows + (y + r) * CLSDF_COARSE);
            }
#ifdef NEAREST
        const size_t slice = sample_offset(layout, first.x, first.y, first.z + z);
        finish_slice(output.finishing, output.slice, count, begin, end, slice, size.x);
#endif
        // A separate loop: a row that is read right after it is stored is waited for.
        for (int y = begin.y; y < end.y && !is_finished(output); ++y) {
            const size_t from = sample_offset(layout, first.x + begin.x, first.y + y, first.z + z);
            store_values(output.rows + y * CLSDF_COARSE + begin.x, (__global uint*)output.distance + from,
                         (__global uint*)output.distance + from + (end.x - begin.x));
        }
    }
    for (int n = 0; n < count; ++n) clear_minimum(minima + n);  // while they are in the innermost cache
}

static inline void write_runs(Layout layout, int3 coarse, ulong bricks, __global Minimum* minima, Output output,
                              __private ulong* counters) {
    while (bricks) {
        const uint b = lowest_bit_of_long(bricks);
        const uint row = (uint)(bricks >> b) & (0xFu >> b % CLSDF_BRICKS_PER_COARSE);
        const uint count = lowest_bit(~row);
        write_run(layout, brick_of_coarse(coarse, b), (int)count, minima + b, output, counters);
        bricks &= ~((((ulong)1 << count) - 1) << b);
    }
}

// The same for two bricks whose rows together are cache lines: they are stored from registers.
static inline void write_lines(Layout layout, int3 brick, __global Minimum* minima, Output output,
                               __private ulong* counters) {
    const int3 size = vload3(0, layout.size);
    const int3 first = brick * CLSDF_BRICK - vload3(0, layout.first);  // y and z may be negative
    const int3 begin = max(-first, (int3)(0)), end = min(size - first, (int3)(CLSDF_BRICK));
    for (int n = 0; n < 2; ++n) mark_of(layout, brick, output)[n] = 1;
    for (int z = begin.z; z < end.z; ++z) {
        for (int y = first_of_vector(begin.y); y < end.y; y += ROWS_PER_VECTOR) {
            const uintL left = finished_rows(layout, brick, minima, 0, y, z, output, counters);
            const uintL right = finished_rows(layout, brick + (int3)(1, 0, 0), minima + 1, 1, y, z, output, counters);
#pragma unroll
            for (int n = 0; n < ROWS_PER_VECTOR; ++n) {
                if (y + n < begin.y || y + n >= end.y) continue;
                const size_t at = sample_offset(layout, first.x, first.y + y + n, first.z + z);
                store_line((uint16)(ROW_OF_VECTOR(left, n), ROW_OF_VECTOR(right, n)),
                           (__global uint*)output.distance + at);
            }
        }
#ifdef NEAREST
        const size_t slice = sample_offset(layout, first.x, first.y, first.z + z);
        finish_slice(output.finishing, output.slice, 2, (int3)(0, begin.y, z), (int3)(2 * CLSDF_BRICK, end.y, z + 1),
                     slice, size.x);
#endif
    }
    for (int n = 0; n < 2; ++n) clear_minimum(minima + n);
}

// Returns a mask of bricks: a bit is set if the rows of that brick and of the next one fill whole lines of memory in
// the part. It is 0 unless every row of the field begins a line, and for distances in double.
INLINE ulong line_beginnings(Layout layout, int3 coarse, Output output) {
    const int3 first = coarse * CLSDF_COARSE - vload3(0, layout.first);
    const size_t from_first = sample_offset(layout, first.x, first.y, first.z);
    if (MISALIGNMENT((size_t)output.distance + from_first * sizeof(float), LINE_NUMBERS) != 0) return 0;
    if (layout.size[0] % LINE_NUMBERS != 0 || is_finished(output)) return 0;
    ulong bricks = 0;
    for (int line = 0; line < CLSDF_COARSE / LINE_NUMBERS; ++line) {
        const int begin = first.x + line * LINE_NUMBERS;
        if (begin >= 0 && begin + LINE_NUMBERS <= layout.size[0])
            bricks |= 0x1111111111111111ul << (line * (LINE_NUMBERS / CLSDF_BRICK));
    }
    return bricks;
}

// Whether a brick has a sample in the band.
static inline bool has_band(Layout layout, int3 brick, __global const Minimum* minimum, Output output) {
    for (int z = 0; z < CLSDF_BRICK; ++z)
        for (int y = 0; y < CLSDF_BRICK; y += ROWS_PER_VECTOR) {
            const intL inside = bits_to_lanes(inside_of_rows(layout, brick, y, z, output));
            intL in_band;
            signed_distances(layout, inside, as_floatL(ROWS_FROM(squares_of_row, minimum, y, z)), &in_band);
            if (lanes_to_bits(in_band) != 0) return true;
        }
    return false;
}

// Writes all samples of a brick to place `at` of the list.
static inline void write_listed(Layout layout, int3 brick, uint at, __global const Minimum* minimum, Output output,
                                __private ulong* counters) {
    for (int z = 0; z < CLSDF_BRICK; ++z) {
        const size_t slice = (size_t)at * CLSDF_BRICK_SAMPLES + z * CLSDF_BRICK * CLSDF_BRICK;
        for (int y = 0; y < CLSDF_BRICK; y += ROWS_PER_VECTOR) {
            const uintL rows = finished_rows(layout, brick, minimum, 0, y, z, output, counters);
            if (!is_finished(output)) store_lanes(rows, 0, (__global uint*)output.distance + slice + y * CLSDF_BRICK);
        }
#ifdef NEAREST
        finish_slice(output.finishing, output.slice, 1, (int3)(0, 0, z), (int3)(CLSDF_BRICK, CLSDF_BRICK, z + 1), slice,
                     CLSDF_BRICK);
#endif
    }
}

// Lists and writes those bricks of a coarse brick that have a sample in the band, and clears all. A brick without one
// stays as it is if no polyhedron overlaps it.
static inline void list_used(Layout layout, int3 coarse, ulong bricks, __global Minimum* minima, Output output,
                             __private ulong* counters) {
    for (; bricks; bricks &= bricks - 1) {
        const uint b = lowest_bit_of_long(bricks);
        const int3 brick = brick_of_coarse(coarse, b);
        if (has_band(layout, brick, minima + b, output)) {
            *mark_of(layout, brick, output) = 1;
            const uint at = atomic_inc(output.listed + CLSDF_STORED_COUNT);
            if (at < output.listed[CLSDF_STORED_ROOM]) {
                output.listed[CLSDF_STORED + at] = (uint)number_of_brick(layout, brick);
                write_listed(layout, brick, at, minima + b, output, counters);
            }
        }
        clear_minimum(minima + b);
    }
}

// Writes and clears the used bricks of a coarse brick, as far as they are in the part. Returns which it wrote. If
// two bricks' rows share a line of the cache, it writes both. Otherwise this store and the fill would write half a line
// each, and each would read the line first.
static inline ulong write_used(Layout layout, int3 coarse, ulong used, ulong in_part, __global Minimum* minima,
                               Output output, __private ulong* counters) {
    const bool is_sparse = output.listed != 0;
    const ulong lines = is_sparse ? 0ul : (used | used >> 1) & in_part & line_beginnings(layout, coarse, output);
    const ulong in_lines = lines | lines << 1, others = used & in_part & ~in_lines;
    for (ulong rest = lines; rest; rest &= rest - 1) {
        const uint b = lowest_bit_of_long(rest);
        write_lines(layout, brick_of_coarse(coarse, b), minima + b, output, counters);
    }
    if (is_sparse)
        list_used(layout, coarse, others, minima, output, counters);
    else
        write_runs(layout, coarse, others, minima, output, counters);
#ifdef NEAREST
    store_slice(output.finishing, output.slice);
#endif
    return in_lines | others;
}

#endif
