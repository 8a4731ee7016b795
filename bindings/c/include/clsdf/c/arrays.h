#ifndef CLSDF_C_ARRAYS_H
#define CLSDF_C_ARRAYS_H

/*
 * Arrays in the caller's memory, and outputs.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "basics.h"

#ifdef __cplusplus
extern "C" {
#endif

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

#ifdef __cplusplus
}
#endif

#endif
