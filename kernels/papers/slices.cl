// The scan by slices, in three kernels: slices_active lists the pieces that cut each slice, slices_scan finds the least
// key of each sample, slices_finish writes the values.
//
// Compile-time options: GROUP, BATCH; LANES, 8 or 1 (simd.h): samples of a row at a time; NEAREST and KEY_64
// (slices.h); LONG_BRICKS (distance.h); COUNT counts work.

#include "distance.h"
#include "frame.h"
#include "piece.h"
#include "sample_values.h"
#include "shares.h"
#include "slices.h"

// The pieces that cut each slice, by count, scan, fill: no other slice of a piece is ever looked at.
//
// Each work-item takes a contiguous range of pieces and counts into a histogram of its own, so that no atomics are
// needed and the lists are in the order of the pieces, whatever the number of work-items:
//   counts[(slice - the part's first) * parts + part], scanned, is where a part's entries of a slice begin.

// Slices [begin, end) of the lattice. With `fill` 0 it counts; with 1 it writes (piece, slice), `counts` being where
// each part's entries begin, `base` entries before the first of `active`.
__kernel void slices_active(Layout layout, uint count, __global const Piece* pieces, int begin, int end,
                            __global uint* counts, __global uint2* active, uint base, int fill) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const uint last = share_of(count, part + 1, parts);
    for (uint i = share_of(count, part, parts); i < last; ++i) {
        const int slice_end = min(pieces[i].slice_end, end);
        for (int slice = max(pieces[i].slice_begin, begin); slice < slice_end; ++slice) {
            const uint slot = counts[(size_t)(slice - layout.first[2]) * parts + part]++;
            if (fill) active[slot - base] = (uint2)(i, as_uint(slice));
        }
    }
}

// The values of whole slices from their keys: the distance with its sign if it lies in the band, else the fill.

// Slices [first_slice, end_slice) of the lattice are those that the keys hold. Global size: (samples of x, rows of y,
// slices), or more.
__kernel void slices_finish(Layout layout, int first_slice, int end_slice, KEY_PARAMETERS,
                            __global const uint* sign_bits, __global float* distance
#ifdef NEAREST
                            ,
                            __global uint* triangle
#endif
#ifdef COUNT
                            ,
                            __global uint* band_samples  // of each slice of the part
#endif
) {
    const int x = get_global_id(0), y = get_global_id(1), z = get_global_id(2);
    if (x >= layout.size[0] || z >= end_slice - first_slice) return;
    const uint2 key = square_and_triangle(KEY_ARGUMENTS, ((size_t)z * layout.size[1] + y) * layout.size[0] + x);
    const int3 from_brick = vload3(0, layout.first) - vload3(0, layout.brick_first) * CLSDF_BRICK;
    const int slice = first_slice - layout.first[2] + z;
    const bool negative =
        is_inside(sign_row(layout, sign_bits, from_brick.y + y, from_brick.z + slice), from_brick.x + x);
    const size_t at = ((size_t)slice * layout.size[1] + y) * layout.size[0] + x;
    bool in_band;
    distance[at] = signed_distance(layout, negative, as_float(key.x), &in_band);
#ifdef NEAREST
    triangle[at] = in_band ? key.y : CLSDF_NO_TRIANGLE;
#endif
#ifdef COUNT
    if (in_band) atomic_inc(band_samples + slice);
#endif
}

// The distance at every sample of the pieces that cut a slice, by seven sites or by the piece's own: the polygon in
// which a piece cuts it gives the rows, the piece's half-spaces the samples of a row, and the least key of a sample
// stays.
//
// A group takes BATCH entries of the active list, and its work-items their rows, so that a large polygon is shared
// among them. Offsets are those of the sample's brick: a sample and a triangle have the same distance as in the scan by
// bricks, within the accuracy; as in bricks_by_group.cl, to the last bit.

// For all code below; distances are contracted.
#pragma OPENCL FP_CONTRACT OFF

// A convex polygon gets one corner more with each half-plane; a few are left for those that rounding makes.
#define MOST_CORNERS (2 * CLSDF_MOST_PLANES)

#ifdef COUNT
#define COUNT_ADD(counter, n) counters[counter] += (n)
#define COUNTERS_PARAMETER , __private ulong* counters
#define COUNTERS_ARGUMENT , counters
#else
#define COUNT_ADD(counter, n)
#define COUNTERS_PARAMETER
#define COUNTERS_ARGUMENT
#endif

