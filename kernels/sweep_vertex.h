// One definition for the host and the kernels: a vertex as the sweep for the sign sees it.
#ifndef CLSDF_SWEEP_VERTEX_H
#define CLSDF_SWEEP_VERTEX_H

#ifdef __OPENCL_VERSION__
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef long clsdf_int64;
#else
#include <cstddef>
#include <cstdint>
namespace clsdf {
using clsdf_int64 = std::int64_t;
#endif

typedef struct SweepVertex {
    clsdf_int64 y, z;  // in samples of the lattice, snapped to multiples of 2^-bits_y and 2^-bits_z
    double x;          // in samples of the lattice
} SweepVertex;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(SweepVertex) == 24 && offsetof(SweepVertex, x) == 16);
}  // namespace clsdf
#endif

#endif
