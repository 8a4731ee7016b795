// Triangles that are cut by the planes between the cells of a grid. Coordinates are in cells of the lattice, so that
// these planes have whole numbers. A coordinate on a plane counts as above it.
//
// A coordinate is the number of the nearest plane and what lies beyond it. So points are as exact far from sample 0 as
// there, and rounding is relative to a cell or, for larger ones, to the triangle. Nothing depends on the grid's first
// cell, so a part has the bytes of the whole.
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

// whole: the nearest planes. part: from there, -0.5 to 0.5.
typedef struct CutPoint {
    double whole[3], part[3];
} CutPoint;

// In cells, from a point, or from the low corner of a cell; or planes.
typedef struct CutVector {
    double at[3];
} CutVector;

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

// Of `count` cells from `first` on those from one cell of the lattice to another.
CUT_INLINE CellRange cells_between(double least, double most, clsdf_int64 first, clsdf_int64 count) {
    const double start = (double)first, end = (double)(first + count);
    CellRange range;
    range.low = least < start ? 0 : (clsdf_int64)lesser_of(least, end) - first;
    range.high = most < start ? -1 : (clsdf_int64)lesser_of(most, end - 1) - first;
    return range;
}

// The whole number that is nearest; of two the higher one, whatever they are: a cell's number is no part of its bytes.
CUT_INLINE double nearest_plane(double x) {
    const double plane = rint(x);
    return x - plane == 0.5 ? plane + 1 : plane;
}

// A coordinate so far from a plane.
CUT_INLINE void set_coordinate(__private CutPoint* point, int axis, double plane, double from_plane) {
    const double planes = nearest_plane(from_plane);
    point->whole[axis] = plane + planes;
    point->part[axis] = from_plane - planes;
}

// A coordinate of the mesh on the lattice: a real number until what lies beyond the nearest plane is rounded. False if
// it is so far away that a place there is a whole number.
CUT_INLINE bool place_coordinate(__private const CutGrid* grid, int axis, double x, __private CutPoint* point) {
    const double origin = grid->origin[axis], spacing = grid->spacing[axis];
    // The difference and what its rounding took away (D. Knuth).
    const double from = x - origin, subtracted = from - x;
    const double rest = (x - (from - subtracted)) - (origin + subtracted);
    const double cells = from / spacing, plane = nearest_plane(cells);
    set_coordinate(point, axis, plane, (fma(-plane, spacing, from) + rest) / spacing);
    const double tolerance = cells == plane ? greater_of(grid->snap, CLSDF_ROUNDED_ONTO_PLANE) : grid->snap;
    if (fabs(point->part[axis]) <= tolerance) point->part[axis] = 0;
    return fabs(cells) <= CLSDF_FARTHEST_VERTEX;
}

// How far a point is above a plane: the sign is exact.
CUT_INLINE double above_plane(CutPoint p, int axis, double plane) {
    return (p.whole[axis] - plane) + p.part[axis];
}
CUT_INLINE bool is_above(CutPoint p, int axis, double plane) {
    return above_plane(p, axis, plane) >= 0;
}
// The cell in which a coordinate lies: the plane below it.
CUT_INLINE double cell_of(CutPoint p, int axis) {
    return p.part[axis] < 0 ? p.whole[axis] - 1 : p.whole[axis];
}

CUT_INLINE CutVector cut_way(CutPoint from, CutPoint to) {
    CutVector way;
    for (int k = 0; k < 3; ++k) way.at[k] = (to.whole[k] - from.whole[k]) + (to.part[k] - from.part[k]);
    return way;
}
CUT_INLINE CutVector from_corner(CutPoint p, CutVector corner) {
    CutVector from;
    for (int k = 0; k < 3; ++k) from.at[k] = above_plane(p, k, corner.at[k]);
    return from;
}

CUT_INLINE CutVector cut_difference(CutVector a, CutVector b) {
    CutVector difference;
    for (int k = 0; k < 3; ++k) difference.at[k] = a.at[k] - b.at[k];
    return difference;
}

CUT_INLINE CutVector cut_cross(CutVector a, CutVector b) {
    CutVector cross;
    cross.at[0] = a.at[1] * b.at[2] - a.at[2] * b.at[1];
    cross.at[1] = a.at[2] * b.at[0] - a.at[0] * b.at[2];
    cross.at[2] = a.at[0] * b.at[1] - a.at[1] * b.at[0];
    return cross;
}

// An order of points.
CUT_INLINE bool is_before(CutPoint p, CutPoint q) {
    for (int k = 0; k < 3; ++k) {
        if (p.whole[k] != q.whole[k]) return p.whole[k] < q.whole[k];
        if (p.part[k] != q.part[k]) return p.part[k] < q.part[k];
    }
    return false;
}

// The point of an edge in a plane, with the same bits from both sides.
CUT_INLINE CutPoint point_at(CutPoint p, CutPoint q, int axis, double plane) {
    if (is_before(q, p)) {
        const CutPoint other = p;
        p = q;
        q = other;
    }
    if (q.whole[axis] == plane && q.part[axis] == 0) return q;
    const CutVector way = cut_way(p, q);
    const double share = ((plane - p.whole[axis]) - p.part[axis]) / way.at[axis];
    CutPoint point;
    for (int k = 0; k < 3; ++k) set_coordinate(&point, k, p.whole[k], p.part[k] + share * way.at[k]);
    point.whole[axis] = plane;
    point.part[axis] = 0;
    return point;
}

