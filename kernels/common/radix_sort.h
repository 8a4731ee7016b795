// One definition for the host and the kernels: how a radix sort (radix_sort.cl) divides its keys.
#ifndef CLSDF_RADIX_SORT_H
#define CLSDF_RADIX_SORT_H

// Bits that a pass sorts by, and their values.
#define CLSDF_RADIX_BITS 8
#define CLSDF_RADIX_DIGITS 256
// Keys of a work-group.
#define CLSDF_RADIX_TILE 2048
// So many tiles are few.
#define CLSDF_FEW_RADIX_TILES 128

#endif
