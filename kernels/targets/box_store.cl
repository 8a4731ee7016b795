// Values on their way from packed memory to targets with strides: samples of a computed block, and links.

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

#define STORE_ITEM(Type)                 \
    for (int c = 0; c < components; ++c) \
        *(__global Type*)(target + c * component_stride) = ((__global const Type*)from)[item * components + c];

// One work-item an item, of so many components. first: the byte of the first item; strides are bytes, which are
// multiples of element_bytes, as `first` is.
__kernel void store_items(ulong count, int components, int element_bytes, __global const uchar* from, long first,
                          long stride, long component_stride, __global uchar* to) {
    const long item = get_global_id(0);
    if ((ulong)item >= count) return;
    __global uchar* target = to + (first + item * stride);
    if (element_bytes == 4) {
        STORE_ITEM(uint)
    } else if (element_bytes == 8) {
        STORE_ITEM(ulong)
    } else {
        STORE_ITEM(uchar)
    }
}

// Fields that all are -1, of floats or doubles. One work-item a piece of a row: its samples piece, piece + pieces, and
// so on. size, strides: of samples and of bytes along x, y and z, and of fields. Global size: (pieces, at least the
// rows of a field, fields).
__kernel void clear_fields(int4 size, long4 strides, int element_bytes, long first, __global uchar* to) {
    const int piece = get_global_id(0), pieces = get_global_size(0), line = get_global_id(1);
    const int y = line % size.y, z = line / size.y, field = get_global_id(2);
    if (z >= size.z) return;
    __global uchar* row = to + (first + y * strides.y + z * strides.z + field * strides.w);
    for (int x = piece; x < size.x; x += pieces) {
        if (element_bytes == 4)
            *(__global float*)(row + x * strides.x) = -1;
        else
            *(__global double*)(row + x * strides.x) = -1;
    }
}

// The parts of links, of floats or doubles, go to the fields of their directions. One work-item a link. begin: the
// first sample of the fields. Otherwise as clear_fields.
__kernel void scatter_links(ulong count, __global const int* samples, __global const uchar* directions,
                            __global const uchar* parts, int4 begin, long4 strides, int element_bytes, long first,
                            __global uchar* to) {
    const long link = get_global_id(0);
    if ((ulong)link >= count) return;
    __global const int* sample = samples + 3 * link;
    __global uchar* target = to + (first + (sample[0] - begin.x) * strides.x + (sample[1] - begin.y) * strides.y +
                                   (sample[2] - begin.z) * strides.z + directions[link] * strides.w);
    if (element_bytes == 4)
        *(__global uint*)target = ((__global const uint*)parts)[link];
    else
        *(__global ulong*)target = ((__global const ulong*)parts)[link];
}
