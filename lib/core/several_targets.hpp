#pragma once

#include <cstddef>  // for __GLIBC__

/// An attribute of a function: it is compiled for several vector widths, and the program picks the one of its
/// processor. All give the same bytes, because multiply-adds are not fused. Functions that it calls must be inlined.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && defined(__OPTIMIZE__)
#define CLSDF_SEVERAL_TARGETS __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define CLSDF_SEVERAL_TARGETS
#endif
