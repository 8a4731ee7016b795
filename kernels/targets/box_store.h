// One definition for the host and the kernels: where samples of a computed block go.
#ifndef CLSDF_BOX_STORE_H
#define CLSDF_BOX_STORE_H

#include "polyhedron.h"

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// A box of samples in a packed block, and its place in a target.
typedef struct StoredBox {
    clsdf_int64 from;              // number of its first sample in the block
    clsdf_int64 to;                // byte of the target where that sample begins
    clsdf_int64 strides[3];        // of the target: bytes from a sample to the next one along x, y and z
    clsdf_int64 component_stride;  // bytes from a component to the next one
    clsdf_int32 size[3];           // in samples
    clsdf_int32 padding;
} StoredBox;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(StoredBox) == 64);
}  // namespace clsdf
#endif

#endif
