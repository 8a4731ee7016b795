// Forms of OpenCL C that compile to single instructions. Only this file names instruction sets and built-in functions
// of compilers (test `simd`). Each form has a fallback in plain OpenCL C, or is a macro that is undefined without its
// instruction.
//
// Vectors are explicit. On a processor, compilers do not vectorise a loop over work-items around an inner loop, so a
// work-item handles LANES samples or blocks at once: 16 or 8, by the device's width. On a GPU a work-item is a lane:
// LANES is 1. So it is on the host, which compiles some headers of kernels (lib/engine/frusta/one_lane.hpp).
#ifndef CLSDF_SIMD_H
#define CLSDF_SIMD_H

#ifndef LANES
#error "define LANES as 16, 8 or 1: the lanes of a work-item"
#endif

// On processors, vectors that are passed through memory cost more than the work of these functions, so all are inlined.
// With LANES 1 the compiler decides; "static" gives a body to compilers that do not inline. The host defines
// PLAIN_INLINE for a compiler that takes C99's "inline" alone.
//
// OUT_OF_LINE is for functions on processors whose work is far more than a call. PoCL compiles each kernel three times,
// with all that is inlined; these functions it compiles once.
#if LANES != 1
#define INLINE static inline __attribute__((always_inline))
#define OUT_OF_LINE static __attribute__((noinline))
#elif defined(PLAIN_INLINE)
#define INLINE inline
#define OUT_OF_LINE inline
#else
#define INLINE static inline
#define OUT_OF_LINE static inline
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

// Vectors of LANES numbers.

#if LANES == 16
#define LANE_BITS 0xFFFFu
#define LANE_NUMBERS (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
#define as_ulong_halfL as_ulong8
#elif LANES == 8
#define LANE_BITS 0xFFu
#define LANE_NUMBERS (uint8)(0, 1, 2, 3, 4, 5, 6, 7)
#define as_ulong_halfL as_ulong4
#endif

#if LANES != 1
#define JOINED(name, number) name##number
#define WITH_NUMBER(name, number) JOINED(name, number)
#define OF_LANES(name) WITH_NUMBER(name, LANES)
typedef OF_LANES(float) floatL;
typedef OF_LANES(double) doubleL;
typedef OF_LANES(long) longL;
typedef OF_LANES(int) intL;
typedef OF_LANES(uint) uintL;
typedef OF_LANES(ulong) ulongL;
#define load_lanes OF_LANES(vload)
#define store_doubles(value, p) OF_LANES(vstore)(value, 0, p)
#define convert_floatL OF_LANES(convert_float)
#define convert_intL OF_LANES(convert_int)
#define convert_doubleL OF_LANES(convert_double)
#define convert_longL OF_LANES(convert_long)
#define as_uintL OF_LANES(as_uint)
#define as_intL OF_LANES(as_int)
#define as_floatL OF_LANES(as_float)
#else
typedef float floatL;
typedef double doubleL;
typedef long longL;
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
#else
#define store_lanes OF_LANES(vstore)
#define store_eight vstore8
#define store_eight_floats vstore8
#define store_eight_doubles vstore8
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

// One load per lane. Compilers turn plain loads into gathers, which are slow on many processors.
#if LANES == 1
#define EACH_LANE(f) f(0)
#else
#define EACH_LANE(f) (f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7))
#endif
#define LOAD(type, p) (*(volatile __global const type*)(p))

// Loads three indices of each face.
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

// Sets bit i of the result if lane i of a comparison's result is true. An instruction for it saves a tree of eight
// operations in the innermost loops.
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

#if LANES != 1
// The other way round: lane i is true if bit i is set.
static inline intL bits_to_lanes(uint bits) {
    return (((intL)(int)bits >> as_intL(LANE_NUMBERS)) & 1) != 0;
}
#endif

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

// The number of the lowest bit that is set; at least one must be. OpenCL C 1.2 has no ctz(), and clz() takes four
// instructions. Only processors use the built-in: other compilers may accept it and then fail, as oclgrind's does.
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

// Stores past the caches. STREAM stores a vector to its aligned address, on any device.
#if HAS_BUILTIN(__builtin_nontemporal_store)
#define STREAM(value, to) __builtin_nontemporal_store(value, to)
#endif

// Stores a whole cache line. `to`: its first number.
#ifdef __OPENCL_VERSION__
INLINE void store_line(uint16 values, __global uint* to) {
#if (defined(__x86_64__) || defined(__aarch64__)) && defined(STREAM)
    STREAM(values, (__global uint16*)to);
#else
    vstore16(values, 0, to);
#endif
}
#endif

