// The outputs: one table for callers, the library and the kernels. A new output is an enumerator and a row here, a
// function in kernels/finish/finish.h, and a value and a contract in lib/reference/output_contracts.cpp.
#ifndef CLSDF_OUTPUT_TABLE_H
#define CLSDF_OUTPUT_TABLE_H

#ifndef __OPENCL_VERSION__
#include <cstdint>

namespace clsdf {

/// What is computed at a sample or a point. All outputs belong to one nearest triangle and one of its sites;
/// docs/library.md defines each. Beyond the band, the triangle is no_triangle, the site no_site, and vectors are NaN.
/// The values of the enumerators never change.
enum class Output : std::int32_t {
    distance = 0,     ///< signed, in the mesh's units; always computed
    triangle = 1,     ///< the nearest triangle; if an edge or a vertex is nearest, the lowest that shares it
    site = 2,         ///< its nearest part: 0 to 2 its vertices, 3 to 5 its edges, 6 its face
    closest = 3,      ///< the closest point, in the mesh's units
    gradient = 4,     ///< of the signed distance: a unit vector
    barycentric = 5,  ///< of the closest point: the weights of the triangle's vertices 1 and 2
};

}  // namespace clsdf
#endif

// The outputs beside the distance, in the order of their numbers: ROW(name, what it is, type of an element, elements of
// a sample). An element of type float32 or float64 is a float or a double, as the caller asks for; in fields and files
// it has this type. Beyond the band every bit is set: no triangle, no site, and not a number.
#define CLSDF_OUTPUTS(ROW)                                   \
    ROW(triangle, "nearest triangle", uint32, 1)             \
    ROW(site, "nearest site of the triangle", uint8, 1)      \
    ROW(closest, "closest point of the surface", float64, 3) \
    ROW(gradient, "gradient of the distance", float32, 3)    \
    ROW(barycentric, "barycentric coordinates", float32, 2)

// The outputs that take the names of sites, and those that take their pseudonormals, as sets of bits.
#define CLSDF_OUTPUTS_BY_NAME (1u << CLSDF_OUTPUT_triangle | 1u << CLSDF_OUTPUT_site | 1u << CLSDF_OUTPUT_barycentric)
#define CLSDF_OUTPUTS_BY_NORMAL (1u << CLSDF_OUTPUT_gradient)

#endif
