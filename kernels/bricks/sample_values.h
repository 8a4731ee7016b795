// The value of a sample, as every kernel writes it: its sign bit, and its distance with that sign.
#ifndef CLSDF_SAMPLE_VALUES_H
#define CLSDF_SAMPLE_VALUES_H

#include "layout.h"
#include "simd.h"

// The number of a sample in the arrays of outputs; x, y, z are counted from the part's first sample. It wraps below
// zero for a sample before the first; numbers that are added undo that.
INLINE size_t sample_offset(Layout layout, int x, int y, int z) {
    return ((size_t)z * layout.size[1] + y) * layout.size[0] + x;
}

// Returns the first word of a row's sign bits. (y, z): the row, counted from the first sample of the part's first
// brick. The rows of sign bits cover whole bricks.
INLINE __global const uint* sign_row(Layout layout, __global const uint* sign_bits, int y, int z) {
    return sign_bits + ((size_t)z * (layout.bricks[1] * CLSDF_BRICK) + y) * layout.sign_words;
}

// True if sample x of a row is inside. x: counted as above.
INLINE bool is_inside(__global const uint* row, uint x) {
    return (row[x / 32] >> (x % 32)) & 1u;
}

// Defines a function that returns the distance with its sign if the sample lies in the band, else the fill. negative:
// the sample is inside; squared: of the distance, in units. A distance of 0 is +0, but negative if signs are exact
// (layout.least_inside): 0 - 0 is +0.
#define DEFINE_SIGNED_DISTANCE(signed_distance, Real, Mask)                                            \
    INLINE Real signed_distance(Layout layout, Mask negative, Real squared, __private Mask* in_band) { \
        const Real fill = negative ? (Real)layout.inside_fill : (Real)layout.outside_fill;             \
        const Real limit = negative ? (Real)layout.inside_squared : (Real)layout.outside_squared;      \
        *in_band = squared <= limit;                                                                   \
        const Real root = sqrt(squared) * layout.unit, most = fabs(fill);                              \
        const Real length = LESSER(root, most), least = (Real)layout.least_inside;                     \
        return *in_band ? (negative ? 0.0f - GREATER(length, least) : length) : fill;                  \
    }
DEFINE_SIGNED_DISTANCE(signed_distance, float, bool)
#if LANES != 1
DEFINE_SIGNED_DISTANCE(signed_distances, floatL, intL)
#endif
#undef DEFINE_SIGNED_DISTANCE

#endif
