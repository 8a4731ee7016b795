// The samples and the corners of faces as exact predicates read them: in units.
#ifndef CLSDF_EXACT_ROWS_H
#define CLSDF_EXACT_ROWS_H

#include "look_windings.h"
#include "segment_crossings.h"
#include "sweep.h"

// Where the coordinates of an axis begin.
INLINE __global const double* on_axis(SampleRows samples, __global const double* at, int axis) {
    return at + (axis > 0 ? samples.size[0] : 0) + (axis > 1 ? samples.size[1] : 0);
}

INLINE double3 sample_at(SampleRows samples, __global const double* at, int x, int y, int z) {
    return (double3)(at[x], on_axis(samples, at, 1)[y], on_axis(samples, at, 2)[z]);
}

INLINE int guessed_sample(SampleRows samples, __global const double* own, int axis, double x) {
    return (int)clamp(ceil((x - own[0]) * samples.per_spacing[axis]), 0.0, (double)samples.size[axis]);
}

// The first sample on an axis whose coordinate is not below x, or above x; `size` if there is none.
INLINE int first_not_below(SampleRows samples, __global const double* at, int axis, double x) {
    __global const double* own = on_axis(samples, at, axis);
    int i = guessed_sample(samples, own, axis, x);
    while (i > 0 && own[i - 1] >= x) --i;
    while (i < samples.size[axis] && !(own[i] >= x)) ++i;
    return i;
}
INLINE int first_above(SampleRows samples, __global const double* at, int axis, double x) {
    __global const double* own = on_axis(samples, at, axis);
    int i = guessed_sample(samples, own, axis, x);
    while (i > 0 && own[i - 1] > x) --i;
    while (i < samples.size[axis] && !(own[i] > x)) ++i;
    return i;
}

INLINE double3 corner_of(SampleRows samples, __global const uint* triangles, __global const double* positions,
                         uint face, uint corner) {
    return vload3(triangles[3 * (size_t)face + corner], positions) * samples.per_unit;
}

// Whether a corner in units is exact: 0 only if the caller's coordinate is.
INLINE bool is_exact_corner(double3 in_units, __global const uint* triangles, __global const double* positions,
                            uint face, uint corner) {
    const double3 p = vload3(triangles[3 * (size_t)face + corner], positions);
    return is_in_exact_range(in_units.x) && is_in_exact_range(in_units.y) && is_in_exact_range(in_units.z) &&
           (in_units.x != 0.0 || p.x == 0.0) && (in_units.y != 0.0 || p.y == 0.0) && (in_units.z != 0.0 || p.z == 0.0);
}

#endif
