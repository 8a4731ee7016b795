// Reads the caller's points.
#ifndef CLSDF_POINT_SOURCE_H
#define CLSDF_POINT_SOURCE_H

#include "point_order.h"

// A coordinate. A float is a double of the same value, also below the normal floats, which a device may flush.
static inline double coordinate(PointSource source, __global const uchar* memory, uint point, int axis) {
    __global const uchar* at = memory + (source.first + (long)point * source.stride + axis * source.component);
    if (source.is_double) return *(__global const double*)at;
    const uint bits = *(__global const uint*)at;
    if ((bits & 0x7F800000u) != 0) return (double)as_float(bits);
    const double small = (double)(bits & 0x7FFFFFu) * 0x1.0p-149;
    return bits >> 31 ? -small : small;
}

static inline double3 position_of(PointSource source, __global const uchar* memory, uint point) {
    return (double3)(coordinate(source, memory, point, 0), coordinate(source, memory, point, 1),
                     coordinate(source, memory, point, 2));
}

// False for a point that is not a number.
static inline bool is_within(PointLimits limits, double3 p) {
    return p.x >= limits.lower[0] && p.x <= limits.upper[0] && p.y >= limits.lower[1] && p.y <= limits.upper[1] &&
           p.z >= limits.lower[2] && p.z <= limits.upper[2];
}

static inline bool is_finite(double3 p) {
    return fabs(p.x) < INFINITY && fabs(p.y) < INFINITY && fabs(p.z) < INFINITY;
}

#endif
