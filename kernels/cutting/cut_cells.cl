// Cells of a grid that the surface meets: the rows of the host (lib/cutting/cut_slab.cpp), with the same bytes.
//
// Faces are divided into items, which leave records in cells, in faces of cells and in cells of lines (cut_records.h).
// Prefix sums give items and records their places. A stable sort by key then has the faces of each cell together, in
// their order, so that sums have one order. Each cell finds its own records, and those of its faces and edges by binary
// search: no array is as large as the grid.
//
// Numbers of items, records and rows stay on the device: CutCounts has them. A kernel for which there is too little
// room sets its limit to 0, and those that follow do nothing.

#include "cut_lookup.h"
#include "cut_records.h"
#include "given_triples.h"

#pragma OPENCL FP_CONTRACT OFF

// The last of the starts, which ascend, that is not above a number.
CUT_INLINE uint owner_of(__global const uint* starts, uint count, uint number) {
    uint low = 0, high = count;
    while (high - low > 1) {
        const uint middle = low + (high - low) / 2;
        if (starts[middle] <= number)
            low = middle;
        else
            high = middle;
    }
    return low;
}

__kernel void begin_cuts(__global CutCounts* counts) {
    if (get_global_id(0) != 0) return;
    counts->rows = counts->is_complete = counts->items = counts->records = 0;
    counts->item_limit = counts->record_limit = counts->row_limit = 0;
    counts->far_vertex = CLSDF_NO_VERTEX;
}

// Vertices in cells of the lattice, so that a part has the bytes of the whole.
__kernel void place_vertices(CutGrid grid, GivenTriples of_vertices, __global const uint* vertices,
                             __global CutPoint* positions, __global CutCounts* counts, uint begin, uint end) {
    const uint vertex = begin + get_global_id(0);
    if (vertex >= end) return;
    bool is_near = true;
    CutPoint position;
    for (int axis = 0; axis < 3; ++axis)
        if (!place_coordinate(&grid, axis, coordinate(of_vertices, vertices, vertex, axis), &position)) is_near = false;
    positions[vertex] = position;
    if (!is_near) atomic_min((volatile __global uint*)&counts->far_vertex, vertex);
}

// layers: how many a face has.
__kernel void count_layers(CutGrid grid, __global const uint* triangles, __global const CutPoint* positions,
                           __global const CutCounts* counts, __global uint* layers, uint begin, uint end) {
    const uint number = begin + get_global_id(0);
    if (number >= end) return;
    ulong count = 0;
    if (counts->far_vertex == CLSDF_NO_VERTEX) {
        CutFace face;
        read_face(&grid, triangles, positions, number, &face);
        CutLayers of_face;
        find_layers(&grid, &face, &of_face);
        count = of_face.count_y * of_face.count_z;
    }
    layers[number] = (uint)min(count, (ulong)0xFFFFFFFFu);
}

// A total of prefix sums, which is behind the sums of so many parts.
__kernel void limit_items(__global const ulong* sums, uint parts, uint room, __global CutCounts* counts) {
    if (get_global_id(0) != 0) return;
    counts->items = sums[parts];
    counts->item_limit = sums[parts] <= room ? (uint)sums[parts] : 0;
}
__kernel void limit_records(__global const ulong* sums, uint parts, uint room, __global CutCounts* counts) {
    if (get_global_id(0) != 0) return;
    counts->records = sums[parts];
    counts->record_limit = sums[parts] <= room ? (uint)sums[parts] : 0;
}
// starts: of the rows, so that the last is their number. asked: the most that a complete result has; room: of the rows
// that are written.
__kernel void limit_rows(__global const uint* starts, uint records_room, uint asked, uint room,
                         __global CutCounts* counts) {
    if (get_global_id(0) != 0) return;
    const uint rows = starts[records_room];
    // Nothing is known without all records.
    const bool is_known = counts->far_vertex == CLSDF_NO_VERTEX && counts->item_limit == counts->items &&
                          counts->record_limit == counts->records;
    counts->rows = is_known ? rows : 0;
    counts->is_complete = is_known && rows <= asked;
    counts->row_limit = counts->is_complete && rows <= room ? rows : 0;
}

