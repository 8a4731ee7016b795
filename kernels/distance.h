// The distance from samples to a triangle by its seven sites (face, edges, vertices).
//
// The altitude on its longest edge divides a triangle in two right-angled halves; the nearest point of the triangle lies in
// the half on the sample's side of the altitude. There, with the coordinates of polyhedron.h:
//   below the base (Y < 0):  distance^2 = max(X - base, 0)^2 + Y^2 + Z^2
//   else:                    distance^2 = max(r, 0)^2 + (t beyond [0, length])^2 + Z^2
// where r is the distance outward from the slanted edge and t the position along it. Each value is an offset at a brick's
// centre, formed in double, plus float gradients times at most 3.5 samples: it rounds with the size of a brick.
#ifndef CLSDF_DISTANCE_H
#define CLSDF_DISTANCE_H

#include "frame.h"
#include "lanes.h"

// Squared distance from the samples (i, j, k) away from the point of the offsets, in voxels.
inline floatL squared_distance(__global const Polyhedron* p, Offsets o, floatL i, floatL j, floatL k) {
    const floatL dx = i * p->gradient_x_high[0] + (j * p->gradient_y_high[0] + k * p->gradient_z_high[0]);
    const floatL dy = i * p->gradient_x_high[1] + (j * p->gradient_y_high[1] + k * p->gradient_z_high[1]);
    const floatL dz = i * p->gradient_x_high[2] + (j * p->gradient_y_high[2] + (k * p->gradient_z_high[2] + o.z_low));
    const floatL y = o.y + dy;
    const floatL z = o.z + dz;  // the one rounding at z's own size: a chain of fma from o.z would round thrice

    const intL right = o.x + dx >= 0.0f;
    const floatL away = right ? dx : -dx;
    const floatL along = right ? (floatL)p->normal_along_high[CLSDF_HALF_RIGHT] : (floatL)p->normal_along_high[CLSDF_HALF_LEFT];
    const floatL across = right ? (floatL)p->normal_across_high[CLSDF_HALF_RIGHT] : (floatL)p->normal_across_high[CLSDF_HALF_LEFT];
    const floatL length = right ? (floatL)p->slanted_length_right : (floatL)p->slanted_length_left;
    const floatL beyond = (right ? (floatL)o.beyond_right : (floatL)o.beyond_left) + away;
    const floatL r = (right ? (floatL)o.outward_right : (floatL)o.outward_left) + (along * away + across * dy);
    const floatL t = (right ? (floatL)o.along_right : (floatL)o.along_left) + (along * dy - across * away);

    const floatL past = t - length;
    const floatL before = LESSER(t, 0.0f);
    const floatL end = GREATER(past, before);
    const floatL out = GREATER(r, 0.0f);
    const floatL corner = GREATER(beyond, 0.0f);
    const floatL in_plane = y < 0.0f ? corner * corner + y * y : end * end + out * out;
    return in_plane + z * z;
}

#endif
