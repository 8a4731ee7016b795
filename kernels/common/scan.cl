// Exclusive prefix sums of 32-bit counts in three launches: each of `parts` work-items sums its range; one sums the
// sums; each writes its range. (GPUs have scan_by_group.cl, with a tree in local memory.)

#include "shares.h"

__kernel void scan_sums(uint count, __global const uint* values, __global ulong* sums) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const uint end = share_of(count, part + 1, parts);
    ulong sum = 0;
    for (uint i = share_of(count, part, parts); i < end; ++i) sum += values[i];
    sums[part] = sum;
}

// sums[parts] becomes the total: 64 bits, so that the host can tell a list that is too long.
__kernel void scan_offsets(uint parts, __global ulong* sums) {
    ulong sum = 0;
    for (uint i = 0; i < parts; ++i) {
        const ulong value = sums[i];
        sums[i] = sum;
        sum += value;
    }
    sums[parts] = sum;
}

__kernel void scan_write(uint count, __global const uint* values, __global const ulong* sums, __global uint* starts) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const uint end = share_of(count, part + 1, parts);
    uint sum = (uint)sums[part];
    for (uint i = share_of(count, part, parts); i < end; ++i) {
        const uint value = values[i];
        starts[i] = sum;
        sum += value;
    }
    if (part + 1 == parts) starts[count] = sum;
}
