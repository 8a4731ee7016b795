#ifndef CLSDF_H
#define CLSDF_H

/*
 * clsdf in C99: exact signed distance fields of triangle meshes with OpenCL. docs/c.md has whole programs; the C++
 * headers and docs/library.md define what is computed. The library is libclsdf_c; clsdf_io.h has files of fields.
 *
 * STATUS. A function returns a status: 0 (CLSDF_OK), else one of the numbers below, and clsdf_last_error() has the
 * message. Functions that cannot fail return their value. A handle or pointer that is null, a handle of another kind,
 * an enumerator out of range, a negative count and a struct of a wrong size are CLSDF_INVALID_ARGUMENT, unless a
 * comment allows them. A call that fails sets the handle that it would make to null; its other results are undefined.
 * Nothing here ends the process on purpose, and no exception leaves; but pointers are not checked beyond null. A wrong
 * address, a handle after its last release, or a void * that is no object of OpenCL is undefined: drivers crash on it.
 *
 * HANDLES are counted references. A function that makes one gives it to the caller, who releases it. Null may be
 * retained and released. An object keeps alive what it needs: a transform its device, for instance. Any number of
 * threads may retain and release a handle, and may use different handles. "Threads: any number" means that threads may
 * use one handle in that call at once; "Threads: one" that no other call may use the handle during that call.
 *
 * STRUCTS. Those that begin with struct_size may grow in later versions: set them with their _INIT macro, then change
 * members. A smaller struct of an older program is accepted, a larger one (up to 4096 bytes) if the bytes that this
 * version does not know are 0. Null means defaults for options, and "not wanted" for results. A struct that calls only
 * fill has an odd struct_size, CLSDF_RESULT_SIZE(type), so that it is never taken for options, nor options for it. The
 * other structs never change. Members called `reserved` must be 0.
 *
 * UNITS. Lengths and positions are in the mesh's units unless a comment says otherwise; counts, indices, offsets and
 * strides are int64_t; sizes, offsets and strides are in bytes. Texts are UTF-8 and end with 0.
 *
 * OPENCL. This header needs none of OpenCL's: a cl_mem, cl_event, cl_context, cl_device_id or cl_command_queue is a
 * void *.
 *
 * CALLBACKS get the `user` pointer of their struct. Unless a comment says otherwise they run on the calling thread, and
 * before the call returns. One that returns a number other than 0 ends the call, which returns that number unchanged: a
 * status of this header, as of a call that failed in the callback, or a number of the program's own from
 * CLSDF_OWN_STATUS on. Other numbers may become statuses of later versions. The message is that of the callback's last
 * failed call, or of its clsdf_set_last_error(). Callbacks must not make or use a transform or plan of the same device:
 * a call that would wait for theirs returns CLSDF_INVALID_ARGUMENT. Only the function that takes slabs may use the
 * transform.
 */

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define CLSDF_API __attribute__((visibility("default")))
#else
#define CLSDF_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Version ---- */

#define CLSDF_VERSION_MAJOR 0
#define CLSDF_VERSION_MINOR 1
#define CLSDF_VERSION_PATCH 0
#define CLSDF_MAKE_VERSION(major, minor, patch) ((major)*1000000 + (minor)*1000 + (patch))
#define CLSDF_VERSION CLSDF_MAKE_VERSION(CLSDF_VERSION_MAJOR, CLSDF_VERSION_MINOR, CLSDF_VERSION_PATCH)

/* The library's CLSDF_VERSION. It differs from the macro if the program was compiled with another version's header. */
CLSDF_API int64_t clsdf_version(void);
/* The library's "major.minor.patch"; lives as long as the process. */
CLSDF_API const char* clsdf_version_text(void);

/* struct_size of a struct that calls fill. */
#define CLSDF_RESULT_SIZE(type) (sizeof(type) + 1)

/* ---- Numbers: they never change ---- */

typedef int32_t clsdf_status;
#define CLSDF_OK 0
#define CLSDF_INVALID_MESH 1     /* index out of range, vertex in use not finite, no triangle, sign rule not met */
#define CLSDF_UNREADABLE_INPUT 2 /* a file that cannot be opened, is truncated or malformed */
#define CLSDF_INVALID_ARGUMENT 3 /* an argument that makes no sense */
#define CLSDF_NO_DEVICE 4        /* no OpenCL device, or none of the name asked for */
#define CLSDF_DEVICE_FAILURE 5   /* an OpenCL call failed: clsdf_last_opencl_error() */
#define CLSDF_OUT_OF_MEMORY 6    /* of the host or the device */
#define CLSDF_UNSUPPORTED 7      /* a correct request that this build or device does not support */
#define CLSDF_CANCELLED 8        /* for callbacks that cancel */
#define CLSDF_OUTPUT_FAILURE 9   /* a result could not be written; nothing is left under its final name */
#define CLSDF_WRONG_RESULTS 10   /* the device computes wrong values in the test at its first use */
#define CLSDF_UNEXPECTED (-1)    /* a failure that the library does not expect; its message says which */
#define CLSDF_OWN_STATUS 1000    /* from here on: a program's own numbers, which clsdf never returns by itself */

/* Types of the numbers in an array. */
#define CLSDF_AUTOMATIC 0 /* of an output: the type that clsdf_output_describe() states */
#define CLSDF_FLOAT32 1
#define CLSDF_FLOAT64 2
#define CLSDF_INT32 3
#define CLSDF_INT64 4
#define CLSDF_UINT32 5
#define CLSDF_UINT64 6
#define CLSDF_UINT8 7

/* Outputs. Beyond the band triangle and body are index_base - 1 (in uint32: 4294967295 or 0), the site 255, and vectors
 * are NaN. */
#define CLSDF_DISTANCE 0    /* signed; always computed */
#define CLSDF_TRIANGLE 1    /* the nearest triangle; if an edge or a vertex is nearest, the lowest that shares it */
#define CLSDF_SITE 2        /* 0 to 2: a vertex of it, 3 to 5: an edge, 6: its face; see CLSDF_SURFACE_OUTER */
#define CLSDF_CLOSEST 3     /* the position of the closest point: float64 */
#define CLSDF_GRADIENT 4    /* of the signed distance: a unit vector */
#define CLSDF_BARYCENTRIC 5 /* of the closest point: the weights of the triangle's vertices 1 and 2 (from 0) */
#define CLSDF_OFFSET 7      /* from the sample or point to the closest point */
#define CLSDF_BODY 8        /* of a scene: the body of the nearest triangle; of a mesh index_base */

/* A set of outputs: CLSDF_SET(CLSDF_TRIANGLE) | CLSDF_SET(CLSDF_SITE). */
#define CLSDF_SET(output) ((uint32_t)1 << (output))

/* Rules of the sign. */
/* balanced: nonzero; closed: parity; open: solid_angle if few points are in doubt; else none (call->log warns unless it
 * is nonzero) */
#define CLSDF_SIGN_AUTOMATIC 0
#define CLSDF_SIGN_NONZERO 1     /* inside if the winding number is not zero; needs a balanced mesh */
#define CLSDF_SIGN_PARITY 2      /* inside if a ray crosses the surface an odd number of times; needs a closed mesh */
#define CLSDF_SIGN_NONE 3        /* the distance alone */
#define CLSDF_SIGN_SOLID_ANGLE 4 /* inside if the winding number is one half or more, or -1/2 or less; any mesh */
#define CLSDF_SIGN_BELOW \
    5 /* inside below a terrain and above clsdf_transform_options.floor, between walls from its rim */

/* The surface that distances are measured to. */
#define CLSDF_SURFACE_GIVEN 0 /* all faces as given, also within other parts */
/* The outer surface of overlapping parts, as clsdf_mesh_outer() makes it. Triangles are told by the faces as given that
 * they are parts of; a site beside those of a triangle, 7, is an edge or a vertex at which faces cut each other. */
#define CLSDF_SURFACE_OUTER 1

/* The hits that count where a segment or a ray meets the surface. */
#define CLSDF_WALLS 0 /* where inside and outside meet, by the sign rule: never a face within the body */
#define CLSDF_FACES 1 /* every face as given, also of sheets and of meshes without a sign */

/* The place of a box. */
#define CLSDF_WITHIN 0  /* the surface may be within the half width of a point of the box */
#define CLSDF_INSIDE 1  /* the surface is farther from every point of the box, and all are inside */
#define CLSDF_OUTSIDE 2 /* the same, and all are outside */
#define CLSDF_BEYOND 3  /* the same, of a mesh without a sign */

/* The outcome of a point in a plan's run. */
#define CLSDF_FOUND 0
#define CLSDF_NOT_FINITE 1 /* the distance is NaN; there is no triangle */
#define CLSDF_TOO_FAR 2    /* the distance is the half width, or NaN if that is infinite; there is no triangle */
#define CLSDF_SIGN_OPEN 3  /* exact arithmetic did not suffice: NaN, no triangle; clsdf_query() has the sign */

#define CLSDF_GPU 0
#define CLSDF_PROCESSOR 1
#define CLSDF_ACCELERATOR 2
#define CLSDF_OTHER_DEVICE 3

/* How a device was found. */
#define CLSDF_REGISTERED 0   /* OpenCL's loader lists it */
#define CLSDF_BUNDLED 1      /* of the driver that the package with this library contains */
#define CLSDF_UNREGISTERED 2 /* of a GPU's driver in the path of the system's loader, which OpenCL's does not know */
#define CLSDF_DEVICE_FILE 3  /* a GPU's file in /dev, and no device that can be used */

/* Units of a length. */
#define CLSDF_MESH_UNITS 0
#define CLSDF_VOXELS 1
#define CLSDF_EXTENT 2 /* the longest side of the mesh's box: 0.1 is 10% of it */

/* Stages of a call. */
#define CLSDF_COMPILING 0
#define CLSDF_COMPUTING 1
#define CLSDF_TESTING 2 /* programs compute a known field */

/* The names of these numbers, as "invalid_mesh", "float", "nonzero", "gpu"; "unknown" for a number of none. They live
 * as long as the process. */
CLSDF_API const char* clsdf_status_name(clsdf_status status);
CLSDF_API const char* clsdf_type_name(int32_t type);
CLSDF_API const char* clsdf_sign_name(int32_t rule);
CLSDF_API const char* clsdf_device_kind_name(int32_t kind);
CLSDF_API const char* clsdf_device_source_name(int32_t source);

/* ---- Errors ---- */

/* The message of this thread's last call that returned a status: "" after a success, whatever its callbacks did. Valid
 * until the thread's next call. The text is the one that C++ gets. */
