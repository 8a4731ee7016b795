// The least distance of each sample of a brick, and its way into the field.
#ifndef CLSDF_BRICK_MINIMUM_H
#define CLSDF_BRICK_MINIMUM_H

#include "frame.h"
#include "request.h"
#include "subblocks.h"

#if defined(__x86_64__) && HAS_BUILTIN(__builtin_nontemporal_store) && HAS_BUILTIN(__builtin_ia32_sfence)
#define STORES_PAST_CACHES
#endif

// The state of a brick's samples, sub-block by sub-block.
typedef struct Minimum {
    floatL squared[SUBBLOCKS * SUBBLOCK_VECTORS];
#ifdef NEAREST
    uintL triangle[SUBBLOCKS * SUBBLOCK_VECTORS];
#endif
} Minimum;

static inline void clear_minimum(__global Minimum* minimum) {
    for (uint n = 0; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) {
        minimum->squared[n] = INFINITY;
#ifdef NEAREST
        minimum->triangle[n] = CLSDF_NO_TRIANGLE;
#endif
    }
}

// Vector n. Of triangles that are equally near the one that comes first in the caller's order is kept.
INLINE void lower_minimum(__global Minimum* minimum, uint n, floatL squared, uint triangle) {
    const floatL least = minimum->squared[n];
#ifdef NEAREST
    const uintL nearest = minimum->triangle[n];
    const intL better = (squared < least) | ((squared == least) & (triangle < nearest));
    minimum->triangle[n] = better ? (uintL)triangle : nearest;
    minimum->squared[n] = better ? squared : least;
#else
    minimum->squared[n] = LESSER(squared, least);
#endif
}

// Upper bounds of the distances in a sub-block and in a brick, as far as they are computed.
INLINE float cap_of_subblock(__global const Minimum* minimum, uint b, float cap) {
    floatL greatest = minimum->squared[b * SUBBLOCK_VECTORS];
    for (uint v = 1; v < SUBBLOCK_VECTORS; ++v)
        greatest = GREATER(greatest, minimum->squared[b * SUBBLOCK_VECTORS + v]);
    const float reached = sqrt(greatest_lane(greatest));
    return LESSER(reached, cap);
}
static inline float cap_of_brick(__global const Minimum* minimum, float cap) {
    floatL greatest = minimum->squared[0];
    for (uint n = 1; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) greatest = GREATER(greatest, minimum->squared[n]);
    const float reached = sqrt(greatest_lane(greatest));
    return LESSER(reached, cap);
}

// Whether any of a brick's samples has a distance.
static inline bool has_distances(__global const Minimum* minimum) {
    floatL least = minimum->squared[0];
    for (uint n = 1; n < SUBBLOCKS * SUBBLOCK_VECTORS; ++n) least = LESSER(least, minimum->squared[n]);
    return -greatest_lane(-least) < INFINITY;
}

// What is written.
typedef struct Output {
    __global float* distance;
#ifdef NEAREST
    __global uint* triangle;
#endif
} Output;

// Where the rows of a brick go: addresses, of those before the part's first sample too.
typedef struct BrickRows {
    size_t distance;
#ifdef NEAREST
    size_t triangle;
#endif
    size_t y_step, z_step;
} BrickRows;

