// Sets of up to 64 things as bits of a number.
#ifndef CLSDF_BITS_H
#define CLSDF_BITS_H

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

#endif
