// One definition for the host and the kernels: a convex piece of a bounding polyhedron, for the scan by slices.
//
// A piece is what its half-spaces have in common: with (i, j, k) = sample - origin,
//   normal . (i, j, k) <= offset
// where the normal contains the axis' spacing and is a unit vector in the metric frame, so that the offset is a length
// in units. A triangle counts for the samples of its pieces, those within the slack CLSDF_PIECE_SLACK included, with
// its own distance or, if a piece belongs to one site of it, with the distance to that site.
//
// Each step from whole pieces to samples has less slack than the step before, by more than its rounding. So no sample
// of a piece is lost, and no step gets an empty input:
//   the host's range of slices:             the slack twice;
//   the polygon of a slice, its rows:       thrice;
//   the samples of a row:                   once: this is what counts, and it is the same in every part of a grid.
#ifndef CLSDF_PIECE_H
#define CLSDF_PIECE_H

#include "layout.h"

#define CLSDF_PIECE_SLACK 1.0e-6

// Planes of a piece, at most.
#define CLSDF_MOST_PLANES 16

// The site whose distance a piece has: the nearest of the record's seven, or one of them. Edges and vertices are those
// of its frame (polyhedron.h). The plane of the face and the line of an edge go on beyond them: such a piece ends where
// the site does.
#define CLSDF_SITE_NEAREST 0u
#define CLSDF_SITE_FACE 1u
#define CLSDF_SITE_EDGE 2u    // + CLSDF_EDGE_BASE, _RIGHT, _LEFT
#define CLSDF_SITE_VERTEX 5u  // + CLSDF_VERTEX_RIGHT, _LEFT, _APEX

// Index of a vertex: the ends of the base at X > 0 and X < 0, and the one opposite.
#define CLSDF_VERTEX_RIGHT 0
#define CLSDF_VERTEX_LEFT 1
#define CLSDF_VERTEX_APEX 2

// The counters of the counting variant of the scan by slices, a set for each work-item.
#define CLSDF_SLICES_INTERSECTIONS 0
#define CLSDF_SLICES_EMPTY 1
#define CLSDF_SLICES_EVALUATED 2
#define CLSDF_SLICES_COVERED 3
#define CLSDF_SLICES_COUNTERS 4

#ifdef __OPENCL_VERSION__
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#else
namespace clsdf {
#endif

typedef struct PiecePlane {
    double normal[3];
    double offset;
} PiecePlane;

typedef struct Piece {
    clsdf_uint32 plane_begin;  // planes[plane_begin, plane_begin + plane_count)
    clsdf_uint32 plane_count;
    clsdf_uint32 polyhedron;  // the record that gives the distance
    clsdf_uint32 site;        // of it
    clsdf_int32 slice_begin;  // slices [slice_begin, slice_end) of the lattice cut it within the grid
    clsdf_int32 slice_end;
    clsdf_int32 origin[3];  // in samples of the lattice
} Piece;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(PiecePlane) == 32 && offsetof(PiecePlane, offset) == 24);
static_assert(sizeof(Piece) == 36 && offsetof(Piece, slice_begin) == 16 && offsetof(Piece, origin) == 24);
}  // namespace clsdf
#endif

#endif
