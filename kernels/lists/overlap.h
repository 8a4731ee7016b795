// The overlap test of a polyhedron and blocks of samples, by which bricks and sub-blocks get their lists.
//
// A block is represented by its centre and by its extent (half its width) along each of the polyhedron's normals; the
// test is conservative. Each block has its own upper bound of the distances of its samples to the mesh: a
// triangle farther away than that is nearest to none of them. The slack exceeds the rounding of what is compared, which
// grows with the bound.
#ifndef CLSDF_BLOCKS_H
#define CLSDF_BLOCKS_H

#include "coarse.h"
#include "frame.h"
#include "simd.h"

// The bricks of a coarse brick, the sub-blocks of a brick: number b of 4 x 4 x 4.
INLINE int3 four_cubed(uint b) {
    return (int3)(b & 3u, (b >> 2) & 3u, b >> 4);
}

// A coarse brick of the part, by its number.
INLINE int3 coarse_brick_at(Layout layout, uint number) {
    const int3 size = vload3(0, layout.coarse_bricks);
    return vload3(0, layout.coarse_first) +
           (int3)(number % size.x, number / size.x % size.y, number / (size.x * size.y));
}

typedef struct Extent {
    float x, y, z, right, left;
    float right_end, left_end, apex;  // along the bounds of the corners (overlapped_within)
} Extent;

// The extent of cubes that extend half_side samples from their centre.
INLINE Extent extent_of_cube(__global const Polyhedron* p, float half_side) {
    const float widen = 1.0f + 1.0e-6f;
    const float3 gx = vload3(0, p->gradient_x), gy = vload3(0, p->gradient_y), gz = vload3(0, p->gradient_z);
    const float4 normal = vload4(0, p->normal_along);  // along right, left, across right, left
    const float3 x = (float3)(gx.x, gy.x, gz.x), y = (float3)(gx.y, gy.y, gz.y);
    const float3 right = fabs(normal.x * x + normal.z * y), left = fabs(normal.w * y - normal.y * x);
    const float3 frame = fabs(gx) * half_side + (fabs(gy) * half_side + fabs(gz) * half_side);
    Extent extent;
    extent.x = widen * frame.x;
    extent.y = widen * frame.y;
    extent.z = widen * frame.z;
    extent.right = widen * (right.x * half_side + (right.y * half_side + right.z * half_side));
    extent.left = widen * (left.x * half_side + (left.y * half_side + left.z * half_side));
    extent.right_end = normal.x * extent.x;
    extent.left_end = normal.y * extent.x;
    extent.apex = (normal.y * normal.z + normal.x * normal.w) * extent.y;
    return extent;
}

// The same, enlarged by the slack of a test.
static inline Extent widened(Extent r, float slack) {
    // The bounds of the corners are sums of two others, with factors of at most one.
    const Extent wide = {r.x + slack,
                         r.y + slack,
                         r.z + slack,
                         r.right + slack,
                         r.left + slack,
                         r.right_end + 2.0f * slack,
                         r.left_end + 2.0f * slack,
                         r.apex + 2.0f * slack};
    return wide;
}

// Centres of blocks in the polyhedron's frame: X and Y relative to `position`, Z from the face.
typedef struct Centres {
    floatL x, y, z;
} Centres;

INLINE Centres centres_of(__global const Polyhedron* p, FramePosition position, floatL i, floatL j, floatL k) {
    Centres c;
    c.x = i * p->gradient_x[0] + (j * p->gradient_y[0] + k * p->gradient_z[0]);
    c.y = i * p->gradient_x[1] + (j * p->gradient_y[1] + k * p->gradient_z[1]);
    c.z = i * p->gradient_x[2] + (j * p->gradient_y[2] + (k * p->gradient_z[2] + position.z));
    return c;
}

