#ifndef CLSDF_C_SEGMENTS_H
#define CLSDF_C_SEGMENTS_H

/*
 * Links of a grid, crossings of its edges, rays.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include <math.h>

#include "arrays.h"
#include "calls.h"
#include "grids.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Links ---- */

/* Bits that tell of a link. */
#define CLSDF_LINK_FILM 1     /* the sign changes where an open mesh has no face: no triangle, q to 2^-30 */
#define CLSDF_LINK_BETWEEN 2  /* both ends are outside, with a body between them */
#define CLSDF_LINK_SHEET 8    /* of CLSDF_FACES: both ends are on one side */
#define CLSDF_LINK_CLOSING 16 /* the wall is one of the walls or the floor of CLSDF_SIGN_BELOW: no triangle */

/* Which links are asked for. */
typedef struct clsdf_link_options {
    int32_t hits;         /* CLSDF_WALLS or CLSDF_FACES */
    int32_t with_between; /* 1: also links with both ends outside and a body between them, a row from each end */
} clsdf_link_options;

/* The caller's arrays for links, packed on the host; each may be null. Those up to `flags` have `room` rows. */
typedef struct clsdf_link_arrays {
    int64_t room;
    int32_t* samples;    /* [room][3], on the lattice: clsdf_grid.first counts */
    uint8_t* directions; /* the number of the direction, from the mesh's index base on */
    double* q;           /* the part of the link up to the first wall, 0 to 1 */
    float* q_floats;     /* the same in floats: neither 0 nor 1 by rounding; q or this */
    uint32_t* triangles; /* the lowest of those met first, from the index base on; 0xFFFFFFFF plus the base: none. Its
                          * group is numbers[triangle - base] of clsdf_mesh_group_numbers() */
    uint32_t* counts;    /* walls on the link */
    uint8_t* flags;      /* CLSDF_LINK_FILM ... */
    uint8_t* inside;     /* for each sample of the grid, x fastest: 1 if it is inside, else 0 */
    double* dense;       /* [direction][z][y][x]: q, or -1 where there is no link; needs no room */
    float* dense_floats; /* the same in floats; dense or this */
} clsdf_link_arrays;

/* The links of a slab: those whose samples are in `part`, whole slices of the grid. The library's arrays, with q,
 * without dense, are there until it returns, and not to be written to. It may use the transform. */
typedef int32_t (*clsdf_link_function)(void* user, const clsdf_grid* part, const clsdf_link_arrays* links,
                                       int64_t count);

/* The number of links that a run of a clsdf_link_plan writes: that of the grid's links, also if the memory has less
 * room. */
typedef struct clsdf_device_link_count {
    int64_t links;
    int64_t is_complete; /* 1: the memory holds all links; 0: there is too little room, and it is as before */
} clsdf_device_link_count;

/* The caller's memory of the device for links: arrays of any strides, of `room` items up to `flags`. An array without
 * memory is not wanted; its count is 0 or the number of its items. */
typedef struct clsdf_link_buffers {
    size_t struct_size;
    int64_t room;
    void* count;            /* a clsdf_device_link_count; may be null */
    int64_t count_offset;   /* bytes, a multiple of 8 */
    clsdf_array samples;    /* int32, an item is three */
    clsdf_array directions; /* uint8, numbers from 0 on */
    clsdf_array q;          /* float64 or float32 */
    clsdf_array triangles;  /* uint32 or int32 */
    clsdf_array counts;     /* uint32 or int32 */
    clsdf_array flags;      /* uint8 */
    clsdf_array inside;     /* uint8, for each sample of the grid */
    clsdf_array dense; /* float64 or float32, [direction][z][y][x], an item a sample: q, or -1; needs no room here */
} clsdf_link_buffers;
#define CLSDF_LINK_BUFFERS_INIT                                                                       \
    {                                                                                                 \
        sizeof(clsdf_link_buffers), 0, NULL, 0, CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, \
            CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT  \
    }

/* The directions of a stencil, "D3Q15", "D3Q19" or "D3Q27", in the order of a code, "OpenLB", "waLBerla", "lbmpy",
 * "Palabos" or "XLB": directions[27][3] is large enough for each. */
CLSDF_API clsdf_status clsdf_stencil(const char* name, const char* code, int32_t* directions, int64_t* count);
/* The links of a grid in directions[direction_count][3] that meet the surface, by sample (z, y, x), then by direction:
 * one if and only if its ends are on different sides. A row's sample is outside and in the grid. `count` gets how many
 * there are. If the arrays have less room, CLSDF_INVALID_ARGUMENT, `count` has it, and nothing is written. options may
 * be null: walls. */