static inline void set_rows(Layout layout, int3 brick, Output output, __private BrickRows* rows) {
    const int3 at = brick * CLSDF_BRICK - vload3(0, layout.first);
    rows->y_step = (size_t)layout.size[0] * sizeof(float);
    rows->z_step = rows->y_step * layout.size[1];
    const size_t from_first = (size_t)at.z * rows->z_step + (size_t)at.y * rows->y_step + (size_t)at.x * sizeof(float);
    rows->distance = (size_t)output.distance + from_first;
#ifdef NEAREST
    rows->triangle = (size_t)output.triangle + from_first;
#endif
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

// Row (y, z) of a brick's samples, out of its sub-blocks.
INLINE uint8 row_of(__global const uint* samples, uint y, uint z) {
    __global const uint* half_row = samples + (z / 2 * 4 + y / 2) * SUBBLOCK_SAMPLES + (z % 2 * 2 + y % 2) * SUBBLOCK_X;
    return (uint8)(vload4(0, half_row), vload4(0, half_row + SUBBLOCK_PLANE * SUBBLOCK_SAMPLES));
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
INLINE __global uchar* mark_of(Layout layout, int3 brick, __global uchar* computed) {
    const int3 at = brick - vload3(0, layout.brick_first);
    return computed + ((size_t)at.z * layout.bricks[1] + at.y) * layout.bricks[0] + at.x;
}

// The sign bits from a brick's row (y, z) on. The rows of sign bits cover whole bricks.
INLINE uint sign_bits_of(Layout layout, int3 brick, int y, int z, __global const uint* sign_bits) {
    const int3 at = brick - vload3(0, layout.brick_first);
    const size_t row = (size_t)(z + at.z * CLSDF_BRICK) * (layout.bricks[1] * CLSDF_BRICK) + (y + at.y * CLSDF_BRICK);
    return sign_bits[row * layout.sign_words + at.x / 4] >> (at.x % 4 * 8);
}

#ifdef COUNT
// Samples [begin, end) of a row.
INLINE void count_band(int8 in_band, int begin, int end, __private ulong* counters) {
    int in[8];
    vstore8(in_band, 0, in);
    for (int x = begin; x < end; ++x) counters[CLSDF_COUNT_BAND] += in[x] != 0;
}
#endif

// Writes the samples of a brick that belong to the part.
static inline void write_brick(Layout layout, int3 brick, __global const Minimum* minimum,
                               __global const uint* sign_bits, __global uchar* computed, Output output,
                               __private ulong* counters) {
    const int3 first = vload3(0, layout.first), size = vload3(0, layout.size);
    const int3 begin = max(brick * CLSDF_BRICK, first) - first,
               end = min((brick + 1) * CLSDF_BRICK, first + size) - first;
    const int3 relative = brick * CLSDF_BRICK - first;  // of the brick's first sample; may be negative
    *mark_of(layout, brick, computed) = 1;
    for (int z = begin.z; z < end.z; ++z)
        for (int y = begin.y; y < end.y; ++y) {
            const uint inside = sign_bits_of(layout, brick, y - relative.y, z - relative.z, sign_bits);
            const float8 square =
                as_float8(row_of((__global const uint*)minimum->squared, y - relative.y, z - relative.z));
            int8 in_band;
            const float8 value = signed_distances(layout, inside, square, &in_band);
            const size_t at = ((size_t)z * size.y + y) * size.x;
            const int x0 = begin.x - relative.x, x1 = end.x - relative.x;
            store_row(as_uint8(value), x0, x1, (__global uint*)output.distance + at + begin.x);
#ifdef NEAREST
            const uint8 nearest = row_of((__global const uint*)minimum->triangle, y - relative.y, z - relative.z);
            store_row(in_band ? nearest : (uint8)CLSDF_NO_TRIANGLE, x0, x1, output.triangle + at + begin.x);
#endif
#ifdef COUNT
            count_band(in_band, x0, x1, counters);
#endif
        }
}

#ifdef STORES_PAST_CACHES
// Whether the rows of a brick (`rows`) and of the next one along x are together lines of memory, all in the part; and
// their sign bits in one word, as write_pair() reads them.
INLINE bool are_lines(Layout layout, int3 brick, const BrickRows* rows) {
    const int3 at = brick * CLSDF_BRICK - vload3(0, layout.first), size = vload3(0, layout.size);
    const size_t row = 2 * CLSDF_BRICK * sizeof(float);
    size_t addresses = rows->distance | rows->y_step | rows->z_step;
#ifdef NEAREST
    addresses |= rows->triangle;
#endif
    return addresses % row == 0 && (brick.x - layout.brick_first[0]) % 2 == 0 && all(at >= 0) &&
           all(at + (int3)(2, 1, 1) * CLSDF_BRICK <= size);
}

// Writes a brick and the next one along x, whose rows are lines of memory: not read before they are written to, as
// lines are that a store to the caches meets. (Measured, on an Intel Xeon: of sphere6 in a band of 10% the bricks take
// a fifth less time, in one of 3 voxels at 512^3 a sixth; of the bunny 7 and 10%.)
static inline void write_pair(Layout layout, int3 brick, __global const Minimum* minima, __global const uint* sign_bits,
                              __global uchar* computed, Output output, const BrickRows* rows,
                              __private ulong* counters) {
    __global uchar* marks = mark_of(layout, brick, computed);
    marks[0] = marks[1] = 1;
    for (int z = 0; z < CLSDF_BRICK; ++z)
        for (int y = 0; y < CLSDF_BRICK; ++y) {
            const uint inside = sign_bits_of(layout, brick, y, z, sign_bits);
            float8 values[2];
            int8 in_band[2];
#pragma unroll
            for (uint n = 0; n < 2; ++n) {
                const float8 square = as_float8(row_of((__global const uint*)minima[n].squared, y, z));
                values[n] = signed_distances(layout, inside >> n * CLSDF_BRICK, square, in_band + n);
            }
            const size_t from_first = y * rows->y_step + z * rows->z_step;
            __builtin_nontemporal_store((float16)(values[0], values[1]),
                                        (__global float16*)(rows->distance + from_first));
#ifdef NEAREST
            uint8 nearest[2];
#pragma unroll
            for (uint n = 0; n < 2; ++n) {
                const uint8 of_row = row_of((__global const uint*)minima[n].triangle, y, z);
                nearest[n] = in_band[n] ? of_row : (uint8)CLSDF_NO_TRIANGLE;
            }
            __builtin_nontemporal_store((uint16)(nearest[0], nearest[1]),
                                        (__global uint16*)(rows->triangle + from_first));
#endif
#ifdef COUNT
            for (uint n = 0; n < 2; ++n) count_band(in_band[n], 0, CLSDF_BRICK, counters);
#endif
        }
}
#endif

#endif
