// One definition for the host and the kernels: the numbers of the outputs.
#ifndef CLSDF_OUTPUT_NUMBERS_H
#define CLSDF_OUTPUT_NUMBERS_H

#ifdef __OPENCL_VERSION__
#include "output_table.h"
#else
#include <clsdf/output_table.h>

namespace clsdf {
#endif

// Numbers of the outputs, in sets of bits; a number may have no output. CLSDF_OUTPUT_COUNT: the last one + 1. Kernels
// write the distance as floats. Finishing makes the other outputs, and the distance if it is in double; then there are
// no floats.
#define CLSDF_OUTPUT_NUMBER(name, content, element, components, number) CLSDF_OUTPUT_##name = number,
enum clsdf_output_number { CLSDF_OUTPUT_distance = 0, CLSDF_OUTPUTS(CLSDF_OUTPUT_NUMBER) CLSDF_OUTPUT_COUNT };
#undef CLSDF_OUTPUT_NUMBER

#ifndef __OPENCL_VERSION__
}  // namespace clsdf
#endif

#endif
