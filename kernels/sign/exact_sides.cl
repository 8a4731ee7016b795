// The exact side of every sample of a box: the rule of the eight looks (docs/method.md). Rows of samples along x cross
// the triangles of a mesh that decides its sign alone; where they do, the winding number of each look changes. Every
// decision is exact, so that the sides are those of the host (lib/segments/sample_sides.cpp).

#include "exact_rows.h"
#include "row_records.h"

#pragma OPENCL FP_CONTRACT OFF

// The looks that move by +e along x.
#define FORWARD_LOOKS 0x55u

// The looks in which the line along x through p crosses the face a, b, c.
OUT_OF_LINE uint looks_along_x(double3 a, double3 b, double3 c, double3 p) {
    const int of_first = orientation_in_plane(a.y, a.z, b.y, b.z, p.y, p.z),
              of_second = orientation_in_plane(b.y, b.z, c.y, c.z, p.y, p.z);
    if (of_first * of_second < 0) return 0;
    const int of_third = orientation_in_plane(c.y, c.z, a.y, a.z, p.y, p.z);
    if (of_first * of_third < 0 || of_second * of_third < 0) return 0;
    if (of_first != 0 && of_second != 0 && of_third != 0) return CLSDF_ALL_LOOKS;
    ExactVector along;
    along.x.high = 1.0;
    along.x.low = along.y.high = along.y.low = along.z.high = along.z.low = 0.0;
    const uint first = positive_looks(of_first, along, exact_difference(b, a)),
               second = positive_looks(of_second, along, exact_difference(c, b)),
               third = positive_looks(of_third, along, exact_difference(a, c));
    return (first & second & third) | (CLSDF_ALL_LOOKS & ~(first | second | third));
}

// Writes the crossings of rows [begin_y, end_y) and [begin_z, end_z) with a face.
INLINE void cross_rows(SampleRows samples, __global const double* at, double3 a, double3 b, double3 c, int begin_y,
                       int end_y, int begin_z, int end_z, __private Writer* writer) {
    // The side of points far ahead. A face that is parallel to x is not crossed in any look.
    const int ahead = orientation_in_plane(a.y, a.z, b.y, b.z, c.y, c.z);
    if (ahead == 0) return;
    // The samples that may be the first one behind the face.
    const int begin_x = first_not_below(samples, at, 0, fmin(a.x, fmin(b.x, c.x))),
              end_x = first_above(samples, at, 0, fmax(a.x, fmax(b.x, c.x)));
    // The plane, for a guess.
    const double normal_x = (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y),
                 normal_y = (b.z - a.z) * (c.x - a.x) - (b.x - a.x) * (c.z - a.z),
                 normal_z = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    for (int z = begin_z; z < end_z; ++z)
        for (int y = begin_y; y < end_y; ++y) {
            double3 p = sample_at(samples, at, 0, y, z);
            const uint looks = looks_along_x(a, b, c, p);
            if (looks == 0) continue;
            const double x = a.x - (normal_y * (p.y - a.y) + normal_z * (p.z - a.z)) / normal_x;
            const double steps = ceil((x - at[0]) * samples.per_spacing[0]);
            int begin = begin_x, end = end_x;
            // No number is not in the range.
            int probe = steps > begin && steps <= end ? (int)steps - 1 : (begin + end) / 2;
            bool is_first = true, is_tie = false;
            while (begin < end) {
                p.x = at[probe];
                const int side = orientation_in_space(a, b, c, p);
                if (side == ahead) {
                    end = probe;
                    probe = (begin + end) / 2;
                } else {
                    is_tie = side == 0;
                    begin = probe + 1;
                    probe = is_first ? begin : (begin + end) / 2;
                }
                is_first = false;
            }
            // The looks that move forward see a sample on the face behind it.
            const uint row = (uint)y + (uint)samples.size[1] * (uint)z, is_up = ahead < 0;
            const uint at_tie = is_tie ? looks & FORWARD_LOOKS : 0u, behind = looks & ~at_tie;
            if (at_tie != 0) write_record(writer, row, CLSDF_CROSSING_KEY(begin - 1, at_tie, is_up));
            if (behind != 0 && begin < samples.size[0])
                write_record(writer, row, CLSDF_CROSSING_KEY(begin, behind, is_up));
        }
}