CLSDF_API const char* clsdf_last_error(void);
/* The number that the failed call of OpenCL returned (cl_int); 0 for other errors. */
CLSDF_API int32_t clsdf_last_opencl_error(void);
/* For callbacks that end a call: the message of the call. Null: none. */
CLSDF_API void clsdf_set_last_error(const char* message);

/* ---- Handles ---- */

typedef struct clsdf_devices clsdf_devices;           /* a list of the devices of this machine */
typedef struct clsdf_device clsdf_device;             /* an OpenCL device, with a context and a queue */
typedef struct clsdf_mesh clsdf_mesh;                 /* a checked mesh, a copy of arrays or files */
typedef struct clsdf_transform clsdf_transform;       /* the distance to a mesh, on a device */
typedef struct clsdf_scene clsdf_scene;               /* many bodies, each a mesh with a pose */
typedef struct clsdf_plan clsdf_plan;                 /* boxes that are computed again and again */
typedef struct clsdf_sparse_plan clsdf_sparse_plan;   /* a sparse field that is computed again and again */
typedef struct clsdf_point_plan clsdf_point_plan;     /* points that are looked up again and again */
typedef struct clsdf_link_plan clsdf_link_plan;       /* links that go to memory of the device again and again */
typedef struct clsdf_field clsdf_field;               /* a field in the library's memory */
typedef struct clsdf_sparse_field clsdf_sparse_field; /* a sparse field in the library's memory */
typedef struct clsdf_points clsdf_points;             /* points read from a file */
typedef struct clsdf_cuda_device clsdf_cuda_device;   /* an NVIDIA GPU as a device of OpenCL and of CUDA */
typedef struct clsdf_cuda_memory clsdf_cuda_memory;   /* memory that CUDA and OpenCL both have */
typedef struct clsdf_cuda_arrays clsdf_cuda_arrays;   /* arrays in memory of CUDA, for calls and plans */
typedef struct clsdf_thread_limit clsdf_thread_limit; /* as long as it lives, the host's loops have fewer threads */

CLSDF_API void clsdf_devices_retain(clsdf_devices* devices);
CLSDF_API void clsdf_devices_release(clsdf_devices* devices);
CLSDF_API void clsdf_device_retain(clsdf_device* device);
CLSDF_API void clsdf_device_release(clsdf_device* device);
CLSDF_API void clsdf_mesh_retain(clsdf_mesh* mesh);
CLSDF_API void clsdf_mesh_release(clsdf_mesh* mesh);
CLSDF_API void clsdf_transform_retain(clsdf_transform* transform);
CLSDF_API void clsdf_transform_release(clsdf_transform* transform);
CLSDF_API void clsdf_scene_retain(clsdf_scene* scene);
CLSDF_API void clsdf_scene_release(clsdf_scene* scene);
CLSDF_API void clsdf_plan_retain(clsdf_plan* plan);
/* The last release waits for what the plan has enqueued. */
CLSDF_API void clsdf_plan_release(clsdf_plan* plan);
CLSDF_API void clsdf_sparse_plan_retain(clsdf_sparse_plan* plan);
CLSDF_API void clsdf_sparse_plan_release(clsdf_sparse_plan* plan);
CLSDF_API void clsdf_point_plan_retain(clsdf_point_plan* plan);
CLSDF_API void clsdf_point_plan_release(clsdf_point_plan* plan);
CLSDF_API void clsdf_link_plan_retain(clsdf_link_plan* plan);
CLSDF_API void clsdf_link_plan_release(clsdf_link_plan* plan);
CLSDF_API void clsdf_field_retain(clsdf_field* field);
CLSDF_API void clsdf_field_release(clsdf_field* field);
CLSDF_API void clsdf_sparse_field_retain(clsdf_sparse_field* field);
CLSDF_API void clsdf_sparse_field_release(clsdf_sparse_field* field);
CLSDF_API void clsdf_points_retain(clsdf_points* points);
CLSDF_API void clsdf_points_release(clsdf_points* points);
CLSDF_API void clsdf_cuda_device_retain(clsdf_cuda_device* device);
CLSDF_API void clsdf_cuda_device_release(clsdf_cuda_device* device);
CLSDF_API void clsdf_cuda_memory_retain(clsdf_cuda_memory* memory);
/* Memory is freed when its handle and the arrays that use it are released, which waits for the device. */
CLSDF_API void clsdf_cuda_memory_release(clsdf_cuda_memory* memory);
CLSDF_API void clsdf_cuda_arrays_retain(clsdf_cuda_arrays* arrays);
/* The last release is also clsdf_cuda_arrays_abandon(). Work that was enqueued goes on. */
CLSDF_API void clsdf_cuda_arrays_release(clsdf_cuda_arrays* arrays);
CLSDF_API void clsdf_thread_limit_retain(clsdf_thread_limit* limit);
CLSDF_API void clsdf_thread_limit_release(clsdf_thread_limit* limit);

/* ---- Arrays ---- */

/* Numbers in the caller's memory. An array has items: vertices, triangles, points or samples, each of one number or of
 * several components. It lies on the host or in a buffer of the device. The caller may free or reuse it when the call
 * returns; only a plan writes later, to its targets, until its last run has ended. Strides of an output cost a copy of
 * its samples inside the call. An input is not written, though `host` is not const. */
typedef struct clsdf_array {
    void* host;     /* the address of the first item, or null */
    void* device;   /* a cl_mem, or null */
    int64_t offset; /* bytes before the first item, a multiple of a number's bytes */
    int64_t count;  /* of items; 0 if that of an output is not known. Any other count must be exactly that of the grid's
                       samples, of the points, or of the samples of all blocks, with strides, too */
    int64_t strides[3];       /* bytes from an item to the next along x, y, z; inputs and points: strides[0] alone.
                                 Negative ones run backwards from the first item. Zeros: packed, x fastest */
    int64_t component_stride; /* bytes from a component to the next; 0: side by side. If it is set and `strides` are
                                 not: the first components of all items, then the second ones */
    int64_t block_stride;     /* bytes from a block of a clsdf_block_set to the next; 0: the blocks follow each other */
    int64_t bytes;            /* of host memory from `host` on; 0: unknown. An array that reaches beyond is refused */
    int32_t type;             /* CLSDF_FLOAT32 ... */
    int32_t pinned;           /* 1: `host` is pinned: mapped memory of a buffer with CL_MEM_ALLOC_HOST_PTR, or
                                 page-locked by another interface of the device's driver. A packed field is then read
                                 into it without a copy by the host. Inputs: not used */
} clsdf_array;
#define CLSDF_ARRAY_INIT \
    { NULL, NULL, 0, 0, {0, 0, 0}, 0, 0, 0, CLSDF_AUTOMATIC, 0 }

/* Packed items in memory of the host. */
static inline clsdf_array clsdf_host_array(int32_t type, const void* first, int64_t count) {
    clsdf_array array = CLSDF_ARRAY_INIT;
    union {
        const void* input;
        void* memory;
    } address;
    address.input = first;
    array.host = address.memory;
    array.type = type;
    array.count = count;
    return array;
}

/* Packed items in a buffer. */
static inline clsdf_array clsdf_buffer_array(int32_t type, void* buffer, int64_t count) {
    clsdf_array array = CLSDF_ARRAY_INIT;
    array.device = buffer;
    array.type = type;
    array.count = count;
    return array;
}

/* An output and the array that it is written to. The triangle may be uint32 or int32; distance, gradient, barycentric
 * and offset may be float32 or float64; the site is uint8; the closest point, a position, is float64. As float64 they
 * are evaluated in double, so that rounding them does not give the float32 results to the last bit. */
typedef struct clsdf_target {
    int32_t output; /* CLSDF_DISTANCE ... */
    int32_t reserved;
    clsdf_array array; /* one without memory is not wanted */
} clsdf_target;

static inline clsdf_target clsdf_host_target(int32_t output, int32_t type, void* first, int64_t count) {
    clsdf_target target = {0, 0, CLSDF_ARRAY_INIT};
    target.output = output;
    target.array = clsdf_host_array(type, first, count);
    return target;
}

static inline clsdf_target clsdf_buffer_target(int32_t output, int32_t type, void* buffer) {
    clsdf_target target = {0, 0, CLSDF_ARRAY_INIT};
    target.output = output;
    target.array = clsdf_buffer_array(type, buffer, 0);
    return target;
}

/* The targets of one request, one for each output at most; the distance has one. */
typedef struct clsdf_targets {
    const clsdf_target* items;
    int64_t count;
} clsdf_targets;

/* A row of the table of outputs. */
typedef struct clsdf_output_info {
    size_t struct_size;
    int32_t output;
    int32_t type;            /* of a value, in fields and files */
    int64_t components;      /* values of a sample, which lie side by side */
    const char* name;        /* "distance"; lives as long as the process, as the next */
    const char* description; /* in words */
} clsdf_output_info;
#define CLSDF_OUTPUT_INFO_INIT \
    { CLSDF_RESULT_SIZE(clsdf_output_info), 0, 0, 0, NULL, NULL }

/* The numbers of outputs lie below this; 6 is no output's. */
CLSDF_API int64_t clsdf_output_count(void);
CLSDF_API clsdf_status clsdf_output_describe(int32_t output, clsdf_output_info* info);

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

/* ---- Devices ---- */

/* The properties that a device reports; unknown ones are 0 or "". Texts live as long as the handle that gave them. */
typedef struct clsdf_device_info {
    size_t struct_size;
    int64_t index;    /* in the list of devices; -1: not in it, as a part of a device */
    void* id;         /* cl_device_id */
    const char* name; /* of a device without one, that of its platform */
    const char* platform;
    const char* version;   /* of OpenCL */
    const char* driver;    /* its version */
    const char* why_not;   /* why this library cannot use it; "" if it can */
    int64_t compute_units; /* 0: this and all to atomics64 are unknown */
    int64_t clock_megahertz;
    int64_t memory;             /* bytes */
    int64_t largest_allocation; /* bytes */
    int64_t float_width;        /* floats in a native vector; 1 on most GPUs */
    int32_t kind;               /* CLSDF_GPU ... */
    int32_t fp64;               /* 1: double precision, which this library needs */
    int32_t atomics64;          /* 1: atomic operations on 64 bits, which it does not need */
    int32_t source;             /* CLSDF_REGISTERED ..., how it was found: always known */
    const char* driver_file;    /* if this library opened it; of CLSDF_DEVICE_FILE, the file in /dev; else "" */
    const char* only_if_named;  /* why it is taken only if it is named, though it can be used; else "" */
} clsdf_device_info;
#define CLSDF_DEVICE_INFO_INIT                                                                                        \
    {                                                                                                                 \
        CLSDF_RESULT_SIZE(clsdf_device_info), 0, NULL, NULL, NULL, NULL, NULL, NULL, 0, 0, 0, 0, 0, 0, 0, 0, 0, NULL, \
            NULL                                                                                                      \
    }

