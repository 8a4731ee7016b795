// The distance from samples to a triangle by its seven sites (face, edges, vertices).
//
// The altitude on its longest edge divides a triangle in two right-angled halves; the nearest point of the triangle
// lies in the half on the sample's side of the altitude. There, with the coordinates of polyhedron.h:
//   below the base (Y < 0):  distance^2 = max(X - base, 0)^2 + Y^2 + Z^2
//   else:                    distance^2 = max(r, 0)^2 + (t beyond [0, length])^2 + Z^2
// where r is the distance outward from the slanted edge and t the position along it. Each value is an offset at a
// brick's centre, formed in double, plus float gradients times at most 3.5 samples: it rounds with the size of a brick.
#ifndef CLSDF_DISTANCE_H
#define CLSDF_DISTANCE_H

#include "frame.h"
#include "lanes.h"

// The formulas above; `past` is t minus the length of the slanted edge.
INLINE floatL squared_from_frame(floatL y, floatL z, floatL beyond, floatL r, floatL t, floatL past) {
    const intL below = y < 0.0f;
    const floatL along = GREATER(below ? beyond : past, below ? (floatL)0.0f : LESSER(t, 0.0f));
    const floatL outward = below ? y : GREATER(r, 0.0f);
    return along * along + outward * outward + z * z;
}

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

// Squared distance from the samples displaced by (dx, dy, dz) along X, Y, Z from the point of the offsets, in squared
// units. dz contains what the offset of z lacks.
INLINE floatL squared_distance_displaced(Steps s, Offsets o, floatL dx, floatL dy, floatL dz) {
    const floatL y = o.y + dy;
    const floatL z = o.z + dz;  // the one rounding at z's own size: a chain of fma from o.z would round thrice

    const intL right = dx >= -o.x;
    const floatL away = right ? dx : -dx;
    const floatL along = right ? (floatL)s.along_right : (floatL)s.along_left;
    const floatL across = right ? (floatL)s.across_right : (floatL)s.across_left;
    const floatL dr = along * away + across * dy;
    const floatL dt = along * dy - across * away;
    const floatL beyond = (right ? (floatL)o.beyond_right : (floatL)o.beyond_left) + away;
    const floatL r = (right ? (floatL)o.outward_right : (floatL)o.outward_left) + dr;
    const floatL t = (right ? (floatL)o.along_right : (floatL)o.along_left) + dt;
    const floatL past = (right ? (floatL)o.past_right : (floatL)o.past_left) + dt;
    return squared_from_frame(y, z, beyond, r, t, past);
}

// The same from the samples (i, j, k) away from the point of the offsets.
INLINE floatL squared_distance(Steps s, Offsets o, floatL i, floatL j, floatL k) {
    return squared_distance_displaced(s, o, i * s.x[0] + (j * s.y[0] + k * s.z[0]),
                                      i * s.x[1] + (j * s.y[1] + k * s.z[1]),
                                      i * s.x[2] + (j * s.y[2] + (k * s.z[2] + o.z_low)));
}

// The same where a brick is so long on one axis that floats around its centre are too coarse: everything in double up
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
    const longL right = x >= 0.0;
    const doubleL away = right ? x : -x;
    const doubleL along = right ? (doubleL)normals.x : (doubleL)normals.y;
    const doubleL across = right ? (doubleL)normals.z : (doubleL)normals.w;
    const doubleL beyond = away - (right ? (doubleL)base.x : (doubleL)base.y);
    const doubleL above_apex = y - p->exact_altitude;
    return squared_from_frame(convert_floatL(y), convert_floatL(z), convert_floatL(beyond),
                              convert_floatL(along * beyond + across * y), convert_floatL(along * y - across * beyond),
                              convert_floatL(along * above_apex - across * away));
}

#endif