CLSDF_API clsdf_status clsdf_links(const clsdf_transform* transform, const clsdf_grid* grid, const int32_t* directions,
                                   int64_t direction_count, const clsdf_link_options* options,
                                   const clsdf_link_arrays* arrays, const clsdf_call_options* call,
                                   clsdf_statistics* statistics, int64_t* count);
/* The links of a grid of any size, slab by slab in the order of z, which are those of clsdf_slabs_of(): their rows, one
 * slab after another, are those of clsdf_links(). */
CLSDF_API clsdf_status clsdf_link_slabs(const clsdf_transform* transform, const clsdf_grid* grid,
                                        const int32_t* directions, int64_t direction_count,
                                        const clsdf_link_options* options, clsdf_link_function sink, void* user,
                                        const clsdf_call_options* call, clsdf_statistics* statistics);
/* How many there are. */
CLSDF_API clsdf_status clsdf_count_links(const clsdf_transform* transform, const clsdf_grid* grid,
                                         const int32_t* directions, int64_t direction_count,
                                         const clsdf_link_options* options, const clsdf_call_options* call,
                                         int64_t* count);

/* ---- Crossings ---- */

/* The caller's arrays for the edges of a grid along x, y and z, packed on the host; each may be null. There is one edge
 * less than samples on the axis; x fastest. No two of them may overlap. */
typedef struct clsdf_crossing_arrays {
    double* coordinates[3]; /* along the axis, of the first wall from the end outside; NaN if the sides agree */
    uint32_t* triangles[3]; /* from the index base on; 0xFFFFFFFF plus the base: none */
    uint32_t* counts[3];    /* walls on the edge, also where the sides agree */
    uint8_t* inside;        /* for each sample: 1 if it is inside, else 0 */
} clsdf_crossing_arrays;

/* The places where edges of a grid between neighbouring samples meet walls. */
CLSDF_API clsdf_status clsdf_crossings(const clsdf_transform* transform, const clsdf_grid* grid,
                                       const clsdf_crossing_arrays* arrays, const clsdf_call_options* call,
                                       clsdf_statistics* statistics);

/* ---- Rays ---- */

/* A question about rays, and the arrays for the results, an item for each ray. An array without memory is not
 * wanted; what is given decides what is looked for: the first hits alone, whether there is any, or all. */
typedef struct clsdf_ray_request {
    size_t struct_size;
    int32_t hits; /* CLSDF_WALLS or CLSDF_FACES */
    int32_t reserved;
    double limit;          /* hits beyond are left out: in lengths of the direction, 0 to infinity */
    int64_t most;          /* components of an item of `t` and `triangles`: the first hits of a ray, ascending */
    clsdf_array t;         /* float64 or float32, in lengths of the direction; infinity if there is no further hit */
    clsdf_array triangles; /* uint32 or int32, the lowest at that t; 0xffffffff (-1) if there is no further hit,
                              with index base 1: 0 */
    clsdf_array counts;    /* uint32 or int32: all hits up to the limit */
    clsdf_array any;       /* uint8: 1 if there is a hit up to the limit, else 0 */
} clsdf_ray_request;
#define CLSDF_RAY_REQUEST_INIT                                                                                        \
    {                                                                                                                 \
        sizeof(clsdf_ray_request), CLSDF_WALLS, 0, HUGE_VAL, 1, CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, \
            CLSDF_ARRAY_INIT                                                                                          \
    }

/* Where rays from origins along directions of any length meet the surface, exactly: no ray slips through an edge or a
 * vertex, and the number of walls up to infinity is odd if and only if the origin is inside. A ray whose origin is not
 * finite, or whose direction is 0 or not finite, has t = NaN and no hits; call->log gets one warning, and
 * statistics->unusable_points has their number. call and statistics may be null. */
CLSDF_API clsdf_status clsdf_rays(const clsdf_transform* transform, const clsdf_array* origins,
                                  const clsdf_array* directions, const clsdf_ray_request* request,
                                  const clsdf_call_options* call, clsdf_statistics* statistics);
/* Whether the segments between pairs of points meet nothing, as uint8: 1, else 0. hits: CLSDF_WALLS or CLSDF_FACES. A
 * pair and its reverse agree. */
CLSDF_API clsdf_status clsdf_visible(const clsdf_transform* transform, const clsdf_array* from, const clsdf_array* to,
                                     int32_t hits, const clsdf_array* visible, const clsdf_call_options* call,
                                     clsdf_statistics* statistics);

#ifdef __cplusplus
}
#endif

#endif
