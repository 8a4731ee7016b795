#pragma once

#include <cstddef>  // for __GLIBC__

/// In front of a function: it is compiled for several vector widths, and the program takes the one its processor has.
/// Without contraction to fused multiply-adds all of them give the same bytes. What it calls must be inlined.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && defined(__OPTIMIZE__)
#define CLSDF_SEVERAL_TARGETS __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define CLSDF_SEVERAL_TARGETS
#endif
