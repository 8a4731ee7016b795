// What the faces of a mesh leave in the cells of a grid, as records: a key, which tells a cell, a face of a cell or a
// cell of a line, and the triangle. They are those that the host's loops visit (lib/cutting/cut_slab.cpp,
// sections.cpp).
//
// A work-item takes an item: a face and a layer of it, which is a row of cells along x: (j, k) along y and z, and the
// planes below it. So no work-item has more to do than a row of the grid. Layers beyond the last cells have their
// planes alone.
#ifndef CLSDF_CUT_RECORDS_H
#define CLSDF_CUT_RECORDS_H

#include "cell_rows.h"

#pragma OPENCL FP_CONTRACT OFF

// A corner of a face in cells of the lattice.
CUT_INLINE CutPoint vertex_at(__global const CutPoint* positions, uint vertex) {
    return positions[vertex];
}

// least, most: the cells of its corners.
typedef struct CutFace {
    CutPoint corners[3];
    double least[3], most[3];
    int moved;
} CutFace;

CUT_INLINE void read_face(__private const CutGrid* grid, __global const uint* triangles,
                          __global const CutPoint* positions, uint number, __private CutFace* face) {
    for (int i = 0; i < 3; ++i) face->corners[i] = vertex_at(positions, triangles[3 * (size_t)number + i]);
    for (int k = 0; k < 3; ++k) {
        const double a = cell_of(face->corners[0], k), b = cell_of(face->corners[1], k),
                     c = cell_of(face->corners[2], k);
        face->least[k] = lesser_of(a, lesser_of(b, c));
        face->most[k] = greater_of(a, greater_of(b, c));
    }
    face->moved = moved_axis(face->corners, grid->walls);
}

// Layers, counted from the grid's first cells.
typedef struct CutLayers {
    long low_y, low_z;
    ulong count_y, count_z;
} CutLayers;

CUT_INLINE void find_layers(__private const CutGrid* grid, __private const CutFace* face, __private CutLayers* layers) {
    layers->low_y = layers->low_z = 0;
    layers->count_y = layers->count_z = 0;
    bool is_beyond = false;
    int axes_below = 0;
    for (int axis = 0; axis < 2; ++axis) {
        is_beyond = is_beyond || face->least[axis] > (double)(grid->first[axis] + grid->counts[axis]);
        axes_below += face->most[axis] < (double)grid->first[axis] ? 1 : 0;
    }
    if (is_beyond || axes_below == 2) return;
    const double end = (double)(grid->first[2] + grid->counts[2]);
    CellRange z = cells_between(face->least[2], face->most[2], grid->first[2], grid->counts[2] + 1);
    if (z.low > z.high || (face->moved != 2 && face->least[2] >= end)) return;
    layers->low_z = z.low;
    layers->count_z = (ulong)(z.high - z.low) + 1;
    if (face->most[1] < (double)grid->first[1]) {
        layers->count_y = 1;  // its lines
        return;
    }
    // Cut points may lie beyond the corners by rounding.
    const double room = 0x1p-48 * (face->most[1] - face->least[1] + 2);
    double least = face->least[1], most = face->most[1];
    for (int i = 0; i < 3; ++i) {
        const double whole = face->corners[i].whole[1], part = face->corners[i].part[1];
        least = lesser_of(least, whole + floor(part - room));
        most = greater_of(most, whole + floor(part + room));
    }
    const CellRange y = cells_between(least, most, grid->first[1], grid->counts[1] + 1);
    layers->low_y = y.low;
    layers->count_y = y.low > y.high ? 0 : (ulong)(y.high - y.low) + 1;
}

// Keys of a cell, and of a face of a cell: that of the cell of the line on its high side is as far from lines_from.
CUT_INLINE uint key_of_cell(__private const CutGrid* grid, long i, long j, long k) {
    return (uint)((k * grid->counts[1] + j) * grid->counts[0] + i);
}
CUT_INLINE uint place_of(__private const CutGrid* grid, int across, long plane, long side, long along) {
    return (uint)((plane * grid->counts[side_of(across)] + side) * grid->counts[along_of(across)] + along);
}

