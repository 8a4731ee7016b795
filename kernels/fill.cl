// Bricks that no polyhedron touches: the band's limit with the sample's sign.

#include "layout.h"

// Global size: (rows of y, slices of z) of the part, from slice `first_slice` on.
__kernel void fill_empty_bricks(Layout layout, __global const uchar* computed, __global const uint* sign_bits,
                                __global float* distance, __global uint* triangle, int with_triangle, int first_slice) {
    const int y = get_global_id(0), z = first_slice + get_global_id(1);
    // Offsets from the first brick's first sample.
    const int shift_x = layout.first[0] - layout.brick_first[0] * CLSDF_BRICK;
    const int from_y = y + layout.first[1] - layout.brick_first[1] * CLSDF_BRICK;
    const int from_z = z + layout.first[2] - layout.brick_first[2] * CLSDF_BRICK;
    __global const uchar* row_computed =
        computed + ((size_t)(from_z / CLSDF_BRICK) * layout.bricks[1] + from_y / CLSDF_BRICK) * layout.bricks[0];
    __global const uint* row_bits =
        sign_bits + ((size_t)from_z * (layout.bricks[1] * CLSDF_BRICK) + from_y) * layout.sign_words;
    const size_t row = ((size_t)z * layout.size[1] + y) * layout.size[0];
    for (int brick = 0; brick < layout.bricks[0]; ++brick) {
        if (row_computed[brick]) continue;
        const int begin = max(brick * CLSDF_BRICK - shift_x, 0),
                  end = min((brick + 1) * CLSDF_BRICK - shift_x, layout.size[0]);
        const uint inside = row_bits[brick / 4] >> (brick % 4 * 8);
        const int8 negative = (((int8)inside >> (int8)(0, 1, 2, 3, 4, 5, 6, 7)) & 1) != 0;
        const float8 fill = negative ? (float8)layout.inside_fill : (float8)layout.outside_fill;
        if (end - begin == CLSDF_BRICK) {
            vstore8(fill, 0, distance + row + begin);
        } else {
            float values[CLSDF_BRICK];
            vstore8(fill, 0, values);
            for (int x = begin; x < end; ++x) distance[row + x] = values[x + shift_x - brick * CLSDF_BRICK];
        }
        if (with_triangle)
            for (int x = begin; x < end; ++x) triangle[row + x] = CLSDF_NO_TRIANGLE;
    }
}
