// The rows of cells that the surface meets: sums over the surface in a cell, and the numbers that are told of it. The
// host compiles this file, too: see cut_polygons.h.
#ifndef CLSDF_CELL_ROWS_H
#define CLSDF_CELL_ROWS_H

#include "cut_grid.h"
#include "cut_sections.h"

#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#endif

// Integrals over the surface in a cell, in cells from its low corner.
typedef struct CellSums {
    CutSum normal[3], moment[3], second[3];  // of n_d, x_d n_d and x_d^2 n_d / 2 dA
    CutSum area;                             // in the mesh's units, as those that follow
    CutSum centre[3];                        // of the coordinates
} CellSums;

CUT_INLINE void add_piece(__private CellSums* sums, __private const CutPiece* piece, __private const double* spacing) {
    CutVector in_units;
    for (int d = 0; d < 3; ++d) {
        const double a = piece->a.at[d], b = piece->b.at[d], c = piece->c.at[d];
        const double normal = piece->twice.at[d] / 2;
        add_to(&sums->normal[d], normal);
        add_to(&sums->moment[d], normal * (a + b + c) / 3);
        add_to(&sums->second[d], normal * (a * a + b * b + c * c + a * b + b * c + c * a) / 12);
        in_units.at[d] = normal * spacing[(d + 1) % 3] * spacing[(d + 2) % 3];
    }
    const double area =
        sqrt(in_units.at[0] * in_units.at[0] + in_units.at[1] * in_units.at[1] + in_units.at[2] * in_units.at[2]);
    add_to(&sums->area, area);
    for (int d = 0; d < 3; ++d) add_to(&sums->centre[d], area * (piece->a.at[d] + piece->b.at[d] + piece->c.at[d]) / 3);
}

CUT_INLINE double clamped(double x, double low, double high) {
    return x < low ? low : high < x ? high : x;
}

// The row of the solid, with integrals from the middle of cell and faces in place of centroids. sections: of the faces,
// low and high across x, y and z.
CUT_INLINE void make_solid_row(__private const CellSums* sums, __private const FaceValues* sections,
                               __private const double* spacing, __private FractionRow* row) {
    row->volume = sections[5].area + value_of(sums->moment[2]);
    row->area = value_of(sums->area);
    for (int d = 0; d < 3; ++d) {
        row->vector_area[d] = value_of(sums->normal[d]) * spacing[(d + 1) % 3] * spacing[(d + 2) % 3];
        row->centroid[d] = sections[2 * d + 1].area / 2 + value_of(sums->second[d]) - row->volume / 2;
        row->surface_centroid[d] = row->area > 0 ? clamped(value_of(sums->centre[d]) / row->area - 0.5, -0.5, 0.5) : 0;
        const bool is_side_first = side_of(d) < along_of(d);
        for (int face = 2 * d; face < 2 * d + 2; ++face) {
            const FaceValues of_face = sections[face];
            const double first = of_face.first - of_face.area / 2, second = of_face.second - of_face.area / 2;
            row->face_fractions[face] = of_face.area;
            row->face_centroids[face][0] = is_side_first ? first : second;
            row->face_centroids[face][1] = is_side_first ? second : first;
        }
    }
}

CUT_INLINE double told_part(double solid, __private const CutGrid* grid) {
    return grid->is_fluid ? 1 - solid : solid;
}
CUT_INLINE double told_point(double from_middle, __private const CutGrid* grid, clsdf_int32 cell, int axis) {
    if (!grid->as_points) return from_middle;
    return fma((double)cell, grid->spacing[axis], grid->origin[axis]) + grid->spacing[axis] * (0.5 + from_middle);
}
// The moments of both parts, from the middle, add up to 0.
CUT_INLINE double told_centroid(double size, double moment, __private const CutGrid* grid, clsdf_int32 cell, int axis) {
    if (grid->is_fluid) moment = -moment;
    return told_point(size > 0 ? clamped(moment / size, -0.5, 0.5) : 0, grid, cell, axis);
}

CUT_INLINE double length_of(__private const double* v) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// The same row in the way that is asked for.
CUT_INLINE void tell_row(__private FractionRow* row, __private const CutGrid* grid) {
    row->volume = told_part(row->volume, grid);
    for (int d = 0; d < 3; ++d) {
        row->centroid[d] = told_centroid(row->volume, row->centroid[d], grid, row->cell[d], d);
        row->surface_centroid[d] = told_point(row->surface_centroid[d], grid, row->cell[d], d);
        for (int face = 2 * d; face < 2 * d + 2; ++face) {
            row->face_fractions[face] = told_part(row->face_fractions[face], grid);
            for (int n = 0; n < 2; ++n) {
                const int axis = n < d ? n : n + 1;
                row->face_centroids[face][n] =
                    told_centroid(row->face_fractions[face], row->face_centroids[face][n], grid, row->cell[axis], axis);
            }
        }
    }
    if (grid->into_solid)
        for (int d = 0; d < 3; ++d) row->vector_area[d] = -row->vector_area[d];
    if (grid->areas_of_faces) {
        const double whole = length_of(row->vector_area);
        double of_faces[3];
        for (int d = 0; d < 3; ++d)
            of_faces[d] = row->vector_area[d] * grid->spacing[(d + 1) % 3] * grid->spacing[(d + 2) % 3];
        const double scale = whole > 0 ? whole / length_of(of_faces) : 0;
        for (int d = 0; d < 3; ++d) row->vector_area[d] *= scale;
        row->area = whole * scale;
    }
}

#endif
