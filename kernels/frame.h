// A polyhedron's frame at a point of the lattice, and the polyhedron's test for blocks of samples.
//
// Offsets are formed in double from the two floats of each number and rounded once, so that what follows in float
// rounds with the size of the block, not with that of the triangle or the grid.
#ifndef CLSDF_FRAME_H
#define CLSDF_FRAME_H

#include "layout.h"

#pragma OPENCL EXTENSION cl_khr_fp64 : enable

// Arguments in memory cost more than these functions' own work.
#define INLINE inline __attribute__((always_inline))

// A comparison with a select: fmin and fmax cost four times as much, for the sake of NaN.
#define LESSER(a, b) ((a) < (b) ? (a) : (b))
#define GREATER(a, b) ((a) > (b) ? (a) : (b))

// The frame's coordinates, and what follows from them by subtraction of nearly equal numbers, at one point. "Right" and
// "left" are the formulas of the two halves; each holds where X lies on its side.
typedef struct Offsets {
    float x, y, z;
    float z_low;                        // what z lacks: most samples' nearest site is a face, and their distance is |z|
    float beyond_right, beyond_left;    // X - base[right], -X - base[left]
    float outward_right, outward_left;  // distance outward from the line of the slanted edge
    float along_right, along_left;      // position along it, from its end at the base
    float past_right, past_left;        // the same from the apex: along minus the edge's length
} Offsets;

inline double4 two_floats(__global const float* high, __global const float* low) {
    return convert_double4(vload4(0, high)) + convert_double4(vload4(0, low));
}

// (X, Y, Z, -) at a point given in samples of the lattice.
INLINE double4 frame_at(__global const Polyhedron* p, double x, double y, double z) {
    const double4 gx = two_floats(p->gradient_x_high, p->gradient_x_low);
    const double4 gy = two_floats(p->gradient_y_high, p->gradient_y_low);
    const double4 gz = two_floats(p->gradient_z_high, p->gradient_z_low);
    const double4 at_origin = two_floats(p->constant_high, p->constant_low);
    return gx * (x - p->origin_x) + (gy * (y - p->origin_y) + (gz * (z - p->origin_z) + at_origin));
}

INLINE Offsets offsets_at(__global const Polyhedron* p, double x, double y, double z) {
    const double4 frame = frame_at(p, x, y, z);
    const double4 high = convert_double4(vload4(0, p->base_high));           // base right, left, low parts right, left
    const double4 along = convert_double4(vload4(0, p->normal_along_high));  // along right, left, across right, left
    const double4 low = convert_double4(vload4(0, p->normal_along_low));
    const double beyond_right = frame.x - (high.x + high.z);
    const double beyond_left = -frame.x - (high.y + high.w);
    const double4 normal = along + low;
    Offsets o;
    o.x = (float)frame.x;
    o.y = (float)frame.y;
    o.z = (float)frame.z;
    o.z_low = (float)(frame.z - (double)o.z);
    o.beyond_right = (float)beyond_right;
    o.beyond_left = (float)beyond_left;
    o.outward_right = (float)(normal.x * beyond_right + normal.z * frame.y);
    o.outward_left = (float)(normal.y * beyond_left + normal.w * frame.y);
    o.along_right = (float)(normal.x * frame.y - normal.z * beyond_right);
    o.along_left = (float)(normal.y * frame.y - normal.w * beyond_left);
    const double above_apex = frame.y - ((double)p->altitude_high + (double)p->altitude_low);
    o.past_right = (float)(normal.x * above_apex - normal.z * frame.x);
    o.past_left = (float)(normal.y * above_apex + normal.w * frame.x);
    return o;
}

#endif
