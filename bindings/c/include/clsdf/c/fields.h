#ifndef CLSDF_C_FIELDS_H
#define CLSDF_C_FIELDS_H

/*
 * Fields: dense and sparse, in the caller's arrays and in the library's memory.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "arrays.h"
#include "calls.h"
#include "grids.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Fields ---- */

/* One box of many. */
typedef struct clsdf_request {
    clsdf_grid grid;
    clsdf_band band;
    clsdf_targets targets;
} clsdf_request;

/* Equal blocks of one lattice. */
typedef struct clsdf_block_set {
    size_t struct_size;
    clsdf_grid lattice; /* its origin and spacing count */
    clsdf_band band;
    int64_t size[3];      /* samples of each block */
    const int64_t* first; /* [block_count][3]: the first sample of each block, on the lattice */
    int64_t block_count;
    clsdf_targets targets; /* of the first block; clsdf_array.block_stride leads to the others */
} clsdf_block_set;
#define CLSDF_BLOCK_SET_INIT                                                                                       \
    {                                                                                                              \
        sizeof(clsdf_block_set), {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}}, {0, 0, 0, 0}, {0, 0, 0}, NULL, 0, { \
            NULL, 0                                                                                                \
        }                                                                                                          \
    }

/* A slab of a field: whole slices. The values are packed and there until it returns. It may use the transform. */
typedef int32_t (*clsdf_slab_function)(void* user, const clsdf_grid* part, const clsdf_target* values, int64_t count);

typedef struct clsdf_slab_options {
    size_t struct_size;
    int32_t own_thread; /* 1: the function is called on another thread, while the next slab is computed */
    int32_t reserved;
} clsdf_slab_options;
#define CLSDF_SLAB_OPTIONS_INIT \
    { sizeof(clsdf_slab_options), 0, 0 }

/* The field on a grid, into the caller's arrays, all on the host or all on the device. targets[target_count], one of
 * them the distance. An error leaves the arrays undefined. */
CLSDF_API clsdf_status clsdf_compute(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                                     const clsdf_target* targets, int64_t target_count, const clsdf_call_options* call,
                                     clsdf_statistics* statistics);
/* The distance alone, into a packed array of the host: distance[size[2]][size[1]][size[0]], x fastest. */
static inline clsdf_status clsdf_compute_distance(const clsdf_transform* transform, const clsdf_grid* grid,
                                                  const clsdf_band* band, float* distance) {
    const clsdf_target target = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance, 0);
    return clsdf_compute(transform, grid, band, &target, 1, NULL, NULL);
}
/* Many boxes in one call, of any lattices, bands and outputs. Messages number the requests from 0. */
CLSDF_API clsdf_status clsdf_compute_requests(const clsdf_transform* transform, const clsdf_request* requests,
                                              int64_t count, const clsdf_call_options* call,
                                              clsdf_statistics* statistics);
/* Equal blocks of one lattice in one call. */
CLSDF_API clsdf_status clsdf_compute_blocks(const clsdf_transform* transform, const clsdf_block_set* blocks,
                                            const clsdf_call_options* call, clsdf_statistics* statistics);
/* A field of any size, slab by slab in the order of z. `outputs`: CLSDF_SET(...); 0: the distance. */
CLSDF_API clsdf_status clsdf_compute_slabs(const clsdf_transform* transform, const clsdf_grid* grid,
                                           const clsdf_band* band, uint32_t outputs, clsdf_slab_function sink,
                                           void* user, const clsdf_slab_options* options,
                                           const clsdf_call_options* call, clsdf_statistics* statistics);
/* The field in memory of the library. Its triangles count from the mesh's index base; those of files count from 0. */
CLSDF_API clsdf_status clsdf_compute_field(const clsdf_transform* transform, const clsdf_grid* grid,
                                           const clsdf_band* band, uint32_t outputs, const clsdf_call_options* call,
                                           clsdf_statistics* statistics, clsdf_field** field);
/* The slabs of a field on a device that sets no closer limit: the first `size` of *count. `slabs` may be null if size
 * is 0. */
CLSDF_API clsdf_status clsdf_slabs_of(const clsdf_grid* grid, clsdf_grid* slabs, int64_t size, int64_t* count);

/* ---- Sparse fields ---- */

/* Bricks are blocks of 8 x 8 x 8 samples. They tile the lattice from its sample (0, 0, 0); a brick is named by its
 * first sample. */
#define CLSDF_BRICK_SIDE 8
#define CLSDF_BRICK_SAMPLES 512

/* Bricks that follow each other along x: (first[0] + 8 n, first[1], first[2]) for n < count. */
typedef struct clsdf_brick_run {
    int64_t first[3];
    int64_t count;
} clsdf_brick_run;

