// The kernel coarse_bounds, which both bodies make coarse lists with.
#ifndef CLSDF_COARSE_BOUNDS_H
#define CLSDF_COARSE_BOUNDS_H

#include "coarse_clusters.h"

// An upper bound of the distances in a coarse brick: the least, over a sample of surface points, of the distance to the
// brick's farthest sample. (Bricks find finer bounds.) A work-item computes LANES columns of four bricks along z of a
// group, including bricks beyond the part, so a group has the same bounds in every part.
__kernel void coarse_bounds(Layout layout, uint count, __global const SurfacePoint* points, __global float* bounds,
                            uint first) {
    const uint item = first + get_global_id(0), items = CLSDF_COARSE_COLUMNS / LANES;
    const int number = item / items;
    const int groups_x = coarse_groups(layout, 0), groups_y = coarse_groups(layout, 1);
    const int3 group = 4 * (int3)(first_coarse_group(layout, 0) + number % groups_x,
                                  first_coarse_group(layout, 1) + number / groups_x % groups_y,
                                  first_coarse_group(layout, 2) + number / (groups_x * groups_y));
    const uintL column = LANE_NUMBERS + item % items * LANES;
    const float3 spacing = vload3(0, layout.spacing), half_side = COARSE_CENTRE * spacing;
    const floatL side_x = convert_floatL(column & 3u) * (CLSDF_COARSE * spacing.x),
                 side_y = convert_floatL(column >> 2) * (CLSDF_COARSE * spacing.y);
    floatL least[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
    for (uint i = 0; i < count; ++i) {
        const int3 offset = group * CLSDF_COARSE - vload3(0, points[i].origin);
        const float3 from_foot = (convert_float3(offset) + COARSE_CENTRE) * spacing - vload3(0, points[i].foot);
        const floatL x = fabs(side_x + from_foot.x) + half_side.x, y = fabs(side_y + from_foot.y) + half_side.y;
        const floatL across = x * x + y * y;
#pragma unroll
        for (uint layer = 0; layer < 4; ++layer) {
            const float z = fabs((float)layer * (CLSDF_COARSE * spacing.z) + from_foot.z) + half_side.z;
            const floatL squared = across + z * z;
            least[layer] = LESSER(least[layer], squared);
        }
    }
#pragma unroll
    for (uint layer = 0; layer < 4; ++layer) {
        const floatL bound = sqrt(least[layer]) * (1.0f + 1.0e-5f) + layout.coarse_slack;
        store_lanes(LESSER(bound, layout.half_width), (number * 4 + layer) * items + item % items, bounds);
    }
}

// A group's bounds, and the greatest of them.
INLINE float load_bounds(__global const float* bounds, __private float* group_bounds) {
    floatL greatest = 0.0f;
    for (uint v = 0; v < CLSDF_COARSE_GROUP / LANES; ++v) {
        const floatL some = load_lanes(v, bounds);
        store_lanes(some, v, group_bounds);
        greatest = GREATER(greatest, some);
    }
    return greatest_lane(greatest);
}

INLINE size_t coarse_brick_count(Layout layout) {
    return (size_t)layout.coarse_bricks[0] * layout.coarse_bricks[1] * layout.coarse_bricks[2];
}

#endif
