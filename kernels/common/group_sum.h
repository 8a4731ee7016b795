// The sum over the work-items of a group, for kernels of GPUs.
//
// DEFINE_SUM_BEFORE(name, number, items) defines name(value, sums): the sum of the values of the work-items before this
// one, of a group of `items` work-items. sums: `items` numbers in local memory, of which the last becomes the total. It
// may be called again with the same memory.

#define DEFINE_SUM_BEFORE(name, number, items)                          \
    static inline number name(number value, __local number* sums) {     \
        const uint item = get_local_id(0);                              \
        barrier(CLK_LOCAL_MEM_FENCE);                                   \
        sums[item] = value;                                             \
        barrier(CLK_LOCAL_MEM_FENCE);                                   \
        for (uint step = 1; step < items; step *= 2) {                  \
            const number before = item >= step ? sums[item - step] : 0; \
            barrier(CLK_LOCAL_MEM_FENCE);                               \
            sums[item] += before;                                       \
            barrier(CLK_LOCAL_MEM_FENCE);                               \
        }                                                               \
        return sums[item] - value;                                      \
    }
