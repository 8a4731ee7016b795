// One definition for the host and the kernels: the links of a lattice that a call asks for.
#ifndef CLSDF_LINK_LATTICE_H
#define CLSDF_LINK_LATTICE_H

#include "sweep.h"

// Faces that may cross one link, of which the order is found on the device.
#define CLSDF_MOST_LINK_FACES 16
// A line has no direction that way.
#define CLSDF_NO_DIRECTION 0xFFFFFFFFu
// Rows of lines that one work-item takes; a triangle that may meet more is divided.
#define CLSDF_LARGE_LINES 256

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

typedef struct LinkLattice {
    SampleRows samples;    // of the grid and of a margin around it
    clsdf_int64 first[3];  // the number on the lattice of the first one
    // Of the lattice in units: see LinkRaster of lib/segments.
    double origin[3];
    double per_unit[3];
    double far;
    double slope;
    double rounding;
    clsdf_int32 margin[3];
    clsdf_int32 directions;  // their number
    clsdf_int32 lines;       // their number
    clsdf_int32 is_parity;
} LinkLattice;

// A step, not 0.
typedef struct LinkStep {
    clsdf_int32 step[3];
    clsdf_int32 number;  // of its direction
} LinkStep;

// Links along one step: those whose samples, on the axis `along`, are begin, begin + stride and so on. A place has the
// coordinates u and v on the axes `first` and `second`, where the line meets the plane of sample 0 of `along`, and k
// along it, in steps.
typedef struct LinkLine {
    clsdf_int32 step[3];
    clsdf_int32 along, first, second;
    clsdf_int32 begin;
    clsdf_int32 count;               // of links, one after another
    clsdf_uint32 forward, backward;  // numbers of the directions, or CLSDF_NO_DIRECTION
} LinkLine;

// What the host is told of the rows.
typedef struct LinkResults {
    clsdf_uint32 open;   // links whose first wall the kernels cannot tell
    clsdf_uint32 wrong;  // links without a wall
    clsdf_uint32 first_wrong;
    clsdf_uint32 padding;
} LinkResults;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(LinkLattice) == 168 && offsetof(LinkLattice, first) == 48);
static_assert(sizeof(LinkStep) == 16 && sizeof(LinkLine) == 40 && sizeof(LinkResults) == 16);
}  // namespace clsdf
#endif

#endif
