// One definition for the host and the kernels: the caller's points in memory of a device, and what is found about them
// before they are looked up.
#ifndef CLSDF_POINT_ORDER_H
#define CLSDF_POINT_ORDER_H

#include "polyhedron.h"

// Why a point is not usable: the indices of `unusable` and `first`.
#define CLSDF_POINT_TOO_FAR 0
#define CLSDF_POINT_NOT_FINITE 1

// The outcome of a point: the values of PointStatus (clsdf/point_plan.hpp).
#define CLSDF_STATUS_FOUND 0
#define CLSDF_STATUS_NOT_FINITE 1
#define CLSDF_STATUS_TOO_FAR 2
#define CLSDF_STATUS_SIGN_OPEN 3

// A point nearer to the surface, in units, may lie on it.
#define CLSDF_NEARLY_ON_SURFACE 1.0e-9

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

// The cells of the curve, and counts: of the unusable points of a query; and, of the points that are computed at once,
// of those whose sign neither their nearest face nor the mesh's box decides, and of those that kernels leave open.
typedef struct PointCells {
    double lower[3];
    double scale;  // cells per length
    clsdf_uint32 unusable[2];
    clsdf_uint32 first[2];
    clsdf_uint32 open;
    clsdf_uint32 left;
} PointCells;

// The surface that decides signs, beside its arrays (lib/points/sign_faces.hpp). Lengths are in units.
typedef struct SignFaces {
    double per_unit;          // units per length: a power of two
    double lower_x, upper_x;  // of the mesh
    double floor;             // z down to which walls hang from the open edges
    clsdf_uint32 has_sign;    // 0: no point is inside
    clsdf_uint32 is_parity;
    clsdf_uint32 has_sign_positions;  // the surface has other positions than the mesh
    clsdf_uint32 has_counts;          // its faces do not all count once
    clsdf_uint32 loops;               // of open edges that count
    clsdf_uint32 is_backward;         // rays must run towards -x
    clsdf_uint32 are_moderate;        // each coordinate is 0, or of a size from 2^-60 to 2^40
    clsdf_uint32 count;               // of the faces
    clsdf_uint32 has_floor;           // walls hang from the loops, and no film closes them
    clsdf_uint32 unused;
} SignFaces;

// Where values of a target go, in bytes.
typedef struct ValuePlaces {
    clsdf_int64 first;
    clsdf_int64 stride;            // from a point to the next one
    clsdf_int64 component_stride;  // from a component to the next one
} ValuePlaces;

// A point whose sign the host decides.
typedef struct OpenPoint {
    double position[3];
    double squared;  // of the distance in units
} OpenPoint;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(PointSource) == 32 && sizeof(PointLimits) == 48 && sizeof(PointUnits) == 32);
static_assert(sizeof(PointExtent) == 64 && offsetof(PointExtent, unusable) == 48);
static_assert(sizeof(PointCells) == 56 && offsetof(PointCells, unusable) == 32 && offsetof(PointCells, open) == 48);
static_assert(sizeof(SignFaces) == 72 && offsetof(SignFaces, has_sign) == 32);
static_assert(sizeof(ValuePlaces) == 24);
static_assert(sizeof(OpenPoint) == 32);
}  // namespace clsdf
#endif

#endif
