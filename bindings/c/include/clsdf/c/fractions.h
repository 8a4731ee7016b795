#ifndef CLSDF_C_FRACTIONS_H
#define CLSDF_C_FRACTIONS_H

/*
 * Fractions of cells that a mesh fills.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "arrays.h"
#include "calls.h"
#include "grids.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Fractions of cells (docs/fractions.md) ---- */

/* The part of a cell that is measured. */
#define CLSDF_PART_SOLID 0
#define CLSDF_PART_FLUID 1
/* The cell that has a piece of surface in the face between two cells: the one above, or the one on that side. */
#define CLSDF_WALL_ABOVE 0
#define CLSDF_WALL_SOLID 1
#define CLSDF_WALL_FLUID 2
/* Values of the array `types`: a cell without the part, wholly of it, met by the surface. */
#define CLSDF_CELL_EMPTY 0
#define CLSDF_CELL_FULL 1
#define CLSDF_CELL_CUT 2

/* The meaning of a cell's numbers. */
typedef struct clsdf_fraction_options {
    size_t struct_size;
    int32_t part;                /* CLSDF_PART_SOLID ... */
    int32_t walls;               /* CLSDF_WALL_ABOVE ... */
    int32_t normals_into_solid;  /* 1: vector areas and normals point into the solid; 0: out of it */
    int32_t areas_of_faces;      /* 1: areas are parts of a cell's face across the normal, as AMReX's */
    int32_t centroids_as_points; /* 1: centroids in the mesh's space; 0: in cells from the middle, -0.5 to 0.5 */
    int32_t reserved;
    double snap;                /* vertices so near to a plane between cells are moved onto it: in cells, 0 to 0.001 */
    double no_surface_centroid; /* of arrays: the surface's centroid in cells without surface */
} clsdf_fraction_options;
#define CLSDF_FRACTION_OPTIONS_INIT \
    { sizeof(clsdf_fraction_options), CLSDF_PART_SOLID, CLSDF_WALL_ABOVE, 0, 0, 0, 0, 0, 0 }

/* A cell that the surface meets; cells lie between neighbouring samples. */
typedef struct clsdf_cell_fraction {
    int32_t cell[3]; /* the sample at its low corner, on the lattice: clsdf_grid.first counts */
    uint32_t pieces; /* parts of the surface in the cell that are joined over edges */
    double volume;   /* of the part, as a fraction of the cell */
    double centroid[3];
    double area;           /* of the surface in the cell */
    double vector_area[3]; /* the integral of its normal */
    double surface_centroid[3];
    double face_fractions[6];    /* of the part in the low and high face across x, y and z */
    double face_centroids[6][2]; /* in these faces, along the two other axes in the order x, y, z */
} clsdf_cell_fraction;

/* The cells of a grid, sorted by z, y, x. full: a bit for each cell of the grid that the surface does not meet, x
 * fastest, the lowest of a byte first: 1 if it is wholly of the part. Both are there until it returns. */
typedef int32_t (*clsdf_fraction_function)(void* user, int64_t grid_number, const clsdf_cell_fraction* cells,
                                           int64_t count, const uint8_t* full);

/* A box of cells and the caller's arrays, on the host, each of which may be without memory: float64 or float32, but for
 * the first two. Of cells they have one item less than the grid has samples along each axis; those of faces across an
 * axis as many as samples along it. */
typedef struct clsdf_fraction_request {
    clsdf_grid grid;
    clsdf_array types;    /* uint8: CLSDF_CELL_EMPTY ... */
    clsdf_array pieces;   /* uint32, int32 or uint8 */
    clsdf_array volume;   /* clamped to [0, 1], as face_fractions */
    clsdf_array centroid; /* an item is three, as of the next but `area` */
    clsdf_array area;
    clsdf_array vector_area;
    clsdf_array normal; /* the vector area divided by its length */
    clsdf_array surface_centroid;
    clsdf_array face_fractions[3]; /* across x, y, z */
    clsdf_array face_centroids[3]; /* an item is two */
} clsdf_fraction_request;

/* The cells of a slab, as those of a grid above: `part` is the slab, whole layers of cells. */
typedef int32_t (*clsdf_fraction_slab_function)(void* user, const clsdf_grid* part, const clsdf_cell_fraction* cells,
                                                int64_t count, const uint8_t* full);

/* The caller's arrays for the members of clsdf_cell_fraction, each of which may be without memory, of any strides: up
 * to the last `room` items, one for each cell that the surface meets; float64 or float32, but for the first two. */
typedef struct clsdf_fraction_row_arrays {
    int64_t room;
    clsdf_array cells;  /* int32, an item is three */
    clsdf_array pieces; /* uint32 or int32 */
    clsdf_array volume;
    clsdf_array centroid; /* an item is three, as of the next but `area` */
    clsdf_array area;
    clsdf_array vector_area;
    clsdf_array surface_centroid;
    clsdf_array face_fractions; /* an item is six */
    clsdf_array face_centroids; /* an item is twelve: two of each face */
    clsdf_array full; /* uint8, for each cell of the grid, x fastest: 1 if it is wholly of the part; needs no room */
} clsdf_fraction_row_arrays;

/* The options of a convention: "plain", "amrex", "chombo" or "vtk". */
CLSDF_API clsdf_status clsdf_fraction_convention(const char* name, clsdf_fraction_options* options);
/* The parts of grids' cells that a mesh fills. A mesh of clsdf_mesh_outer() is used as it is; of others the outer
 * surface is made, by `sign` as there. `options` and `call`, of which should_stop and progress count, may be null. The
 * sink is called for each grid in their order. */
CLSDF_API clsdf_status clsdf_fractions(const clsdf_mesh* mesh, int32_t sign, const clsdf_grid* grids,
                                       int64_t grid_count, const clsdf_fraction_options* options,
                                       clsdf_fraction_function sink, void* user, const clsdf_call_options* call);
/* The same into the caller's arrays. After an error before the first cell is computed no array has changed. */
CLSDF_API clsdf_status clsdf_fraction_arrays(const clsdf_mesh* mesh, int32_t sign,
                                             const clsdf_fraction_request* requests, int64_t request_count,
                                             const clsdf_fraction_options* options, const clsdf_call_options* call);
/* The cells of a grid of any size, slab by slab in the order of z: their rows, one slab after another, are those of
 * clsdf_fractions(). */
CLSDF_API clsdf_status clsdf_fraction_slabs(const clsdf_mesh* mesh, int32_t sign, const clsdf_grid* grid,
                                            const clsdf_fraction_options* options, clsdf_fraction_slab_function sink,
                                            void* user, const clsdf_call_options* call);
/* How many cells of a grid the surface meets. Takes the time of clsdf_fraction_slabs(). */
CLSDF_API clsdf_status clsdf_count_fractions(const clsdf_mesh* mesh, int32_t sign, const clsdf_grid* grid,
                                             const clsdf_fraction_options* options, const clsdf_call_options* call,
                                             int64_t* count);
/* The rows of a grid into the caller's arrays. `count` gets how many there are. If the arrays have less room,
 * CLSDF_INVALID_ARGUMENT, `count` has it, and nothing is written. device: arrays may be buffers of its context; null:
 * they are on the host. */
CLSDF_API clsdf_status clsdf_fraction_rows(const clsdf_mesh* mesh, int32_t sign, const clsdf_device* device,
                                           const clsdf_grid* grid, const clsdf_fraction_row_arrays* arrays,
                                           const clsdf_fraction_options* options, const clsdf_call_options* call,
                                           int64_t* count);

#ifdef __cplusplus
}
#endif

#endif
