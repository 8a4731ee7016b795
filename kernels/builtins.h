// INLINE, LESSER, GREATER, the lowest bit, prefetch: forms that compile to single instructions.
#ifndef CLSDF_BUILTINS_H
#define CLSDF_BUILTINS_H

#include "layout.h"

// With vectors, arguments in memory cost more than these functions' own work. With LANES 1, compilers for GPUs inline
// by themselves; "static" keeps a body for the calls of those that do not. The host defines PLAIN_INLINE for a compiler
// that needs C99's "inline" alone.
#if LANES != 1
#define INLINE static inline __attribute__((always_inline))
#elif defined(PLAIN_INLINE)
#define INLINE inline
#else
#define INLINE static inline
#endif

// A comparison with a select; fmin and fmax take more instructions, because they treat NaN.
#define LESSER(a, b) ((a) < (b) ? (a) : (b))
#define GREATER(a, b) ((a) > (b) ? (a) : (b))

// Whether the compiler has a built-in function, which the instruction set alone does not promise.
#ifdef __has_builtin
#define HAS_BUILTIN(name) __has_builtin(name)
#else
#define HAS_BUILTIN(name) 0
#endif

// The lowest bit that is set, of which there is one. (OpenCL C has ctz() from version 2.0 on; without, it takes four
// instructions for one. On processors alone: other compilers may accept a built-in and then not know what to make of
// it, as oclgrind's does.)
#if (defined(__x86_64__) || defined(__aarch64__)) && HAS_BUILTIN(__builtin_ctz) && HAS_BUILTIN(__builtin_ctzl)
static inline uint lowest_bit(uint bits) {
    return (uint)__builtin_ctz(bits);
}
static inline uint lowest_bit_of_long(ulong bits) {
    return (uint)__builtin_ctzl(bits);
}
#else
static inline uint lowest_bit(uint bits) {
    return 31 - clz(bits & (0 - bits));
}
static inline uint lowest_bit_of_long(ulong bits) {
    return 63 - (uint)clz(bits & (0 - bits));
}
#endif

// Prefetch of memory ahead of its use. OpenCL's own prefetch() does nothing in PoCL; on GPUs these functions do
// nothing.

// Prefetches a cache line, which need not be in our buffers: to the L2, to the L1 cache.
#if (defined(__x86_64__) || defined(__aarch64__)) && HAS_BUILTIN(__builtin_prefetch)
#define PREFETCH(address, locality) __builtin_prefetch((__private const void*)(size_t)(address), 0, locality)
#else
#define PREFETCH(address, locality)
#endif
static inline void prefetch_line(__global const void* at) {
    PREFETCH(at, 2);
}
static inline void prefetch_line_to_l1(__global const void* at) {
    PREFETCH(at, 3);
}

// A list's polyhedra lie scattered over more memory than the inner caches hold.
static inline void prefetch_record(__global const Polyhedron* p) {
    for (uint line = 0; line < sizeof(Polyhedron); line += 64) prefetch_line((__global const uchar*)p + line);
}
static inline void prefetch_foot(__global const Polyhedron* p) {
    prefetch_line(p->foot);
    prefetch_line(&p->origin_z);
}

#endif
