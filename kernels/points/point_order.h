// One definition for the host and the kernels: the caller's points in memory of a device, and what is found about them
// before they are looked up.
#ifndef CLSDF_POINT_ORDER_H
#define CLSDF_POINT_ORDER_H

#include "polyhedron.h"

// Why a point is not usable: the indices of `unusable` and `first`.
#define CLSDF_POINT_TOO_FAR 0
#define CLSDF_POINT_NOT_FINITE 1

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// Where the coordinates lie, in bytes of a buffer.
typedef struct PointSource {
    clsdf_int64 first;      // x of the first point
    clsdf_int64 stride;     // from a point to the next one
    clsdf_int64 component;  // from a coordinate to the next one
    clsdf_int64 is_double;
} PointSource;

// A closed box in the caller's coordinates.
typedef struct PointLimits {
    double lower[3];
    double upper[3];
} PointLimits;

// The lattice that points are measured in.
typedef struct PointUnits {
    double origin[3];
    double unit;
} PointUnits;

// Of some points: the box of those that are usable; of the others the number and the first index, or the greatest
// integer.
typedef struct PointExtent {
    double lower[3];
    double upper[3];
    clsdf_uint32 unusable[2];
    clsdf_uint32 first[2];
} PointExtent;

// The cells of the curve, and the unusable points of all.
typedef struct PointCells {
    double lower[3];
    double scale;  // cells per length
    clsdf_uint32 unusable[2];
    clsdf_uint32 first[2];
} PointCells;

// A point whose sign the host decides.
typedef struct OpenPoint {
    double position[3];
    double squared;  // of the distance in units
} OpenPoint;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(PointSource) == 32 && sizeof(PointLimits) == 48 && sizeof(PointUnits) == 32);
static_assert(sizeof(PointExtent) == 64 && offsetof(PointExtent, unusable) == 48);
static_assert(sizeof(PointCells) == 48 && offsetof(PointCells, unusable) == 32);
static_assert(sizeof(OpenPoint) == 32);
}  // namespace clsdf
#endif

#endif