// Records that are counted, or written if there are keys. A word is twice the face, and one more if a line enters.
typedef struct RecordSink {
    __global uint* keys;
    __global uint* words;
    uint face, count;
} RecordSink;

CUT_INLINE void add_record(__private RecordSink* sink, uint key, bool enters) {
    if (sink->keys != 0) {
        sink->keys[sink->count] = key;
        sink->words[sink->count] = 2 * sink->face + (enters ? 1 : 0);
    }
    ++sink->count;
}

CUT_INLINE CellRange range_of_segment(__private const CutGrid* grid, CutPoint p, CutPoint q, int axis) {
    const double a = cell_of(p, axis), b = cell_of(q, axis);
    return cells_between(lesser_of(a, b), greater_of(a, b), grid->first[axis], grid->counts[axis]);
}

CUT_INLINE bool is_in_range(CellRange range, long number) {
    return number >= range.low && number <= range.high;
}

// The line on the high side of so many cells.
CALLED_CUT void add_line_record(__private RecordSink* sink, __private const CutGrid* grid, int across, long plane,
                                long side, CutPoint down, CutPoint up) {
    const int axis = side_of(across), along = along_of(across);
    const double at = (double)(grid->first[axis] + side + 1);
    bool enters;
    if (!crosses_line(down, up, axis, at, &enters)) return;
    const double place = cell_of(point_at(down, up, axis, at), along);
    const CellRange cell = cells_between(place, place, grid->first[along], grid->counts[along]);
    if (cell.low < grid->counts[along])
        add_record(sink, grid->lines_from[across] + place_of(grid, across, plane, side, cell.low), enters);
}

// The faces of cells that a segment in a plane meets, of those with these numbers along side and along.
CALLED_CUT void add_face_records(__private RecordSink* sink, __private const CutGrid* grid, int across, long plane,
                                 CutPoint down, CutPoint up, CellRange of_sides, CellRange of_cells) {
    const int axis = side_of(across), along = along_of(across);
    const CellRange sides = range_of_segment(grid, down, up, axis);
    for (long side = max(sides.low, of_sides.low); side <= min(sides.high, of_sides.high); ++side) {
        CutPoint p = down, q = up;
        if (!cut_segment(&p, &q, axis, (double)(grid->first[axis] + side))) continue;
        const CellRange cells = range_of_segment(grid, p, q, along);
        for (long cell = max(cells.low, of_cells.low); cell <= min(cells.high, of_cells.high); ++cell) {
            CutPoint from = p, to = q;
            if (cut_segment(&from, &to, along, (double)(grid->first[along] + cell)))
                add_record(sink, grid->faces_from[across] + place_of(grid, across, plane, side, cell), false);
        }
    }
}

// The part of a face in a cell, whose low corner is `low`; along the axis across which it is moved, all of it.
CALLED_CUT __private const CutPolygon* part_of_face(__private const CutFace* face, CutVector low,
                                                    __private CutPolygon* rooms) {
    __private const CutPolygon* part = &rooms[0];
    for (int i = 0; i < 3; ++i) rooms[0].corners[i] = face->corners[i];
    rooms[0].count = 3;
    for (int axis = 2; axis >= 0 && part->count >= 3; --axis)
        if (axis != face->moved) part = part_in_cell(part, axis, low.at[axis], &rooms[3 - axis]);
    return part;
}