/* Limits of clsdf_device_limited(). */
typedef struct clsdf_device_limits {
    size_t struct_size;
    int64_t compute_units; /* to use; on a processor, cores. 0: all */
    int64_t memory;        /* bytes that the buffers of one transform and its plans may take; 0: all */
} clsdf_device_limits;
#define CLSDF_DEVICE_LIMITS_INIT \
    { sizeof(clsdf_device_limits), 0, 0 }

/* All devices of all platforms, also those that cannot be used. */
CLSDF_API clsdf_status clsdf_devices_list(clsdf_devices** devices);
/* 0 for null. Threads: any number, as in the next. */
CLSDF_API int64_t clsdf_devices_count(const clsdf_devices* devices);
CLSDF_API clsdf_status clsdf_devices_describe(const clsdf_devices* devices, int64_t index, clsdf_device_info* info);

/* The strongest GPU, else the strongest other device; none with a text in only_if_named. CLSDF_NO_DEVICE says why each
 * is not taken, and the remedy. */
CLSDF_API clsdf_status clsdf_device_strongest(clsdf_device** device);
/* A whole number is an index in the list. Any other text is a part of the name, or of the platform's name, of exactly
 * one usable device. */
CLSDF_API clsdf_status clsdf_device_select(const char* index_or_part, clsdf_device** device);
/* clsdf_device_select() with the environment variable CLSDF_DEVICE if it is set and not empty, else the strongest. */
CLSDF_API clsdf_status clsdf_device_automatic(clsdf_device** device);
/* The share of a process: `rank` of the `ranks` processes on this machine, 0 <= rank < ranks. GPUs that may be
 * taken are dealt out in turn. If there is none, or if CLSDF_DEVICE names a device, it is that of
 * clsdf_device_automatic(), of a processor an equal part of the compute units, at least one. CLSDF_UNSUPPORTED names
 * the driver's variable if a processor cannot be divided. clsdf_limit_threads() limits the host's loops. */
CLSDF_API clsdf_status clsdf_device_of_rank(int64_t rank, int64_t ranks, clsdf_device** device);
/* Retains the caller's cl_context, cl_device_id and cl_command_queue. */
CLSDF_API clsdf_status clsdf_device_from_handles(void* context, void* id, void* queue, clsdf_device** device);
/* The same device with limits, with a context and a queue of its own. Threads: any number, as in all that follow. */
CLSDF_API clsdf_status clsdf_device_limited(const clsdf_device* device, const clsdf_device_limits* limits,
                                            clsdf_device** limited);
/* Asks every driver. */
CLSDF_API clsdf_status clsdf_device_describe(const clsdf_device* device, clsdf_device_info* info);
/* The cl_context, cl_device_id and cl_command_queue. They belong to the device: retain those that you keep for longer.
 * Each pointer may be null. */
CLSDF_API clsdf_status clsdf_device_handles(const clsdf_device* device, void** context, void** id, void** queue);
/* A cl_mem of `bytes` bytes, of the device's context, that is memory of another interface: of CUDA for instance,
 * exported as a POSIX file descriptor (cuMemExportToShareableHandle). On success the driver owns the descriptor, and
 * you release the cl_mem; after an error you still own the descriptor. Commands may use the cl_mem only between
 * clEnqueueAcquireExternalMemObjectsKHR and clEnqueueReleaseExternalMemObjectsKHR, which you enqueue. CLSDF_UNSUPPORTED
 * if the driver has no cl_khr_external_memory_opaque_fd, CLSDF_INVALID_ARGUMENT if it does not take the descriptor as
 * memory of this size. */
CLSDF_API clsdf_status clsdf_device_import_memory(const clsdf_device* device, int32_t descriptor, int64_t bytes,
                                                  void** memory);

/* Keeps records of passed tests in the folder, for programs that are built from now on. Null or "": none. */
CLSDF_API clsdf_status clsdf_device_keep_records(const clsdf_device* device, const char* folder);
/* Takes compiled programs from a folder that clsdf_device_write_programs() filled. The process runs the code in it:
 * name one in which nobody else can write. Null or "": none. */
CLSDF_API clsdf_status clsdf_device_read_programs(const clsdf_device* device, const char* folder);
/* Writes programs that are compiled from now on to the folder, too. Null or "": none. */
CLSDF_API clsdf_status clsdf_device_write_programs(const clsdf_device* device, const char* folder);
/* Deletes the records of this device: programs are tested again. */
CLSDF_API clsdf_status clsdf_device_forget_records(const clsdf_device* device);
/* Gives back what the device keeps for later calls, beside what transforms and plans hold: arrays of the host, at most
 * 32 MiB; and, of a device with memory of its own, memory of the device that no transform uses, at most 512 MiB and
 * 1/32 of its memory, and 40 MiB of pinned memory of the host. *bytes, if not null: how many. The next call makes what
 * it needs anew. */
CLSDF_API clsdf_status clsdf_device_release_memory(const clsdf_device* device, int64_t* bytes);
/* The folder of clsdf_device_keep_records(). Here and below, a text is written to text[size] with its ending 0, cut if
 * it is too long; *length, if not null, is that of the whole text. `text` may be null if size is 0. */
CLSDF_API clsdf_status clsdf_device_record_folder(const clsdf_device* device, char* text, int64_t size,
                                                  int64_t* length);
/* The folder that clsdf's command uses: CLSDF_CACHE_DIR, or one of the user's. "" if none is known. */
CLSDF_API clsdf_status clsdf_default_record_folder(char* text, int64_t size, int64_t* length);

/* The loops of the library on the host (oneTBB's) have at most `count` threads, the calling one included, until the
 * handle is released. Holds for the process; of several limits the smallest. It does not limit an OpenCL driver's
 * threads: clsdf_device_limited() does. */
CLSDF_API clsdf_status clsdf_limit_threads(int64_t count, clsdf_thread_limit** limit);
/* The limit in force. */
CLSDF_API int64_t clsdf_thread_count(void);

/* ---- Meshes ---- */

/* A mesh in the caller's arrays, on the host or in buffers of the device's context. Each call that takes one copies
 * what it keeps. */
typedef struct clsdf_mesh_arrays {
    size_t struct_size;
    clsdf_array vertices;  /* three float32 or float64 an item */
    clsdf_array triangles; /* three indices an item, int32, int64, uint32 or uint64, counter-clockwise from outside */
    int32_t index_base;    /* 0 or 1: what indices of vertices count from, and triangles of outputs. With 1, `triangles`
                              lie on the host, and a copy of them is made for the call */
    int32_t reserved;
    const char* name; /* of the mesh that clsdf_mesh_create() makes, in messages and files; null: "mesh" */
} clsdf_mesh_arrays;
#define CLSDF_MESH_ARRAYS_INIT \
    { sizeof(clsdf_mesh_arrays), CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, 0, 0, NULL }

typedef struct clsdf_edge {
    double from[3];
    double to[3];
} clsdf_edge;

/* The facts that decide the sign rule. Vertices of equal coordinates count as one. If the mesh itself is not balanced,
 * another surface decides the sign, with joined vertices, doubled faces that count once and faces turned around: what
 * is said of closed and balanced meshes and of edges is true of that surface. */
typedef struct clsdf_topology {
    size_t struct_size;
    int32_t closed;     /* 1: every undirected edge has an even number of faces */
    int32_t balanced;   /* 1: every edge is used equally often in both directions */
    int32_t inside_out; /* 1: balanced, and the enclosed volume is negative; or not, and the winding number is */
    int32_t reserved;
    int64_t open_edges;            /* undirected edges with an odd number of faces */
    int64_t unbalanced_edges;      /* undirected edges not used equally often in both directions */
    int64_t non_manifold_edges;    /* undirected edges with more than two faces, of the mesh itself */
    int64_t repeated_vertex_faces; /* faces with fewer than three different vertices */
    int64_t coincident_vertices;   /* vertices in use that equal an earlier one */
    int64_t unused_vertices;
    int64_t first_open_count;       /* of first_open */
    int64_t first_unbalanced_count; /* of first_unbalanced */
    clsdf_edge first_open[5];       /* in the order of the triangles */
    clsdf_edge first_unbalanced[5];
    int64_t boundary_edges;        /* undirected edges with one face: some of the open ones */
    int64_t joined_vertices;       /* in use, differ from another one by rounding and count as it */
    int64_t duplicate_faces;       /* with the vertices of an earlier face; 0 if every edge has two faces */
    int64_t uncounted_faces;       /* of doubled faces those that do not count for the sign */
    int64_t reoriented_faces;      /* look the wrong way and are turned around for the sign */
    int64_t inner_wall_faces;      /* between regions; without them the mesh would be closed */
    int64_t first_inner_wall_face; /* the lowest of them, counted from 0, as those that follow */
    int64_t parts;                 /* of a balanced mesh: those that share no vertex; else 0 */
    int64_t inward_parts;          /* look inwards and are not wholly within others */
    int64_t first_inward_face;     /* the lowest face of the first of them */
    int64_t nested_parts;          /* lie within others, look the same way and are filled */
    int64_t first_nested_face;     /* the lowest face of the first of them */
    /* These three are 0 unless the mesh is not balanced and the rule may become solid_angle. */
    int64_t tested_points;   /* points beside faces and in the parts' boxes at which the winding number was computed */
    int64_t doubtful_points; /* tested points at which it is more than 0.1 from an integer */
    int64_t inside_points;   /* tested points at which it is at least 1/2, or at most -1/2 */
    int64_t unclear_parts;   /* parts where it is in doubt at more than a tenth of them, or at none inside */
    int64_t first_unclear_face;        /* the lowest face of the first of them */
    int64_t double_sided_faces;        /* of bodies that are there on both sides; each counts once */
    int64_t doubled_cavity_faces;      /* of cavities that are there twice, so the cavities are filled */
    int64_t first_doubled_cavity_face; /* the lowest of them */
    int64_t sheet_faces;               /* of sheets and inner walls beside closed bodies, left out for the sign */
    int64_t first_sheet_face;          /* the lowest of them */
    int64_t enclosing_faces;           /* of open sheets that are not left out, because they enclose something */
    int64_t first_enclosing_face;      /* the lowest of them */
    int64_t overlapping_parts;         /* parts of a balanced mesh that are partly within others */
    int64_t first_overlapping_face;    /* the lowest face of the first of them */
    /* The rule below needs a mesh that is not closed, whose faces look up and whose rim does not overlap. */
    int64_t downward_faces;        /* look down, to smaller z */
    int64_t first_downward_face;   /* the lowest of them */
    int64_t rim_loops;             /* of a mesh that is not closed and has no downward_faces: loops of open edges */
    int64_t overlapping_rim_edges; /* of them that cross others, seen from above, or at which the mesh lies twice */
    /* Small open parts that are attached to the others and count as details of them; 0 if the mesh has its sign without
     * that. */
    int64_t detail_parts;
    int64_t detail_faces;      /* of these parts */
    int64_t first_detail_face; /* the lowest of them */
    /* Set for a transform with CLSDF_SURFACE_OUTER; else 0. */
    int64_t partial_faces; /* faces of which parts are on the outer surface */
    int64_t hidden_faces;  /* faces that are not on it at all */
} clsdf_topology;
#define CLSDF_EDGE_INIT \
    {                   \
        {0, 0, 0}, {    \
            0, 0, 0     \
        }               \
    }