// Makes stores past the caches visible before the kernel ends. It follows the last line of a work-item or of its group.
// (On x86 such stores are not ordered with others; on AArch64 they are.)
INLINE void finish_lines(void) {
#if defined(__x86_64__) && HAS_BUILTIN(__builtin_ia32_sfence)
    __builtin_ia32_sfence();
#endif
}

#if LANES == 8
#if defined(__clang__)
typedef double8 __attribute__((aligned(8))) UnalignedDoubles;
#define STORE_DOUBLES(value, space, p) (*(space UnalignedDoubles*)(p) = (value))
#else
#define STORE_DOUBLES(value, space, p) vstore8(value, 0, p)
#endif

#if defined(__clang__) && (defined(__x86_64__) || defined(__aarch64__)) && defined(STREAM)
#define STREAM_DOUBLES(value, p) STREAM(value, (__global double8*)(p))
#else
#define STREAM_DOUBLES(value, p) STORE_DOUBLES(value, __global, p)
#endif
#endif

// Permutations of lanes, for vectors only.
#if LANES != 1

// Moves the lanes whose bit is set to the front of the vector, in order. The lanes behind them are undefined.
#if LANES == 16 && defined(__AVX512F__) && HAS_BUILTIN(__builtin_ia32_compresssi512_mask)
INLINE uintL packed(uintL values, uint bits) {
    return as_uint16(__builtin_ia32_compresssi512_mask(as_int16(values), (int16)(0), (ushort)bits));
}
#elif LANES == 8 && defined(__AVX2__) && HAS_BUILTIN(__builtin_ia32_permvarsi256)
// For each mask of eight bits: the numbers of its set bits, ascending, a byte each. (pdep and pext would find them, but
// are slow on many processors that have AVX2.)
#define IS_SET(mask, bit) ((ulong)((mask) >> (bit)&1))
#define RANK_1(mask) IS_SET(mask, 0)
#define RANK_2(mask) (RANK_1(mask) + IS_SET(mask, 1))
#define RANK_3(mask) (RANK_2(mask) + IS_SET(mask, 2))
#define RANK_4(mask) (RANK_3(mask) + IS_SET(mask, 3))
#define RANK_5(mask) (RANK_4(mask) + IS_SET(mask, 4))
#define RANK_6(mask) (RANK_5(mask) + IS_SET(mask, 5))
#define RANK_7(mask) (RANK_6(mask) + IS_SET(mask, 6))
#define PLACED(mask, bit) (IS_SET(mask, bit) * (ulong)(bit) << 8 * RANK_##bit(mask))
#define PACKING(mask)                                                                                            \
    (PLACED(mask, 1) | PLACED(mask, 2) | PLACED(mask, 3) | PLACED(mask, 4) | PLACED(mask, 5) | PLACED(mask, 6) | \
     PLACED(mask, 7))
#define PACKINGS_4(mask) PACKING(mask), PACKING(mask + 1), PACKING(mask + 2), PACKING(mask + 3)
#define PACKINGS_16(mask) PACKINGS_4(mask), PACKINGS_4(mask + 4), PACKINGS_4(mask + 8), PACKINGS_4(mask + 12)
#define PACKINGS_64(mask) PACKINGS_16(mask), PACKINGS_16(mask + 16), PACKINGS_16(mask + 32), PACKINGS_16(mask + 48)
__constant ulong packings[256] = {PACKINGS_64(0), PACKINGS_64(64), PACKINGS_64(128), PACKINGS_64(192)};

INLINE uintL packed(uintL values, uint bits) {
    return as_uint8(__builtin_ia32_permvarsi256(as_int8(values), convert_int8(as_uchar8(packings[bits]))));
}
#else
INLINE uintL packed(uintL values, uint bits) {
    uint each[LANES];
    store_lanes(values, 0, each);
    for (uint n = 0; bits; bits &= bits - 1) each[n++] = each[lowest_bit(bits)];
    return load_lanes(0, each);
}
#endif

// Looks `indices` up in the table of each four lanes; only their lowest two bits are used.
#if LANES == 16 && defined(__AVX512F__) && HAS_BUILTIN(__builtin_ia32_vpermilvarps512)
#define SHUFFLED(table, indices) __builtin_ia32_vpermilvarps512(table, as_int16(indices))
#elif LANES == 8 && defined(__AVX__) && HAS_BUILTIN(__builtin_ia32_vpermilvarps256)
#define SHUFFLED(table, indices) __builtin_ia32_vpermilvarps256(table, as_int8(indices))
#endif

