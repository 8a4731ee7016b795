// One definition for the host and the kernels.
#ifndef CLSDF_SPREAD_BITS_H
#define CLSDF_SPREAD_BITS_H

#include "polyhedron.h"

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// The ten bits of `x`, each followed by two zeros: three of them make a code of a cell's place on a curve.
static inline clsdf_uint32 spread_bits(clsdf_uint32 x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

#ifndef __OPENCL_VERSION__
}  // namespace clsdf
#endif

#endif