#define CLSDF_FIVE_EDGES_INIT \
    { CLSDF_EDGE_INIT, CLSDF_EDGE_INIT, CLSDF_EDGE_INIT, CLSDF_EDGE_INIT, CLSDF_EDGE_INIT }
#define CLSDF_TOPOLOGY_INIT                                                                                            \
    {                                                                                                                  \
        CLSDF_RESULT_SIZE(clsdf_topology), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, CLSDF_FIVE_EDGES_INIT,                  \
            CLSDF_FIVE_EDGES_INIT, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, \
            0, 0, 0, 0, 0, 0, 0                                                                                        \
    }

/* Defects beside those of edges. The distance is exact in spite of them. */
typedef struct clsdf_defects {
    size_t struct_size;
    int64_t zero_area_faces; /* three different vertices on one line, exactly */
    int64_t duplicate_faces; /* with the vertices of an earlier face, in whatever order */
    int64_t components;      /* parts that share no vertex */
} clsdf_defects;
#define CLSDF_DEFECTS_INIT \
    { CLSDF_RESULT_SIZE(clsdf_defects), 0, 0, 0 }

typedef int32_t (*clsdf_log_function)(void* user, const char* message);

/* How files of meshes are read. */
typedef struct clsdf_read_options {
    size_t struct_size;
    void* user; /* the first argument of the function */
    /* Warnings, each with the file: what was skipped (faces of one or two corners, bytes after the last row of a binary
     * .ply, unknown lines) or changed (vertices of an .obj with a fourth number are divided by it). May be null. */
    clsdf_log_function log;
    double scale;        /* a position x becomes R (x * scale) + translate; without a rotation R, product and sum are
                            each rounded once; > 0 */
    double translate[3]; /* in the units after the scale */
    /* 1: faces with a coordinate that is not finite, or that name a vertex that does not exist, are left out; log gets
     * their number and the first of them. 0: they are errors. */
    int32_t skip_bad_facets;
    int32_t reserved;
    const char* up;       /* the axis of the file that points up: "x", "y", "z", "-x", "-y" or "-z"; null: "z". The mesh
                             gets z up: of a file with y up, (x, y, z) becomes (x, -z, y) */
    double rotate[3];     /* degrees about the fixed axes x, y and z, one after the other, after `up`; exact for
                             multiples of 90 */
    const char* group_by; /* a property of the faces of .ply files, whose values name the groups; null: none */
} clsdf_read_options;
#define CLSDF_READ_OPTIONS_INIT \
    { sizeof(clsdf_read_options), NULL, NULL, 1, {0, 0, 0}, 0, 0, NULL, {0, 0, 0}, NULL }

/* How a mesh differs from the one that it was welded from, face by face. */
typedef struct clsdf_weld_report {
    size_t struct_size;
    int64_t lost_faces;       /* had three different vertices, and have fewer now, so no area */
    int64_t coinciding_faces; /* have the three vertices of other faces now, and did not before */
    /* A closed mesh has its volume, > 0 if its faces look outwards; an open one that of the cones from the faces to the
     * centre of the box. */
    double volume_before;
    double volume_after;
} clsdf_weld_report;
#define CLSDF_WELD_REPORT_INIT \
    { CLSDF_RESULT_SIZE(clsdf_weld_report), 0, 0, 0, 0 }

/* A checked copy of arrays of the host. CLSDF_INVALID_MESH names the element, the value and the base of its numbers. */
CLSDF_API clsdf_status clsdf_mesh_create(const clsdf_mesh_arrays* arrays, clsdf_mesh** mesh);
/* A mesh made by code: "sphere0" to "sphere9", "torus", "knot", ... */
CLSDF_API clsdf_status clsdf_mesh_shape(const char* name, clsdf_mesh** mesh);
/* Reads .off, .obj, .stl or .ply; polygons become triangles. CLSDF_UNREADABLE_INPUT names the line and the value. */
CLSDF_API clsdf_status clsdf_mesh_read(const char* path, clsdf_mesh** mesh);
/* Reads files as one mesh: the vertices and the triangles of each follow those of the one before it. Each file is a
 * group with the name of the file; a file with several groups has "file/group". `options` may be null. */
CLSDF_API clsdf_status clsdf_mesh_read_files(const char* const* paths, int64_t count, const clsdf_read_options* options,
                                             clsdf_mesh** mesh);
/* The mesh in which vertices of equal coordinates are one, with the same index base. */
CLSDF_API clsdf_status clsdf_mesh_weld(const clsdf_mesh* mesh, clsdf_mesh** welded);
/* The mesh in which vertices are one, too, if they differ by at most `tolerance` on every axis, in the mesh's units, or
 * are connected by others that do; clusters longer than four tolerances are left apart. */
CLSDF_API clsdf_status clsdf_mesh_weld_within(const clsdf_mesh* mesh, double tolerance, clsdf_mesh** welded);
/* A terrain closed by walls from its rim down to z = `floor`, and by a floor there: what CLSDF_SIGN_BELOW takes to be
 * inside. The vertices and triangles of `mesh` come first; no groups. CLSDF_INVALID_MESH if the mesh does not meet that
 * rule, CLSDF_INVALID_ARGUMENT if the floor is not below all vertices. */
CLSDF_API clsdf_status clsdf_mesh_close_down(const clsdf_mesh* mesh, double floor, clsdf_mesh** closed);
/* What clsdf_mesh_weld_within() did to `mesh`: a wall that is thinner than the tolerance is flat. The warning, which
 * may be "", says so, with the remedy. */
CLSDF_API clsdf_status clsdf_mesh_describe_weld(const clsdf_mesh* mesh, const clsdf_mesh* welded,
                                                clsdf_weld_report* report, char* warning, int64_t size,
                                                int64_t* length);
/* Writes by the file's ending, complete or not at all. `colours`: red, green, blue of each triangle, as uint8_t
 * [colour_count][3], or null and 0. Without them a .ply of an outer surface has the property given_face of each
 * triangle. Threads: any number. */
CLSDF_API clsdf_status clsdf_mesh_write(const clsdf_mesh* mesh, const char* path, const uint8_t* colours,
                                        int64_t colour_count);
/* Names and descriptions of shapes, 0 <= index < count; null beyond. They live as long as the process. */
CLSDF_API int64_t clsdf_shape_count(void);
CLSDF_API const char* clsdf_shape_name(int64_t index);
CLSDF_API const char* clsdf_shape_description(int64_t index);

/* New positions of the same vertices, on the host. A mesh of clsdf_mesh_outer() is a mesh like others then. Threads:
 * one. */
CLSDF_API clsdf_status clsdf_mesh_set_positions(clsdf_mesh* mesh, const clsdf_array* positions);
/* Sets the index base that transforms of this mesh have from now on: 0 (as of files and shapes) or 1. Threads: one. */
CLSDF_API clsdf_status clsdf_mesh_set_index_base(clsdf_mesh* mesh, int32_t index_base);
/* The mesh's own memory, as long as the mesh lives: count[3] doubles, and count[3] indices from 0, whatever the index
 * base. clsdf_mesh_set_positions() writes the new positions there. Threads: any number, as in all that follow. */
CLSDF_API clsdf_status clsdf_mesh_vertices(const clsdf_mesh* mesh, const double** vertices, int64_t* count);
CLSDF_API clsdf_status clsdf_mesh_triangles(const clsdf_mesh* mesh, const uint32_t** triangles, int64_t* count);
CLSDF_API clsdf_status clsdf_mesh_index_base(const clsdf_mesh* mesh, int32_t* index_base);
CLSDF_API clsdf_status clsdf_mesh_name(const clsdf_mesh* mesh, const char** name);
/* Groups of triangles: the solids of an ASCII STL file, the groups and objects of an OBJ file, several files, or those
 * that are set. A mesh without groups has 0 names and 0 numbers. Welded meshes have the same groups. All is the mesh's
 * own memory, as long as it lives and until clsdf_mesh_set_groups(). */
CLSDF_API clsdf_status clsdf_mesh_group_count(const clsdf_mesh* mesh, int64_t* count);
/* 0 <= index < count; all names are different. */
CLSDF_API clsdf_status clsdf_mesh_group_name(const clsdf_mesh* mesh, int64_t index, const char** name);
/* The index of its name for each triangle, from 0 whatever the index base. */
CLSDF_API clsdf_status clsdf_mesh_group_numbers(const clsdf_mesh* mesh, const uint32_t** numbers, int64_t* count);
/* Sets copies of names and numbers, a number for each triangle; none of both removes the groups. Threads: one. */
CLSDF_API clsdf_status clsdf_mesh_set_groups(clsdf_mesh* mesh, const char* const* names, int64_t name_count,
                                             const uint32_t* numbers, int64_t count);
/* The box of the vertices in use. */
CLSDF_API clsdf_status clsdf_mesh_box(const clsdf_mesh* mesh, clsdf_box* box);
/* A hash of all vertices and triangles in their order, the same on every machine. It tells whether ranks have the same
 * mesh. The index base and the name do not count. */
CLSDF_API clsdf_status clsdf_mesh_hash(const clsdf_mesh* mesh, uint64_t* hash);
CLSDF_API clsdf_status clsdf_mesh_topology(const clsdf_mesh* mesh, clsdf_topology* topology);
CLSDF_API clsdf_status clsdf_mesh_defects(const clsdf_mesh* mesh, clsdf_defects* defects);
/* The rule that a transform would use, and a warning about it, which may be "". CLSDF_INVALID_MESH if the mesh does not
 * meet the rule. */
