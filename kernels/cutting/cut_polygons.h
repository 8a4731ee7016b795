// Triangles that are cut by the planes between the cells of a grid. Coordinates are in cells of the lattice, so that
// these planes have whole numbers. A coordinate on a plane counts as above it.
//
// The host compiles this file, too (lib/cutting/cut_shapes.hpp). Both make the same operations in the same order, so
// cells have the same bytes.
#ifndef CLSDF_CUT_POLYGONS_H
#define CLSDF_CUT_POLYGONS_H

#include "cut_grid.h"

// Functions of kernels, of which those with more work than a call are compiled once.
#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#include "simd.h"
#define CUT_INLINE INLINE
#ifdef PLAIN_INLINE
#define CALLED_CUT inline
#else
#define CALLED_CUT static __attribute__((noinline))
#endif
#else
#define CUT_INLINE static inline
#define CALLED_CUT static inline
#endif

typedef struct CutPoint {
    double at[3];
} CutPoint;

// The lowest and the highest of the cells along an axis, counted from the grid's first; none if low > high.
typedef struct CellRange {
    clsdf_int64 low, high;
} CellRange;

CUT_INLINE double lesser_of(double a, double b) {
    return b < a ? b : a;
}
CUT_INLINE double greater_of(double a, double b) {
    return a < b ? b : a;
}

// Of `count` cells from `first` on those in which a range of coordinates lies.
CUT_INLINE CellRange cells_between(double least, double most, clsdf_int64 first, clsdf_int64 count) {
    const double start = (double)first, end = (double)(first + count);
    CellRange range;
    range.low = least < start ? 0 : (clsdf_int64)lesser_of(floor(least), end) - first;
    range.high = most < start ? -1 : (clsdf_int64)lesser_of(floor(most), end - 1) - first;
    return range;
}

CUT_INLINE CutPoint cut_difference(CutPoint a, CutPoint b) {
    CutPoint point;
    for (int k = 0; k < 3; ++k) point.at[k] = a.at[k] - b.at[k];
    return point;
}

CUT_INLINE CutPoint cut_cross(CutPoint a, CutPoint b) {
    CutPoint point;
    point.at[0] = a.at[1] * b.at[2] - a.at[2] * b.at[1];
    point.at[1] = a.at[2] * b.at[0] - a.at[0] * b.at[2];
    point.at[2] = a.at[0] * b.at[1] - a.at[1] * b.at[0];
    return point;
}

CUT_INLINE bool is_before(CutPoint p, CutPoint q) {
    if (p.at[0] != q.at[0]) return p.at[0] < q.at[0];
    if (p.at[1] != q.at[1]) return p.at[1] < q.at[1];
    return p.at[2] < q.at[2];
}

// The point of an edge at which a coordinate has a value, with the same bits from both sides.
CUT_INLINE CutPoint point_at(CutPoint p, CutPoint q, int axis, double value) {
    if (is_before(q, p)) {
        const CutPoint other = p;
        p = q;
        q = other;
    }
    if (value == q.at[axis]) return q;
    const double share = (value - p.at[axis]) / (q.at[axis] - p.at[axis]);
    CutPoint point;
    for (int k = 0; k < 3; ++k) point.at[k] = p.at[k] + share * (q.at[k] - p.at[k]);
    point.at[axis] = value;
    return point;
}

// A convex polygon: a triangle has at most nine corners after six cuts. With less than three it is empty.
typedef struct CutPolygon {
    CutPoint corners[12];
    clsdf_int32 count;
} CutPolygon;

// The part at or above a value, or below.
CALLED_CUT void cut_polygon(__private const CutPolygon* whole, int axis, double value, bool is_above,
                            __private CutPolygon* part) {
    clsdf_int32 count = 0;
    for (clsdf_int32 i = 0; i < whole->count; ++i) {
        __private const CutPoint* p = &whole->corners[i];
        __private const CutPoint* q = &whole->corners[i + 1 < whole->count ? i + 1 : 0];
        const bool is_in = (p->at[axis] >= value) == is_above, is_next_in = (q->at[axis] >= value) == is_above;
        if (is_in) part->corners[count++] = *p;
        if (is_in != is_next_in) part->corners[count++] = point_at(*p, *q, axis, value);
    }
    part->count = count;
}

