// Exclusive prefix sums of 32-bit counts on a GPU, in two launches: each work-group sums a part of the counts; each
// group sums the sums of the parts before its own, and writes its part. A work-item takes a range of its group's part.

#include "group_sum.h"
#include "shares.h"

#define ITEMS 64  // of a group

typedef struct Range {
    uint begin, end;
} Range;

// A work-item's range of a part of `count` values.
static inline Range range_of_item(uint count, uint part, uint parts) {
    const uint begin = share_of(count, part, parts), length = share_of(count, part + 1, parts) - begin;
    const uint item = get_local_id(0);
    const Range range = {begin + share_of(length, item, ITEMS), begin + share_of(length, item + 1, ITEMS)};
    return range;
}

DEFINE_SUM_BEFORE(sum_before, ulong, ITEMS)

__kernel __attribute__((reqd_work_group_size(ITEMS, 1, 1))) void scan_sums(uint count, __global const uint* values,
                                                                           __global ulong* sums) {
    __local ulong item_sums[ITEMS];
    const Range range = range_of_item(count, get_group_id(0), get_num_groups(0));
    ulong sum = 0;
    for (uint i = range.begin; i < range.end; ++i) sum += values[i];
    sum_before(sum, item_sums);
    if (get_local_id(0) == 0) sums[get_group_id(0)] = item_sums[ITEMS - 1];
}

// sums[parts] becomes the total: 64 bits, so that the host can tell a list that is too long.
__kernel __attribute__((reqd_work_group_size(ITEMS, 1, 1))) void scan_write(uint count, __global const uint* values,
                                                                            __global ulong* sums,
                                                                            __global uint* starts) {
    __local ulong item_sums[ITEMS];
    const uint part = get_group_id(0), parts = get_num_groups(0);
    ulong before = 0;
    for (uint i = get_local_id(0); i < part; i += ITEMS) before += sums[i];
    sum_before(before, item_sums);
    before = item_sums[ITEMS - 1];
    const Range range = range_of_item(count, part, parts);
    ulong sum = 0;
    for (uint i = range.begin; i < range.end; ++i) sum += values[i];
    sum = sum_before(sum, item_sums) + before;
    for (uint i = range.begin; i < range.end; ++i) {
        const uint value = values[i];
        starts[i] = (uint)sum;
        sum += value;
    }
    if (part + 1 == parts && get_local_id(0) + 1 == ITEMS) {
        starts[count] = (uint)sum;
        sums[parts] = sum;
    }
}