// Loads of floats from scattered addresses, and stores.
#if LANES == 16 && defined(__AVX512F__) && HAS_BUILTIN(__builtin_ia32_gathersiv16sf) && \
    HAS_BUILTIN(__builtin_ia32_scattersiv16sf)
#define ALL_LANES ((ushort)LANE_BITS)
#define GATHERED(from, indices) \
    __builtin_ia32_gathersiv16sf((float16)(0.0f), from, as_intL(indices), ALL_LANES, sizeof(float))
#define SCATTER(to, indices, values) \
    __builtin_ia32_scattersiv16sf(to, ALL_LANES, as_intL(indices), values, sizeof(float))
#endif

// Selects eight numbers of two vectors; those of the second are 8 to 15. A vector that is put together from its
// elements takes several instructions.
#if HAS_BUILTIN(__builtin_shufflevector)
#define EIGHT_OF(a, b, Order, n0, n1, n2, n3, n4, n5, n6, n7) \
    __builtin_shufflevector(a, b, n0, n1, n2, n3, n4, n5, n6, n7)
#else
#define EIGHT_OF(a, b, Order, n0, n1, n2, n3, n4, n5, n6, n7) shuffle2(a, b, (Order)(n0, n1, n2, n3, n4, n5, n6, n7))
#endif

// Transposes 4 x 4 numbers in each half of four vectors. Each half is loaded from its own address, so no numbers move
// between halves.
#define DEFINE_TRANSPOSE_HALVES(name, Vector, Order)                             \
    INLINE void name(__private Vector* rows) {                                   \
        const Vector a = rows[0], b = rows[1], c = rows[2], d = rows[3];         \
        const Vector ab_even = EIGHT_OF(a, b, Order, 0, 8, 2, 10, 4, 12, 6, 14); \
        const Vector ab_odd = EIGHT_OF(a, b, Order, 1, 9, 3, 11, 5, 13, 7, 15);  \
        const Vector cd_even = EIGHT_OF(c, d, Order, 0, 8, 2, 10, 4, 12, 6, 14); \
        const Vector cd_odd = EIGHT_OF(c, d, Order, 1, 9, 3, 11, 5, 13, 7, 15);  \
        rows[0] = EIGHT_OF(ab_even, cd_even, Order, 0, 1, 8, 9, 4, 5, 12, 13);   \
        rows[1] = EIGHT_OF(ab_odd, cd_odd, Order, 0, 1, 8, 9, 4, 5, 12, 13);     \
        rows[2] = EIGHT_OF(ab_even, cd_even, Order, 2, 3, 10, 11, 6, 7, 14, 15); \
        rows[3] = EIGHT_OF(ab_odd, cd_odd, Order, 2, 3, 10, 11, 6, 7, 14, 15);   \
    }
DEFINE_TRANSPOSE_HALVES(transpose_halves, float8, uint8)
DEFINE_TRANSPOSE_HALVES(transpose_double_halves, double8, ulong8)
#undef DEFINE_TRANSPOSE_HALVES

// Transposes size x size numbers. Each round shuffles the first half of the rows into the second.
#define DEFINE_TRANSPOSE(name, Vector, size, rounds)                               \
    INLINE void name(__private Vector* rows) {                                     \
        _Pragma("unroll") for (uint round = 0; round < rounds; ++round) {          \
            Vector zipped[size];                                                   \
            _Pragma("unroll") for (uint i = 0; i < size / 2; ++i) {                \
                const Vector a = rows[i], b = rows[i + size / 2];                  \
                zipped[2 * i] = ZIP_LOW_##size(Vector, a, b);                      \
                zipped[2 * i + 1] = ZIP_HIGH_##size(Vector, a, b);                 \
            }                                                                      \
            _Pragma("unroll") for (uint i = 0; i < size; ++i) rows[i] = zipped[i]; \
        }                                                                          \
    }
#if LANES == 16
#define ZIP_LOW_16(Vector, a, b) \
    (Vector)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7)
#define ZIP_HIGH_16(Vector, a, b) \
    (Vector)(a.s8, b.s8, a.s9, b.s9, a.sa, b.sa, a.sb, b.sb, a.sc, b.sc, a.sd, b.sd, a.se, b.se, a.sf, b.sf)
DEFINE_TRANSPOSE(transpose, float16, 16, 4)
#elif LANES == 8
#define ZIP_LOW_8(Vector, a, b) (Vector)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3)
#define ZIP_HIGH_8(Vector, a, b) (Vector)(a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7)
DEFINE_TRANSPOSE(transpose_doubles, double8, 8, 3)
#endif
#undef DEFINE_TRANSPOSE

#endif

#endif
