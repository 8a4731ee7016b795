// One definition for the host and the kernels: cells that are cut, and the rows that are told of them.
#ifndef CLSDF_CUT_GRID_H
#define CLSDF_CUT_GRID_H

#include "polyhedron.h"

// WallCell.
#define CLSDF_WALLS_ABOVE 0
#define CLSDF_WALLS_SOLID 1
#define CLSDF_WALLS_FLUID 2

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// The cells of a grid, and what is told of them. Faces of cells across axis d are numbered by plane, side and along
// (cut_sections.h), as are cells of lines, which are the edges on the high side of these faces.
typedef struct CutGrid {
    double origin[3], spacing[3];
    double snap;
    clsdf_int64 first[3];   // the first cell, on the lattice
    clsdf_int32 counts[3];  // of cells
    clsdf_int32 walls;
    // Keys of records: those of cells from 0 on, of faces and of lines from these on, and how many keys there are.
    clsdf_uint32 faces_from[3], lines_from[3];
    clsdf_uint32 keys;
    clsdf_int32 is_fluid, into_solid, areas_of_faces, as_points;  // FractionOptions
    clsdf_int32 padding;
} CutGrid;

// CellFraction, in the same layout.
typedef struct FractionRow {
    clsdf_int32 cell[3];
    clsdf_uint32 pieces;
    double volume;
    double centroid[3];
    double area;
    double vector_area[3];
    double surface_centroid[3];
    double face_fractions[6];
    double face_centroids[6][2];
} FractionRow;

// What a run finds. The first two are a DeviceFractionCount.
typedef struct CutCounts {
    clsdf_uint64 rows;         // cells that are cut; 0 if it is not known
    clsdf_uint64 is_complete;  // 1: all rows are there
    clsdf_uint64 items;        // needed: layers of faces
    clsdf_uint64 records;      // needed; 0 if it is not known
    // Those that there are; 0 if they are more than there is room for, or others were.
    clsdf_uint32 item_limit, record_limit, row_limit;
    clsdf_uint32 far_vertex;  // the first vertex that is too far away, or CLSDF_NO_VERTEX
} CutCounts;

// How store_cells.cl writes numbers.
#define CLSDF_STORED_WORDS 0
#define CLSDF_STORED_DOUBLES 1
#define CLSDF_STORED_FLOATS 2

#define CLSDF_NO_VERTEX 0xFFFFFFFFu
// In cells: a place there is a whole number.
#define CLSDF_FARTHEST_VERTEX 0x1p53
// In cells: a vertex whose place, rounded, is a plane is in it if it is so near. That is the rounding of places up to
// 4,096 cells from sample 0.
#define CLSDF_ROUNDED_ONTO_PLANE 0x1p-42

#ifndef __OPENCL_VERSION__
static_assert(sizeof(CutGrid) == 144 && offsetof(CutGrid, first) == 56 && offsetof(CutGrid, keys) == 120);
static_assert(sizeof(FractionRow) == 248 && offsetof(FractionRow, face_centroids) == 152);
static_assert(sizeof(CutCounts) == 48);
}  // namespace clsdf
#endif

#endif
