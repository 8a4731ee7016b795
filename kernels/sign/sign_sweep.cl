// Inside or outside at every sample: the exact winding number by a sweep along x (docs/method.md, 'Sign by crossings').
//
// y and z of the vertices are snapped to multiples of 2^-b spacings, such that samples are exact: sample (j, k) lies at
// (j << bits_y, k << bits_z). A triangle projected along x covers a row (j, k) if the signs of three edge functions
// agree, which are exact integers. A row through an edge or a vertex is treated as moved by (+epsilon, +epsilon^2) in
// (y, z), so every row crosses a closed mesh consistently. The snapped mesh has the same connectivity. A vertex moves
// by at most 2^-21 voxel in y and in z. The sign may differ only within 2^-20 / sqrt 2 voxel of the surface. The
// crossing of the row and the triangle is interpolated in double. The edge functions are the weights: all have one
// sign, so nothing cancels. (On steep triangles the plane would be extrapolated.)
//
// Crossings are found once, as records in no order, and counted by row. A prefix sum of the counts gives the start of
// each row. The records are scattered to their rows and sorted; a running sum of their orientation is the winding
// number.

#include "layout.h"
#include "row_records.h"
#include "sweep_edges.h"

// A crossing has the same coordinate on every device.
#pragma OPENCL FP_CONTRACT OFF

// The rows (y, z) of the part that a box holds, limits included.
typedef struct RowRange {
    long begin_y, end_y, begin_z, end_z;
} RowRange;

INLINE RowRange rows_within(Layout layout, SweepVertex a, SweepVertex b, SweepVertex c, int bits_y, int bits_z) {
    const long first_y = (long)layout.brick_first[1] * CLSDF_BRICK, first_z = (long)layout.brick_first[2] * CLSDF_BRICK;
    const long last_y = first_y + (long)layout.bricks[1] * CLSDF_BRICK - 1,
               last_z = first_z + (long)layout.bricks[2] * CLSDF_BRICK - 1;
    RowRange rows;
    rows.begin_y = max(first_y, -(-min(a.y, min(b.y, c.y)) >> bits_y));
    rows.end_y = min(last_y, max(a.y, max(b.y, c.y)) >> bits_y);
    rows.begin_z = max(first_z, -(-min(a.z, min(b.z, c.z)) >> bits_z));
    rows.end_z = min(last_z, max(a.z, max(b.z, c.z)) >> bits_z);
    return rows;
}

INLINE ulong row_count(RowRange rows) {
    return rows.begin_y > rows.end_y || rows.begin_z > rows.end_z
               ? 0
               : (ulong)(rows.end_y - rows.begin_y + 1) * (ulong)(rows.end_z - rows.begin_z + 1);
}

// Writes the crossing of a row with the triangle, at the position that the weights give.
INLINE void write_weighted(Layout layout, SweepVertex a, SweepVertex b, SweepVertex c, double wa, double wb, double wc,
                           uint row, uint faces_back, __private Writer* writer) {
    const double x = (wa * a.x + wb * b.x + wc * c.x) / (wa + wb + wc);
    // The least integer not below x: PoCL's ceil is two dozen operations.
    const int first = layout.brick_first[0] * CLSDF_BRICK, end = first + layout.bricks[0] * CLSDF_BRICK;
    const double limited = clamp(x, (double)first, (double)end);
    const int truncated = (int)limited;
    const uint sample = (uint)(truncated + (limited > truncated) - first);
    write_record(writer, row, 2 * sample + faces_back);
}

