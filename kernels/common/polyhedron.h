// One definition for the host and the kernels: the polyhedron of a triangle (or of a point site) as the device reads
// it.
//
// Lengths are in units, in the metric frame; the unit is the greatest power of two (of the mesh's units) not above the
// voxel. The frame of a triangle has its origin at the foot of the altitude on the longest edge:
//   X along the longest edge, the triangle's base; its ends lie at X = -base[left] and X = +base[right];
//   Y in the plane, from the base to the apex, which lies at (0, altitude);
//   Z along the unit normal (the height s of docs/method.md, 'Leaned frusta').
// The altitude cuts the triangle in two right-angled halves; X < 0 is "left", X >= 0 is "right". A slanted edge has the
// outward unit normal (normal_along, normal_across) in the right half, and the mirror image in the left half.
//
// X, Y and Z are affine in the sample's index: with the integer offset (i, j, k) = sample - origin,
//   (X, Y, Z) = i gradient_x + j gradient_y + k gradient_z + constant
// where the gradients contain the axis' spacing in units. The numbers are there in double ("exact"), from which offsets
// are formed, and rounded to float, for tests that have slack and, but in the scan by vectors, for steps within a
// brick.
//
// The polyhedron, both sides of the face at once, with slack eta and height bound (docs/method.md, 'Rounding and
// slack'):
//   outward distance from edge j <= min(max(slope_above[j] (Z + eta), slope_below[j] (eta - Z)), bound) + eta,
//   |Z| <= bound + eta,  -base[left] - bound - eta <= X <= base[right] + bound + eta.
#ifndef CLSDF_POLYHEDRON_H
#define CLSDF_POLYHEDRON_H

#ifdef __OPENCL_VERSION__
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef int clsdf_int32;
typedef long clsdf_int64;
typedef uint clsdf_uint32;
typedef ulong clsdf_uint64;
typedef uchar clsdf_uint8;
#else
#include <cstddef>
#include <cstdint>
namespace clsdf {
using clsdf_int32 = std::int32_t;
using clsdf_int64 = std::int64_t;
using clsdf_uint32 = std::uint32_t;
using clsdf_uint64 = std::uint64_t;
using clsdf_uint8 = std::uint8_t;
#endif

// Records are selected and made in groups of so many (lib/engine/frusta/records.hpp).
#define CLSDF_RECORD_GROUP 16
// Faces that share a box (lib/engine/frusta/cluster_index.hpp).
#define CLSDF_CLUSTER 64

// Index of an edge in the slopes, and of a half in pairs.
#define CLSDF_EDGE_BASE 0
#define CLSDF_EDGE_RIGHT 1
#define CLSDF_EDGE_LEFT 2
#define CLSDF_HALF_RIGHT 0
#define CLSDF_HALF_LEFT 1

// The slope of an edge that no other face shares: its plane never cuts (docs/method.md, 'Leaned frusta': open * eta >=
// d).
#define CLSDF_OPEN_SLOPE 1.0e6f

// No slope above 1 and no slanted edge steeper than 0.15 to the base: the lateral planes alone bound the polyhedron
// well, so the tests of X and of the bounds on the lateral distances can be left out.
#define CLSDF_POLYHEDRON_COMPACT 1u
// No side longer than CLSDF_NEAR_LENGTH units: tests with slack may be made in float from the integer origin, because
// their rounding, at most 2^-24 (10 R + 15 L) for side lengths L and blocks at distances R, is below half of it.
#define CLSDF_POLYHEDRON_NEAR 2u
#define CLSDF_NEAR_LENGTH 500
// At one of its edges three faces or more meet: another face may lie upon it.
#define CLSDF_POLYHEDRON_NON_MANIFOLD 4u
// A vertex by itself, whose frame has shrunk to a point.
#define CLSDF_POLYHEDRON_POINT 8u
// Two bits from here on: the number of the triangle's vertex at the left end of the base, of which the next one is the
// right end, and the one after it the apex; of a point, the number of the vertex.
#define CLSDF_POLYHEDRON_VERTEX_SHIFT 4

typedef struct Polyhedron {
    // The 32 words that tests read, so that several polyhedra can be transposed into lanes (lane_records.h).
    // Columns: [0] of X, [1] of Y, [2] of Z. Columns are read as vectors of four, the fourth being the next member.
    float gradient_x[3];
    float gradient_y[3];
    float gradient_z[3];
    float constant_at_origin[3];
    float base[2];           // by half: distance from the altitude's foot to the end of the base, >= 0
    float normal_along[2];   // by half: component of the slanted edge's outward normal away from the altitude, >= 0
    float normal_across[2];  // by half: its component along Y, >= 0
    float slope_above[3];    // by edge, on the side Z > 0; widened by the rounding of a float
    float slope_below[3];    // by edge, on the side Z < 0
    float foot[3];           // of the altitude, from the integer origin, along the lattice's axes
    clsdf_int32 origin_x;    // of the integer origin, in samples of the lattice
    clsdf_int32 origin_y;
    clsdf_int32 origin_z;
    clsdf_uint32 flags;
    clsdf_uint32 triangle;  // index in the caller's order; of a point site: one of its vertex's triangles

    double exact_gradient_x[3];
    double exact_gradient_y[3];
    double exact_gradient_z[3];
    double exact_constant_at_origin[3];
    double exact_base[2];
    double exact_normal_along[2];
    double exact_normal_across[2];
    double exact_altitude;
} Polyhedron;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(Polyhedron) == 280);
static_assert(offsetof(Polyhedron, base) == 48);
static_assert(offsetof(Polyhedron, normal_along) == 56);
static_assert(offsetof(Polyhedron, slope_above) == 72);
static_assert(offsetof(Polyhedron, origin_x) == 108);
static_assert(offsetof(Polyhedron, flags) == 120);
static_assert(offsetof(Polyhedron, exact_gradient_x) == 128);
static_assert(offsetof(Polyhedron, exact_base) == 224);
static_assert(offsetof(Polyhedron, exact_normal_along) == 240);
static_assert(offsetof(Polyhedron, exact_altitude) == 272);
}  // namespace clsdf
#endif

#ifdef __OPENCL_VERSION__
// Positions of the numbers of a polyhedron: in its words and, up to the normals, in its exact numbers.
#define NUMBER_GRADIENT_X 0
#define NUMBER_GRADIENT_Y 3
#define NUMBER_GRADIENT_Z 6
#define NUMBER_CONSTANT 9
#define NUMBER_BASE 12
#define NUMBER_NORMAL_ALONG 14
#define NUMBER_NORMAL_ACROSS 16

#define WORD_SLOPE_ABOVE 18
#define WORD_SLOPE_BELOW 21
#define WORD_FOOT 24
#define WORD_ORIGIN 27
#define WORD_FLAGS 30
#define WORDS 32

#define EXACT_ALTITUDE 18
#define EXACT_NUMBERS 19

// The frame's n-th coordinate (i, j, k) samples from the integer origin.
#define FRAME_AT(numbers, n, i, j, k)       \
    ((numbers)[NUMBER_GRADIENT_X + n] * i + \
     ((numbers)[NUMBER_GRADIENT_Y + n] * j + ((numbers)[NUMBER_GRADIENT_Z + n] * k + (numbers)[NUMBER_CONSTANT + n])))
#endif

#endif
