// The device's own limits, for the benchmark: how fast it stores, how fast it multiplies and adds, and what an empty
// launch costs.
//
// Compile-time options: FLOATS, 4, 8 or 16: floats in a vector; LANES (simd.h), 1.

#include "simd.h"

#if FLOATS == 16
typedef float16 floats;
#define STORE(value, n, target) vstore16(value, n, target)
#elif FLOATS == 8
typedef float8 floats;
#define STORE(value, n, target) vstore8(value, n, target)
#else
typedef float4 floats;
#define STORE(value, n, target) vstore4(value, n, target)
#endif

// Work-item i stores vectors i * first, i * first + step, ...: a range of its own on a processor (step 1), interleaved
// with its neighbours on a GPU (first 1, step the global size).
__kernel void bench_store(__global float* target, ulong count, ulong first, ulong step, float value) {
    const floats vector = (floats)value;
    ulong n = get_global_id(0) * first;
    for (ulong m = 0; m < count; ++m, n += step) STORE(vector, n, target);
}

#ifdef STREAM
// The same past the caches; n counts vectors. `target` is aligned to one.
__kernel void bench_store_past_caches(__global float* target, ulong count, ulong first, ulong step, float value) {
    const floats vector = (floats)value;
    ulong n = get_global_id(0) * first;
    for (ulong m = 0; m < count; ++m, n += step) STREAM(vector, (__global floats*)target + n);
}
#endif

// Twelve independent chains, enough to hide the latency of fma on every device we know; 12 * FLOATS * 2 operations
// a round. The values stay finite, and the sum keeps the compiler from leaving them out.
__kernel void bench_fma(__global float* target, int rounds, float factor, float term) {
    const floats f = (floats)factor, t = (floats)term;
    floats a0 = (floats)(float)get_global_id(0), a1 = a0 + 1, a2 = a0 + 2, a3 = a0 + 3, a4 = a0 + 4, a5 = a0 + 5,
           a6 = a0 + 6, a7 = a0 + 7, a8 = a0 + 8, a9 = a0 + 9, a10 = a0 + 10, a11 = a0 + 11;
    for (int round = 0; round < rounds; ++round) {
        a0 = fma(a0, f, t);
        a1 = fma(a1, f, t);
        a2 = fma(a2, f, t);
        a3 = fma(a3, f, t);
        a4 = fma(a4, f, t);
        a5 = fma(a5, f, t);
        a6 = fma(a6, f, t);
        a7 = fma(a7, f, t);
        a8 = fma(a8, f, t);
        a9 = fma(a9, f, t);
        a10 = fma(a10, f, t);
        a11 = fma(a11, f, t);
    }
    STORE(a0 + a1 + a2 + a3 + a4 + a5 + a6 + a7 + a8 + a9 + a10 + a11, get_global_id(0), target);
}

__kernel void bench_nothing(__global float* target) {
    if (get_global_id(0) > 0) target[0] = 0;
}
