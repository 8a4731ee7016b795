// A polyhedron's frame at a point of the lattice.
//
// Offsets are formed in double and rounded once, so that what follows in float rounds with the size of the block, not
// with that of the triangle or the grid.
#ifndef CLSDF_FRAME_H
#define CLSDF_FRAME_H

#include "layout.h"
#include "simd.h"

// (X, Y, Z, -) at a point given in samples of the lattice.
INLINE double4 frame_at(__global const Polyhedron* p, double x, double y, double z) {
    return vload4(0, p->exact_gradient_x) * (x - p->origin_x) +
           (vload4(0, p->exact_gradient_y) * (y - p->origin_y) +
            (vload4(0, p->exact_gradient_z) * (z - p->origin_z) + vload4(0, p->exact_constant_at_origin)));
}

#ifdef __OPENCL_VERSION__
// From the first sample of a brick, or of a coarse brick, to its centre, in samples.
#define BRICK_CENTRE (0.5f * (CLSDF_BRICK - 1))
#define COARSE_CENTRE (0.5f * (CLSDF_COARSE - 1))

// The frame's coordinates but X, and what follows from them by subtraction of nearly equal numbers, at one point, as a
// test with slack takes them. "Right" and "left" are the formulas of the two halves; each holds where X lies on its
// side.
typedef struct FramePosition {
    float y, z;
    float beyond_right, beyond_left;    // X - base[right], -X - base[left]
    float outward_right, outward_left;  // distance outward from the line of the slanted edge
} FramePosition;

// All that follows from one point.
typedef struct Offsets {
    FramePosition at;
    float x;
    float z_low;                      // what z lacks: most samples' nearest site is a face, and their distance is |z|
    float before_right, before_left;  // along the slanted edge, before its end at the base; negative on it
    float past_right, past_left;      // past its end at the apex
} Offsets;

INLINE Offsets offsets_at(__global const Polyhedron* p, double x, double y, double z) {
    const double4 frame = frame_at(p, x, y, z);
    const double2 beyond = (double2)(frame.x, -frame.x) - vload2(0, p->exact_base);  // right, left
    const double2 along = vload2(0, p->exact_normal_along), across = vload2(0, p->exact_normal_across);
    const double above_apex = frame.y - p->exact_altitude;
    const float2 beyond_base = convert_float2(beyond);
    const float2 outward = convert_float2(along * beyond + across * frame.y);
    const float2 before = convert_float2(across * beyond - along * frame.y);
    const float2 past = convert_float2(along * above_apex - across * (double2)(frame.x, -frame.x));
    Offsets o;
    o.x = (float)frame.x;
    o.at.y = (float)frame.y;
    o.at.z = (float)frame.z;
    o.z_low = (float)(frame.z - (double)o.at.z);
    o.at.beyond_right = beyond_base.x;
    o.at.beyond_left = beyond_base.y;
    o.at.outward_right = outward.x;
    o.at.outward_left = outward.y;
    o.before_right = before.x;
    o.before_left = before.y;
    o.past_right = past.x;
    o.past_left = past.y;
    return o;
}

// At the point `centre` samples along each axis from sample (x, y, z).
INLINE FramePosition frame_position_at(__global const Polyhedron* p, int x, int y, int z, float centre) {
    if (!(p->flags & CLSDF_POLYHEDRON_NEAR))
        return offsets_at(p, x + (double)centre, y + (double)centre, z + (double)centre).at;
    const float i = (float)(x - p->origin_x) + centre, j = (float)(y - p->origin_y) + centre,
                k = (float)(z - p->origin_z) + centre;
    const float4 frame =
        vload4(0, p->gradient_x) * i +
        (vload4(0, p->gradient_y) * j + (vload4(0, p->gradient_z) * k + vload4(0, p->constant_at_origin)));
    const float4 normal = vload4(0, p->normal_along);  // along right, left, across right, left
    FramePosition position;
    position.y = frame.y;
    position.z = frame.z;
    position.beyond_right = frame.x - p->base[CLSDF_HALF_RIGHT];
    position.beyond_left = -frame.x - p->base[CLSDF_HALF_LEFT];
    position.outward_right = normal.x * position.beyond_right + normal.z * frame.y;
    position.outward_left = normal.y * position.beyond_left + normal.w * frame.y;
    return position;
}

INLINE float longest_spacing(Layout layout) {
    const float two = GREATER(layout.spacing[0], layout.spacing[1]);
    return GREATER(two, layout.spacing[2]);
}

// The greatest power of two not above a positive number.
INLINE float power_of_two_below(float number) {
    return as_float(as_uint(number) & 0x7F800000u);
}

// From the foot of the polyhedron's altitude, a point of the surface, to the point `centre` samples along each axis
// from sample (x, y, z): along the lattice's axes, in units.
INLINE float3 from_foot_to(Layout layout, __global const Polyhedron* p, int x, int y, int z, float centre) {
    const float3 samples =
        (float3)((float)(x - p->origin_x), (float)(y - p->origin_y), (float)(z - p->origin_z)) + centre;
    return samples * vload3(0, layout.spacing) - vload3(0, p->foot);
}

// Prefetch a polyhedron, or its foot alone: those of a list are scattered over more memory than the inner caches hold.
static inline void prefetch_record(__global const Polyhedron* p) {
    for (uint line = 0; line < sizeof(Polyhedron); line += 64) prefetch_line((__global const uchar*)p + line);
}
static inline void prefetch_foot(__global const Polyhedron* p) {
    prefetch_line(p->foot);
    prefetch_line(&p->origin_z);
}

#endif

#endif
