// The shares of a range that is divided among work-items.
#ifndef CLSDF_SHARES_H
#define CLSDF_SHARES_H

// Where share `number` of `shares` begins. Share number + 1 begins where it ends.
static inline uint share_of(uint count, uint number, uint shares) {
    return (uint)((ulong)count * number / shares);
}

#endif