/* How many bricks with values a sparse field has, and how many runs of bricks inside. */
typedef struct clsdf_sparse_counts {
    int64_t bricks;
    int64_t runs;
} clsdf_sparse_counts;

/* One sparse field of many. */
typedef struct clsdf_sparse_request {
    clsdf_grid grid;
    clsdf_band band;
    uint32_t outputs; /* CLSDF_SET(...); 0: the distance */
    int32_t reserved;
} clsdf_sparse_request;

/* The caller's arrays for a sparse field, on the host. Elements that the field does not need stay as they are. */
typedef struct clsdf_sparse_arrays {
    size_t struct_size;
    int64_t* bricks; /* [brick_room][3] */
    int64_t brick_room;
    clsdf_brick_run* inside; /* [run_room] */
    int64_t run_room;
    clsdf_targets values; /* packed arrays of brick_room * 512 items, of the types that clsdf_output_describe() states;
                             the triangle may be int32. The distance has one */
} clsdf_sparse_arrays;
#define CLSDF_SPARSE_ARRAYS_INIT                         \
    {                                                    \
        sizeof(clsdf_sparse_arrays), NULL, 0, NULL, 0, { \
            NULL, 0                                      \
        }                                                \
    }

/* The counts that a run of a clsdf_sparse_plan writes. They are those of the whole field, also if the
 * memory has less room. */
typedef struct clsdf_device_sparse_counts {
    int64_t bricks;
    int64_t runs;
    int64_t is_complete; /* 1: the memory holds the field; 0: it had too little room, and is undefined */
} clsdf_device_sparse_counts;

/* The caller's memory of the device (cl_mem) for a sparse field, with room for what the plan has room for. Nothing
 * overlaps. The offsets are bytes, multiples of 8. Memory without room may be null. */
typedef struct clsdf_sparse_buffers {
    size_t struct_size;
    void* counts; /* a clsdf_device_sparse_counts */
    int64_t counts_offset;
    void* bricks; /* int64_t [bricks][3] */
    int64_t bricks_offset;
    void* inside; /* clsdf_brick_run [runs] */
    int64_t inside_offset;
    clsdf_targets values; /* packed, 512 items for each brick that there is room for, as in clsdf_sparse_arrays */
} clsdf_sparse_buffers;
#define CLSDF_SPARSE_BUFFERS_INIT                                  \
    {                                                              \
        sizeof(clsdf_sparse_buffers), NULL, 0, NULL, 0, NULL, 0, { \
            NULL, 0                                                \
        }                                                          \
    }

/* Whole layers of a sparse field's bricks. A brick of the grid has values if one of its samples is in the band, or if
 * it has samples of both signs; all its 512 samples have them then. In each other brick all samples are beyond the band
 * and have one sign: they are inside if a run of `inside` holds the brick. Bricks and runs are sorted by z, then y,
 * then x. */
typedef struct clsdf_sparse_slab {
    size_t struct_size;
    clsdf_grid part;               /* the layers: a block of whole bricks */
    const int64_t* bricks;         /* [brick_count][3] */
    int64_t brick_count;           /* that have values */
    const clsdf_brick_run* inside; /* [run_count], of bricks without values */
    int64_t run_count;
    clsdf_targets values; /* packed: brick n has the items [512 n, 512 (n + 1)), x fastest */
} clsdf_sparse_slab;
#define CLSDF_SPARSE_SLAB_INIT                                                                       \
    {                                                                                                \
        sizeof(clsdf_sparse_slab), {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}}, NULL, 0, NULL, 0, { \
            NULL, 0                                                                                  \
        }                                                                                            \
    }

/* The next layers of a sparse field, there until it returns. It may use the transform. */
typedef int32_t (*clsdf_sparse_function)(void* user, const clsdf_sparse_slab* slab);

/* A sparse field, into the caller's arrays: the bricks near the surface and the sign of the rest. The half widths are
 * finite, of a field without a sign the one outside. *counts: how many bricks and runs there are. If the arrays have
 * less room, the call is CLSDF_INVALID_ARGUMENT, the message names both numbers, *counts has them, too, and nothing is
 * written beyond the arrays. After other errors *counts is 0. */
CLSDF_API clsdf_status clsdf_compute_sparse(const clsdf_transform* transform, const clsdf_grid* grid,
                                            const clsdf_band* band, const clsdf_sparse_arrays* arrays,
                                            const clsdf_call_options* call, clsdf_statistics* statistics,
                                            clsdf_sparse_counts* counts);
/* How many bricks and runs there would be. Takes nearly the time of the field, and no memory for values. */
CLSDF_API clsdf_status clsdf_count_sparse(const clsdf_transform* transform, const clsdf_grid* grid,
                                          const clsdf_band* band, const clsdf_call_options* call,
                                          clsdf_statistics* statistics, clsdf_sparse_counts* counts);
