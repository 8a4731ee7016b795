// The records of the faces and the lines of a cell, found among all by their keys, and what they add up to.
#ifndef CLSDF_CUT_LOOKUP_H
#define CLSDF_CUT_LOOKUP_H

#include "cut_records.h"

#pragma OPENCL FP_CONTRACT OFF

// The sorted records, in which cells find those of their faces and lines.
typedef struct Records {
    __global const uint* keys;
    __global const uint* words;
    __global const uint* ways;  // sums of those before
    uint count;
} Records;

// The first record whose key is not less.
CUT_INLINE uint first_of_key(Records records, uint key) {
    uint from = 0, to = records.count;
    while (from < to) {
        const uint middle = from + (to - from) / 2;
        if (records.keys[middle] < key)
            from = middle + 1;
        else
            to = middle;
    }
    return from;
}

// Adds what a record leaves in its cell of a line.
CALLED_CUT void add_crossing_of(__private LineSums* sums, __private const CutGrid* grid, __global const uint* triangles,
                                __global const CutPoint* positions, uint word, int across, long plane, long side,
                                long cell) {
    const int axis = side_of(across), along = along_of(across);
    CutFace face;
    read_face(grid, triangles, positions, word / 2, &face);
    CutPoint down, up;
    section_of(face.corners, across, (double)(grid->first[across] + plane), &down, &up);
    const CutPoint place = point_at(down, up, axis, (double)(grid->first[axis] + side + 1));
    // Before the first cell: whole cells alone.
    if (is_above(place, along, (double)grid->first[along]))
        add_crossing(sums, (word & 1) != 0 ? 1 : -1, above_plane(place, along, (double)(grid->first[along] + cell)));
}

// What the solid has of a cell of a line on the high side of a face. steps: how often the cell's end is within.
CUT_INLINE LineSums sums_of_line(__private const CutGrid* grid, Records records, __global const uint* triangles,
                                 __global const CutPoint* positions, int across, long plane, long side, long cell,
                                 __private int* steps) {
    LineSums sums = {{0, 0}, {0, 0}};
    const uint line = grid->lines_from[across] + place_of(grid, across, plane, side, 0), key = line + (uint)cell;
    uint record = first_of_key(records, key);
    for (; record < records.count && records.keys[record] == key; ++record)
        add_crossing_of(&sums, grid, triangles, positions, records.words[record], across, plane, side, cell);
    *steps = (int)(records.ways[record] - records.ways[first_of_key(records, line)]);
    return sums;
}

CUT_INLINE FaceValues values_of_cell_face(__private const CutGrid* grid, Records records,
                                          __global const uint* triangles, __global const CutPoint* positions,
                                          int across, long plane, long side, long cell) {
    FaceSums sums = {{0, 0}, {0, 0}, {0, 0}};
    const int axis = side_of(across), along = along_of(across);
    CutVector low;
    low.at[across] = (double)(grid->first[across] + plane);
    low.at[axis] = (double)(grid->first[axis] + side);
    low.at[along] = (double)(grid->first[along] + cell);
    const uint key = grid->faces_from[across] + place_of(grid, across, plane, side, cell);
    for (uint record = first_of_key(records, key); record < records.count && records.keys[record] == key; ++record) {
        CutFace face;
        read_face(grid, triangles, positions, records.words[record] / 2, &face);
        if (face.moved == across) {
            CutPolygon rooms[4];
            CutVector below = low;
            below.at[across] -= 1;
            __private const CutPolygon* part = part_of_face(&face, below, rooms);
            for (int n = 0; n < piece_count(part); ++n) {
                CutPiece piece;
                if (make_piece(part, n, below, &piece)) add_moved_piece(&sums, &piece, across);
            }
        } else {
            CutPoint down, up;
            section_of(face.corners, across, low.at[across], &down, &up);
            cut_segment(&down, &up, axis, low.at[axis]);
            cut_segment(&down, &up, along, low.at[along]);
            add_segment(&sums, down, up, across, low.at[axis], low.at[along]);
        }
    }
    int steps;
    const LineSums line = sums_of_line(grid, records, triangles, positions, across, plane, side, cell, &steps);
    return values_of_face(length_in_cell(steps, &line), moment_in_cell(steps, &line), &sums);
}

#endif
