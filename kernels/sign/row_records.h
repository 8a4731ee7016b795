// Records of rows, in no order: found once and counted by row. A prefix sum of the counts gives the start of each row;
// scatter_records moves the records to their rows, where they are sorted. lib/engine/sign/row_records.hpp launches
// this.
#ifndef CLSDF_ROW_RECORDS_H
#define CLSDF_ROW_RECORDS_H

#include "shares.h"
#include "simd.h"
#include "sweep.h"

// Room for a work-item's records: records [next, end).
typedef struct Writer {
    __global uint* row_counts;
    __global SweepRecord* records;
    uint capacity, block;
    __global SweepTotals* totals;
    uint next, end;
} Writer;

INLINE void write_record(__private Writer* writer, uint row, uint key) {
    if (writer->next == writer->end) {
        writer->next = atomic_add(&writer->totals->records, writer->block);
        writer->end = writer->next + writer->block;
    }
    const uint index = atomic_inc(writer->row_counts + row);
    if (writer->next < writer->capacity) {
        __global SweepRecord* record = writer->records + writer->next;
        record->row = row;
        record->key = key;
        record->index = index;
    }
    ++writer->next;
}

INLINE void leave_records(Writer writer) {
    for (uint n = writer.next; n < min(writer.end, writer.capacity); ++n) writer.records[n].row = CLSDF_NO_ROW;
}

// Leaves a triangle that may meet `rows` rows to the second launch.
INLINE void leave_large(uint t, ulong rows, __global uint* large, __global SweepTotals* totals) {
    large[atomic_inc(&totals->large)] = t;
    atomic_add(&totals->large_blocks, (uint)(rows / CLSDF_LARGE_ROWS));
    atomic_max(&totals->largest_rows, (uint)min(rows, (ulong)0x7FFFFFFFu));
}

// Moves the key of a record, one per work-item, to its row. starts: where the keys of each row begin.
__kernel void scatter_records(uint begin, uint end, __global const SweepRecord* records, __global const uint* starts,
                              __global uint* keys) {
    const uint n = begin + get_global_id(0);
    if (n >= end || records[n].row == CLSDF_NO_ROW) return;
    keys[starts[records[n].row] + records[n].index] = records[n].key;
}

// Sorts keys[0, count) by insertion at falling strides (D. L. Shell; strides of R. Sedgewick, 1986: about count^(4/3)
// steps, up to 2^28 keys). Most rows have few crossings.
__constant uint strides[] = {1, 8, 23, 77, 281, 1073, 4193, 16577, 65921, 262913, 1050113, 4197377, 16783361};
static inline void sort_keys(__global uint* keys, uint count) {
    for (int n = count <= 16 ? 0 : 12; n >= 0; --n) {
        const uint stride = strides[n];
        for (uint i = stride; i < count; ++i) {
            const uint key = keys[i];
            uint j = i;
            for (; j >= stride && keys[j - stride] > key; j -= stride) keys[j] = keys[j - stride];
            keys[j] = key;
        }
    }
}

// Bits [begin, end) of a row, which are 0 so far.
INLINE void set_bits(__global uint* bits, uint begin, uint end) {
    if (begin >= end) return;
    uint word = begin >> 5;
    const uint last = (end - 1) >> 5;
    const uint from_begin = 0xFFFFFFFFu << (begin & 31), to_end = 0xFFFFFFFFu >> (31 - ((end - 1) & 31));
    if (word == last) {
        bits[word] |= from_begin & to_end;
        return;
    }
    bits[word] |= from_begin;
    while (++word < last) bits[word] = 0xFFFFFFFFu;
    bits[last] |= to_end;
}

#endif
