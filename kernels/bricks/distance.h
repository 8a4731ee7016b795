// The distance from samples to a triangle by its seven sites (face, edges, vertices).
//
// The altitude on its longest edge divides a triangle in two right-angled halves; the nearest point of the triangle
// lies in the half on the sample's side of the altitude. This half has two outer edges: the base counts if Y < 0, else
// the slanted one. With r the distance outward from that edge and t the position along it, in the coordinates of
// polyhedron.h,
//   distance^2 = max(r, 0)^2 + (t beyond [0, length])^2 + Z^2
// (for the base, t is the distance from the altitude; the base goes on in the other half, so t has no lower limit).
// Each value is an offset at a brick's centre, formed in double, plus a displacement by at most 3.5 samples along each
// axis: it rounds with the size of a brick.
#ifndef CLSDF_DISTANCE_H
#define CLSDF_DISTANCE_H

#include "edge_offsets.h"
#include "frame.h"
#include "layout.h"
#include "simd.h"

DEFINE_SQUARED_FROM_EDGE(squared_from_edge, floatL)

// The numbers of a polyhedron that the distance takes beside the offsets.
typedef struct Steps {
    float x[3], y[3], z[3];         // of (X, Y, Z), along the lattice's axes
    float along_right, along_left;  // normals of the slanted edges
    float across_right, across_left;
} Steps;

INLINE Steps steps_of(__global const Polyhedron* p) {
    const float4 normal = vload4(0, p->normal_along);
    const Steps s = {{p->gradient_x[0], p->gradient_x[1], p->gradient_x[2]},
                     {p->gradient_y[0], p->gradient_y[1], p->gradient_y[2]},
                     {p->gradient_z[0], p->gradient_z[1], p->gradient_z[2]},
                     normal.x,
                     normal.y,
                     normal.z,
                     normal.w};
    return s;
}

// Squared distance from the samples (i, j, k) away from the point of the offsets, in squared units.
INLINE floatL squared_distance(Steps s, Offsets o, floatL i, floatL j, floatL k) {
    const floatL dx = i * s.x[0] + (j * s.y[0] + k * s.z[0]);
    const floatL dy = i * s.x[1] + (j * s.y[1] + k * s.z[1]);
    const floatL dz = i * s.x[2] + (j * s.y[2] + (k * s.z[2] + o.z_low));
    const floatL y = o.at.y + dy;
    const floatL z = o.at.z + dz;  // the one rounding at z's own size: a chain of fma from o.at.z would round thrice
    const intL left = dx < -o.x, below = y < 0.0f;
    const floatL away = left ? -dx : dx;
    const floatL along = left ? (floatL)s.along_left : (floatL)s.along_right;
    const floatL across = left ? (floatL)s.across_left : (floatL)s.across_right;
    const floatL beyond = (left ? (floatL)o.at.beyond_left : (floatL)o.at.beyond_right) + away;
    const floatL dr = along * away + across * dy, dt = along * dy - across * away;
    const floatL outward = (left ? (floatL)o.at.outward_left : (floatL)o.at.outward_right) + dr;
    const floatL before = (left ? (floatL)o.before_left : (floatL)o.before_right) - dt;
    const floatL past = (left ? (floatL)o.past_left : (floatL)o.past_right) + dt;
    return squared_from_edge(below ? -y : outward, below ? beyond : before, below ? beyond : past, z);
}

DEFINE_EDGE_OFFSETS(LaneEdgeOffsets, lane_edge_offsets, doubleL, longL)

// The same if a brick is so long on one axis that floats around its centre are too coarse: everything in double up
// to the values that are squared. `centre`: (X, Y, Z) at the brick's centre.
static inline floatL squared_distance_long_brick(__global const Polyhedron* p, double4 centre, floatL i, floatL j,
                                                 floatL k) {
    const double4 gx = vload4(0, p->exact_gradient_x), gy = vload4(0, p->exact_gradient_y),
                  gz = vload4(0, p->exact_gradient_z);
    const double2 base = vload2(0, p->exact_base);
    const double4 normals = vload4(0, p->exact_normal_along);  // along right, left, across right, left
    const doubleL di = convert_doubleL(i), dj = convert_doubleL(j), dk = convert_doubleL(k);
    const doubleL x = di * gx.x + (dj * gy.x + (dk * gz.x + centre.x));
    const doubleL y = di * gx.y + (dj * gy.y + (dk * gz.y + centre.y));
    const doubleL z = di * gx.z + (dj * gy.z + (dk * gz.z + centre.z));
    const LaneEdgeOffsets o =
        lane_edge_offsets(x, y, base.x, base.y, normals.x, normals.y, normals.z, normals.w, p->exact_altitude);
    return squared_from_edge(EDGE_THAT_COUNTS(o, convert_floatL), convert_floatL(z));
}

#endif
