#ifndef CLSDF_C_GRIDS_H
#define CLSDF_C_GRIDS_H

/*
 * Boxes, lengths, bands, grids.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include <math.h>

#include "basics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Boxes, lengths, bands, grids ---- */

typedef struct clsdf_box {
    double lower[3];
    double upper[3]; /* included */
} clsdf_box;

typedef struct clsdf_length {
    double value;
    int32_t unit; /* CLSDF_MESH_UNITS ... */
    int32_t reserved;
} clsdf_length;

/* Samples with -inside <= distance <= outside carry their distance, others +outside or -inside. Both may be infinite;
 * at least one is > 0. With signs_only both are 0, and the field holds -0.0 inside and +0.0 outside. With exact_signs
 * the field is below 0 at exactly those samples that are inside by the exact sides of links and crossings, on the
 * surface, too: values inside are then at most minus the least normal float. */
typedef struct clsdf_band {
    double inside;
    double outside;
    int32_t signs_only;  /* 0 or 1 */
    int32_t exact_signs; /* 0 or 1 */
} clsdf_band;

static inline clsdf_band clsdf_band_symmetric(double half_width) {
    clsdf_band band = {0, 0, 0, 0};
    band.inside = band.outside = half_width;
    return band;
}
/* Every sample carries its distance. */
static inline clsdf_band clsdf_band_full(void) {
    return clsdf_band_symmetric(HUGE_VAL);
}
static inline clsdf_band clsdf_band_signs_only(void) {
    clsdf_band band = {0, 0, 1, 0};
    return band;
}

/* Sample (i, j, k) lies at origin + (i hx, j hy, k hz). The grid is the block first <= (i, j, k) < first + size of this
 * lattice; x runs fastest in memory. Results do not depend on `first`: a part has the bytes of the whole. */
typedef struct clsdf_grid {
    double origin[3];
    double spacing[3];
    int64_t size[3];
    int64_t first[3];
} clsdf_grid;

/* Options of clsdf_grid_around_box(). */
typedef struct clsdf_grid_options {
    size_t struct_size;
    int64_t resolution;   /* samples on the longest side of the box, margin included; >= 2 */
    double spacing[3];    /* per axis, instead of a resolution; zeros: not set */
    clsdf_length margin;  /* 0: the first sample on the longest side is box->lower exactly */
    int32_t cubic;        /* 1: every axis gets as many samples as the longest one */
    int32_t cell_centred; /* 1: samples at the centres of cells, half a voxel further */
} clsdf_grid_options;
#define CLSDF_GRID_OPTIONS_INIT \
    { sizeof(clsdf_grid_options), 256, {0, 0, 0}, {0.05, CLSDF_EXTENT, 0}, 0, 0 }

/* How clsdf_grid_between() divides a box: by samples or by cells. Give one of them, on each axis; the other is 0. */
typedef struct clsdf_grid_division {
    size_t struct_size;
    int64_t samples[3];   /* at least 2: both ends of the box are samples; 1 on an axis on which they are equal */
    int64_t cells[3];     /* at least 1: samples at their corners, one more than the cells */
    int32_t cell_centred; /* 1, with cells: one sample at the centre of each instead */
    int32_t reserved;
} clsdf_grid_division;
#define CLSDF_GRID_DIVISION_INIT \
    { sizeof(clsdf_grid_division), {0, 0, 0}, {0, 0, 0}, 0, 0 }

/* The longest side. */
CLSDF_API clsdf_status clsdf_box_longest_side(const clsdf_box* box, double* side);
/* In the mesh's units; `voxel` is the grid's smallest spacing, `extent` the longest side of the mesh's box. */
CLSDF_API clsdf_status clsdf_length_resolve(const clsdf_length* length, double voxel, double extent, double* resolved);
CLSDF_API clsdf_status clsdf_band_validate(const clsdf_band* band);

/* A grid around a box. */
CLSDF_API clsdf_status clsdf_grid_around_box(const clsdf_box* box, const clsdf_grid_options* options, clsdf_grid* grid);
/* A grid around a mesh with `resolution` samples on the longest side. The margin is the band's outside half width; 5%
 * of the longest side if it is infinite. */
CLSDF_API clsdf_status clsdf_grid_around_mesh(const clsdf_mesh* mesh, int64_t resolution, const clsdf_band* band,
                                              clsdf_grid* grid);
/* The grid from one corner of a box to the other. The first sample is box->lower exactly; the spacing is rounded once,
 * so the last sample is within n/2 ulp of the spacing of box->upper, n being the cells along an axis. A slice: an axis
 * on which both corners are equal has one sample (samples 1, or cells 1 if cell_centred), and the least of the other
 * spacings. */
CLSDF_API clsdf_status clsdf_grid_between(const clsdf_box* box, const clsdf_grid_division* division, clsdf_grid* grid);
/* In the next seven, `result` may be `grid`. */
/* The block of size[3] samples that starts offset[3] samples from this grid's first one; must be inside. */
CLSDF_API clsdf_status clsdf_grid_part(const clsdf_grid* grid, const int64_t* offset, const int64_t* size,
                                       clsdf_grid* result);
/* Any block of this lattice: size[3] samples from the lattice's sample first[3] on. Not checked. */
CLSDF_API clsdf_status clsdf_grid_block(const clsdf_grid* grid, const int64_t* first, const int64_t* size,
                                        clsdf_grid* result);
/* So many samples more on every side; fewer if negative. */
CLSDF_API clsdf_status clsdf_grid_grown(const clsdf_grid* grid, int64_t samples, clsdf_grid* result);
/* A lattice `ratio` times as fine, from the first sample to the last: samples at nodes. */
CLSDF_API clsdf_status clsdf_grid_refined(const clsdf_grid* grid, int64_t ratio, clsdf_grid* result);
/* The same for samples at centres of cells: each cell becomes ratio^3 cells. */
CLSDF_API clsdf_status clsdf_grid_refined_cells(const clsdf_grid* grid, int64_t ratio, clsdf_grid* result);
/* The bricks of sparse fields that overlap the grid: it is rounded out to multiples of 8 on the lattice. */
CLSDF_API clsdf_status clsdf_grid_in_whole_bricks(const clsdf_grid* grid, clsdf_grid* result);
/* Shifted by half a voxel on every axis. */
CLSDF_API clsdf_status clsdf_grid_cell_centred(const clsdf_grid* grid, clsdf_grid* result);
/* position[3] of the block's sample (i, j, k), counted from its first one. */
CLSDF_API clsdf_status clsdf_grid_position(const clsdf_grid* grid, int64_t i, int64_t j, int64_t k, double* position);
/* From the first sample to the last. */
CLSDF_API clsdf_status clsdf_grid_box(const clsdf_grid* grid, clsdf_box* box);
/* The smallest spacing. */
CLSDF_API clsdf_status clsdf_grid_voxel(const clsdf_grid* grid, double* voxel);
CLSDF_API clsdf_status clsdf_grid_sample_count(const clsdf_grid* grid, int64_t* count);
CLSDF_API clsdf_status clsdf_grid_validate(const clsdf_grid* grid);
/* The offset of the block's sample (i, j, k) in a packed array. */
static inline int64_t clsdf_grid_offset(const clsdf_grid* grid, int64_t i, int64_t j, int64_t k) {
    return i + grid->size[0] * (j + grid->size[1] * k);
}

#ifdef __cplusplus
}
#endif

#endif
