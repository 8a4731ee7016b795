// Sections of the solid with planes between cells. In the plane across an axis, `side` and `along` are the other axes:
// lines run along the latter. By Green's theorem the integral over a section in the face of a cell is one along its
// boundary: pieces of triangles that the plane cuts, and the edge of the cell on the high side. The host compiles this
// file, too: see cut_polygons.h.
#ifndef CLSDF_CUT_SECTIONS_H
#define CLSDF_CUT_SECTIONS_H

#include "cut_polygons.h"

#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#endif

// A sum that rounds once (A. Neumaier, 1974), with the rest of each addition by D. Knuth's, which has no branch.
typedef struct CutSum {
    double sum, rest;
} CutSum;

CUT_INLINE void add_to(__private CutSum* to, double value) {
    const double sum = to->sum + value, part = sum - to->sum;
    to->rest += (to->sum - (sum - part)) + (value - part);
    to->sum = sum;
}
CUT_INLINE double value_of(CutSum sum) {
    return sum.sum + sum.rest;
}

CUT_INLINE int side_of(int across) {
    return across == 2 ? 0 : 2;
}
CUT_INLINE int along_of(int across) {
    return across == 1 ? 0 : 1;
}

// Integrals over a solid's section with a face of a cell: of 1, and of the coordinates along `side` and `along`, from
// the cell's low corner.
typedef struct FaceSums {
    CutSum area, first, second;
} FaceSums;
typedef struct FaceValues {
    double area, first, second;
} FaceValues;

CUT_INLINE void add_face_values(__private FaceSums* to, double area, double first, double second) {
    add_to(&to->area, area);
    add_to(&to->first, first);
    add_to(&to->second, second);
}

// length, moment: of the edge on the high side, where the side's coordinate is 1.
CUT_INLINE FaceValues values_of_face(double length, double moment, __private const FaceSums* sums) {
    FaceValues values;
    values.area = length + value_of(sums->area);
    values.first = length / 2 + value_of(sums->first);
    values.second = moment + value_of(sums->second);
    return values;
}

// The ends of a triangle's part in a plane. Seen from above, the solid is on the left of the way from `down` to `up`.
// False if the plane does not cut it.
CALLED_CUT bool section_of(__private const CutPoint* corners, int across, double plane, __private CutPoint* down,
                           __private CutPoint* up) {
    bool are_above[3];
    for (int i = 0; i < 3; ++i) are_above[i] = is_above(corners[i], across, plane);
    if (are_above[0] == are_above[1] && are_above[1] == are_above[2]) return false;
    const bool is_turned = across == 0;
    for (int i = 0; i < 3; ++i) {
        const int next = i < 2 ? i + 1 : 0;
        if (are_above[i] == are_above[next]) continue;
        const CutPoint point = point_at(corners[i], corners[next], across, plane);
        if (are_above[i] != is_turned)
            *down = point;
        else
            *up = point;
    }
    return true;
}

// Shortens a segment to a cell; its ends keep their order. False if nothing is left.
CUT_INLINE bool cut_segment(__private CutPoint* p, __private CutPoint* q, int axis, double cell) {
    const CutPoint from = *p, to = *q;
    const double a = cell_of(from, axis), b = cell_of(to, axis);
    if ((a < cell && b < cell) || (a > cell && b > cell)) return false;
    if (a != cell) *p = point_at(from, to, axis, a < cell ? cell : cell + 1);
    if (b != cell) *q = point_at(from, to, axis, b < cell ? cell : cell + 1);
    return true;
}

CUT_INLINE void add_segment(__private FaceSums* to, CutPoint from, CutPoint end, int across, double low_side,
                            double low_along) {
    const int side = side_of(across), along = along_of(across);
    const double b0 = above_plane(from, side, low_side), b1 = above_plane(end, side, low_side);
    const double c0 = above_plane(from, along, low_along), c1 = above_plane(end, along, low_along);
    const double step = cut_way(from, end).at[along];
    add_face_values(to, (b0 + b1) / 2 * step, (b0 * b0 + b0 * b1 + b1 * b1) / 6 * step,
                    (2 * (b0 * c0 + b1 * c1) + b0 * c1 + b1 * c0) / 6 * step);
}

CUT_INLINE double mean_of_piece(__private const CutPiece* piece, int axis) {
    return (piece->a.at[axis] + piece->b.at[axis] + piece->c.at[axis]) / 3;
}

// A piece that lies in the face and goes to the cell below adds itself to the solid's section, or takes itself away.
CUT_INLINE void add_moved_piece(__private FaceSums* to, __private const CutPiece* piece, int across) {
    const double area = -piece->twice.at[across] / 2;
    add_face_values(to, area, area * mean_of_piece(piece, side_of(across)),
                    area * mean_of_piece(piece, along_of(across)));
}

// Of the part of a line in a cell that is within the solid.
typedef struct LineSums {
    CutSum length, moment;
} LineSums;

// Whether the way from `down` to `up` crosses a line, at `at` of the axis `side`, and whether the line enters there.
CUT_INLINE bool crosses_line(CutPoint down, CutPoint up, int side, double at, __private bool* enters) {
    *enters = is_above(up, side, at);
    return is_above(down, side, at) != *enters;
}

// A line that enters the solid (way 1) or leaves it (-1), so far from the cell's low end.
CUT_INLINE void add_crossing(__private LineSums* to, int way, double from) {
    add_to(&to->length, -way * from);
    add_to(&to->moment, -way * from * from / 2);
}
CUT_INLINE double length_in_cell(int steps, __private const LineSums* sums) {
    return steps + value_of(sums->length);
}
CUT_INLINE double moment_in_cell(int steps, __private const LineSums* sums) {
    return 0.5 * steps + value_of(sums->moment);
}

#endif