// A convex polygon: a triangle has at most nine corners after six cuts. With less than three it is empty.
typedef struct CutPolygon {
    CutPoint corners[12];
    clsdf_int32 count;
} CutPolygon;

// The part at or above a plane, or below.
CALLED_CUT void cut_polygon(__private const CutPolygon* whole, int axis, double plane, bool is_upper,
                            __private CutPolygon* part) {
    clsdf_int32 count = 0;
    for (clsdf_int32 i = 0; i < whole->count; ++i) {
        __private const CutPoint* p = &whole->corners[i];
        __private const CutPoint* q = &whole->corners[i + 1 < whole->count ? i + 1 : 0];
        const bool is_in = is_above(*p, axis, plane) == is_upper, is_next_in = is_above(*q, axis, plane) == is_upper;
        if (is_in) part->corners[count++] = *p;
        if (is_in != is_next_in) part->corners[count++] = point_at(*p, *q, axis, plane);
    }
    part->count = count;
}

// The part from `low` up to a cell farther: in `room`, unless it is all of the polygon.
CUT_INLINE __private const CutPolygon* part_in_cell(__private const CutPolygon* whole, int axis, double low,
                                                    __private CutPolygon* room) {
    bool has_lower = false, has_upper = false;
    for (clsdf_int32 i = 0; i < whole->count; ++i) {
        has_lower = has_lower || !is_above(whole->corners[i], axis, low);
        has_upper = has_upper || is_above(whole->corners[i], axis, low + 1);
    }
    if (!has_lower && !has_upper) return whole;
    if (has_lower && has_upper) {
        CutPolygon above;
        cut_polygon(whole, axis, low, true, &above);
        cut_polygon(&above, axis, low + 1, false, room);
    } else {
        cut_polygon(whole, axis, has_lower ? low : low + 1, has_lower, room);
    }
    return room;
}

// A triangle's surface that lies in a plane between cells may go to the cell below it.
#define CLSDF_NOT_MOVED 3

// The axis across which it lies in such a plane, if it goes there. walls: a WallCell.
CUT_INLINE int moved_axis(__private const CutPoint* corners, int walls) {
    if (walls == CLSDF_WALLS_ABOVE) return CLSDF_NOT_MOVED;
    for (int axis = 0; axis < 3; ++axis) {
        bool is_in_plane = true;
        for (int i = 0; i < 3; ++i)
            is_in_plane = is_in_plane && corners[i].whole[axis] == corners[0].whole[axis] && corners[i].part[axis] == 0;
        if (!is_in_plane) continue;
        const CutVector twice = cut_cross(cut_way(corners[0], corners[1]), cut_way(corners[0], corners[2]));
        return (walls == CLSDF_WALLS_FLUID ? twice.at[axis] < 0 : twice.at[axis] > 0) ? axis : CLSDF_NOT_MOVED;
    }
    return CLSDF_NOT_MOVED;
}

// The cells along an axis in which a polygon lies. If it is moved across that axis, the cell below its plane, which may
// be the one below the first.
CUT_INLINE CellRange cells_of_polygon(__private const CutPolygon* polygon, int axis, bool is_moved, clsdf_int64 first,
                                      clsdf_int64 count) {
    double least = cell_of(polygon->corners[0], axis), most = least;
    for (clsdf_int32 i = 1; i < polygon->count; ++i) {
        const double cell = cell_of(polygon->corners[i], axis);
        least = lesser_of(least, cell);
        most = greater_of(most, cell);
    }
    if (!is_moved) return cells_between(least, most, first, count);
    CellRange range = {0, -1};
    if (least >= (double)first && least <= (double)(first + count))
        range.low = range.high = (clsdf_int64)least - first - 1;
    return range;
}

// A triangle of a polygon's fan, from a cell's low corner. twice: its vector area.
typedef struct CutPiece {
    CutVector a, b, c, twice;
} CutPiece;

CUT_INLINE clsdf_int32 piece_count(__private const CutPolygon* polygon) {
    return polygon->count - 2;
}

// False if it has no area: it is an edge of the triangle in a plane between cells.
CUT_INLINE bool make_piece(__private const CutPolygon* polygon, clsdf_int32 number, CutVector low,
                           __private CutPiece* piece) {
    piece->a = from_corner(polygon->corners[0], low);
    piece->b = from_corner(polygon->corners[number + 1], low);
    piece->c = from_corner(polygon->corners[number + 2], low);
    piece->twice = cut_cross(cut_difference(piece->b, piece->a), cut_difference(piece->c, piece->a));
    return piece->twice.at[0] != 0 || piece->twice.at[1] != 0 || piece->twice.at[2] != 0;
}

// Whether an edge has a part in a cell that is longer than a point.
CUT_INLINE bool edge_meets_cell(CutPoint p, CutPoint q, CutVector low) {
    const CutVector start = from_corner(p, low), way = cut_way(p, q);
    double from = 0, to = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double at = start.at[axis], step = way.at[axis];
        if (step == 0) {
            if (at < 0 || at > 1) return false;
            continue;
        }
        const double one = -at / step, other = (1 - at) / step;
        from = greater_of(from, lesser_of(one, other));
        to = lesser_of(to, greater_of(one, other));
    }
    return from < to;
}

#endif
