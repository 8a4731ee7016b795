// The nearest triangle of a sample so far is the least of an ordered key: the bits of the squared distance above the
// triangle's index. So a scan in any order ends with the same one. Squared distances are not negative, so their bits
// are in their order; equal ones go to the lower triangle.
//   KEY_64: one 64-bit number, by 64-bit atomics.
//   else: two 32-bit numbers, in two passes: the least distances first, then the least triangle among those that have
//   them. Without NEAREST the first pass is all.
#ifndef CLSDF_SLICES_H
#define CLSDF_SLICES_H

#include "distance.h"
#include "piece.h"

#ifdef KEY_64
#pragma OPENCL EXTENSION cl_khr_int64_extended_atomics : enable
#endif

#ifdef KEY_64
#define KEY_PARAMETERS __global ulong* keys
#define KEY_ARGUMENTS keys
#else
#define KEY_PARAMETERS __global uint *squares, __global uint *triangles, int pass
#define KEY_ARGUMENTS squares, triangles, pass
#endif

static inline void propose(KEY_PARAMETERS, size_t sample, float squared, uint triangle) {
#ifdef KEY_64
    atom_min(keys + sample, (ulong)as_uint(squared) << 32 | triangle);
#else
    if (pass == 0)
        atomic_min(squares + sample, as_uint(squared));
    else if (as_uint(squared) == squares[sample])
        atomic_min(triangles + sample, triangle);
#endif
}

static inline uint2 square_and_triangle(KEY_PARAMETERS, size_t sample) {
#ifdef KEY_64
    return (uint2)((uint)(keys[sample] >> 32), (uint)keys[sample]);
#elif defined(NEAREST)
    return (uint2)(squares[sample], triangles[sample]);
#else
    return (uint2)(squares[sample], 0u);
#endif
}

// The distance from samples to one site of a triangle: its face's plane, the line of an edge, or a vertex. The plane
// and the line count only for samples whose foot lies on the site.

// The numbers are those of the half in which the site lies: how far `beyond` the end of the base, the distance r
// outward from the slanted edge's line, and how far `past` its end at the apex.
INLINE floatL squared_at_site(uint site, floatL y, floatL z, floatL beyond, floatL r, floatL past) {
    const floatL zz = z * z;
    if (site == CLSDF_SITE_FACE) return zz;
    if (site == CLSDF_SITE_EDGE + CLSDF_EDGE_BASE) return y * y + zz;
    if (site < CLSDF_SITE_VERTEX) return r * r + zz;
    return site == CLSDF_SITE_VERTEX + CLSDF_VERTEX_APEX ? past * past + r * r + zz : beyond * beyond + y * y + zz;
}

static inline bool is_of_left_half(uint site) {
    return site == CLSDF_SITE_EDGE + CLSDF_EDGE_LEFT || site == CLSDF_SITE_VERTEX + CLSDF_VERTEX_LEFT;
}

// As squared_distance and squared_distance_long_brick, for any site but CLSDF_SITE_NEAREST.
static inline floatL squared_distance_to_site(__global const Polyhedron* p, Offsets o, uint site, floatL i, floatL j,
                                              floatL k) {
    const floatL dx = i * p->gradient_x[0] + (j * p->gradient_y[0] + k * p->gradient_z[0]);
    const floatL dy = i * p->gradient_x[1] + (j * p->gradient_y[1] + k * p->gradient_z[1]);
    const floatL dz = i * p->gradient_x[2] + (j * p->gradient_y[2] + (k * p->gradient_z[2] + o.z_low));
    const bool left = is_of_left_half(site);
    const floatL away = left ? -dx : dx;
    const float along = p->normal_along[left ? CLSDF_HALF_LEFT : CLSDF_HALF_RIGHT];
    const float across = p->normal_across[left ? CLSDF_HALF_LEFT : CLSDF_HALF_RIGHT];
    const floatL beyond = (left ? o.at.beyond_left : o.at.beyond_right) + away;
    const floatL r = (left ? o.at.outward_left : o.at.outward_right) + (along * away + across * dy);
    const floatL past = (left ? o.past_left : o.past_right) + (along * dy - across * away);
    return squared_at_site(site, o.at.y + dy, o.at.z + dz, beyond, r, past);
}

static inline floatL squared_distance_to_site_long_brick(__global const Polyhedron* p, double4 centre, uint site,
                                                         floatL i, floatL j, floatL k) {
    const double4 gx = vload4(0, p->exact_gradient_x), gy = vload4(0, p->exact_gradient_y),
                  gz = vload4(0, p->exact_gradient_z);
    const doubleL di = convert_doubleL(i), dj = convert_doubleL(j), dk = convert_doubleL(k);
    const doubleL x = di * gx.x + (dj * gy.x + (dk * gz.x + centre.x));
    const doubleL y = di * gx.y + (dj * gy.y + (dk * gz.y + centre.y));
    const doubleL z = di * gx.z + (dj * gy.z + (dk * gz.z + centre.z));
    const bool left = is_of_left_half(site);
    const int side = left ? CLSDF_HALF_LEFT : CLSDF_HALF_RIGHT;
    const double along = p->exact_normal_along[side], across = p->exact_normal_across[side];
    const doubleL away = left ? -x : x;
    const doubleL beyond = away - p->exact_base[side];
    return squared_at_site(site, convert_floatL(y), convert_floatL(z), convert_floatL(beyond),
                           convert_floatL(along * beyond + across * y),
                           convert_floatL(along * (y - p->exact_altitude) - across * away));
}

#endif
