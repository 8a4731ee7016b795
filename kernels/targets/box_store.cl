// Samples on their way from a computed block, which is packed, to targets with strides.

#include "box_store.h"

#define STORE(Type)                                                                                              \
    for (int x = piece; x < box->size[0]; x += pieces) {                                                         \
        __global const Type* samples = (__global const Type*)from + (first + x) * components;                    \
        __global uchar* sample = target + x * box->strides[0];                                                   \
        for (int c = 0; c < components; ++c) *(__global Type*)(sample + c * box->component_stride) = samples[c]; \
    }

// One work-item a piece of a row of a box: its samples piece, piece + pieces, and so on. row, slice: samples of the
// block's rows and slices; element_bytes: 1, 4 or 8, which the target's bytes are multiples of.
// Global size: (pieces, rows of a box, at least the most; boxes).
__kernel void store_boxes(__global const StoredBox* boxes, int row, long slice, int components, int element_bytes,
                          __global const uchar* from, __global uchar* to) {
    __global const StoredBox* box = boxes + get_global_id(2);
    const int piece = get_global_id(0), pieces = get_global_size(0), line = get_global_id(1);
    const int y = line % box->size[1], z = line / box->size[1];
    if (z >= box->size[2]) return;
    const long first = box->from + z * slice + (long)y * row;
    __global uchar* target = to + (box->to + y * box->strides[1] + z * box->strides[2]);
    if (element_bytes == 4) {
        STORE(uint)
    } else if (element_bytes == 8) {
        STORE(ulong)
    } else {
        STORE(uchar)
    }
}
