// Explicit vectors: on a processor the loop over work-items around an inner loop is not vectorised, so one work-item
// works on LANES samples or blocks at once: 16 or 8, by the device's width. On a GPU a work-item is a lane itself:
// LANES is 1.
#ifndef CLSDF_LANES_H
#define CLSDF_LANES_H

#include "builtins.h"

#if LANES == 16
typedef float16 floatL;
typedef double16 doubleL;
typedef long16 longL;
typedef int16 intL;
typedef uint16 uintL;
typedef ulong16 ulongL;
#define LANE_BITS 0xFFFFu
#define LANE_NUMBERS (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
#define load_lanes vload16
#define convert_floatL convert_float16
#define convert_intL convert_int16
#define convert_doubleL convert_double16
#define convert_longL convert_long16
#define as_uintL as_uint16
#define as_ulong_halfL as_ulong8
#define as_intL as_int16
#define as_floatL as_float16
#elif LANES == 8
typedef float8 floatL;
typedef double8 doubleL;
typedef long8 longL;
typedef int8 intL;
typedef uint8 uintL;
typedef ulong8 ulongL;
#define LANE_BITS 0xFFu
#define LANE_NUMBERS (uint8)(0, 1, 2, 3, 4, 5, 6, 7)
#define load_lanes vload8
#define convert_floatL convert_float8
#define convert_intL convert_int8
#define convert_doubleL convert_double8
#define convert_longL convert_long8
#define as_uintL as_uint8
#define as_ulong_halfL as_ulong4
#define as_intL as_int8
#define as_floatL as_float8
#elif LANES == 1
typedef float floatL;
typedef double doubleL;
typedef int longL;
typedef int intL;
typedef uint uintL;
#define LANE_BITS 1u
#define LANE_NUMBERS 0u
#define load_lanes(offset, p) ((p)[offset])
#define convert_floatL convert_float
#define convert_doubleL convert_double
#endif

#if LANES == 1
#define store_lanes(value, offset, p) ((p)[offset] = (value))
#elif defined(__clang__)
// PoCL's vstore16 is three stores and two shuffles, its vstore8 two and one; a vector without alignment is one store.
#define DEFINE_STORE(name, Vector, Element, count, space)                                             \
    typedef Vector __attribute__((aligned(4))) Unaligned_##name##_##Vector##_##space;                 \
    static inline __attribute__((overloadable, always_inline)) void name(Vector value, size_t offset, \
                                                                         __##space Element* p) {      \
        *(__##space Unaligned_##name##_##Vector##_##space*)(p + count * offset) = value;              \
    }
DEFINE_STORE(store_lanes, floatL, float, LANES, private)
DEFINE_STORE(store_lanes, floatL, float, LANES, global)
DEFINE_STORE(store_lanes, uintL, uint, LANES, private)
DEFINE_STORE(store_lanes, uintL, uint, LANES, global)
DEFINE_STORE(store_eight, uint8, uint, 8, private)
DEFINE_STORE(store_eight, uint8, uint, 8, global)
DEFINE_STORE(store_eight_floats, float8, float, 8, private)
DEFINE_STORE(store_eight_floats, float8, float, 8, global)
DEFINE_STORE(store_eight_doubles, double8, double, 8, private)
DEFINE_STORE(store_eight_doubles, double8, double, 8, global)
#undef DEFINE_STORE
#elif LANES == 16
#define store_lanes vstore16
#define store_eight vstore8
#define store_eight_floats vstore8
#define store_eight_doubles vstore8
#else
#define store_lanes vstore8
#define store_eight vstore8
#define store_eight_floats vstore8
#define store_eight_doubles vstore8
#endif

#if LANES == 16
#define store_doubles(value, p) vstore16(value, 0, p)
#elif LANES == 8
#define store_doubles(value, p) vstore8(value, 0, p)
#endif

// Between types of lanes.
#if LANES == 1
#define TO_FLOATS(values) ((float)(values))
#define TO_DOUBLES(values) ((double)(values))
#define TO_INTS(values) ((int)(values))
#define TO_LONGS(condition) (condition)
#define AS_FLOATS as_float
#define AS_UINTS as_uint
#else
#if defined(__clang__)
#define TO_FLOATS(values) __builtin_convertvector(values, floatL)
#define TO_DOUBLES(values) __builtin_convertvector(values, doubleL)
#define TO_INTS(values) __builtin_convertvector(values, intL)
#define TO_LONGS(condition) __builtin_convertvector(condition, longL)
#else
#define TO_FLOATS convert_floatL
#define TO_DOUBLES convert_doubleL
#define TO_INTS convert_intL
#define TO_LONGS convert_longL
#endif
#define AS_FLOATS as_floatL
#define AS_UINTS as_uintL
#endif

// One load for each lane. Compilers make gathers of plain ones, which take many times as long on some processors.
#if LANES == 1
#define EACH_LANE(f) f(0)
#else
#define EACH_LANE(f) (f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7))
#endif
#define LOAD(type, p) (*(volatile __global const type*)(p))

// Three numbers of each face.
INLINE void load_corners(__global const uint* indices, __private const uint* faces, __private uint* a,
                         __private uint* b, __private uint* c) {
#pragma unroll
    for (uint lane = 0; lane < LANES; ++lane) {
        __global const uint* const corners = indices + 3 * (size_t)faces[lane];
        a[lane] = LOAD(uint, corners);
        b[lane] = LOAD(uint, corners + 1);
        c[lane] = LOAD(uint, corners + 2);
    }
}

// Bit i of the result: whether lane i of a comparison's result is true. The built-ins of an instruction set, where the
// compiler has them, save a tree of eight operations in the innermost loops.
static inline uint lanes_to_bits(intL mask) {
#if LANES == 1
    return mask != 0;
#elif LANES == 16 && defined(__AVX512DQ__) && HAS_BUILTIN(__builtin_ia32_cvtd2mask512)
    return (uint)(ushort)__builtin_ia32_cvtd2mask512(mask);
#elif LANES == 8 && defined(__AVX__) && HAS_BUILTIN(__builtin_ia32_movmskps256)
    return (uint)__builtin_ia32_movmskps256(as_float8(mask));
#else
    uintL bits = (as_uintL(mask) >> 31) << LANE_NUMBERS;
#if LANES == 16
    const uint8 eight = bits.lo | bits.hi;
#else
    const uint8 eight = bits;
#endif
    const uint4 four = eight.lo | eight.hi;
    const uint2 two = four.lo | four.hi;
    return two.x | two.y;
#endif
}

// One instruction if the processor has it; PoCL's floor() and ceil() take eight.
#if (defined(__SSE4_1__) || defined(__aarch64__)) && HAS_BUILTIN(__builtin_elementwise_floor) && \
    HAS_BUILTIN(__builtin_elementwise_ceil)
#define FLOOR __builtin_elementwise_floor
#define CEIL __builtin_elementwise_ceil
#else
#define FLOOR floor
#define CEIL ceil
#endif

static inline float greatest_lane(floatL values) {
#if LANES == 1
    return values;
#else
#if LANES == 16
    const float8 eight = GREATER(values.lo, values.hi);
#else
    const float8 eight = values;
#endif
    const float4 four = GREATER(eight.lo, eight.hi);
    const float2 two = GREATER(four.lo, four.hi);
    return GREATER(two.x, two.y);
#endif
}

#endif