CLSDF_API clsdf_status clsdf_mesh_sign(const clsdf_mesh* mesh, int32_t asked, int32_t* rule, char* warning,
                                       int64_t size, int64_t* length);

/* ---- Options and results of calls ---- */

typedef struct clsdf_progress {
    int32_t stage; /* CLSDF_COMPILING, CLSDF_COMPUTING, CLSDF_TESTING */
    int32_t reserved;
    double fraction; /* of the stage, 0 to 1 */
    int64_t step;    /* of compiling, from 1 */
    int64_t steps;   /* of compiling, at most */
} clsdf_progress;

typedef int32_t (*clsdf_progress_function)(void* user, const clsdf_progress* progress);
/* 0: go on; CLSDF_CANCELLED: cancel. No truth value: 1 would end the call as CLSDF_INVALID_MESH. */
typedef int32_t (*clsdf_stop_function)(void* user);

/* Options of one call. Functions may be null. */
typedef struct clsdf_call_options {
    size_t struct_size;
    void* user;                       /* the first argument of the functions */
    clsdf_progress_function progress; /* called between launches, and before each step of building programs */
    clsdf_stop_function should_stop;  /* asked there, too */
    clsdf_log_function log;           /* warnings of this call */
    void* const* wait_list;           /* cl_events after which the call uses the caller's memory */
    int64_t wait_count;
    int32_t refuse_unusable_points; /* 1: clsdf_query() fails if a point is not finite or too far from the mesh */
    int32_t reserved;
} clsdf_call_options;
#define CLSDF_CALL_OPTIONS_INIT \
    { sizeof(clsdf_call_options), NULL, NULL, NULL, NULL, NULL, 0, 0, 0 }

/* An outer surface, beside the faces as given. */
typedef struct clsdf_outer_report {
    size_t struct_size;
    int64_t whole_faces;   /* faces as given that are on the outer surface wholly, */
    int64_t partial_faces; /* in parts, */
    int64_t hidden_faces;  /* and not at all */
    double volume;         /* inside, in cubed units of the mesh */
    double area;           /* of the outer surface, in squared units */
} clsdf_outer_report;
#define CLSDF_OUTER_REPORT_INIT \
    { CLSDF_RESULT_SIZE(clsdf_outer_report), 0, 0, 0, 0, 0 }

/* The outer surface of a mesh whose parts may overlap, touch, repeat or contain each other: closed, its faces look
 * outwards, with the groups of the faces as given. Distances to it are those to the union of the parts. `sign`:
 * CLSDF_SIGN_AUTOMATIC, CLSDF_SIGN_NONZERO or CLSDF_SIGN_PARITY; of `call`, which may be null, should_stop counts;
 * `report` may be null. CLSDF_UNSUPPORTED for other rules, also if the mesh has one of them; CLSDF_INVALID_MESH if the
 * mesh does not meet the rule or nothing is inside. */
CLSDF_API clsdf_status clsdf_mesh_outer(const clsdf_mesh* mesh, int32_t sign, const clsdf_call_options* call,
                                        clsdf_mesh** outer, clsdf_outer_report* report);
/* The number of the face as given that each triangle of a mesh of clsdf_mesh_outer() is a part of, from 0 whatever the
 * index base, in the mesh's own memory, as long as it lives; 0 numbers for other meshes. */
CLSDF_API clsdf_status clsdf_mesh_given_faces(const clsdf_mesh* mesh, const uint32_t** faces, int64_t* count);
/* The same for a mesh of clsdf_scene_outer(): the body of each triangle, from 0; the faces count within its mesh. */
CLSDF_API clsdf_status clsdf_mesh_given_bodies(const clsdf_mesh* mesh, const uint32_t** bodies, int64_t* count);

/* Times (wall-clock seconds of the host) and memory of a call. */
typedef struct clsdf_statistics {
    size_t struct_size;
    int64_t slabs;            /* parts of the grid computed one after the other */
    int64_t device_bytes;     /* the most that buffers took at once; of a plan, its own buffers */
    int64_t host_bytes;       /* the library's arrays on the host for slabs */
    double compile_seconds;   /* building or loading the device's programs, and testing them */
    double polyhedra_seconds; /* preparing the mesh */
    double field_seconds;     /* samples or points */
    int32_t first_use;        /* 1: programs computed for the first time on this device */
    int32_t reserved;
    int64_t unusable_points; /* of clsdf_query(): points that are not finite or too far from the mesh */
} clsdf_statistics;
#define CLSDF_STATISTICS_INIT \
    { CLSDF_RESULT_SIZE(clsdf_statistics), 0, 0, 0, 0, 0, 0, 0, 0, 0 }

typedef struct clsdf_transform_options {
    size_t struct_size;
    int32_t sign;       /* CLSDF_SIGN_AUTOMATIC ... */
    int32_t surface;    /* CLSDF_SURFACE_GIVEN, the default, or CLSDF_SURFACE_OUTER */
    int64_t kept_bytes; /* limit of the device memory kept between calls; 0: none; -1: the default */
    double floor;       /* of CLSDF_SIGN_BELOW, which needs one: z below all vertices; DBL_MAX, the default: none */
} clsdf_transform_options;
#define CLSDF_TRANSFORM_OPTIONS_INIT \
    { sizeof(clsdf_transform_options), CLSDF_SIGN_AUTOMATIC, CLSDF_SURFACE_GIVEN, -1, 1.7976931348623157e308 }

/* Memory that a transform keeps between calls, beside the mesh. */
typedef struct clsdf_kept_memory {
    size_t struct_size;
    int64_t host_bytes;
    int64_t device_bytes;
    /* All transforms of the device share these: clsdf_device_release_memory() gives them back. */
    int64_t shared_host_bytes;   /* for copies, most of it pinned */
    int64_t shared_device_bytes; /* that no transform uses */
} clsdf_kept_memory;
#define CLSDF_KEPT_MEMORY_INIT \
    { CLSDF_RESULT_SIZE(clsdf_kept_memory), 0, 0, 0, 0 }

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

/* A box of the domain, and what is asked in it. */
typedef struct clsdf_region {
    clsdf_box box;
    double half_width; /* the largest distance asked for; positive and finite */
    double spacing;    /* the largest spacing of grids; 0: only points and boxes */
} clsdf_region;

/* A slab of a field: whole slices. The values are packed and there until it returns. It may use the transform. */
typedef int32_t (*clsdf_slab_function)(void* user, const clsdf_grid* part, const clsdf_target* values, int64_t count);

typedef struct clsdf_slab_options {
    size_t struct_size;
    int32_t own_thread; /* 1: the function is called on another thread, while the next slab is computed */
    int32_t reserved;
} clsdf_slab_options;
#define CLSDF_SLAB_OPTIONS_INIT \
    { sizeof(clsdf_slab_options), 0, 0 }

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

/* ---- Transforms ---- */

/* Threads: calls with a const transform any number; their work takes turns on the device. Others: one.
 *
 * Triangles of outputs count from the mesh's index base: beyond the band they are -1 with base 0 and 0 with base 1.
 * With base 1 they cost one more pass over the output, and the output must lie on the host: in a buffer, and so in a
 * plan, it is CLSDF_UNSUPPORTED. */

/* Copies and checks the mesh. Compiles nothing: the first call that needs a program does. A warning, such as that a
 * mesh with holes gets distances without a sign, goes to call->log alone: the library prints nothing. */
CLSDF_API clsdf_status clsdf_transform_create(const clsdf_device* device, const clsdf_mesh* mesh,
                                              const clsdf_transform_options* options, const clsdf_call_options* call,
                                              clsdf_transform** transform);
/* The same from arrays, which may be buffers of the device's context. The transform has its own copy: the arrays may go
 * when the call returns. */
CLSDF_API clsdf_status clsdf_transform_from_arrays(const clsdf_device* device, const clsdf_mesh_arrays* arrays,
                                                   const clsdf_transform_options* options,
                                                   const clsdf_call_options* call, clsdf_transform** transform);
/* A transform for a part of the domain, which keeps only what the regions need. Results have the bytes of the whole.
 * Calls outside the regions are CLSDF_INVALID_ARGUMENT; new positions are CLSDF_UNSUPPORTED, unless it has a margin. */
CLSDF_API clsdf_status clsdf_transform_restrict(const clsdf_transform* transform, const clsdf_region* regions,
                                                int64_t count, clsdf_transform** restricted);
/* The same of a part whose vertices may move by up to `margin`, in the mesh's units, from where they are now: its
 * clsdf_transform_set_positions() takes one position for each vertex that clsdf_transform_part_vertices() tells, and
 * results have the bytes of the whole at the same positions. A vertex farther than the margin is
 * CLSDF_INVALID_ARGUMENT, which names it. A transform of the outer surface is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_transform_restrict_with_margin(const clsdf_transform* transform,
                                                            const clsdf_region* regions, int64_t count, double margin,
                                                            clsdf_transform** restricted);
/* The vertices of a part with a margin, ascending, by their numbers in the mesh of the whole, from the index base of
 * the transform; of vertices with equal coordinates the lowest. *count of them, into `vertices`, which has room for
 * `room`. With vertices null and room 0 only *count is set; if the room is too small nothing is written, and *count is
 * set, too (CLSDF_INVALID_ARGUMENT). A transform without a margin is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_transform_part_vertices(const clsdf_transform* transform, uint32_t* vertices, int64_t room,
                                                     int64_t* count);

/* A restricted transform as bytes, for another process or for later: *count of them, into `bytes`, which has room for
 * `room`. With bytes null and room 0 only *count is set; if the room is too small nothing is written, and *count is
 * set, too (CLSDF_INVALID_ARGUMENT). A whole transform, or one of the outer surface, is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_transform_part_bytes(const clsdf_transform* transform, uint8_t* bytes, int64_t room,
                                                  int64_t* count);
/* The restricted transform of these bytes, without the mesh, on any device. They are of the same version of clsdf and
 * of this kind of machine; damaged or foreign bytes are CLSDF_INVALID_ARGUMENT. Their hash tells damage, not forgery.
 * kept_bytes: as of clsdf_transform_options; -1: the default. */
CLSDF_API clsdf_status clsdf_transform_from_part(const clsdf_device* device, const uint8_t* bytes, int64_t count,
                                                 int32_t index_base, int64_t kept_bytes, clsdf_transform** transform);

/* One copy of a prepared mesh for the processes of a node, in memory of the caller's that they share: POSIX shared
 * memory, a window of MPI, a mapped file. It begins at a multiple of 64 bytes.
 *
 * The size of that memory in bytes, about 640 for each triangle. Makes what is not made yet. A transform that is
 * restricted, has moved, or is of the outer surface is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_transform_prepared_bytes(const clsdf_transform* transform, int64_t* bytes);
/* Writes the prepared mesh into memory of so many bytes, its head last: until the call returns,
 * clsdf_transform_from_shared() refuses the memory. */
