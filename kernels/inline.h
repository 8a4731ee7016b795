// How small functions and comparisons are written, so that compilers make of them what is meant.
#ifndef CLSDF_INLINE_H
#define CLSDF_INLINE_H

// Arguments in memory cost more than these functions' own work. Where a work-item is a lane, compilers for GPUs inline
// everything by themselves; forced to, or free to by "static", oclgrind's leaves in the code what it does not know.
#if LANES == 1
#define INLINE inline
#else
#define INLINE static inline __attribute__((always_inline))
#endif

// A comparison with a select: fmin and fmax cost four times as much, for the sake of NaN.
#define LESSER(a, b) ((a) < (b) ? (a) : (b))
#define GREATER(a, b) ((a) > (b) ? (a) : (b))

#endif
