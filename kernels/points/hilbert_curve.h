// One definition for the host and the kernels: a Hilbert curve through cells, in the order of which points lie.
#ifndef CLSDF_HILBERT_CURVE_H
#define CLSDF_HILBERT_CURVE_H

#include "polyhedron.h"
#include "spread_bits.h"

// Cells along an axis, in bits: a place on the curve has three times as many.
#define CLSDF_CURVE_BITS 10

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// All bits if the bit is set.
static inline clsdf_uint32 curve_mask(clsdf_uint32 x, clsdf_uint32 bit) {
    return 0u - (x >> bit & 1u);
}

// The place of a cell on the curve (J. Skilling, Programming the Hilbert curve, 2004), without branches: compilers take
// several cells at a time.
static inline clsdf_uint32 place_on_curve(clsdf_uint32 x, clsdf_uint32 y, clsdf_uint32 z) {
    for (clsdf_uint32 bit = CLSDF_CURVE_BITS - 1; bit > 0; --bit) {
        const clsdf_uint32 below = (1u << bit) - 1u;
        x ^= curve_mask(x, bit) & below;
        const clsdf_uint32 of_y = curve_mask(y, bit), with_y = (x ^ y) & below & ~of_y;
        x ^= (below & of_y) | with_y;
        y ^= with_y;
        const clsdf_uint32 of_z = curve_mask(z, bit), with_z = (x ^ z) & below & ~of_z;
        x ^= (below & of_z) | with_z;
        z ^= with_z;
    }
    y ^= x;
    z ^= y;
    clsdf_uint32 flips = 0;
    for (clsdf_uint32 bit = CLSDF_CURVE_BITS - 1; bit > 0; --bit) flips ^= curve_mask(z, bit) & ((1u << bit) - 1u);
    return spread_bits(x ^ flips) << 2 | spread_bits(y ^ flips) << 1 | spread_bits(z ^ flips);
}

#ifndef __OPENCL_VERSION__
}  // namespace clsdf
#endif

#endif