CLSDF_API clsdf_status clsdf_transform_share(const clsdf_transform* transform, void* memory, int64_t bytes);
/* A whole transform that reads the prepared mesh in place. The memory stays as it is, and may be read-only, until the
 * transform and its plans are destroyed. Memory without a complete transform, damaged, or of another version of clsdf
 * is CLSDF_INVALID_ARGUMENT: all of it is read once, and a hash tells damage, not forgery. A device with memory of its
 * own gets copies. kept_bytes: as of clsdf_transform_options; -1: the default. */
CLSDF_API clsdf_status clsdf_transform_from_shared(const clsdf_device* device, const void* memory, int64_t bytes,
                                                   int32_t index_base, int64_t kept_bytes, clsdf_transform** transform);

/* New positions of all vertices, on the host or in a buffer; of a part with a margin, of those that it has. After an
 * error the positions are those of before. */
CLSDF_API clsdf_status clsdf_transform_set_positions(clsdf_transform* transform, const clsdf_array* positions,
                                                     const clsdf_call_options* call);
/* Puts the vertices at R x + t; x are the positions that the transform was made with. rotation[9] has the rows of R.
 * Each element of R R^T may differ from the identity's by 1e-12, and det R > 0, else CLSDF_INVALID_ARGUMENT: a rotation
 * in floats, or a product of thousands of rotations, is farther off. Make R from an angle or a quaternion in double
 * precision, or make the rows of a product orthonormal again. */
CLSDF_API clsdf_status clsdf_transform_set_motion(clsdf_transform* transform, const double* rotation,
                                                  const double* translation);

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
/* The slabs of a field on a device that sets no closer limit: the first `size` of *count. `slabs` may be null if size
 * is 0. */
CLSDF_API clsdf_status clsdf_slabs_of(const clsdf_grid* grid, clsdf_grid* slabs, int64_t size, int64_t* count);

/* The distance at points, and all else that has an array of points->count items. Beyond half_width, which may be 0 or
 * infinite, the distance is half_width with the point's sign. At most 96 points are answered by the calling thread.
 * A point that is not finite gets the distance NaN and no triangle. A finite one more than 1e14 voxels (1/256 of the
 * mesh's longest side) from the mesh's box gets half_width if that is finite, else NaN, and no triangle. call->log gets
 * one warning with their number. With call->refuse_unusable_points such a point fails the whole call; the message has
 * its index from 0, and no output is written. Targets may lie on the points: they are read first. */
CLSDF_API clsdf_status clsdf_query(const clsdf_transform* transform, const clsdf_array* points, double half_width,
                                   const clsdf_target* targets, int64_t target_count, const clsdf_call_options* call,
                                   clsdf_statistics* statistics);
/* The distances to points[count][3], packed on the host; beyond half_width, which may be HUGE_VAL, half_width with the
 * point's sign. clsdf_query() says more. */
static inline clsdf_status clsdf_query_distance(const clsdf_transform* transform, const double* points, int64_t count,
                                                double half_width, float* distance) {
    const clsdf_array at = clsdf_host_array(CLSDF_FLOAT64, points, count);
    const clsdf_target target = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance, count);
    return clsdf_query(transform, &at, half_width, &target, 1, NULL, NULL);
}
/* The places (CLSDF_WITHIN ...) of `count` boxes. */
CLSDF_API clsdf_status clsdf_classify(const clsdf_transform* transform, const clsdf_box* boxes, int64_t count,
                                      double half_width, uint8_t* places);
/* The generalised winding number at points->count points anywhere, in floats or doubles: an integer for a closed mesh.
 * The sign rule solid_angle takes points with 1/2 or more, or -1/2 or less, to be inside. NaN for a point that is not
 * finite. results->count is 0 or that of the points. */
CLSDF_API clsdf_status clsdf_winding(const clsdf_transform* transform, const clsdf_array* points,
                                     const clsdf_array* results, const clsdf_call_options* call);

/* ---- Scenes: many bodies with poses, their fields, and points among them (docs/scenes.md) ---- */

/* The pose of a body, whose points x are at R x + t. */
typedef struct clsdf_pose {
    double rotation[9]; /* R, by rows */
    double translation[3];
} clsdf_pose;
#define CLSDF_POSE_INIT                \
    {                                  \
        {1, 0, 0, 0, 1, 0, 0, 0, 1}, { \
            0, 0, 0                    \
        }                              \
    }
/* The pose of a 4 x 4 matrix by rows, double[16], whose last row is 0, 0, 0, 1. Its rotation may be rounded to floats,
 * and is replaced by the nearest rotation, with the same bytes on every machine. */
CLSDF_API clsdf_status clsdf_pose_of_matrix(const double* matrix, clsdf_pose* pose);

typedef struct clsdf_scene_options {
    size_t struct_size;
    int64_t kept_bytes; /* limit of the memory that is kept of each mesh; 0: none; -1: the default */
    int32_t index_base; /* 0 or 1: from which bodies, the points of pairs and the triangles of results count. Numbers in
                           messages count from 0 */
    /* CLSDF_SURFACE_GIVEN, the default: the distance is the least of the bodies'. CLSDF_SURFACE_OUTER: that to the
     * surface of the union of the bodies that are on, within overlaps, too; each body's mesh is replaced by its own
     * outer surface when it is added. */
    int32_t surface;
} clsdf_scene_options;
#define CLSDF_SCENE_OPTIONS_INIT \
    { sizeof(clsdf_scene_options), -1, 0, CLSDF_SURFACE_GIVEN }

/* A scene without bodies; `options` may be null. device: whose memory points and results may be in; the host computes.
 * Calls that change a scene: threads: one. Calls of a const scene: threads: any number. After an error the scene is
 * that of before. */
CLSDF_API clsdf_status clsdf_scene_create(const clsdf_device* device, const clsdf_scene_options* options,
                                          clsdf_scene** scene);
/* Adds a mesh, which is copied, and gives the body's number, which stays: they are given in the order of the calls.
 * sign: CLSDF_SIGN_AUTOMATIC ...; CLSDF_SIGN_BELOW is CLSDF_UNSUPPORTED. pose: null: R = 1, t = 0. */
CLSDF_API clsdf_status clsdf_scene_add(clsdf_scene* scene, const clsdf_mesh* mesh, int32_t sign, const clsdf_pose* pose,
                                       const clsdf_call_options* call, int64_t* body);
/* Adds a body that has the mesh and the sign rule of another one. */
CLSDF_API clsdf_status clsdf_scene_add_instance(clsdf_scene* scene, int64_t of, const clsdf_pose* pose, int64_t* body);
/* Moves the bodies, bodies[count], or all of them if `bodies` is null and `count` is their number. Elements of R R^T
 * may differ from the identity's by 1e-5, so that rotations may be rounded to floats: each is replaced by the nearest
 * one. CLSDF_INVALID_ARGUMENT names the body of a matrix that is no rotation; no body moves then. */
CLSDF_API clsdf_status clsdf_scene_set_poses(clsdf_scene* scene, const int64_t* bodies, const clsdf_pose* poses,
                                             int64_t count);
/* Gives the mesh of a body, and so all its instances, new positions before their poses. */
CLSDF_API clsdf_status clsdf_scene_set_positions(clsdf_scene* scene, int64_t body, const clsdf_array* positions,
                                                 const clsdf_call_options* call);
/* 0: switches a body off, as if it were not there; 1: on again. */
CLSDF_API clsdf_status clsdf_scene_set_active(clsdf_scene* scene, int64_t body, int32_t active);
CLSDF_API clsdf_status clsdf_scene_size(const clsdf_scene* scene, int64_t* count);
CLSDF_API clsdf_status clsdf_scene_active(const clsdf_scene* scene, int64_t body, int32_t* active);
/* With the rotation that is used. */
CLSDF_API clsdf_status clsdf_scene_pose(const clsdf_scene* scene, int64_t body, clsdf_pose* pose);
/* The rule in use, never CLSDF_SIGN_AUTOMATIC. */
CLSDF_API clsdf_status clsdf_scene_sign(const clsdf_scene* scene, int64_t body, int32_t* rule);
/* 1: a body that is on has a sign. */
CLSDF_API clsdf_status clsdf_scene_has_sign(const clsdf_scene* scene, int32_t* has_sign);
/* Around the bodies that are on, where they are. */
CLSDF_API clsdf_status clsdf_scene_box(const clsdf_scene* scene, clsdf_box* box);
/* The memory that is kept of all meshes. */
CLSDF_API clsdf_status clsdf_scene_memory(const clsdf_scene* scene, clsdf_kept_memory* memory);
/* The outer surface of the bodies that are on, where they are: faces are cut where bodies meet, and what lies in
 * another body is left out. Distances to this mesh are those to the union, within overlaps, too, where those of the
 * scene are only a lower bound of the depth. It is made anew by each call: for bodies at rest. The index base is the
 * scene's; of `call`, which may be null, should_stop counts; `report`, which may be null, counts triangles of the
 * bodies' own outer surfaces. CLSDF_UNSUPPORTED if a body has no outer surface, as an open one. */
CLSDF_API clsdf_status clsdf_scene_outer(const clsdf_scene* scene, const clsdf_call_options* call, clsdf_mesh** outer,
                                         clsdf_outer_report* report);

/* As clsdf_compute() and clsdf_compute_field(): the least of the bodies' signed distances, with the outputs of the body
 * that has it, and CLSDF_BODY, which count from index_base. A sample in the depth of a body, beyond its band, is beyond
 * the band of the field. Each body has the bytes of a transform of its own that was moved there. Fields of a scene take
 * turns. CLSDF_UNSUPPORTED for CLSDF_SITE and CLSDF_BARYCENTRIC of a scene with CLSDF_SURFACE_OUTER. */
CLSDF_API clsdf_status clsdf_scene_compute(const clsdf_scene* scene, const clsdf_grid* grid, const clsdf_band* band,
                                           const clsdf_target* targets, int64_t target_count,
                                           const clsdf_call_options* call, clsdf_statistics* statistics);
CLSDF_API clsdf_status clsdf_scene_compute_field(const clsdf_scene* scene, const clsdf_grid* grid,
                                                 const clsdf_band* band, uint32_t outputs,
                                                 const clsdf_call_options* call, clsdf_statistics* statistics,
                                                 clsdf_field** field);

