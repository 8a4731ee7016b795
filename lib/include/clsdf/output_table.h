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
    site = 2,         ///< its nearest part: 0 to 2 its vertices, 3 to 5 its edges, 6 its face; of Surface::outer also
                      ///< 7, where faces cut each other
    closest = 3,      ///< the position of the closest point, in the mesh's units: doubles
    gradient = 4,     ///< of the signed distance: a unit vector
    barycentric = 5,  ///< of the closest point: the weights of the triangle's vertices 1 and 2
    // 6 is kept.
    offset = 7,  ///< from the sample or point to the closest point, in the mesh's units
    body = 8,    ///< of a Scene: the body of the nearest triangle; of a mesh 0
};

}  // namespace clsdf
#endif

// The outputs beside the distance, in the order of their numbers: ROW(name, what it is, type of an element, elements of
// a sample, number). An element of type float32 is a float, or a double if the caller asks for it; in fields and files
// it is a float. Beyond the band every bit is set: no triangle, no site, and not a number.
#define CLSDF_OUTPUTS(ROW)                                      \
    ROW(triangle, "nearest triangle", uint32, 1, 1)             \
    ROW(site, "nearest site of the triangle", uint8, 1, 2)      \
    ROW(closest, "closest point of the surface", float64, 3, 3) \
    ROW(gradient, "gradient of the distance", float32, 3, 4)    \
    ROW(barycentric, "barycentric coordinates", float32, 2, 5)  \
    ROW(offset, "offset to the closest point", float32, 3, 7)   \
    ROW(body, "body of the nearest triangle", uint32, 1, 8)

// The outputs that take the names of sites, and those that take their pseudonormals, as sets of bits.
#define CLSDF_OUTPUTS_BY_NAME (1u << CLSDF_OUTPUT_triangle | 1u << CLSDF_OUTPUT_site | 1u << CLSDF_OUTPUT_barycentric)
#define CLSDF_OUTPUTS_BY_NORMAL (1u << CLSDF_OUTPUT_gradient)

#endif
