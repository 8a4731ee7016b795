// INLINE, LESSER, GREATER: forms that compile to single instructions.
#ifndef CLSDF_INLINE_H
#define CLSDF_INLINE_H

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

#endif
