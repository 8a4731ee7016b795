// Points in memory of a GPU, before and after they are looked up (points.cl): their order along a curve, which of them
// have no sign yet, and the outputs of those that are not usable. The curve's places are those that the host computes
// (lib/points/curve_order.cpp): coordinates are compared and multiplied in double, and nothing is fused.

#include "finish.h"
#include "hilbert_curve.h"
#include "point_order.h"
#include "point_tree.h"

#pragma OPENCL FP_CONTRACT OFF

#define ITEMS 64  // of a group that joins extents
#define GROUP_THAT_JOINS __attribute__((reqd_work_group_size(ITEMS, 1, 1)))

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

// Extents. ------------------------------------------------------------------------------------------------------------

static inline PointExtent extent_of_none(void) {
    PointExtent extent;
    for (int axis = 0; axis < 3; ++axis) {
        extent.lower[axis] = INFINITY;
        extent.upper[axis] = -INFINITY;
    }
    for (int why = 0; why < 2; ++why) {
        extent.unusable[why] = 0;
        extent.first[why] = 0xFFFFFFFFu;
    }
    return extent;
}

static inline PointExtent joined_extent(PointExtent a, PointExtent b) {
    for (int axis = 0; axis < 3; ++axis) {
        a.lower[axis] = LESSER(b.lower[axis], a.lower[axis]);
        a.upper[axis] = GREATER(b.upper[axis], a.upper[axis]);
    }
    for (int why = 0; why < 2; ++why) {
        a.unusable[why] += b.unusable[why];
        a.first[why] = min(a.first[why], b.first[why]);
    }
    return a;
}

// extents[0] becomes the join of a group's.
static inline void join_group(PointExtent own, __local PointExtent* extents) {
    const uint item = get_local_id(0);
    extents[item] = own;
    for (uint step = ITEMS / 2; step > 0; step /= 2) {
        barrier(CLK_LOCAL_MEM_FENCE);
        if (item < step) extents[item] = joined_extent(extents[item], extents[item + step]);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// The extent of each group's points. usable: the limits of points that are looked up.
__kernel GROUP_THAT_JOINS void measure_points(PointSource source, uint count, PointLimits usable,
                                              __global const uchar* memory, __global PointExtent* extents) {
    __local PointExtent of_items[ITEMS];
    PointExtent own = extent_of_none();
    for (uint i = get_global_id(0); i < count; i += get_global_size(0)) {
        const double3 p = position_of(source, memory, i);
        PointExtent of_point = extent_of_none();
        if (is_within(usable, p)) {
            of_point.lower[0] = of_point.upper[0] = p.x;
            of_point.lower[1] = of_point.upper[1] = p.y;
            of_point.lower[2] = of_point.upper[2] = p.z;
        } else {
            const int why = is_finite(p) ? CLSDF_POINT_TOO_FAR : CLSDF_POINT_NOT_FINITE;
            of_point.unusable[why] = 1;
            of_point.first[why] = i;
        }
        own = joined_extent(own, of_point);
    }
    join_group(own, of_items);
    if (get_local_id(0) == 0) extents[get_group_id(0)] = of_items[0];
}

#define CURVE_CELLS ((double)(1u << CLSDF_CURVE_BITS))

// The cells of the points' box, as far as it lies in `most`. One group.
__kernel GROUP_THAT_JOINS void join_extents(uint count, PointLimits most, __global const PointExtent* extents,
                                            __global PointCells* cells) {
    __local PointExtent of_items[ITEMS];
    PointExtent own = extent_of_none();
    for (uint i = get_local_id(0); i < count; i += ITEMS) own = joined_extent(own, extents[i]);
    join_group(own, of_items);
    if (get_local_id(0) != 0) return;
    double longest = -INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
        const double raised = GREATER(of_items[0].lower[axis], most.lower[axis]);
        const double lower = LESSER(raised, most.upper[axis]);
        const double raised_upper = GREATER(of_items[0].upper[axis], most.lower[axis]);
        const double length = LESSER(raised_upper, most.upper[axis]) - lower;
        cells->lower[axis] = lower;
        longest = GREATER(length, longest);
    }
    cells->scale = longest > CURVE_CELLS / DBL_MAX ? CURVE_CELLS / longest : 0.0;
    for (int why = 0; why < 2; ++why) {
        cells->unusable[why] = of_items[0].unusable[why];
        cells->first[why] = of_items[0].first[why];
    }
}

// Order. --------------------------------------------------------------------------------------------------------------

static inline uint cell_of(double x, double lower, double scale) {
    const double cell = (x - lower) * scale;
    const double positive = GREATER(cell, 0.0);
    return (uint)(int)LESSER(positive, CURVE_CELLS - 1.0);
}

// The place of each point on the curve. A point that is not usable counts as the first cell.
__kernel void keys_of_points(PointSource source, uint count, PointLimits usable, __global const uchar* memory,
                             __global const PointCells* cells, __global uint* keys) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    const double3 p = position_of(source, memory, i);
    const double scale = cells->scale;
    keys[i] = is_within(usable, p)
                  ? place_on_curve(cell_of(p.x, cells->lower[0], scale), cell_of(p.y, cells->lower[1], scale),
                                   cell_of(p.z, cells->lower[2], scale))
                  : 0;
}

