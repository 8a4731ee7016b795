// One definition for the host and the kernels: what finishing needs for the outputs.
#ifndef CLSDF_OUTPUTS_H
#define CLSDF_OUTPUTS_H

#include "output_numbers.h"
#include "polyhedron.h"

// Sites of a triangle: its vertices 0, 1, 2; its edges 3, 4, 5, of which edge 3 + k runs from vertex k to the next;
// its face. If triangles are pieces of faces, also an edge or a vertex at which faces cut each other.
#define CLSDF_SITE_OF_FACE 6
#define CLSDF_SITE_OF_CUT 7

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// Names of a triangle's vertices and edges: each is named as a site of the lowest triangle that shares it.
typedef struct TriangleSites {
    clsdf_uint32 triangle[6];  // by site: the lowest triangle, in the caller's order
    // By site: its number there, with CLSDF_SITE_REVERSED if that triangle's edge runs the other way.
    clsdf_uint8 site[6];
    clsdf_uint8 unused[2];  // 0: bytes that are shared have no padding
} TriangleSites;

// A triangle that is a piece of a face as given, and how the outputs tell it. Rows of two TriangleSites.
typedef struct FacePiece {
    double weights[6];     // by vertex: its barycentric coordinates in the face, the weights of the vertices 1 and 2
    clsdf_uint32 face;     // its number
    clsdf_uint8 site[12];  // by site, up to that of the face: its number in the lowest face that has it
} FacePiece;

#define CLSDF_SITE_NUMBER 7u
#define CLSDF_SITE_REVERSED 8u

// The properties of the grid and of the outputs that finishing needs.
typedef struct Finish {
    double origin[3];       // position of the lattice's sample (0, 0, 0), in the mesh's units
    double spacing[3];      // in the mesh's units
    double per_spacing[3];  // the reciprocals, per unit of the layout
    double unit;            // of the layout, in the mesh's units
    double inside_fill;     // -inside and outside, the distances in double beyond the band
    double outside_fill;
    clsdf_uint32 wanted;      // bit n: output n, beside the distance, is stored
    clsdf_uint32 in_double;   // bit n: its elements are doubles
    float outward;            // -1 if pseudonormals point inside: the mesh is inside out
    clsdf_uint32 renumbered;  // triangles of a part of a mesh, whose numbers in the whole follow their sites; else 0
    clsdf_uint32 pieces;      // triangles that are pieces of faces, of which rows follow their sites; else 0
    clsdf_uint32 turned;      // triangles whose directions, 1 or -1, follow their pseudonormals; 0: all are 1
    float least_inside;       // of the layout
} Finish;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(TriangleSites) == 32);
static_assert(sizeof(FacePiece) == 2 * sizeof(TriangleSites));
static_assert(sizeof(Finish) == 128 && offsetof(Finish, wanted) == 96);
}  // namespace clsdf
#endif

#endif
