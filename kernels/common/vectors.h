// Short vectors of doubles. The host, which compiles some headers of kernels, has the types and operators of
// lib/foundations/core/kernel_language.hpp.
#ifndef CLSDF_VECTORS_H
#define CLSDF_VECTORS_H

#include "simd.h"

#ifdef __OPENCL_VERSION__
#define DOUBLE2(x, y) ((double2)(x, y))
#define DOUBLE3(x, y, z) ((double3)(x, y, z))
#else
#define DOUBLE2(x, y) (double2{x, y})
#define DOUBLE3(x, y, z) (double3{x, y, z})
#endif

// A driver's dot() may fuse and order its operations as it likes.
INLINE double scalar_product(double3 a, double3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

#endif
