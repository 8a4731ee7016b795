// The values of whole slices from their keys: the distance with its sign where it lies in the band, else the fill.

#include "frame.h"
#include "piece.h"
#include "signed_distance.h"
#include "slices_key.h"

// Slices [first_slice, end_slice) of the lattice are those that the keys hold. Global size: (samples of x, rows of y,
// slices), or more.
__kernel void slices_finish(Layout layout, int first_slice, int end_slice, KEY_PARAMETERS,
                            __global const uint* sign_bits, __global float* distance
#ifdef NEAREST
                            ,
                            __global uint* triangle
#endif
#ifdef COUNT
                            ,
                            __global uint* band_samples  // of each slice of the part
#endif
) {
    const int x = get_global_id(0), y = get_global_id(1), z = get_global_id(2);
    if (x >= layout.size[0] || z >= end_slice - first_slice) return;
    const uint2 key = square_and_triangle(KEY_ARGUMENTS, ((size_t)z * layout.size[1] + y) * layout.size[0] + x);
    // The rows of sign bits cover whole bricks.
    const int3 from_brick = vload3(0, layout.first) - vload3(0, layout.brick_first) * CLSDF_BRICK;
    const int slice = first_slice - layout.first[2] + z;
    const size_t bit_row = (size_t)(from_brick.z + slice) * (layout.bricks[1] * CLSDF_BRICK) + (from_brick.y + y);
    const int bit = from_brick.x + x;
    const bool negative = (sign_bits[bit_row * layout.sign_words + bit / 32] >> (bit % 32)) & 1u;
    const size_t at = ((size_t)slice * layout.size[1] + y) * layout.size[0] + x;
    bool in_band;
    distance[at] = signed_distance(layout, negative, as_float(key.x), &in_band);
#ifdef NEAREST
    triangle[at] = in_band ? key.y : CLSDF_NO_TRIANGLE;
#endif
#ifdef COUNT
    if (in_band) atomic_inc(band_samples + slice);
#endif
}
