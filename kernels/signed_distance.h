// The value of a sample, as every kernel writes it.
#ifndef CLSDF_SIGNED_DISTANCE_H
#define CLSDF_SIGNED_DISTANCE_H

#include "inline.h"
#include "layout.h"

// The distance with its sign where it lies in the band, else the fill. negative: the sample is inside; squared: of the
// distance, in units. (write_bricks.h has the same for vectors.)
INLINE float signed_distance(Layout layout, bool negative, float squared, __private bool* in_band) {
    const float fill = negative ? layout.inside_fill : layout.outside_fill;
    *in_band = squared <= (negative ? layout.inside_squared : layout.outside_squared);
    const float root = sqrt(squared) * layout.unit;
    const float length = LESSER(root, fabs(fill));
    return *in_band ? (negative && length != 0.0f ? -length : length) : fill;
}

#endif
