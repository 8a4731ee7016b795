// Points in memory of a GPU, before and after they are looked up (points.cl): their order along a curve, which of them
// have no sign yet, and the outputs of those that are not usable. The curve's places are those that the host computes
// (lib/points/curve_order.cpp): coordinates are compared and multiplied in double, and nothing is fused.

#include "finish.h"
#include "hilbert_curve.h"
#include "point_order.h"
#include "point_source.h"
#include "point_tree.h"

#pragma OPENCL FP_CONTRACT OFF

#define ITEMS 64  // of a group that joins extents
#define GROUP_THAT_JOINS __attribute__((reqd_work_group_size(ITEMS, 1, 1)))

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
    for (ulong next = get_global_id(0); next < count; next += get_global_size(0)) {
        const uint i = (uint)next;
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

// The place of each point on the curve. A point that is not usable counts as the first cell. No point is open yet.
__kernel void keys_of_points(PointSource source, uint count, PointLimits usable, __global const uchar* memory,
                             __global PointCells* cells, __global uint* keys) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    if (i == 0) cells->open = cells->left = 0;
    const double3 p = position_of(source, memory, i);
    const double scale = cells->scale;
    keys[i] = is_within(usable, p)
                  ? place_on_curve(cell_of(p.x, cells->lower[0], scale), cell_of(p.y, cells->lower[1], scale),
                                   cell_of(p.z, cells->lower[2], scale))
                  : 0;
}

// The points in their order, in units; the origin if a point is not usable.
__kernel void gather_points(PointSource source, uint count, PointLimits usable, PointUnits units,
                            __global const uchar* memory, __global const uint* order, __global double* points) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    const uint point = order[i];
    const double3 p = position_of(source, memory, point);
    const bool is_usable = is_within(usable, p);
    points[3 * (size_t)i] = is_usable ? (p.x - units.origin[0]) / units.unit : 0.0;
    points[3 * (size_t)i + 1] = is_usable ? (p.y - units.origin[1]) / units.unit : 0.0;
    points[3 * (size_t)i + 2] = is_usable ? (p.z - units.origin[2]) / units.unit : 0.0;
}

// Signs. --------------------------------------------------------------------------------------------------------------

// Points without a sign: those outside of `limits` are outside; those farther than CLSDF_NEARLY_ON_SURFACE are,
// too, if no point is inside (all_outside). The others are open, and listed. has_signs: points that are not
// CLSDF_POINT_UNDECIDED are left out. are_left: no kernel decides them. places: the point of each place in the order.
__kernel void find_open_points(PointSource source, uint count, PointLimits limits, uint all_outside, uint has_signs,
                               uint are_left, __global const uchar* memory, __global const uint* places,
                               __global const double* squared, __global uchar* signs,
                               volatile __global PointCells* cells, __global uint* open) {
    const uint i = get_global_id(0);
    if (i >= count || (has_signs && signs[i] != CLSDF_POINT_UNDECIDED)) return;
    const bool is_outside = !is_within(limits, position_of(source, memory, places[i])) ||
                            (all_outside && !(sqrt(squared[i]) < CLSDF_NEARLY_ON_SURFACE));
    signs[i] = is_outside ? CLSDF_POINT_OUTSIDE : CLSDF_POINT_UNDECIDED;
    if (!is_outside) open[atomic_inc(are_left ? &cells->left : &cells->open)] = i;
}

// The open points of a list, for the host.
__kernel void gather_open_points(PointSource source, uint count, __global const uchar* memory,
                                 __global const uint* left, __global const double* points, __global const uint* places,
                                 __global const uint* faces, __global const double* squared,
                                 __global OpenPoint* open_points, __global double* open_in_units,
                                 __global uint* open_places, __global uint* open_faces) {
    const uint to = get_global_id(0);
    if (to >= count) return;
    const uint i = left[to];
    const double3 p = position_of(source, memory, places[i]);
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

// Points without a result. --------------------------------------------------------------------------------------------

// The outputs of points that are not usable and, if leaves_open, of those whose sign is open: every bit is set, but of
// the distance. That is `within` if the point is finite, but too far, and has_limit, else not a number. has_status: the
// status of every point goes to `status`.
__kernel void mark_points(PointSource source, uint count, PointLimits usable, uint has_limit, double within,
                          uint leaves_open, uint has_status, ValuePlaces of_status, __global const uchar* memory,
                          __global const uint* places, __global const uchar* signs, __global uchar* status,
                          __global const Polyhedron* polyhedra, __global float* distance, FINISHING_PARAMETERS) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    const uint place = places[i];
    const double3 p = position_of(source, memory, place);
    uint result = CLSDF_STATUS_FOUND;
    if (!is_within(usable, p))
        result = is_finite(p) ? CLSDF_STATUS_TOO_FAR : CLSDF_STATUS_NOT_FINITE;
    else if (leaves_open && signs[i] == CLSDF_POINT_UNDECIDED)
        result = CLSDF_STATUS_SIGN_OPEN;
    if (has_status) status[of_status.first + (long)place * of_status.stride] = (uchar)result;
    if (result == CLSDF_STATUS_FOUND) return;
    SET_FINISHING(finishing)
    const bool is_number = has_limit && result == CLSDF_STATUS_TOO_FAR;
    if (IS_DOUBLE(&finishing, distance)) {
        finishing.of_distance[place] = is_number ? within : as_double((ulong)0x7FF8000000000000ul);
    } else {
        ((__global uint*)distance)[place] = is_number ? as_uint((float)within) : 0x7FC00000u;
    }
    leave_sample(&finishing, place);
}

// Packed values of the points to a target with strides. value_bytes: 1, 4 or 8.
__kernel void store_values(uint count, uint components, uint value_bytes, ValuePlaces to, __global const uchar* from,
                           __global uchar* target) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    __global uchar* at = target + (to.first + (long)i * to.stride);
    for (uint c = 0; c < components; ++c, at += to.component_stride) {
        const size_t number = (size_t)i * components + c;
        if (value_bytes == 8)
            *(__global ulong*)at = ((__global const ulong*)from)[number];
        else if (value_bytes == 4)
            *(__global uint*)at = ((__global const uint*)from)[number];
        else
            *at = from[number];
    }
}
