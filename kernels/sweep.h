// One definition for the host and the kernels: what the sweep for the sign works on.
#ifndef CLSDF_SWEEP_H
#define CLSDF_SWEEP_H

#ifdef __OPENCL_VERSION__
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef long clsdf_int64;
typedef uint clsdf_sweep_uint;
#else
#include <cstddef>
#include <cstdint>
namespace clsdf {
using clsdf_int64 = std::int64_t;
using clsdf_sweep_uint = std::uint32_t;
#endif

// A triangle whose box holds more rows is shared by several work-items.
#define CLSDF_LARGE_ROWS 64
// A work-item takes so many records at a time.
#define CLSDF_RECORD_BLOCK 32
// The row of a record that a block has left over.
#define CLSDF_NO_ROW 0xFFFFFFFFu

typedef struct SweepVertex {
    clsdf_int64 y, z;  // in samples of the lattice, snapped to multiples of 2^-bits_y and 2^-bits_z
    double x;          // in samples of the lattice
} SweepVertex;

// Where a row crosses the surface.
typedef struct SweepRecord {
    clsdf_sweep_uint row;
    clsdf_sweep_uint key;    // 2 k + (1 where the surface faces -x there), see sign_sweep.cl
    clsdf_sweep_uint place;  // among the row's crossings, in no order
} SweepRecord;

// What the work-items add up.
typedef struct SweepTotals {
    clsdf_sweep_uint records;       // taken, those left over included
    clsdf_sweep_uint large;         // triangles that wait for the second launch
    clsdf_sweep_uint large_blocks;  // their rows, by CLSDF_LARGE_ROWS
    clsdf_sweep_uint largest_rows;  // of one of them
} SweepTotals;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(SweepVertex) == 24 && offsetof(SweepVertex, x) == 16);
static_assert(sizeof(SweepRecord) == 12 && sizeof(SweepTotals) == 16);
}  // namespace clsdf
#endif

#endif
