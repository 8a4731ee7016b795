#pragma once

#include <clsdf/export.hpp>

#include <string>

namespace clsdf {

/// The polyhedra that bound the samples a triangle is nearest to. A triangle counts only for samples it may be nearest
/// to; with `bricks` that is decided for whole blocks of samples, with `slices` for each sample.
enum class Polyhedra {
    leaned,        ///< exact for every mesh
    peikert_sigg,  ///< as Peikert & Sigg published them, gaps closed; not exact: to be compared with
    mauch,         ///< Mauch's towers of faces, wedges of edges and cones of vertices; exact: to be compared with
};

/// How the samples of the polyhedra are found.
enum class Scan {
    automatic,  ///< bricks for leaned polyhedra, slices for the others
    bricks,     ///< bricks of 8 x 8 x 8 samples, each with a list of polyhedra; for leaned polyhedra only
    slices,     ///< slice by slice, each polyhedron's samples row by row, as in Peikert & Sigg
};

/// How the least distance and its triangle are kept where several polyhedra of a slice hold a sample; the result is the
/// same.
enum class SliceMinimum {
    automatic,  ///< in one pass where the device has 64-bit atomics and memory for a slice of them
    one_pass,   ///< an ordered key of distance and triangle: 64-bit atomics
    two_passes  ///< first the distances, then the triangles of the least ones: 32-bit atomics
};

/// "leaned", "peikert-sigg", "mauch".
CLSDF_EXPORT const char* name_of(Polyhedra polyhedra);

/// "auto", "bricks", "slices".
CLSDF_EXPORT const char* name_of(Scan scan);

/// The scan that will be used, never `automatic`. Throws Error(unsupported) for bricks of other polyhedra than leaned
/// ones.
CLSDF_EXPORT Scan resolve_scan(Polyhedra polyhedra, Scan asked);

}  // namespace clsdf
