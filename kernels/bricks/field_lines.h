// Stores of consecutive values to the field as whole cache lines, past the caches. No kernel reads them soon, and a
// store to the caches reads the line first.
#ifndef CLSDF_FIELD_LINES_H
#define CLSDF_FIELD_LINES_H

#include "simd.h"

// Numbers in a cache line. Half a line costs as much past the caches as a whole one.
#define LINE_NUMBERS 16

// The bytes from the last multiple of `numbers` numbers to an address.
#define MISALIGNMENT(address, numbers) ((size_t)(address) % ((numbers) * sizeof(uint)))

// Values before the first whole line and after the last are stored by fours and ones.

// One value into [begin, end): a double, or two floats of the same value.
INLINE void store_value(ulong value, __global uint* begin, __global uint* end) {
    const uint2 pair = as_uint2(value);
    const uint4 four = (uint4)(pair, pair);
    const uint16 line = (uint16)(four, four, four, four);
    for (; begin < end && MISALIGNMENT(begin, 4) != 0; ++begin) *begin = MISALIGNMENT(begin, 2) == 0 ? pair.x : pair.y;
    for (; begin + 4 <= end && MISALIGNMENT(begin, LINE_NUMBERS) != 0; begin += 4) vstore4(four, 0, begin);
    for (; begin + LINE_NUMBERS <= end; begin += LINE_NUMBERS) store_line(line, begin);
    for (; begin + 4 <= end; begin += 4) vstore4(four, 0, begin);
    for (; begin < end; ++begin) *begin = MISALIGNMENT(begin, 2) == 0 ? pair.x : pair.y;
}

// Sets every bit of [begin, end). Elements that are wider than a byte begin at a multiple of four.
INLINE void store_ones(__global uchar* begin, __global uchar* end) {
    for (; begin < end && (size_t)begin % sizeof(uint) != 0; ++begin) *begin = 0xFF;
    __global uchar* last = end - (size_t)end % sizeof(uint);
    if (begin >= last) last = begin;
    store_value(~(ulong)0, (__global uint*)begin, (__global uint*)last);
    for (; last < end; ++last) *last = 0xFF;
}

// values[0], values[1], ... into [begin, end).
INLINE void store_values(__global const uint* values, __global uint* begin, __global uint* end) {
    for (; begin < end && MISALIGNMENT(begin, 4) != 0; ++begin) *begin = *values++;
    for (; begin + 4 <= end && MISALIGNMENT(begin, LINE_NUMBERS) != 0; begin += 4, values += 4)
        vstore4(vload4(0, values), 0, begin);
    for (; begin + LINE_NUMBERS <= end; begin += LINE_NUMBERS, values += LINE_NUMBERS)
        store_line(vload16(0, values), begin);
    for (; begin + 4 <= end; begin += 4, values += 4) vstore4(vload4(0, values), 0, begin);
    for (; begin < end; ++begin) *begin = *values++;
}

// The same of bytes; are_words: of elements of whole words.
INLINE void store_bytes(__global const uchar* bytes, __global uchar* begin, __global uchar* end, bool are_words) {
    if (are_words) {
        store_values((__global const uint*)bytes, (__global uint*)begin, (__global uint*)end);
    } else {
        for (; begin + 8 <= end; begin += 8, bytes += 8) vstore8(vload8(0, bytes), 0, begin);
        for (; begin < end; ++begin) *begin = *bytes++;
    }
}

#endif
