// Cells that were cut (cut_cells.cl), on their way to the caller's arrays.

#include "cut_lookup.h"

#pragma OPENCL FP_CONTRACT OFF

// A member of each row. from: its byte in a row. kind: how its numbers are written: as words of 32 bits, as doubles, or
// as floats that were doubles. Strides are bytes.
__kernel void store_rows(__global const CutCounts* counts, __global const uchar* rows, int from, int components,
                         int kind, long first, long stride, long component_stride, __global uchar* to, uint begin,
                         uint end) {
    const uint row = begin + get_global_id(0);
    if (row >= end || row >= counts->row_limit) return;
    __global const uchar* member = rows + sizeof(FractionRow) * (size_t)row + from;
    __global uchar* target = to + (first + (long)row * stride);
    for (int c = 0; c < components; ++c, target += component_stride) {
        if (kind == CLSDF_STORED_WORDS)
            *(__global uint*)target = ((__global const uint*)member)[c];
        else if (kind == CLSDF_STORED_DOUBLES)
            *(__global double*)target = ((__global const double*)member)[c];
        else
            *(__global float*)target = (float)((__global const double*)member)[c];
    }
}

// Of each cell whether it is wholly of the part that is asked for, as if the surface met none: without surface in a
// cell its high face across z is as that face's edge, which runs along y. One work-item a row of cells along y.
__kernel void store_full(CutGrid grid, __global const uint* triangles, __global const CutPoint* positions,
                         __global const CutCounts* counts, __global const uint* keys, __global const uint* words,
                         __global const uint* ways, long first, long stride, __global uchar* to, uint begin, uint end) {
    const uint number = begin + get_global_id(0);
    if (number >= end || counts->is_complete == 0) return;
    const Records records = {keys, words, ways, counts->record_limit};
    const long i = number % grid.counts[0], k = number / grid.counts[0];
    const uint line = grid.lines_from[2] + place_of(&grid, 2, k + 1, i, 0);
    uint record = first_of_key(records, line);
    int steps = 0;
    for (long j = 0; j < grid.counts[1]; ++j) {
        LineSums sums = {{0, 0}, {0, 0}};
        for (; record < records.count && keys[record] == line + (uint)j; ++record) {
            add_crossing_of(&sums, &grid, triangles, positions, words[record], 2, k + 1, i, j);
            steps += (words[record] & 1) != 0 ? 1 : -1;
        }
        const bool is_solid = length_in_cell(steps, &sums) > 0.5;
        to[first + (long)key_of_cell(&grid, i, j, k) * stride] = is_solid != (grid.is_fluid != 0);
    }
}

// Cells that the surface meets are not. One work-item a record.
__kernel void clear_full(CutGrid grid, __global const CutCounts* counts, __global const uint* keys, long first,
                         long stride, __global uchar* to, uint begin, uint end) {
    const uint i = begin + get_global_id(0);
    if (i >= end || counts->is_complete == 0 || i >= counts->record_limit || keys[i] >= grid.faces_from[0]) return;
    to[first + (long)keys[i] * stride] = 0;
}
