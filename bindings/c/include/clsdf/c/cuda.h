#ifndef CLSDF_C_CUDA_H
#define CLSDF_C_CUDA_H

/*
 * Memory of CUDA as inputs and outputs.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "arrays.h"

#ifdef __cplusplus
extern "C" {
#endif

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

#ifdef __cplusplus
}
#endif

#endif