// Writes the crossings of a range of rows of a triangle's box.
INLINE void find_crossings(Layout layout, SweepVertex a, SweepVertex b, SweepVertex c, RowRange rows, int bits_y,
                           int bits_z, __private Writer* writer) {
    const bool wide = max(a.y, max(b.y, c.y)) - min(a.y, min(b.y, c.y)) >= (1L << 30) ||
                      max(a.z, max(b.z, c.z)) - min(a.z, min(b.z, c.z)) >= (1L << 30);
    long orientation;
    if (wide) {
        const Wide area = twice_area(a, b, c);
        orientation = area.hi != 0 ? area.hi : area.lo != 0;
    } else {
        orientation = (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
    }
    if (orientation == 0) return;
    const uint faces_back = orientation < 0;
    if (faces_back) {
        const SweepVertex swap = b;
        b = c;
        c = swap;
    }
    const int first_y = layout.brick_first[1] * CLSDF_BRICK, first_z = layout.brick_first[2] * CLSDF_BRICK,
              rows_y = layout.bricks[1] * CLSDF_BRICK;
    for (long z = rows.begin_z; z <= rows.end_z; ++z) {
        uint row = (uint)(z - first_z) * (uint)rows_y + (uint)(rows.begin_y - first_y);
        if (wide) {
            for (long y = rows.begin_y; y <= rows.end_y; ++y, ++row) {
                double wa, wb, wc;
                if (left_of(b, c, y << bits_y, z << bits_z, &wa) && left_of(c, a, y << bits_y, z << bits_z, &wb) &&
                    left_of(a, b, y << bits_y, z << bits_z, &wc))
                    write_weighted(layout, a, b, c, wa, wb, wc, row, faces_back, writer);
            }
        } else {
            Edge of_a = edge_at(b, c, rows.begin_y << bits_y, z << bits_z, bits_y),
                 of_b = edge_at(c, a, rows.begin_y << bits_y, z << bits_z, bits_y),
                 of_c = edge_at(a, b, rows.begin_y << bits_y, z << bits_z, bits_y);
            for (long y = rows.begin_y; y <= rows.end_y; ++y, ++row) {
                if ((long)(of_a.value | of_b.value | of_c.value) >= 0)
                    write_weighted(layout, a, b, c, weight_of(of_a), weight_of(of_b), weight_of(of_c), row, faces_back,
                                   writer);
                of_a.value -= of_a.step;
                of_b.value -= of_b.step;
                of_c.value -= of_c.step;
            }
        }
    }
}

// The crossings of triangle t in one of `strips` ranges of its slices. If strips is 0, all crossings, unless its box
// holds many rows: then its number goes to `large`.
INLINE void sweep_triangle(Layout layout, uint t, uint strip, uint strips, __global const uint* triangles,
                           __global const SweepVertex* vertices, int bits_y, int bits_z, __global uint* large,
                           __private Writer* writer) {
    const SweepVertex a = vertices[triangles[3 * t]], b = vertices[triangles[3 * t + 1]],
                      c = vertices[triangles[3 * t + 2]];
    RowRange rows = rows_within(layout, a, b, c, bits_y, bits_z);
    const ulong number = row_count(rows);
    if (number == 0) return;
    if (strips > 0) {
        const long begin_z = rows.begin_z, slices = rows.end_z - begin_z + 1;
        rows.begin_z = begin_z + slices * strip / strips;
        rows.end_z = begin_z + slices * (strip + 1) / strips - 1;
    } else if (number > CLSDF_LARGE_ROWS) {
        leave_large(t, number, large, writer->totals);
        return;
    }
    find_crossings(layout, a, b, c, rows, bits_y, bits_z, writer);
}

// Each work-item takes a range of the triangles [begin, end), or, if has_chosen, of those that `chosen` names there. If
// strips is 0, it handles those with few rows, and appends the numbers of the others to `large`. Otherwise it takes a
// range of the strips of all triangles. It takes room for `block` records at a time. Keys: 2 k + (1 if the surface
// faces -x), k the first sample at or after the crossing, counted from the first brick's first sample and clamped to
// [0, row_length].
__kernel void sign_crossings(Layout layout, __global const uint* triangles, __global const SweepVertex* vertices,
                             int bits_y, int bits_z, uint begin, uint end, __global uint* row_counts, uint capacity,
                             uint block, __global SweepRecord* records, __global SweepTotals* totals,
                             __global uint* large, int has_chosen, __global const uint* chosen, uint strips) {
    const uint part = get_global_id(0), parts = get_global_size(0), count = (end - begin) * max(strips, 1u);
    const uint own_end = share_of(count, part + 1, parts);
    Writer writer = {row_counts, records, capacity, block, totals, 0, 0};
    for (uint i = share_of(count, part, parts); i < own_end; ++i) {
        const uint n = begin + (strips > 0 ? i / strips : i), strip = strips > 0 ? i % strips : 0;
        sweep_triangle(layout, has_chosen ? chosen[n] : n, strip, strips, triangles, vertices, bits_y, bits_z, large,
                       &writer);
    }
    leave_records(writer);
}

// Each work-item takes `rows_per_item` of the rows [begin_row, end_row) of samples of the part's bricks: their sign
// bits, 1 inside.
__kernel void sign_rows(Layout layout, uint begin_row, uint end_row, uint rows_per_item, int parity,
                        __global const uint* starts, __global uint* keys, __global uint* sign_bits) {
    const uint first = min(begin_row + (uint)get_global_id(0) * rows_per_item, end_row),
               last = min(first + rows_per_item, end_row);
    const uint words = layout.sign_words;
    // Most rows meet no surface.
    for (size_t word = (size_t)first * words; word < (size_t)last * words; ++word) sign_bits[word] = 0;
    for (uint row = first; row < last; ++row) {
        const uint begin = starts[row], count = starts[row + 1] - begin;
        if (count == 0) continue;
        __global uint* own = keys + begin;
        sort_keys(own, count);
        __global uint* bits = sign_bits + (size_t)row * words;
        int winding = 0;
        for (uint n = 0; n < count; ++n) {
            winding += (own[n] & 1u) ? 1 : -1;
            if (parity ? (winding & 1) : winding != 0)
                set_bits(bits, own[n] >> 1, n + 1 < count ? own[n + 1] >> 1 : words * 32);
        }
    }
}