/* A sparse field of any size: layers of bricks in the order of z. */
CLSDF_API clsdf_status clsdf_compute_sparse_slabs(const clsdf_transform* transform, const clsdf_grid* grid,
                                                  const clsdf_band* band, uint32_t outputs, clsdf_sparse_function sink,
                                                  void* user, const clsdf_call_options* call,
                                                  clsdf_statistics* statistics);
/* The sparse field in memory of the library. Its triangles count from the mesh's index base. */
CLSDF_API clsdf_status clsdf_compute_sparse_field(const clsdf_transform* transform, const clsdf_grid* grid,
                                                  const clsdf_band* band, uint32_t outputs,
                                                  const clsdf_call_options* call, clsdf_statistics* statistics,
                                                  clsdf_sparse_field** field);
/* Many sparse fields in one call, of any lattices, bands and outputs: fields[count], all null after an error. */
CLSDF_API clsdf_status clsdf_compute_sparse_requests(const clsdf_transform* transform,
                                                     const clsdf_sparse_request* requests, int64_t count,
                                                     const clsdf_call_options* call, clsdf_statistics* statistics,
                                                     clsdf_sparse_field** fields);

/* ---- Fields in the library's memory ---- */

typedef struct clsdf_field_description {
    size_t struct_size;
    clsdf_grid grid;
    clsdf_band band;
    int32_t sign;            /* CLSDF_SIGN_AUTOMATIC if a file of another program states none */
    int32_t positive_inside; /* 1: distances and gradients are negated, also zeros and what lies beyond the band */
    const char* mesh_name;   /* null: ""; of a field, lives as long as the field */
    double floor;            /* of CLSDF_SIGN_BELOW: its z; DBL_MAX, the default: none, or not known */
} clsdf_field_description;
#define CLSDF_FIELD_DESCRIPTION_INIT                                                                                  \
    {                                                                                                                 \
        sizeof(clsdf_field_description), {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}}, {0, 0, 0, 0}, CLSDF_SIGN_NONE, \
            0, NULL, 1.7976931348623157e308                                                                           \
    }

/* A field with room for these outputs; the values are not set. Triangles count from 0. */
CLSDF_API clsdf_status clsdf_field_create(const clsdf_field_description* description, uint32_t outputs,
                                          clsdf_field** field);
/* Threads: any number, as in the next two; but the array is the caller's to guard. */
CLSDF_API clsdf_status clsdf_field_describe(const clsdf_field* field, clsdf_field_description* description);
CLSDF_API clsdf_status clsdf_field_outputs(const clsdf_field* field, uint32_t* outputs);
/* The field's own memory of an output, packed, to read and to write, as long as the field lives. An output that the
 * field does not have: an array without memory. */
CLSDF_API clsdf_status clsdf_field_array(const clsdf_field* field, int32_t output, clsdf_array* array);
/* Makes the field's triangles count from 0 or 1. Threads: one. */
CLSDF_API clsdf_status clsdf_field_set_index_base(clsdf_field* field, int32_t index_base);
/* Gives the field a copy of the mesh's groups, which may be none: a .vti or .vtkhdf gets the group of each sample
 * beside its triangle. Threads: one. */
CLSDF_API clsdf_status clsdf_field_set_groups(clsdf_field* field, const clsdf_mesh* mesh);

/* ---- Sparse fields in the library's memory ---- */

/* Threads: any number, as in all that follow. mesh_name lives as long as the field. */
CLSDF_API clsdf_status clsdf_sparse_field_describe(const clsdf_sparse_field* field,
                                                   clsdf_field_description* description);
/* All layers of the field; the addresses are those of the field's own memory, as long as it lives. */
CLSDF_API clsdf_status clsdf_sparse_field_slab(const clsdf_sparse_field* field, clsdf_sparse_slab* slab);
/* As clsdf_field_set_index_base(). Threads: one. */
CLSDF_API clsdf_status clsdf_sparse_field_set_index_base(clsdf_sparse_field* field, int32_t index_base);

/* The number of the brick that has the sample's values; -1: none, or it is not in the layers. sample[3] counts on the
 * lattice, as in the next. */
CLSDF_API clsdf_status clsdf_sparse_find(const clsdf_sparse_slab* slab, const int64_t* sample, int64_t* number);
/* The distances of samples[count][3] of the layers, wherever they lie. band: the field's. The arrays of a
 * clsdf_sparse_arrays can be the slab's: of its values, items beyond the slab's bricks are not used. */
CLSDF_API clsdf_status clsdf_sparse_distances(const clsdf_sparse_slab* slab, const clsdf_band* band,
                                              const int64_t* samples, int64_t count, float* distances);

#ifdef __cplusplus
}
#endif

#endif
