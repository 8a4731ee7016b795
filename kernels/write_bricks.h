// The way of bricks' samples into the field.
#ifndef CLSDF_WRITE_BRICKS_H
#define CLSDF_WRITE_BRICKS_H

#include "bits.h"
#include "brick_lists.h"
#include "brick_minimum.h"
#include "field_lines.h"
#include "lanes.h"
#include "layout.h"
#include "request.h"

// What is written, and what gives it its sign: a bit a sample.
typedef struct Output {
    __global float* distance;
#ifdef NEAREST
    __global uint* triangle;
#endif
    __global uchar* computed;  // of each brick, whether it was written
    __global const uint* sign_bits;
} Output;

// Where the rows of a brick go: addresses, of those before the part's first sample too.
typedef struct BrickRows {
    size_t distance;
#ifdef NEAREST
    size_t triangle;
#endif
    size_t y_step, z_step;
} BrickRows;

INLINE BrickRows rows_of(Layout layout, int3 brick, Output output) {
    BrickRows rows;
    const int3 at = brick * CLSDF_BRICK - vload3(0, layout.first);
    rows.y_step = (size_t)layout.size[0] * sizeof(float);
    rows.z_step = rows.y_step * layout.size[1];
    const size_t from_first = (size_t)at.z * rows.z_step + (size_t)at.y * rows.y_step + (size_t)at.x * sizeof(float);
    rows.distance = (size_t)output.distance + from_first;
#ifdef NEAREST
    rows.triangle = (size_t)output.triangle + from_first;
#endif
    return rows;
}

// Asks for two of the rows, at each of the turns from 0 to ROW_TURNS - 1. Spread over a brick's computation, the lines
// of the field are there when they are stored to; else all stores after them would wait, and soon everything.
// (Measured: a tenth of the bricks' time, where the field is on huge pages.) Of a row that does not lie in one line of
// memory only the first is asked for.
#define ROW_TURNS (CLSDF_BRICK * CLSDF_BRICK / 2)
INLINE void request_rows(__private const BrickRows* rows, uint turn) {
    const size_t from_first = turn % 4 * 2 * rows->y_step + turn / 4 * rows->z_step;
    request_line_to_store(rows->distance + from_first);
    request_line_to_store(rows->distance + from_first + rows->y_step);
#ifdef NEAREST
    request_line_to_store(rows->triangle + from_first);
    request_line_to_store(rows->triangle + from_first + rows->y_step);
#endif
}

// Stores values[begin, end) of a row of a brick.
static inline void store_row(uint8 values, int begin, int end, __global uint* row) {
    if (end - begin == 8) {
        store_eight(values, 0, row);
        return;
    }
    uint each[8];
    vstore8(values, 0, each);
    for (int x = begin; x < end; ++x) row[x - begin] = each[x];
}

// The values of a row's samples: the distance with its sign where it lies in the band, else the fill. inside: a bit a
// sample.
INLINE float8 signed_distances(Layout layout, uint inside, float8 square, int8* in_band) {
    const int8 negative = (((int8)inside >> (int8)(0, 1, 2, 3, 4, 5, 6, 7)) & 1) != 0;
    const float8 fill = negative ? (float8)layout.inside_fill : (float8)layout.outside_fill;
    const float8 limit = negative ? (float8)layout.inside_squared : (float8)layout.outside_squared;
    *in_band = square <= limit;
    const float8 length = LESSER(sqrt(square) * layout.unit, fabs(fill));
    return *in_band ? ((negative & (length != 0.0f)) ? -length : length) : fill;
}

// Where a brick is marked as computed.
INLINE __global uchar* mark_of(Layout layout, int3 brick, Output output) {
    const int3 at = brick - vload3(0, layout.brick_first);
    return output.computed + ((size_t)at.z * layout.bricks[1] + at.y) * layout.bricks[0] + at.x;
}

// Where the sign bits of a brick's slice z begin, whose rows are layout.sign_words apart; and from which bit of a word
// on. The rows of sign bits cover whole bricks.
INLINE __global const uint* sign_bits_of(Layout layout, int3 brick, int z, Output output) {
    const int3 at = brick - vload3(0, layout.brick_first);
    const size_t row = (size_t)(at.z * CLSDF_BRICK + z) * (layout.bricks[1] * CLSDF_BRICK) + at.y * CLSDF_BRICK;
    return output.sign_bits + row * layout.sign_words + at.x / 4;
}
INLINE uint sign_shift_of(Layout layout, int3 brick) {
    return (uint)(brick.x - layout.brick_first[0]) % 4 * CLSDF_BRICK;
}

// A row of a brick, as it is written.
typedef struct FinishedRow {
    uint8 distance;
#ifdef NEAREST
    uint8 triangle;
#endif
} FinishedRow;