// Writes the crossings of a triangle and the rows that it may meet, as sweep_triangle() of sign_sweep.cl does.
INLINE void cross_triangle(SampleRows samples, uint t, uint strip, uint strips, __global const uint* triangles,
                           __global const double* positions, __global const double* at, __global uint* large,
                           __private Writer* writer) {
    const double3 a = corner_of(samples, triangles, positions, t, 0),
                  b = corner_of(samples, triangles, positions, t, 1),
                  c = corner_of(samples, triangles, positions, t, 2);
    if (!is_exact_corner(a, triangles, positions, t, 0) || !is_exact_corner(b, triangles, positions, t, 1) ||
        !is_exact_corner(c, triangles, positions, t, 2)) {
        atomic_or(&writer->totals->inexact, 1u);
        return;
    }
    if (fmin(a.x, fmin(b.x, c.x)) > at[samples.size[0] - 1]) return;
    const int begin_y = first_not_below(samples, at, 1, fmin(a.y, fmin(b.y, c.y))),
              end_y = first_above(samples, at, 1, fmax(a.y, fmax(b.y, c.y)));
    if (begin_y >= end_y) return;
    int begin_z = first_not_below(samples, at, 2, fmin(a.z, fmin(b.z, c.z))),
        end_z = first_above(samples, at, 2, fmax(a.z, fmax(b.z, c.z)));
    if (begin_z >= end_z) return;
    const ulong number = (ulong)(end_y - begin_y) * (ulong)(end_z - begin_z);
    if (strips > 0) {
        const long first_z = begin_z, slices = end_z - begin_z;
        begin_z = (int)(first_z + slices * strip / strips);
        end_z = (int)(first_z + slices * (strip + 1) / strips);
    } else if (number > CLSDF_LARGE_ROWS) {
        leave_large(t, number, large, writer->totals);
        return;
    }
    cross_rows(samples, at, a, b, c, begin_y, end_y, begin_z, end_z, writer);
}

// As sign_crossings of sign_sweep.cl. Keys: see look_windings.h.
__kernel void exact_crossings(SampleRows samples, __global const uint* triangles, __global const double* positions,
                              __global const double* at, uint begin, uint end, __global uint* row_counts, uint capacity,
                              uint block, __global SweepRecord* records, __global SweepTotals* totals,
                              __global uint* large, int has_chosen, __global const uint* chosen, uint strips) {
    const uint part = get_global_id(0), parts = get_global_size(0), count = (end - begin) * max(strips, 1u);
    const uint own_end = share_of(count, part + 1, parts);
    Writer writer = {row_counts, records, capacity, block, totals, 0, 0};
    for (uint i = share_of(count, part, parts); i < own_end; ++i) {
        const uint n = begin + (strips > 0 ? i / strips : i), strip = strips > 0 ? i % strips : 0;
        cross_triangle(samples, has_chosen ? chosen[n] : n, strip, strips, triangles, positions, at, large, &writer);
    }
    leave_records(writer);
}

// The sides of the samples of rows [begin, end), one row per work-item, 1 inside. Sorts the keys of the rows.
__kernel void exact_rows(SampleRows samples, int parity, __global const uint* starts, __global uint* keys,
                         __global uint* sides, uint begin, uint end) {
    const uint row = begin + (uint)get_global_id(0);
    if (row >= end) return;
    __global uint* bits = sides + (size_t)row * samples.words;
    for (uint word = 0; word < samples.words; ++word) bits[word] = 0;
    const uint count = starts[row + 1] - starts[row];
    if (count == 0) return;
    __global uint* own = keys + starts[row];
    sort_keys(own, count);
    LookWindings windings = {{0}};
    for (uint n = 0; n < count;) {
        const uint sample = CLSDF_SAMPLE_OF_CROSSING(own[n]);
        while (n < count && CLSDF_SAMPLE_OF_CROSSING(own[n]) == sample) add_crossing(&windings, own[n++]);
        const uint behind = n < count ? CLSDF_SAMPLE_OF_CROSSING(own[n]) : (uint)samples.size[0];
        if (are_inside(&windings, parity)) set_bits(bits, sample, behind);
    }
}