// The part from `low` up to a cell farther: in `room`, unless it is all of the polygon.
CUT_INLINE __private const CutPolygon* part_in_cell(__private const CutPolygon* whole, int axis, double low,
                                                    __private CutPolygon* room) {
    bool is_below = false, is_above = false;
    for (clsdf_int32 i = 0; i < whole->count; ++i) {
        is_below = is_below || whole->corners[i].at[axis] < low;
        is_above = is_above || whole->corners[i].at[axis] >= low + 1;
    }
    if (!is_below && !is_above) return whole;
    if (is_below && is_above) {
        CutPolygon above;
        cut_polygon(whole, axis, low, true, &above);
        cut_polygon(&above, axis, low + 1, false, room);
    } else {
        cut_polygon(whole, axis, is_below ? low : low + 1, is_below, room);
    }
    return room;
}

// A triangle's surface that lies in a plane between cells may go to the cell below it.
#define CLSDF_NOT_MOVED 3

// The axis across which it lies in such a plane, if it goes there. walls: a WallCell.
CUT_INLINE int moved_axis(__private const CutPoint* corners, int walls) {
    if (walls == CLSDF_WALLS_ABOVE) return CLSDF_NOT_MOVED;
    for (int axis = 0; axis < 3; ++axis) {
        const double at = corners[0].at[axis];
        if (at != corners[1].at[axis] || at != corners[2].at[axis] || at != floor(at)) continue;
        const CutPoint twice =
            cut_cross(cut_difference(corners[1], corners[0]), cut_difference(corners[2], corners[0]));
        return (walls == CLSDF_WALLS_FLUID ? twice.at[axis] < 0 : twice.at[axis] > 0) ? axis : CLSDF_NOT_MOVED;
    }
    return CLSDF_NOT_MOVED;
}

// The cells along an axis in which a polygon lies. If it is moved across that axis, the cell below its plane, which may
// be the one below the first.
CUT_INLINE CellRange cells_of_polygon(__private const CutPolygon* polygon, int axis, bool is_moved, clsdf_int64 first,
                                      clsdf_int64 count) {
    double least = polygon->corners[0].at[axis], most = least;
    for (clsdf_int32 i = 1; i < polygon->count; ++i) {
        least = lesser_of(least, polygon->corners[i].at[axis]);
        most = greater_of(most, polygon->corners[i].at[axis]);
    }
    if (!is_moved) return cells_between(least, most, first, count);
    CellRange range = {0, -1};
    if (least >= (double)first && least <= (double)(first + count))
        range.low = range.high = (clsdf_int64)least - first - 1;
    return range;
}

// A triangle of a polygon's fan, from a cell's low corner. twice: its vector area.
typedef struct CutPiece {
    CutPoint a, b, c, twice;
} CutPiece;

CUT_INLINE clsdf_int32 piece_count(__private const CutPolygon* polygon) {
    return polygon->count - 2;
}

// False if it has no area: it is an edge of the triangle in a plane between cells.
CUT_INLINE bool make_piece(__private const CutPolygon* polygon, clsdf_int32 number, CutPoint low,
                           __private CutPiece* piece) {
    piece->a = cut_difference(polygon->corners[0], low);
    piece->b = cut_difference(polygon->corners[number + 1], low);
    piece->c = cut_difference(polygon->corners[number + 2], low);
    piece->twice = cut_cross(cut_difference(piece->b, piece->a), cut_difference(piece->c, piece->a));
    return piece->twice.at[0] != 0 || piece->twice.at[1] != 0 || piece->twice.at[2] != 0;
}

// Whether an edge has a part in a cell.
CUT_INLINE bool edge_meets_cell(CutPoint p, CutPoint q, CutPoint low) {
    double from = 0, to = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double step = q.at[axis] - p.at[axis];
        if (step == 0) {
            if (p.at[axis] < low.at[axis] || p.at[axis] > low.at[axis] + 1) return false;
            continue;
        }
        const double one = (low.at[axis] - p.at[axis]) / step, other = (low.at[axis] + 1 - p.at[axis]) / step;
        from = greater_of(from, lesser_of(one, other));
        to = lesser_of(to, greater_of(one, other));
    }
    return from <= to;
}

#endif
