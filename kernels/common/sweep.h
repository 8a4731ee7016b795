// One definition for the host and the kernels: what sweeps of rows for sides work on, and records of rows.
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

// What a row meets; of the sweep for the sign a crossing with the surface.
typedef struct SweepRecord {
    clsdf_uint32 row;
    clsdf_uint32 key;    // see sign_sweep.cl, exact_sides.cl and links.cl
    clsdf_uint32 index;  // among the row's records, in no order
} SweepRecord;

// Counters of the work-items.
typedef struct SweepTotals {
    clsdf_uint32 records;       // taken, those left over included
    clsdf_uint32 large;         // triangles that wait for the second launch
    clsdf_uint32 large_blocks;  // their rows, by CLSDF_LARGE_ROWS
    clsdf_uint32 largest_rows;  // of one of them
    clsdf_uint32 inexact;       // exact sides: of triangles whose coordinates are out of range (expansions.h)
} SweepTotals;

// The samples whose exact sides are found. Their coordinates, in units, are in one array: those along x, then y, z.
typedef struct SampleRows {
    double per_unit;        // what the caller's coordinates are multiplied by; a power of two
    double per_spacing[3];  // 1 / the spacing in units
    clsdf_int32 size[3];
    clsdf_uint32 words;  // of 32 sides, in a row along x; rows follow each other by y, then by z
} SampleRows;

// The most samples of a row: a key of exact_sides.cl has so many bits for them.
#define CLSDF_MOST_EXACT_SAMPLES (1 << 22)

#ifndef __OPENCL_VERSION__
static_assert(sizeof(SweepVertex) == 24 && offsetof(SweepVertex, x) == 16);
static_assert(sizeof(SweepRecord) == 12 && sizeof(SweepTotals) == 20 && sizeof(SampleRows) == 48);
}  // namespace clsdf
#endif

#endif