// The points in their order, in units; the origin if a point is not usable. first_place: where the results of the
// first of the caller's points go. places: those of each point's.
__kernel void gather_points(PointSource source, uint count, PointLimits usable, PointUnits units, uint first_place,
                            __global const uchar* memory, __global const uint* order, __global double* points,
                            __global uint* places) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    const uint point = order[i];
    const double3 p = position_of(source, memory, point);
    const bool is_usable = is_within(usable, p);
    points[3 * (size_t)i] = is_usable ? (p.x - units.origin[0]) / units.unit : 0.0;
    points[3 * (size_t)i + 1] = is_usable ? (p.y - units.origin[1]) / units.unit : 0.0;
    points[3 * (size_t)i + 2] = is_usable ? (p.z - units.origin[2]) / units.unit : 0.0;
    places[i] = first_place + point;
}

// Signs. --------------------------------------------------------------------------------------------------------------

// Points without a sign: those outside of `limits` are outside; those farther than nearly_on_surface, in units, are,
// too, if no point is inside (all_outside). The others are open, 1. has_signs: points that are not
// CLSDF_POINT_UNDECIDED are left out.
__kernel void find_open_points(PointSource source, uint count, PointLimits limits, uint all_outside,
                               double nearly_on_surface, uint first_place, uint has_signs, __global const uchar* memory,
                               __global const uint* places, __global const double* squared, __global uchar* signs,
                               __global uint* open) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    bool is_open = !has_signs || signs[i] == CLSDF_POINT_UNDECIDED;
    if (is_open) {
        const bool is_outside = !is_within(limits, position_of(source, memory, places[i] - first_place)) ||
                                (all_outside && !(sqrt(squared[i]) < nearly_on_surface));
        signs[i] = is_outside ? CLSDF_POINT_OUTSIDE : CLSDF_POINT_UNDECIDED;
        is_open = !is_outside;
    }
    open[i] = is_open;
}

// Lists the open points, in their order. starts: the prefix sums of `open`.
__kernel void list_open_points(PointSource source, uint count, uint first_place, __global const uchar* memory,
                               __global const uint* starts, __global const double* points, __global const uint* places,
                               __global const uint* faces, __global const double* squared,
                               __global OpenPoint* open_points, __global double* open_in_units,
                               __global uint* open_places, __global uint* open_faces) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    const uint to = starts[i];
    if (starts[i + 1] == to) return;
    const double3 p = position_of(source, memory, places[i] - first_place);
    OpenPoint point;
    point.position[0] = p.x;
    point.position[1] = p.y;
    point.position[2] = p.z;
    point.squared = squared[i];
    open_points[to] = point;
    for (int axis = 0; axis < 3; ++axis) open_in_units[3 * (size_t)to + axis] = points[3 * (size_t)i + axis];
    open_places[to] = places[i];
    open_faces[to] = faces[i];
}

// Points that are not usable. -----------------------------------------------------------------------------------------

// Their outputs: every bit is set, but of the distance. That is `within` if the point is finite and has_limit, else not
// a number.
__kernel void leave_unusable_points(PointSource source, uint count, PointLimits usable, uint has_limit, double within,
                                    uint first_place, __global const uchar* memory,
                                    __global const Polyhedron* polyhedra, __global float* distance,
                                    FINISHING_PARAMETERS) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    const double3 p = position_of(source, memory, i);
    if (is_within(usable, p)) return;
    SET_FINISHING(finishing)
    const size_t place = (size_t)first_place + i;
    const bool is_number = has_limit && is_finite(p);
    if (IS_DOUBLE(&finishing, distance)) {
        finishing.of_distance[place] = is_number ? within : as_double((ulong)0x7FF8000000000000ul);
    } else {
        ((__global uint*)distance)[place] = is_number ? as_uint((float)within) : 0x7FC00000u;
    }
    leave_sample(&finishing, place);
}
