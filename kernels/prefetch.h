// Prefetch of memory ahead of its use. OpenCL's own prefetch() does nothing in PoCL; on GPUs these functions do
// nothing.
#ifndef CLSDF_PREFETCH_H
#define CLSDF_PREFETCH_H

#include "bits.h"
#include "layout.h"

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