// Returns bit b for block b. base[b], right[b] and left[b]: how far outward of the edges the block's lateral planes
// lie. `extent` includes the slack of the greatest bound.
//
// Between two lateral planes that meet at a sharp angle a block can lie far from the triangle and yet overlap both. The
// polyhedron ends there at its corner: along X at the ends of the base, along Y above the apex. That bound is a sum of
// the planes' own, each times a component of a normal.
INLINE uint overlapped_within(__global const Polyhedron* p, FramePosition position, Centres c, floatL base,
                              floatL right, floatL left, Extent extent, floatL bound) {
    const float along_right = p->normal_along[CLSDF_HALF_RIGHT], across_right = p->normal_across[CLSDF_HALF_RIGHT];
    const float along_left = p->normal_along[CLSDF_HALF_LEFT], across_left = p->normal_across[CLSDF_HALF_LEFT];
    intL in = fabs(c.z) <= bound + extent.z;
    if (!(p->flags & CLSDF_POLYHEDRON_COMPACT)) {
        base = LESSER(base, bound);
        right = LESSER(right, bound);
        left = LESSER(left, bound);
        in &= (position.beyond_right + c.x <= bound + extent.x) & (position.beyond_left - c.x <= bound + extent.x);
    }
    const floatL past_base = -position.y - c.y - base;
    const floatL past_right = position.outward_right + (along_right * c.x + across_right * c.y) - right;
    const floatL past_left = position.outward_left + (across_left * c.y - along_left * c.x) - left;
    in &= (past_base <= extent.y) & (past_right <= extent.right) & (past_left <= extent.left) &
          (past_right + across_right * past_base <= extent.right_end) &
          (past_left + across_left * past_base <= extent.left_end) &
          (along_left * past_right + along_right * past_left <= extent.apex);
    return lanes_to_bits(in);
}

// Bit b: block b.
INLINE uint overlapped_blocks(__global const Polyhedron* p, FramePosition position, Centres c, Extent extent,
                              floatL bound) {
    const floatL above = extent.z + c.z, below = extent.z - c.z;
#define WIDTH(edge) GREATER(p->slope_above[edge] * above, p->slope_below[edge] * below)
    return overlapped_within(p, position, c, WIDTH(CLSDF_EDGE_BASE), WIDTH(CLSDF_EDGE_RIGHT), WIDTH(CLSDF_EDGE_LEFT),
                             extent, bound);
#undef WIDTH
}

// Slopes of the lateral planes for a group of blocks that is small: those of the side of the face on which all its
// samples lie. If samples lie on both sides, or within the slack of the face, the greater slopes hold for both.
typedef struct Slopes {
    float base, right, left;
} Slopes;

// z: of the group's centre; extent: of the group.
INLINE Slopes slopes_of(__global const Polyhedron* p, float z, float extent, float slack) {
    const int above = z - extent > slack, below = -z - extent > slack;
    Slopes slopes;
#define SLOPE(edge) \
    (above ? p->slope_above[edge] : below ? p->slope_below[edge] : GREATER(p->slope_above[edge], p->slope_below[edge]))
    slopes.base = SLOPE(CLSDF_EDGE_BASE);
    slopes.right = SLOPE(CLSDF_EDGE_RIGHT);
    slopes.left = SLOPE(CLSDF_EDGE_LEFT);
#undef SLOPE
    return slopes;
}

// As overlapped_blocks, in fewer operations.
INLINE uint overlapped_near_blocks(__global const Polyhedron* p, FramePosition position, Slopes slopes, Centres c,
                                   Extent extent, floatL bound) {
    const floatL height = fabs(c.z) + extent.z;
    return overlapped_within(p, position, c, slopes.base * height, slopes.right * height, slopes.left * height, extent,
                             bound);
}

// The index of the bound of coarse brick (x, y, z) of the lattice. Bounds are stored by groups of 4 x 4 x 4
// that start at multiples of four.
static inline size_t coarse_bound_index(Layout layout, int x, int y, int z) {
    const int group_x = (x >> 2) - first_coarse_group(layout, 0), group_y = (y >> 2) - first_coarse_group(layout, 1),
              group_z = (z >> 2) - first_coarse_group(layout, 2);
    const size_t number = ((size_t)group_z * coarse_groups(layout, 1) + group_y) * coarse_groups(layout, 0) + group_x;
    return number * CLSDF_COARSE_GROUP + ((z & 3) * 16 + (y & 3) * 4 + (x & 3));
}

#ifdef COUNT
// Bit b: whether the polyhedron itself, with a band's half width and slack, holds sample b.
INLINE uint covered_samples(__global const Polyhedron* p, Offsets o, floatL i, floatL j, floatL k, float half_width,
                            float slack) {
    const Extent extent = widened((Extent){0.0f}, slack);
    return overlapped_blocks(p, o.at, centres_of(p, o.at, i, j, k), extent, (floatL)half_width);
}
#endif

#endif
