// Which blocks of samples a polyhedron touches: the test by which bricks and sub-blocks get their lists.
//
// A block is represented by its centre and by its reach (half its width) along each of the polyhedron's normals; the
// test is conservative. Each block has a cap of its own, an upper bound of the distance of its samples to the mesh: a
// triangle farther away than that is nearest to none of them. The slack grows with the cap, as the rounding of what is
// compared does.
#ifndef CLSDF_BLOCKS_H
#define CLSDF_BLOCKS_H

#include "frame.h"
#include "lanes.h"

typedef struct Reach {
    float x, y, z, right, left;
} Reach;

inline Reach reach_of(__global const float* reach, float scale) {
    Reach r;
    r.x = scale * reach[0];
    r.y = scale * reach[1];
    r.z = scale * reach[2];
    r.right = scale * reach[3];
    r.left = scale * reach[4];
    return r;
}

// Bit b: the block whose centre lies (i[b], j[b], k[b]) samples from the point of the offsets.
INLINE uint touched_blocks(__global const Polyhedron* p, Offsets o, floatL i, floatL j, floatL k, Reach reach,
                           floatL cap, floatL slack) {
    const float along_right = p->normal_along_high[CLSDF_HALF_RIGHT],
                across_right = p->normal_across_high[CLSDF_HALF_RIGHT];
    const float along_left = p->normal_along_high[CLSDF_HALF_LEFT],
                across_left = p->normal_across_high[CLSDF_HALF_LEFT];
    const floatL dx = i * p->gradient_x_high[0] + (j * p->gradient_y_high[0] + k * p->gradient_z_high[0]);
    const floatL dy = i * p->gradient_x_high[1] + (j * p->gradient_y_high[1] + k * p->gradient_z_high[1]);
    const floatL s = i * p->gradient_x_high[2] + (j * p->gradient_y_high[2] + (k * p->gradient_z_high[2] + o.z));

    const floatL above = s + (slack + reach.z);
    const floatL below = (slack + reach.z) - s;
    floatL base = GREATER(p->slope_above[CLSDF_EDGE_BASE] * above, p->slope_below[CLSDF_EDGE_BASE] * below);
    floatL right = GREATER(p->slope_above[CLSDF_EDGE_RIGHT] * above, p->slope_below[CLSDF_EDGE_RIGHT] * below);
    floatL left = GREATER(p->slope_above[CLSDF_EDGE_LEFT] * above, p->slope_below[CLSDF_EDGE_LEFT] * below);
    intL in = fabs(s) <= cap + (slack + reach.z);
    if (!(p->flags & CLSDF_POLYHEDRON_COMPACT)) {
        base = LESSER(base, cap);
        right = LESSER(right, cap);
        left = LESSER(left, cap);
        in &= (o.beyond_right + dx <= cap + (slack + reach.x)) & (o.beyond_left - dx <= cap + (slack + reach.x));
    }
    in &= (-o.y - dy <= base + (slack + reach.y)) &
          (o.outward_right + (along_right * dx + across_right * dy) <= right + (slack + reach.right)) &
          (o.outward_left + (across_left * dy - along_left * dx) <= left + (slack + reach.left));
    return lanes_to_bits(in);
}

// Bit b of the result: block b of a group of 4 x 4 x 4 (x fastest), each of `side` samples a side, whose first sample
// is (x, y, z) of the lattice. caps: one a block.
INLINE ulong touched_group(__global const Polyhedron* p, int x, int y, int z, float side, __private const float* caps,
                           float level_slack, float slack_rate) {
    // The frame at the centre of the group; the blocks' centres lie at most 1.5 sides from it.
    const double centre = 2.0 * side - 0.5;
    const Offsets o = offsets_at(p, x + centre, y + centre, z + centre);
    const Reach reach = reach_of(p->reach_cube, 0.5f * (side - 1.0f));
    ulong touched = 0;
    for (uint first = 0; first < 64; first += LANES) {
        const uintL block = LANE_NUMBERS + first;
        const floatL i = (convert_floatL(block & 3u) - 1.5f) * side;
        const floatL j = (convert_floatL((block >> 2) & 3u) - 1.5f) * side;
        const floatL k = (convert_floatL(block >> 4) - 1.5f) * side;
        const floatL cap = load_lanes(0, caps + first);
        touched |= (ulong)touched_blocks(p, o, i, j, k, reach, cap, cap * slack_rate + level_slack) << first;
    }
    return touched;
}

#endif