// starts: of the layers of faces. If there are no keys, the records of each item are counted; else they are written
// from record_starts on.
CUT_INLINE uint records_of_item(__private const CutGrid* grid, __global const uint* triangles,
                                __global const CutPoint* positions, uint faces, __global const uint* starts, uint item,
                                __global uint* keys, __global uint* words) {
    RecordSink sink = {keys, words, owner_of(starts, faces, item), 0};
    CutFace face;
    read_face(grid, triangles, positions, sink.face, &face);
    CutLayers layers;
    find_layers(grid, &face, &layers);
    const uint layer = item - starts[sink.face];
    const long j = layers.low_y + (long)(layer % layers.count_y), k = layers.low_z + (long)(layer / layers.count_y);
    add_records(&sink, grid, &face, j, k, j == layers.low_y);
    return sink.count;
}

__kernel void count_records(CutGrid grid, __global const uint* triangles, __global const CutPoint* positions,
                            uint faces, __global const uint* starts, __global const CutCounts* counts,
                            __global uint* records, uint begin, uint end) {
    const uint item = begin + get_global_id(0);
    if (item >= end) return;
    records[item] =
        item < counts->item_limit ? records_of_item(&grid, triangles, positions, faces, starts, item, 0, 0) : 0;
}

// sorted_keys: a second copy, for take_sorted().
__kernel void write_records(CutGrid grid, __global const uint* triangles, __global const CutPoint* positions,
                            uint faces, __global const uint* starts, __global const CutCounts* counts,
                            __global const uint* record_starts, __global uint* keys, __global uint* words, uint begin,
                            uint end) {
    const uint item = begin + get_global_id(0);
    if (item >= end || counts->record_limit == 0 || item >= counts->item_limit) return;
    const uint first = record_starts[item];
    if (first == record_starts[item + 1]) return;
    records_of_item(&grid, triangles, positions, faces, starts, item, keys + first, words + first);
}

// The keys beyond the records are behind all others. copy: of the keys, which a sort overwrites.
__kernel void copy_keys(CutGrid grid, __global const CutCounts* counts, __global uint* keys, __global uint* copy,
                        uint begin, uint end) {
    const uint i = begin + get_global_id(0);
    if (i >= end) return;
    if (i >= counts->record_limit) keys[i] = grid.keys;
    copy[i] = keys[i];
}

// Keys and words in order. heads: 1 for the first record of a cell. ways: of lines, 1 or -1 in 32 bits.
__kernel void take_sorted(CutGrid grid, __global const CutCounts* counts, __global const uint* order,
                          __global const uint* keys, __global const uint* words, __global uint* sorted_keys,
                          __global uint* sorted_words, __global uint* heads, __global uint* ways, uint begin,
                          uint end) {
    const uint i = begin + get_global_id(0);
    if (i >= end) return;
    const uint from = order[i], key = keys[from];
    const bool is_record = i < counts->record_limit;
    const uint word = is_record ? words[from] : 0;
    sorted_keys[i] = key;
    sorted_words[i] = word;
    heads[i] = is_record && key < grid.faces_from[0] && (i == 0 || keys[order[i - 1]] != key);
    ways[i] = !is_record || key < grid.lines_from[0] ? 0 : (word & 1) != 0 ? 1 : 0xFFFFFFFFu;
}

// row_firsts: the first record of each row, and the end of the last one's. set_of: each record of a cell by itself.
__kernel void list_rows(CutGrid grid, __global const CutCounts* counts, __global const uint* sorted_keys,
                        __global const uint* heads, __global const uint* row_starts, __global uint* row_firsts,
                        __global uint* set_of, uint begin, uint end) {
    const uint i = begin + get_global_id(0);
    if (i >= end || counts->row_limit == 0 || i >= counts->record_limit) return;
    set_of[i] = i;
    if (heads[i] != 0) row_firsts[row_starts[i]] = i;
    const uint cells = grid.faces_from[0];
    if (sorted_keys[i] < cells && (i + 1 == counts->record_limit || sorted_keys[i + 1] >= cells))
        row_firsts[counts->row_limit] = i + 1;
}

// Sets of records, which are trees whose roots are their least ones. All access is atomic.
CUT_INLINE uint root_of(volatile __global uint* set_of, uint record) {
    uint above = atomic_or(&set_of[record], 0u);
    while (above != record) {
        record = above;
        above = atomic_or(&set_of[record], 0u);
    }
    return record;
}

CUT_INLINE void join_sets(volatile __global uint* set_of, uint a, uint b) {
    for (;;) {
        a = root_of(set_of, a);
        b = root_of(set_of, b);
        if (a == b) return;
        const uint low = min(a, b), high = max(a, b);
        if (atomic_cmpxchg(&set_of[high], high, low) == high) return;
    }
}