// Row (y, z); of its samples [begin, end) it is counted which lie in the band.
INLINE FinishedRow finished_row(Layout layout, __global const Minimum* minimum, int y, int z, uint inside, int begin,
                                int end, __private ulong* counters) {
    FinishedRow row;
    int8 in_band;
    const float8 square = as_float8(row_of((__global const uint*)minimum->squared, y, z));
    row.distance = as_uint8(signed_distances(layout, inside, square, &in_band));
#ifdef NEAREST
    const uint8 nearest = row_of((__global const uint*)minimum->triangle, y, z);
    row.triangle = in_band ? nearest : (uint8)CLSDF_NO_TRIANGLE;
#endif
#ifdef COUNT
    int in[8];
    vstore8(in_band, 0, in);
    for (int x = begin; x < end; ++x) counters[CLSDF_COUNT_BAND] += in[x] != 0;
#endif
    return row;
}

// Writes the samples of a brick that belong to the part, whose rows were asked for.
static inline void write_brick(Layout layout, int3 brick, __global const Minimum* minimum, Output output,
                               __private ulong* counters) {
    const int3 size = vload3(0, layout.size);
    const int3 first = brick * CLSDF_BRICK - vload3(0, layout.first);  // may be negative
    const int3 begin = max(-first, (int3)(0)), end = min(size - first, (int3)(CLSDF_BRICK));
    *mark_of(layout, brick, output) = 1;
    const uint shift = sign_shift_of(layout, brick);
    for (int z = begin.z; z < end.z; ++z) {
        __global const uint* sign_bits = sign_bits_of(layout, brick, z, output);
        for (int y = begin.y; y < end.y; ++y) {
            const uint inside = sign_bits[y * layout.sign_words] >> shift;
            const FinishedRow row = finished_row(layout, minimum, y, z, inside, begin.x, end.x, counters);
            const size_t at = ((size_t)(first.z + z) * size.y + (first.y + y)) * size.x + (first.x + begin.x);
            store_row(row.distance, begin.x, end.x, (__global uint*)output.distance + at);
#ifdef NEAREST
            store_row(row.triangle, begin.x, end.x, output.triangle + at);
#endif
        }
    }
}

// The same of `count` bricks that follow each other along x. None of their rows was asked for: of two bricks and more
// they have whole lines of memory, which are not read; at least where they begin on a line.
static inline void write_run(Layout layout, int3 brick, int count, __global const Minimum* minima, Output output,
                             __private ulong* counters) {
    const int3 size = vload3(0, layout.size);
    const int3 first = brick * CLSDF_BRICK - vload3(0, layout.first);  // may be negative
    const int3 begin = max(-first, (int3)(0)), end = min(size - first, (int3)(count, 1, 1) * CLSDF_BRICK);
    for (int n = 0; n < count; ++n) mark_of(layout, brick, output)[n] = 1;
    // Of a slice: rows that are read right after they are stored would be waited for.
    uint distances[CLSDF_BRICK][CLSDF_COARSE];
#ifdef NEAREST
    uint triangles[CLSDF_BRICK][CLSDF_COARSE];
#endif
    for (int z = begin.z; z < end.z; ++z) {
        for (int n = 0; n < count; ++n) {
            const int3 each = brick + (int3)(n, 0, 0);
            __global const uint* sign_bits = sign_bits_of(layout, each, z, output);
            const uint shift = sign_shift_of(layout, each);
            const int x0 = max(begin.x - n * CLSDF_BRICK, 0), x1 = min(end.x - n * CLSDF_BRICK, CLSDF_BRICK);
            for (int y = begin.y; y < end.y; ++y) {
                const uint inside = sign_bits[y * layout.sign_words] >> shift;
                const FinishedRow row = finished_row(layout, minima + n, y, z, inside, x0, x1, counters);
                store_eight(row.distance, n, distances[y]);
#ifdef NEAREST
                store_eight(row.triangle, n, triangles[y]);
#endif
            }
        }
        for (int y = begin.y; y < end.y; ++y) {
            const size_t row = ((size_t)(first.z + z) * size.y + (first.y + y)) * size.x;
            const size_t from = row + first.x + begin.x, to = row + first.x + end.x;
            store_values(distances[y] + begin.x, (__global uint*)output.distance + from,
                         (__global uint*)output.distance + to);
#ifdef NEAREST
            store_values(triangles[y] + begin.x, output.triangle + from, output.triangle + to);
#endif
        }
    }
}

// Writes some bricks of a coarse brick, by runs. (Measured, on an Intel Xeon: where rows begin on lines of memory, the
// bricks of sphere6 and of the bunny, in bands of 10% and of 3 voxels at 512^3, take 5 to 11% less time than one by one
// with their rows asked for; where they begin anywhere, as long.)
static inline void write_runs(Layout layout, int3 coarse, ulong bricks, __global const Minimum* minima, Output output,
                              __private ulong* counters) {
    while (bricks) {
        const uint b = lowest_bit_of_long(bricks);
        const uint row = (uint)(bricks >> b) & (0xFu >> b % CLSDF_BRICKS_PER_COARSE);
        const uint count = lowest_bit(~row);
        write_run(layout, brick_of_coarse(coarse, b), (int)count, minima + b, output, counters);
        bricks &= ~((((ulong)1 << count) - 1) << b);
    }
}

#endif