/* As clsdf_query(), of the body whose signed distance is the least; closest points, gradients and offsets are in the
 * scene's coordinates, triangles and sites those of its mesh; CLSDF_BODY says which body. `own`, which may be null, has
 * an item for each point: 1 if the distance is that of the union of the bodies, 0 if the union's surface may be farther
 * away. */
CLSDF_API clsdf_status clsdf_scene_query(const clsdf_scene* scene, const clsdf_array* points, double half_width,
                                         const clsdf_target* targets, int64_t target_count, uint8_t* own,
                                         const clsdf_call_options* call, clsdf_statistics* statistics);
/* The outputs of pairs of a point and a body, pairs[count][2], by that body alone; targets have `count` items. */
CLSDF_API clsdf_status clsdf_scene_query_pairs(const clsdf_scene* scene, const clsdf_array* points,
                                               const uint32_t* pairs, int64_t count, double half_width,
                                               const clsdf_target* targets, int64_t target_count,
                                               const clsdf_call_options* call, clsdf_statistics* statistics);
/* 1 for each point that is inside a body, else 0. A point on the surface of a body is not inside this one. */
CLSDF_API clsdf_status clsdf_scene_contains(const clsdf_scene* scene, const clsdf_array* points, uint8_t* inside,
                                            const clsdf_call_options* call);
/* The sum of the bodies' winding numbers, in their order, for each point. */
CLSDF_API clsdf_status clsdf_scene_winding(const clsdf_scene* scene, const clsdf_array* points, double* results,
                                           const clsdf_call_options* call);
/* The places of `count` boxes: CLSDF_INSIDE one of the bodies, CLSDF_OUTSIDE all of them (CLSDF_BEYOND if no body has a
 * sign), else CLSDF_WITHIN. */
CLSDF_API clsdf_status clsdf_scene_classify(const clsdf_scene* scene, const clsdf_box* boxes, int64_t count,
                                            double half_width, uint8_t* places);

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

/* The caller's arrays for the edges of a grid along x, y and z, packed on the host; each may be null. There is one edge
 * less than samples on the axis; x fastest. No two of them may overlap. */
typedef struct clsdf_crossing_arrays {
    double* coordinates[3]; /* along the axis, of the first wall from the end outside; NaN if the sides agree */
    uint32_t* triangles[3]; /* from the index base on; 0xFFFFFFFF plus the base: none */
    uint32_t* counts[3];    /* walls on the edge, also where the sides agree */
    uint8_t* inside;        /* for each sample: 1 if it is inside, else 0 */
} clsdf_crossing_arrays;

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
/* The places where edges of a grid between neighbouring samples meet walls. */
CLSDF_API clsdf_status clsdf_crossings(const clsdf_transform* transform, const clsdf_grid* grid,
                                       const clsdf_crossing_arrays* arrays, const clsdf_call_options* call,
                                       clsdf_statistics* statistics);

/* What is asked about rays, and the arrays for the results, an item for each ray. An array without memory is not
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

/* The box of the vertices in use, at their present positions. */
CLSDF_API clsdf_status clsdf_transform_box(const clsdf_transform* transform, clsdf_box* box);
CLSDF_API clsdf_status clsdf_transform_topology(const clsdf_transform* transform, clsdf_topology* topology);
/* The rule in use, never automatic. */
CLSDF_API clsdf_status clsdf_transform_sign(const clsdf_transform* transform, int32_t* rule);
CLSDF_API clsdf_status clsdf_transform_index_base(const clsdf_transform* transform, int32_t* index_base);
/* A new reference. */
CLSDF_API clsdf_status clsdf_transform_device(const clsdf_transform* transform, clsdf_device** device);
CLSDF_API clsdf_status clsdf_transform_memory(const clsdf_transform* transform, clsdf_kept_memory* memory);
/* Builds and tests the programs that such a field needs. Computations do it by themselves. */
CLSDF_API clsdf_status clsdf_transform_compile(const clsdf_transform* transform, const clsdf_grid* grid,
                                               const clsdf_band* band, uint32_t outputs, const clsdf_call_options* call,
                                               clsdf_statistics* statistics);

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

/* ---- Plans ---- */

/* A plan has what it needs and may outlive the transform. Threads: one, in every call with a plan. */

/* A plan of one grid, without targets: clsdf_plan_enqueue_to() gives them, packed and aligned. With index base 1 the
 * triangle is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_plan_create(const clsdf_transform* transform, const clsdf_grid* grid,
                                         const clsdf_band* band, uint32_t outputs, const clsdf_call_options* call,
                                         clsdf_plan** plan);
/* Plans of boxes, into buffers of the device's context, which must outlive them. The structs need not. */
CLSDF_API clsdf_status clsdf_plan_create_requests(const clsdf_transform* transform, const clsdf_request* requests,
                                                  int64_t count, const clsdf_call_options* call, clsdf_plan** plan);
CLSDF_API clsdf_status clsdf_plan_create_blocks(const clsdf_transform* transform, const clsdf_block_set* blocks,
                                                const clsdf_call_options* call, clsdf_plan** plan);
/* The device memory of such a plan, which is made and given back. */
CLSDF_API clsdf_status clsdf_plan_bytes_requests(const clsdf_transform* transform, const clsdf_request* requests,
                                                 int64_t count, const clsdf_call_options* call, int64_t* bytes);
CLSDF_API clsdf_status clsdf_plan_bytes_blocks(const clsdf_transform* transform, const clsdf_block_set* blocks,
                                               const clsdf_call_options* call, int64_t* bytes);

/* Enqueues all requests on a cl_command_queue (null: the device's own) after the events. Never blocks. *done, if not
 * null, gets the cl_event of the end, which the caller releases; null after an error. */
CLSDF_API clsdf_status clsdf_plan_enqueue(clsdf_plan* plan, void* queue, void* const* wait_list, int64_t wait_count,
                                          void** done);
/* One run into other targets: targets[count], one for each request. */
CLSDF_API clsdf_status clsdf_plan_enqueue_to(clsdf_plan* plan, void* queue, const clsdf_targets* targets, int64_t count,
                                             void* const* wait_list, int64_t wait_count, void** done);
/* Prepares the next runs for the present positions of the transform, which made the plan or has its device, and has its
 * index base. Blocks.
 * After an error the plan must be updated again, but for requests or grids that are refused. */
CLSDF_API clsdf_status clsdf_plan_update(clsdf_plan* plan, const clsdf_transform* transform,
                                         const clsdf_call_options* call);
/* The same with a grid for each request. */
CLSDF_API clsdf_status clsdf_plan_update_grids(clsdf_plan* plan, const clsdf_transform* transform,
                                               const clsdf_grid* grids, int64_t count, const clsdf_call_options* call);
/* The same with other requests, any number. */
CLSDF_API clsdf_status clsdf_plan_update_requests(clsdf_plan* plan, const clsdf_transform* transform,
                                                  const clsdf_request* requests, int64_t count,
                                                  const clsdf_call_options* call);
CLSDF_API clsdf_status clsdf_plan_update_blocks(clsdf_plan* plan, const clsdf_transform* transform,
                                                const clsdf_block_set* blocks, const clsdf_call_options* call);
CLSDF_API clsdf_status clsdf_plan_sign(const clsdf_plan* plan, int32_t* rule);
/* Of making or updating it. */
CLSDF_API clsdf_status clsdf_plan_statistics(const clsdf_plan* plan, clsdf_statistics* statistics);
CLSDF_API clsdf_status clsdf_plan_request_count(const clsdf_plan* plan, int64_t* count);
/* Request `index` from 0. Its targets: the first `size` of *target_count. Pointers may be null. */
CLSDF_API clsdf_status clsdf_plan_request(const clsdf_plan* plan, int64_t index, clsdf_grid* grid, clsdf_band* band,
                                          clsdf_target* targets, int64_t size, int64_t* target_count);

/* A sparse field that stays in memory of the device: counts, bricks, runs and values have the bytes and the order of
 * clsdf_compute_sparse(), and a run reads nothing back. room: how many bricks and runs a run has room for. With index
 * base 1 the triangle is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_sparse_plan_create(const clsdf_transform* transform, const clsdf_sparse_request* request,
                                                const clsdf_sparse_counts* room, const clsdf_call_options* call,
                                                clsdf_sparse_plan** plan);
/* As clsdf_plan_enqueue(), into this memory. */
CLSDF_API clsdf_status clsdf_sparse_plan_enqueue(clsdf_sparse_plan* plan, void* queue,
                                                 const clsdf_sparse_buffers* buffers, void* const* wait_list,
                                                 int64_t wait_count, void** done);
/* As clsdf_plan_update(). */
CLSDF_API clsdf_status clsdf_sparse_plan_update(clsdf_sparse_plan* plan, const clsdf_transform* transform,
                                                const clsdf_call_options* call);
/* The same with another grid, band and outputs, and with other room. */
CLSDF_API clsdf_status clsdf_sparse_plan_update_request(clsdf_sparse_plan* plan, const clsdf_transform* transform,
                                                        const clsdf_sparse_request* request,
                                                        const clsdf_sparse_counts* room,
                                                        const clsdf_call_options* call);
/* Its field and its room. Pointers may be null. */
CLSDF_API clsdf_status clsdf_sparse_plan_request(const clsdf_sparse_plan* plan, clsdf_sparse_request* request,
                                                 clsdf_sparse_counts* room);
CLSDF_API clsdf_status clsdf_sparse_plan_sign(const clsdf_sparse_plan* plan, int32_t* rule);
/* Of making or updating it. */
CLSDF_API clsdf_status clsdf_sparse_plan_statistics(const clsdf_sparse_plan* plan, clsdf_statistics* statistics);

/* A plan of the links of a grid, whose runs write at most `room` rows into memory of the device, with the bytes of
 * clsdf_links(). The links are found when the plan is made or updated, on a GPU by kernels; a run reads nothing back.
 * With index base 1 triangles are CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_link_plan_create(const clsdf_transform* transform, const clsdf_grid* grid,
                                              const int32_t* directions, int64_t direction_count, int64_t room,
                                              const clsdf_link_options* options, const clsdf_call_options* call,
                                              clsdf_link_plan** plan);
/* As clsdf_plan_enqueue(), into this memory. */
CLSDF_API clsdf_status clsdf_link_plan_enqueue(clsdf_link_plan* plan, void* queue, const clsdf_link_buffers* buffers,
                                               void* const* wait_list, int64_t wait_count, void** done);
/* As clsdf_plan_update(); after an error the plan is as it was. */
CLSDF_API clsdf_status clsdf_link_plan_update(clsdf_link_plan* plan, const clsdf_transform* transform,
                                              const clsdf_call_options* call);
