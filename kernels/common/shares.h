// The shares of a range that is divided among work-items.
#ifndef CLSDF_SHARES_H
#define CLSDF_SHARES_H

// The begin of share `number` of `shares`. It ends at the begin of share number + 1.
static inline uint share_of(uint count, uint number, uint shares) {
    return (uint)((ulong)count * number / shares);
}

#endif