// Clips a convex polygon to normal . point <= room; returns the number of its corners.
static inline uint clip(__private const double2* polygon, uint count, double2 normal, double room,
                        __private double2* clipped) {
    uint n = 0;
    double2 before = polygon[count - 1];
    double beyond_before = normal.x * before.x + normal.y * before.y - room;
    for (uint i = 0; i < count; ++i) {
        const double2 corner = polygon[i];
        const double beyond = normal.x * corner.x + normal.y * corner.y - room;
        if ((beyond > 0.0) != (beyond_before > 0.0) && n < MOST_CORNERS)
            clipped[n++] = before + beyond_before / (beyond_before - beyond) * (corner - before);
        if (!(beyond > 0.0) && n < MOST_CORNERS) clipped[n++] = corner;
        before = corner;
        beyond_before = beyond;
    }
    return n;
}

// The rows [x, y) of the part that the polygon of a piece in slice z touches.
static inline int2 rows_of(Layout layout, Piece piece, __global const PiecePlane* planes, int z COUNTERS_PARAMETER) {
    double2 polygon[MOST_CORNERS], other[MOST_CORNERS];
    const double k = (double)z - (double)piece.origin[2];
    const double margin = 1.5;  // samples
    const double left = (double)layout.first[0] - margin - (double)piece.origin[0],
                 front = (double)layout.first[1] - margin - (double)piece.origin[1];
    const double right = left + (double)(layout.size[0] - 1) + 2.0 * margin,
                 back = front + (double)(layout.size[1] - 1) + 2.0 * margin;
    polygon[0] = (double2)(left, front);
    polygon[1] = (double2)(right, front);
    polygon[2] = (double2)(right, back);
    polygon[3] = (double2)(left, back);
    uint corners = 4;
    for (uint n = 0; n < piece.plane_count && corners > 0; ++n) {
        const double4 plane = vload4(piece.plane_begin + n, (__global const double*)planes);
        const double room = plane.w + 3.0 * CLSDF_PIECE_SLACK - plane.z * k;
        corners = clip(polygon, corners, plane.xy, room, other);
        for (uint i = 0; i < corners; ++i) polygon[i] = other[i];
    }
    COUNT_ADD(CLSDF_SLICES_INTERSECTIONS, 1);
    COUNT_ADD(CLSDF_SLICES_EMPTY, corners == 0);
    if (corners == 0) return (int2)(0, 0);
    double low = polygon[0].y, high = low;
    for (uint i = 1; i < corners; ++i) {
        low = LESSER(low, polygon[i].y);
        high = GREATER(high, polygon[i].y);
    }
    const double first = (double)layout.first[1] - (double)piece.origin[1], last = first + (layout.size[1] - 1);
    low = ceil(low);
    high = floor(high);
    const int begin = layout.first[1] + (int)(GREATER(low, first) - first);
    const int end = layout.first[1] + (int)(LESSER(high, last) - first) + 1;
    return (int2)(begin, max(begin, end));
}

// The samples [x, y) of the part's row (y, z) in the piece.
static inline int2 span_of(Layout layout, Piece piece, __global const PiecePlane* planes, int y, int z) {
    const double j = (double)y - (double)piece.origin[1], k = (double)z - (double)piece.origin[2];
    const double first = (double)layout.first[0] - (double)piece.origin[0];
    double low = first, high = first + (layout.size[0] - 1);
    for (uint n = 0; n < piece.plane_count; ++n) {
        const double4 plane = vload4(piece.plane_begin + n, (__global const double*)planes);
        const double room = plane.w + CLSDF_PIECE_SLACK - plane.y * j - plane.z * k;
        const double at = room / plane.x;
        if (plane.x > 0.0) high = LESSER(at, high);
        if (plane.x < 0.0) low = GREATER(at, low);
        if (plane.x == 0.0 && room < 0.0) high = low - 2.0;
    }
    low = ceil(low);
    high = floor(high);
    if (!(low <= high)) return (int2)(0, 0);
    return layout.first[0] + (int2)((int)(low - first), (int)(high - first) + 1);
}

static inline double brick_centre(int sample) {
    return (double)(sample & ~(CLSDF_BRICK - 1)) + 0.5 * (CLSDF_BRICK - 1);
}

