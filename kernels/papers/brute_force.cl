// The distance at every sample to every triangle, without polyhedra and lists: the least of them is the answer.
//
// Offsets are those of the sample's brick: a sample and a triangle have the same distance as in the scans, within the
// accuracy.
//
// Compile-time options: LANES, 8 or 1 (simd.h): samples of a row at a time; ITEM_ROWS, rows of a brick that a
// work-item takes; NEAREST; LONG_BRICKS (distance.h).

#include "distance.h"
#include "slices.h"

#pragma OPENCL FP_CONTRACT OFF

#define ROWS (CLSDF_BRICK * CLSDF_BRICK)
#define ITEM_VECTORS (ITEM_ROWS * CLSDF_BRICK / LANES)

// The minima of a work-item so far.
typedef struct Least {
    floatL squared[ITEM_VECTORS];
    uintL triangle[ITEM_VECTORS];
} Least;

INLINE void lower(__private Least* least, uint v, floatL squared, uint triangle) {
#ifdef NEAREST
    // If distances are equal, the lower triangle is kept.
    const intL is_equal = squared == least->squared[v];
    const intL is_less = (squared < least->squared[v]) | (is_equal & ((uintL)triangle < least->triangle[v]));
    least->triangle[v] = is_less ? (uintL)triangle : least->triangle[v];
#endif
    least->squared[v] = LESSER(least->squared[v], squared);
}

// Bricks [first_brick, end_brick) of the part's, x first, and records [first_record, end_record). The minima are those
// of slices from first_slice on (slices.h), and none is there before the first record.
__kernel void brute_force(Layout layout, int first_slice, uint first_brick, uint end_brick, uint first_record,
                          uint end_record, __global const Polyhedron* polyhedra, __global uint* squares,
                          __global uint* triangles) {
    const uint brick = first_brick + (uint)get_global_id(0) / (ROWS / ITEM_ROWS);
    const uint first_row = (uint)get_global_id(0) % (ROWS / ITEM_ROWS) * ITEM_ROWS;
    if (brick >= end_brick) return;
    const uint bricks_x = layout.bricks[0], bricks_y = layout.bricks[1];
    const int3 corner =
        CLSDF_BRICK * (vload3(0, layout.brick_first) +
                       (int3)(brick % bricks_x, brick / bricks_x % bricks_y, brick / (bricks_x * bricks_y)));
    Least least;
    for (uint v = 0; v < ITEM_VECTORS; ++v) {
        least.squared[v] = (floatL)INFINITY;
        least.triangle[v] = (uintL)CLSDF_NO_TRIANGLE;
    }
    for (uint n = first_record; n < end_record; ++n) {
        __global const Polyhedron* p = polyhedra + n;
        const double3 centre = convert_double3(corner) + (double)BRICK_CENTRE;
#ifdef LONG_BRICKS
        const double4 frame = frame_at(p, centre.x, centre.y, centre.z);
#else
        const Offsets offsets = offsets_at(p, centre.x, centre.y, centre.z);
        const Steps steps = steps_of(p);
#endif
        for (uint v = 0; v < ITEM_VECTORS; ++v) {
            const uint row = first_row + v * LANES / CLSDF_BRICK;
            const floatL i = convert_floatL(LANE_NUMBERS) + ((float)(v * LANES % CLSDF_BRICK) - BRICK_CENTRE);
            const floatL j = (float)(row % CLSDF_BRICK) - BRICK_CENTRE;
            const floatL k = (float)(row / CLSDF_BRICK) - BRICK_CENTRE;
#ifdef LONG_BRICKS
            lower(&least, v, squared_distance_long_brick(p, frame, i, j, k), p->triangle);
#else
            lower(&least, v, squared_distance(steps, offsets, i, j, k), p->triangle);
#endif
        }
    }
    __private const float* of_samples = (__private const float*)least.squared;
    __private const uint* triangle_of_samples = (__private const uint*)least.triangle;
    for (uint s = 0; s < ITEM_ROWS * CLSDF_BRICK; ++s) {
        const uint row = first_row + s / CLSDF_BRICK;
        const int x = corner.x + (int)(s % CLSDF_BRICK) - layout.first[0];
        const int y = corner.y + (int)(row % CLSDF_BRICK) - layout.first[1];
        const int z = corner.z + (int)(row / CLSDF_BRICK);
        if (x < 0 || y < 0 || z < first_slice || z < layout.first[2]) continue;
        if (x >= layout.size[0] || y >= layout.size[1] || z >= layout.first[2] + layout.size[2]) continue;
        const size_t at = ((size_t)(z - first_slice) * layout.size[1] + y) * layout.size[0] + x;
        const uint square = as_uint(of_samples[s]);
#ifdef NEAREST
        if (square < squares[at])
            triangles[at] = triangle_of_samples[s];
        else if (square == squares[at])
            triangles[at] = min(triangles[at], triangle_of_samples[s]);
#endif
        squares[at] = min(squares[at], square);
    }
}