/* The same with another grid and other room. */
CLSDF_API clsdf_status clsdf_link_plan_update_grid(clsdf_link_plan* plan, const clsdf_transform* transform,
                                                   const clsdf_grid* grid, int64_t room,
                                                   const clsdf_call_options* call);
/* Pointers may be null. */
CLSDF_API clsdf_status clsdf_link_plan_grid(const clsdf_link_plan* plan, clsdf_grid* grid, int64_t* room);
CLSDF_API clsdf_status clsdf_link_plan_sign(const clsdf_link_plan* plan, int32_t* rule);
/* Of making or updating it. */
CLSDF_API clsdf_status clsdf_link_plan_statistics(const clsdf_link_plan* plan, clsdf_statistics* statistics);

/* A plan of points: at most `count` of them at a time, in memory of the device. Its own memory is about 200 bytes a
 * point, of at most 2^20 points. With index base 1 the triangle is CLSDF_UNSUPPORTED. A mesh with a coordinate that is
 * not 0 and, in units of about 1/256 of its longest side, smaller than 2^-300 or greater than 2^300 is
 * CLSDF_INVALID_ARGUMENT. */
CLSDF_API clsdf_status clsdf_point_plan_create(const clsdf_transform* transform, int64_t count, double half_width,
                                               uint32_t outputs, const clsdf_call_options* call,
                                               clsdf_point_plan** plan);
/* Enqueues the search for points on a cl_command_queue (null: the device's own) after the events. Never blocks, and
 * nothing comes to the host; the bytes are those of clsdf_query(). Points, targets and status are buffers of the
 * device's context, of any offset and strides, one target for each output of the plan. status, which may be null: a
 * byte of each point, CLSDF_FOUND or why it has no distance. *done as of clsdf_plan_enqueue(). */
CLSDF_API clsdf_status clsdf_point_plan_enqueue(clsdf_point_plan* plan, void* queue, const clsdf_array* points,
                                                const clsdf_target* targets, int64_t target_count,
                                                const clsdf_array* status, void* const* wait_list, int64_t wait_count,
                                                void** done);
/* Prepares the next runs for the present positions of the transform, which made the plan or has its device, and has its
 * index base. Blocks. After an error the plan is as it was. */
CLSDF_API clsdf_status clsdf_point_plan_update(clsdf_point_plan* plan, const clsdf_transform* transform,
                                               const clsdf_call_options* call);
/* The most points of a run. */
CLSDF_API clsdf_status clsdf_point_plan_count(const clsdf_point_plan* plan, int64_t* count);
CLSDF_API clsdf_status clsdf_point_plan_sign(const clsdf_point_plan* plan, int32_t* rule);
/* Of making or updating it. */
CLSDF_API clsdf_status clsdf_point_plan_statistics(const clsdf_point_plan* plan, clsdf_statistics* statistics);

/* ---- Memory of CUDA ---- */

/* Memory of CUDA as inputs and outputs. Nothing of CUDA is needed to compile or to link: NVIDIA's driver, libcuda.so.1,
 * is opened by clsdf_cuda_device_create(). Addresses are those of cudaMalloc() or cuMemAlloc(). A stream is a
 * cudaStream_t or a CUstream; null is CUDA's default stream. CUDA's current context is as before after each call. The
 * message of a call of CUDA that fails has its name and its code: CLSDF_DEVICE_FAILURE or CLSDF_OUT_OF_MEMORY. A
 * process that was forked must neither use nor release these handles. */

/* The use of an array in a call. */
#define CLSDF_CUDA_READ 0
#define CLSDF_CUDA_WRITE 1  /* every byte gets a new value */
#define CLSDF_CUDA_UPDATE 2 /* some bytes keep their value, as those between the values of an array with strides */

/* An array in memory of CUDA: all bytes from its lowest one to its highest one. */
typedef struct clsdf_cuda_array {
    uint64_t address; /* of the lowest byte */
    int64_t bytes;    /* at least 1 */
    /* The call comes after what this stream had to do before it; what the stream has to do later comes after the call.
     */
    void* stream;
    const char* name; /* in messages; null: "the array" */
    int32_t access;   /* CLSDF_CUDA_READ ... */
    int32_t reserved;
} clsdf_cuda_array;

/* Finds CUDA's device by its UUID, and retains its primary context, that of cudaMalloc(). CLSDF_UNSUPPORTED if the
 * driver of OpenCL shares no memory, CLSDF_NO_DEVICE if CUDA has no driver or does not list the device. Threads: any
 * number, in every call with a clsdf_cuda_device or a clsdf_cuda_memory. */
CLSDF_API clsdf_status clsdf_cuda_device_create(const clsdf_device* device, clsdf_cuda_device** cuda_device);
/* CUDA's number of the device, as of cudaSetDevice(). */
CLSDF_API clsdf_status clsdf_cuda_device_ordinal(const clsdf_cuda_device* device, int32_t* ordinal);
/* 1: CUDA and OpenCL wait for each other's semaphores, so that the calls around a plan's run do not block. 0: they do.
 * Tried out at the first call, which may take a second. */
CLSDF_API clsdf_status clsdf_cuda_device_has_semaphores(const clsdf_cuda_device* device, int32_t* has_semaphores);
/* Frees memory that is kept for copies and that no call uses. *bytes, which may be null: how much. */
CLSDF_API clsdf_status clsdf_cuda_device_release_memory(const clsdf_cuda_device* device, int64_t* bytes);

/* Memory that CUDA and OpenCL both have, of undefined content. Arrays that lie in it are used without a copy by calls
 * of the same clsdf_device, which take turns. */
CLSDF_API clsdf_status clsdf_cuda_memory_create(const clsdf_cuda_device* device, int64_t bytes,
                                                clsdf_cuda_memory** memory);
/* Its address for CUDA, its bytes, at most 2 MiB more than asked for, and its cl_mem, which lives as long as the
 * memory. Commands of your own may use the cl_mem only between clEnqueueAcquireExternalMemObjectsKHR and
 * clEnqueueReleaseExternalMemObjectsKHR. Each pointer may be null. */
CLSDF_API clsdf_status clsdf_cuda_memory_place(const clsdf_cuda_memory* memory, uint64_t* address, int64_t* bytes,
                                               void** buffer);

/* The arrays in memory of CUDA that a call uses, as buffers of OpenCL. Arrays in a clsdf_cuda_memory are used there.
 * All others are copied within the GPU, to and from memory that the clsdf_cuda_device keeps; those that overlap stay as
 * they lie to each other. No other stream may write to an array's bytes during the call. CLSDF_INVALID_ARGUMENT for no
 * array, for one on another device of CUDA or at an address that its driver does not know, and for one that reaches
 * beyond the clsdf_cuda_memory in which it begins. Threads: one, in every call with a clsdf_cuda_arrays.
 *
 *     clsdf_cuda_arrays_create(gpu, used, 2, &arrays);
 *     clsdf_cuda_arrays_get(arrays, 0, CLSDF_FLOAT32, vertices, &positions);
 *     clsdf_cuda_arrays_get(arrays, 1, CLSDF_FLOAT32, samples, &target.array);
 *     clsdf_cuda_arrays_begin(arrays);
 *     clsdf_transform_set_positions(transform, &positions, NULL);
 *     clsdf_compute(transform, &grid, &band, &target, 1, NULL, NULL);
 *     clsdf_cuda_arrays_end(arrays);
 */
CLSDF_API clsdf_status clsdf_cuda_arrays_create(const clsdf_cuda_device* device, const clsdf_cuda_array* used,
                                                int64_t count, clsdf_cuda_arrays** arrays);
/* Array `index`, from 0, as packed items in its buffer: an array or a target for calls, whose strides may be set. */
CLSDF_API clsdf_status clsdf_cuda_arrays_get(const clsdf_cuda_arrays* arrays, int64_t index, int32_t type,
                                             int64_t count, clsdf_array* array);
/* Around calls that block, on one thread. The first waits for the streams, and the arrays are OpenCL's until the
 * second. The results arrive in the order of the streams. */
CLSDF_API clsdf_status clsdf_cuda_arrays_begin(clsdf_cuda_arrays* arrays);
CLSDF_API clsdf_status clsdf_cuda_arrays_end(clsdf_cuda_arrays* arrays);
/* Around a run of a plan on this queue (null: the device's own), on one thread. *event is for the run's wait list; it
 * comes after the events of `wait_list`, and the arrays keep it until the next begin. `done` is the event of the run's
 * end, which stays yours; the streams wait for it. May be repeated at once. */
CLSDF_API clsdf_status clsdf_cuda_arrays_begin_run(clsdf_cuda_arrays* arrays, void* queue, void* const* wait_list,
                                                   int64_t wait_count, void** event);
CLSDF_API clsdf_status clsdf_cuda_arrays_end_run(clsdf_cuda_arrays* arrays, void* done);
/* After an error between begin and end, on its thread: waits for all that was enqueued, and gives the memory back to
 * CUDA. Arrays that are written to are undefined then. Without effect after the end. */
CLSDF_API clsdf_status clsdf_cuda_arrays_abandon(clsdf_cuda_arrays* arrays);
/* Later calls follow these streams in place of those of the arrays. */
CLSDF_API clsdf_status clsdf_cuda_arrays_follow(clsdf_cuda_arrays* arrays, void* const* streams, int64_t count);

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

/* ---- Files of points ---- */

/* Reads points from .npy (n, 3), .csv (columns x, y, z) or .ply. */
CLSDF_API clsdf_status clsdf_points_read(const char* path, clsdf_points** points);
/* double[count][3], in the handle's memory. Threads: any number. */
CLSDF_API clsdf_status clsdf_points_data(const clsdf_points* points, const double** positions, int64_t* count);
/* Writes what clsdf_query() found, a row for each point, by the file's ending: .npy, .csv or .ply. `positions` is
 * double[count][3]; `results` are packed arrays on the host of the types that clsdf_output_describe() states. `outputs`
 * is needed only without points. Triangles are written as they are. */
CLSDF_API clsdf_status clsdf_points_write(const double* positions, int64_t count, const clsdf_target* results,
                                          int64_t result_count, const char* path, uint32_t outputs);
/* The error that clsdf_points_write() would give for the ending or the folder. */
CLSDF_API clsdf_status clsdf_points_check_path(const char* path);
/* For a program that is about to end: removes the unfinished files that clsdf_mesh_write() and clsdf_points_write() are
 * writing, on all threads. The program must end now. Not for signal handlers. With clsdf_io.h, call
 * clsdf_io_abandon_unfinished_files() instead. */
CLSDF_API void clsdf_abandon_unfinished_files(void);

#ifdef __cplusplus
}
#endif

#endif