static inline void scan_row(Layout layout, Piece piece, __global const PiecePlane* planes,
                            __global const Polyhedron* polyhedra, int first_slice, int y, int z,
                            KEY_PARAMETERS COUNTERS_PARAMETER) {
    const int2 span = span_of(layout, piece, planes, y, z);
    if (span.x >= span.y) return;
    COUNT_ADD(CLSDF_SLICES_COVERED, span.y - span.x);
    __global const Polyhedron* p = polyhedra + piece.polyhedron;
    const uint triangle = p->triangle;
    const double centre_y = brick_centre(y), centre_z = brick_centre(z);
    const floatL j = (float)((double)y - centre_y), k = (float)((double)z - centre_z);
    const size_t row = ((size_t)(z - first_slice) * layout.size[1] + (y - layout.first[1])) * layout.size[0];
    for (int brick = span.x & ~(CLSDF_BRICK - 1); brick < span.y; brick += CLSDF_BRICK) {
        const double centre_x = brick_centre(brick);
#ifdef LONG_BRICKS
        const double4 frame = frame_at(p, centre_x, centre_y, centre_z);
#else
        const Offsets offsets = offsets_at(p, centre_x, centre_y, centre_z);
#endif
        const int end = min(span.y, brick + CLSDF_BRICK);
#if LANES == 1
        for (int x = max(span.x, brick); x < end; ++x) {
            const int first = x;
#else
        {
            const int x = brick, first = max(span.x, brick);
#endif
            const floatL i = convert_floatL(LANE_NUMBERS) + (float)((double)x - centre_x);
#ifdef LONG_BRICKS
            const floatL squared = piece.site == CLSDF_SITE_NEAREST
                                       ? squared_distance_long_brick(p, frame, i, j, k)
                                       : squared_distance_to_site_long_brick(p, frame, piece.site, i, j, k);
#else
            const floatL squared = piece.site == CLSDF_SITE_NEAREST
                                       ? squared_distance(steps_of(p), offsets, i, j, k)
                                       : squared_distance_to_site(p, offsets, piece.site, i, j, k);
#endif
            COUNT_ADD(CLSDF_SLICES_EVALUATED, LANES);
            float each[LANES];
            store_lanes(squared, 0, each);
            for (int at = first; at < min(end, x + LANES); ++at)
                propose(KEY_ARGUMENTS, row + (at - layout.first[0]), each[at - x], triangle);
        }
    }
}

// Entries [begin, end) of the active list; `first_slice` is the one the keys begin with.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void slices_scan(
    Layout layout, uint begin, uint end, __global const uint2* active, __global const Piece* pieces,
    __global const PiecePlane* planes, __global const Polyhedron* polyhedra, int first_slice, KEY_PARAMETERS
#ifdef COUNT
    ,
    __global ulong* all_counters
#endif
) {
    __local uint row_ends[BATCH];  // of all rows of the batch
    __local int first_rows[BATCH];
    const uint item = get_local_id(0);
    const uint first = min(end, begin + (uint)get_group_id(0) * BATCH), count = min((uint)BATCH, end - first);
#ifdef COUNT
    ulong counters[CLSDF_SLICES_COUNTERS] = {0, 0, 0, 0};
#endif
    for (uint e = item; e < BATCH; e += GROUP) {
        int2 rows = (int2)(0, 0);
        if (e < count)
            rows = rows_of(layout, pieces[active[first + e].x], planes, as_int(active[first + e].y) COUNTERS_ARGUMENT);
        first_rows[e] = rows.x;
        row_ends[e] = rows.y - rows.x;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item == 0)
        for (uint e = 1; e < BATCH; ++e) row_ends[e] += row_ends[e - 1];
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint total = row_ends[BATCH - 1];
    uint e = 0;
    for (uint row = item; row < total; row += GROUP) {
        while (row_ends[e] <= row) ++e;
        const uint2 entry = active[first + e];
        const uint before = e == 0 ? 0 : row_ends[e - 1];
        scan_row(layout, pieces[entry.x], planes, polyhedra, first_slice, first_rows[e] + (int)(row - before),
                 as_int(entry.y), KEY_ARGUMENTS COUNTERS_ARGUMENT);
    }
#ifdef COUNT
    for (uint c = 0; c < CLSDF_SLICES_COUNTERS; ++c)
        all_counters[get_global_id(0) * CLSDF_SLICES_COUNTERS + c] += counters[c];
#endif
}
