// One definition for the host and the kernels: what the sweep for the sign works on.
#ifndef CLSDF_SWEEP_H
#define CLSDF_SWEEP_H

#include "polyhedron.h"

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// A triangle whose box holds more rows is shared by several work-items.
#define CLSDF_LARGE_ROWS 64
// The row of a record that a block has left over.
#define CLSDF_NO_ROW 0xFFFFFFFFu

typedef struct SweepVertex {
    clsdf_int64 y, z;  // in units of 2^-bits_y and 2^-bits_z samples of the lattice
    double x;          // in samples of the lattice
} SweepVertex;

// A crossing of a row and the surface.
typedef struct SweepRecord {
    clsdf_uint32 row;
    clsdf_uint32 key;    // 2 k + (1 if the surface faces -x there), see sign_sweep.cl
    clsdf_uint32 index;  // among the row's crossings, in no order
} SweepRecord;

// Counters of the work-items.
typedef struct SweepTotals {
    clsdf_uint32 records;       // taken, those left over included
    clsdf_uint32 large;         // triangles that wait for the second launch
    clsdf_uint32 large_blocks;  // their rows, by CLSDF_LARGE_ROWS
    clsdf_uint32 largest_rows;  // of one of them
} SweepTotals;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(SweepVertex) == 24 && offsetof(SweepVertex, x) == 16);
static_assert(sizeof(SweepRecord) == 12 && sizeof(SweepTotals) == 16);
}  // namespace clsdf
#endif

#endif
