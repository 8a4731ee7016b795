// One definition for the host and the kernels: what a picture of a field's surface is traced with, and what a ray
// meets.
//
// Points are in samples from the field's first one, distances in voxels (the smallest spacing).
#ifndef CLSDF_RENDER_H
#define CLSDF_RENDER_H

#include "polyhedron.h"

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// A ray meets nothing, the surface, or the inside of the solid where it was opened: by a cut across x, y or z
// (CLSDF_RENDER_CUT + 0, 1, 2), or by the end of the grid.
#define CLSDF_RENDER_NOTHING 0
#define CLSDF_RENDER_SURFACE 1
#define CLSDF_RENDER_CUT 2
#define CLSDF_RENDER_BORDER 5

typedef struct RenderView {
    // The ray in column c and row r: origin + c origin_right + r origin_down + t (direction + ...), t >= 0.
    double origin[3];
    double origin_right[3];
    double origin_down[3];
    double direction[3];
    double direction_right[3];
    double direction_down[3];
    double cut[3];            // taken away is what has cut_side[a] (p[a] - cut[a]) > 0 for every axis a with a side
    float light[3];           // unit vector to the light, in the mesh's space
    float light_spread;       // tangent of half the angle that the light is seen under
    float spacing[3];         // voxels from sample to sample, >= 1
    float level;              // the surface's distance
    float slope[3];           // the steepest edge between two samples along each axis, voxels by voxel
    float highest;            // what the field says far from the surface; it knows nothing of larger distances
    float gradient_step;      // samples; the differences that make a gradient span two of them
    float reach;              // how far a surface is darkened by what is around it
    clsdf_int32 cut_side[3];  // -1, 0 (no cut across this axis) or 1
    clsdf_int32 size[3];      // samples
    clsdf_int32 columns;
    clsdf_int32 rows;
    clsdf_int32 per_side;  // columns and rows of rays that a pixel has
    clsdf_int32 padding;
} RenderView;

typedef struct RenderHit {
    float position[3];
    clsdf_int32 kind;
    float gradient[3];  // of the distance, in the mesh's space: about 1 long
    float value;        // the distance; at the surface the level, within the rounding of the search
    float light;        // of the direct light, 0 ... 1
    float ambient;      // of the light from all around, 0 ... 1
    float padding[2];
} RenderHit;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(RenderView) == 264);
static_assert(offsetof(RenderView, light) == 168);
static_assert(sizeof(RenderHit) == 48);
}  // namespace clsdf
#endif

#endif