CALLED_CUT void add_cell_records(__private RecordSink* sink, __private const CutGrid* grid,
                                 __private const CutFace* face, long j, long k) {
    const int moved = face->moved;
    const long cell_j = moved == 1 ? j - 1 : j, cell_k = moved == 2 ? k - 1 : k;
    if (cell_j >= grid->counts[1] || cell_k >= grid->counts[2]) return;
    if (moved == 1 && face->least[1] != (double)(grid->first[1] + j)) return;
    CutPolygon whole, rooms[3];
    for (int i = 0; i < 3; ++i) whole.corners[i] = face->corners[i];
    whole.count = 3;
    __private const CutPolygon* part = &whole;
    if (moved != 2) part = part_in_cell(part, 2, (double)(grid->first[2] + k), &rooms[2]);
    if (part->count < 3 || !is_in_range(cells_of_polygon(part, 1, moved == 1, grid->first[1], grid->counts[1]), cell_j))
        return;
    if (moved != 1) part = part_in_cell(part, 1, (double)(grid->first[1] + j), &rooms[1]);
    if (part->count < 3) return;
    const CellRange cells = cells_of_polygon(part, 0, moved == 0, grid->first[0], grid->counts[0]);
    for (long i = cells.low; i <= cells.high; ++i) {
        const CutVector low = {
            {(double)(grid->first[0] + i), (double)(grid->first[1] + cell_j), (double)(grid->first[2] + cell_k)}};
        __private const CutPolygon* in_cell = moved == 0 ? part : part_in_cell(part, 0, low.at[0], &rooms[0]);
        bool has_area = false;
        for (int n = 0; n < piece_count(in_cell) && !has_area; ++n) {
            CutPiece piece;
            has_area = make_piece(in_cell, n, low, &piece);
        }
        if (!has_area) continue;
        if (moved == 0)
            add_record(sink, grid->faces_from[0] + place_of(grid, 0, i + 1, cell_k, cell_j), false);
        else if (moved == 1)
            add_record(sink, grid->faces_from[1] + place_of(grid, 1, j, cell_k, i), false);
        else if (moved == 2)
            add_record(sink, grid->faces_from[2] + place_of(grid, 2, k, i, cell_j), false);
        if (i >= 0 && cell_j >= 0 && cell_k >= 0) add_record(sink, key_of_cell(grid, i, cell_j, cell_k), false);
    }
}

// Of one item. is_first: that of the lowest j, which has the lines along y.
CUT_INLINE void add_records(__private RecordSink* sink, __private const CutGrid* grid, __private const CutFace* face,
                            long j, long k, bool is_first) {
    const bool is_below = face->most[1] < (double)grid->first[1];
    const bool has_cells_y = !is_below && j < grid->counts[1], has_cells_z = k < grid->counts[2];
    const CellRange row = {j, j}, layer = {k, k}, all = {0, grid->counts[0] - 1};
    CutPoint down, up;
    if (has_cells_z) {
        const double low = (double)grid->first[0], high = low + grid->counts[0];
        const double to = lesser_of(high, face->most[0]);
        for (double plane = greater_of(low, face->least[0] + 1); plane <= to; ++plane) {
            if (!section_of(face->corners, 0, plane, &down, &up)) continue;
            const long number = (long)plane - grid->first[0];
            if (is_first) add_line_record(sink, grid, 0, number, k, down, up);
            if (has_cells_y) add_face_records(sink, grid, 0, number, down, up, layer, row);
        }
    }
    if (has_cells_z && !is_below && section_of(face->corners, 1, (double)(grid->first[1] + j), &down, &up)) {
        add_line_record(sink, grid, 1, j, k, down, up);
        add_face_records(sink, grid, 1, j, down, up, layer, all);
    }
    if (section_of(face->corners, 2, (double)(grid->first[2] + k), &down, &up)) {
        if (is_first) {
            const double low = (double)grid->first[0], high = low + grid->counts[0];
            const double one = cell_of(down, 0), other = cell_of(up, 0), to = lesser_of(high, greater_of(one, other));
            for (double at = greater_of(low, lesser_of(one, other)) + 1; at <= to; ++at)
                add_line_record(sink, grid, 2, k, (long)at - grid->first[0] - 1, down, up);
        }
        if (has_cells_y) add_face_records(sink, grid, 2, k, down, up, all, row);
    }
    if (!is_below) add_cell_records(sink, grid, face, j, k);
}

#endif