// Joins the faces of a cell over edges that have a part in it. next_of_edge: for each corner of a triangle, at which an
// edge begins, the next corner of the edge's triangles, in a ring.
__kernel void join_faces(CutGrid grid, __global const uint* triangles, __global const CutPoint* positions,
                         __global const uint* next_of_edge, __global const CutCounts* counts,
                         __global const uint* sorted_words, __global const uint* row_starts,
                         __global const uint* row_firsts, __global const uint* sorted_keys,
                         volatile __global uint* set_of, uint begin, uint end) {
    const uint i = begin + get_global_id(0);
    if (i >= end || counts->row_limit == 0 || i >= row_firsts[counts->row_limit]) return;
    const uint row = row_starts[i + 1] - 1, first = row_firsts[row], behind = row_firsts[row + 1];
    if (behind - first < 2) return;
    const uint key = sorted_keys[i], face = sorted_words[i] / 2;
    const CutVector low = {{(double)(grid.first[0] + key % grid.counts[0]),
                            (double)(grid.first[1] + key / grid.counts[0] % grid.counts[1]),
                            (double)(grid.first[2] + key / grid.counts[0] / grid.counts[1])}};
    for (uint corner = 0; corner < 3; ++corner) {
        const uint edge = 3 * face + corner;
        const uint p = triangles[edge], q = triangles[3 * face + (corner < 2 ? corner + 1 : 0)];
        if (!edge_meets_cell(vertex_at(positions, min(p, q)), vertex_at(positions, max(p, q)), low)) continue;
        // The next triangle at the edge that has a part in the cell.
        for (uint next = next_of_edge[edge]; next != edge; next = next_of_edge[next]) {
            uint from = first, to = behind;
            while (from < to) {
                const uint middle = from + (to - from) / 2;
                if (sorted_words[middle] / 2 < next / 3)
                    from = middle + 1;
                else
                    to = middle;
            }
            if (from == behind || sorted_words[from] / 2 != next / 3) continue;
            join_sets(set_of, i, from);
            break;
        }
    }
}

// One work-item a row. Without pieces their number is 0.
__kernel void write_rows(CutGrid grid, __global const uint* triangles, __global const CutPoint* positions,
                         __global const CutCounts* counts, __global const uint* sorted_keys,
                         __global const uint* sorted_words, __global const uint* ways, __global const uint* row_firsts,
                         __global const uint* set_of, int with_pieces, __global FractionRow* rows, uint begin,
                         uint end) {
    const uint number = begin + get_global_id(0);
    if (number >= end || number >= counts->row_limit) return;
    const Records records = {sorted_keys, sorted_words, ways, counts->record_limit};
    const uint first = row_firsts[number], behind = row_firsts[number + 1], key = sorted_keys[first];
    const long cell[3] = {key % grid.counts[0], key / grid.counts[0] % grid.counts[1],
                          key / grid.counts[0] / grid.counts[1]};
    CutVector low;
    for (int d = 0; d < 3; ++d) low.at[d] = (double)(grid.first[d] + cell[d]);
    CellSums sums;
    const CutSum zero = {0, 0};
    for (int d = 0; d < 3; ++d) sums.normal[d] = sums.moment[d] = sums.second[d] = sums.centre[d] = zero;
    sums.area = zero;
    uint pieces = 0;
    for (uint record = first; record < behind; ++record) {
        if (with_pieces) pieces += set_of[record] == record ? 1 : 0;
        CutFace face;
        read_face(&grid, triangles, positions, sorted_words[record] / 2, &face);
        CutPolygon rooms[4];
        __private const CutPolygon* part = part_of_face(&face, low, rooms);
        for (int n = 0; n < piece_count(part); ++n) {
            CutPiece piece;
            if (make_piece(part, n, low, &piece)) add_piece(&sums, &piece, grid.spacing);
        }
    }
    FaceValues sections[6];
    for (int face = 0; face < 6; ++face) {
        const int across = face / 2;
        sections[face] = values_of_cell_face(&grid, records, triangles, positions, across, cell[across] + face % 2,
                                             cell[side_of(across)], cell[along_of(across)]);
    }
    FractionRow row;
    make_solid_row(&sums, sections, grid.spacing, &row);
    row.pieces = pieces;
    for (int d = 0; d < 3; ++d) row.cell[d] = (clsdf_int32)(grid.first[d] + cell[d]);
    tell_row(&row, &grid);
    rows[number] = row;
}
