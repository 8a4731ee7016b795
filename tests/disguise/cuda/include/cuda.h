#ifndef CLSDF_CUDA_STAND_IN_CUDA_H
#define CLSDF_CUDA_STAND_IN_CUDA_H

/* The part of NVIDIA's cuda.h that the programs of clsdf's tests and examples use. They are compiled with the real one
 * in the same way. Names and types are those of CUDA 12; the functions are the stand-in's (driver.hpp). */

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef int CUresult;
#define CUDA_SUCCESS 0
typedef int CUdevice;
typedef unsigned long long CUdeviceptr;
typedef struct CUctx_st* CUcontext;
typedef struct CUstream_st* CUstream;
typedef void (*CUhostFn)(void* user);
#define CU_STREAM_NON_BLOCKING 1

#define cuDevicePrimaryCtxRelease cuDevicePrimaryCtxRelease_v2
#define cuCtxPushCurrent cuCtxPushCurrent_v2
#define cuCtxPopCurrent cuCtxPopCurrent_v2
#define cuMemAlloc cuMemAlloc_v2
#define cuMemFree cuMemFree_v2
#define cuMemcpyHtoDAsync cuMemcpyHtoDAsync_v2
#define cuMemcpyDtoHAsync cuMemcpyDtoHAsync_v2
#define cuStreamDestroy cuStreamDestroy_v2

CUresult cuInit(unsigned int flags);
CUresult cuDevicePrimaryCtxRetain(CUcontext* context, CUdevice device);
CUresult cuDevicePrimaryCtxRelease(CUdevice device);
CUresult cuCtxPushCurrent(CUcontext context);
CUresult cuCtxPopCurrent(CUcontext* context);
CUresult cuCtxGetCurrent(CUcontext* context);
CUresult cuMemAlloc(CUdeviceptr* address, size_t bytes);
CUresult cuMemFree(CUdeviceptr address);
CUresult cuMemcpyHtoDAsync(CUdeviceptr to, const void* from, size_t bytes, CUstream stream);
CUresult cuMemcpyDtoHAsync(void* to, CUdeviceptr from, size_t bytes, CUstream stream);
CUresult cuStreamCreate(CUstream* stream, unsigned int flags);
CUresult cuStreamDestroy(CUstream stream);
CUresult cuStreamSynchronize(CUstream stream);
CUresult cuLaunchHostFunc(CUstream stream, CUhostFn function, void* user);

/* The stand-in alone has these: owners of a device's primary context, how often a function was called, and which call
 * is late. */
int cuda_stand_in_owners(int device);
int cuda_stand_in_calls(const char* function);
/* That call of the function, counted from 1, begins a second later. */
void cuda_stand_in_delay(const char* function, int number);

#ifdef __cplusplus
}
#endif

#endif
