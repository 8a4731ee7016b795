// The nearest triangle of a sample so far, as what a scan in any order ends with: the least of an ordered key, the bits
// of the squared distance above the triangle's index. Squared distances are not negative, so their bits are in their
// order; equal ones go to the lower triangle.
//   KEY_64: one 64-bit number, by 64-bit atomics.
//   else: two 32-bit numbers, in two passes: the least distances first, then the least triangle among those that have
//   them. Without NEAREST the first pass is all.
#ifndef CLSDF_SLICES_KEY_H
#define CLSDF_SLICES_KEY_H

#ifdef KEY_64
#pragma OPENCL EXTENSION cl_khr_int64_extended_atomics : enable
#endif

#ifdef KEY_64
#define KEY_PARAMETERS __global ulong* keys
#define KEY_ARGUMENTS keys
#else
#define KEY_PARAMETERS __global uint *squares, __global uint *triangles, int pass
#define KEY_ARGUMENTS squares, triangles, pass
#endif

static inline void propose(KEY_PARAMETERS, size_t sample, float squared, uint triangle) {
#ifdef KEY_64
    atom_min(keys + sample, (ulong)as_uint(squared) << 32 | triangle);
#else
    if (pass == 0)
        atomic_min(squares + sample, as_uint(squared));
    else if (as_uint(squared) == squares[sample])
        atomic_min(triangles + sample, triangle);
#endif
}

static inline uint2 square_and_triangle(KEY_PARAMETERS, size_t sample) {
#ifdef KEY_64
    return (uint2)((uint)(keys[sample] >> 32), (uint)keys[sample]);
#elif defined(NEAREST)
    return (uint2)(squares[sample], triangles[sample]);
#else
    return (uint2)(squares[sample], 0u);
#endif
}

#endif
