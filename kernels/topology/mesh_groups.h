// Groups of the kernels that look at a whole mesh: GROUP work-items, 64 or 128.
#ifndef CLSDF_MESH_GROUPS_H
#define CLSDF_MESH_GROUPS_H

#include "group_sum.h"

#define GROUP_OF_KERNEL __attribute__((reqd_work_group_size(GROUP, 1, 1)))
typedef volatile __global uint* Atomic;

DEFINE_SUM_BEFORE(sum_before, uint, GROUP)

// Adds the values of a group to a counter. sum: one number.
static inline void count_up(uint value, volatile __local uint* sum, Atomic counter) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0) *sum = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (value != 0) atomic_add(sum, value);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0 && *sum != 0) atomic_add(counter, *sum);
}

#endif
