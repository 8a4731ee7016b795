// What a lattice needs of a mesh, made on a device with memory of its own: the records of faces, and the vertices of
// the sign's sweep. The host sends 40 bytes a face and 24 a vertex, where a record has 280.
//
// A record has the bytes that the host would write: triangle_frame() of lib/polyhedra/triangle_frame.cpp and pack() of
// records.cpp, operation by operation, without their special cases. Quotients and roots of doubles are rounded
// correctly by every device, and nothing is contracted. The host writes the records of point sites and of faces that
// are nearly degenerate, and place_records moves them to their places.
//
// LANES is 1: a work-item is a face, a record or a vertex.

#include "face_sources.h"
#include "inline.h"
#include "sweep.h"

#pragma OPENCL FP_CONTRACT OFF

INLINE double dot_in_order(double3 a, double3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Frame of lib/polyhedra/triangle_frame.hpp, as far as records need it. Components of pairs: right half, left half.
typedef struct FaceFrame {
    double3 along, across, normal;
    double3 foot;  // from the lattice's sample (0, 0, 0)
    double2 base, normal_along, normal_across;
    double altitude;
    uint base_edge;
} FaceFrame;

// Sets the frame's axes, base and altitude. to_apex: the edge from the base's end; from_apex: to its start.
INLINE void set_axes(double3 base, double3 to_apex, double3 from_apex, double squared_base, bool is_right,
                     __private FaceFrame* f) {
    f->along = base / sqrt(squared_base);
    const double right = -dot_in_order(to_apex, f->along), left = -dot_in_order(from_apex, f->along);
    f->base = (double2)(0.0 < right ? right : 0.0, 0.0 < left ? left : 0.0);
    double3 across = is_right ? to_apex : -from_apex;
    across -= dot_in_order(across, f->along) * f->along;
    across -= dot_in_order(across, f->along) * f->along;
    const double height = sqrt(dot_in_order(across, across));
    across /= height;
    across -= dot_in_order(across, f->along) * f->along;
    f->across = across / sqrt(dot_in_order(across, across));
    f->normal = (double3)(f->along.y * f->across.z - f->along.z * f->across.y,
                          f->along.z * f->across.x - f->along.x * f->across.z,
                          f->along.x * f->across.y - f->along.y * f->across.x);
    const double2 slanted = sqrt(f->base * f->base + height * height);
    f->normal_along = height / slanted;
    f->normal_across = f->base / slanted;
    f->altitude = slanted.x * f->normal_along.x;
}

static inline FaceFrame frame_of_face(FaceLattice lattice, double3 a, double3 b, double3 c) {
    const double3 first = lattice.per_unit * (b - a), second = lattice.per_unit * (c - b),
                  third = lattice.per_unit * (a - c);
    const double squared_first = dot_in_order(first, first), squared_second = dot_in_order(second, second),
                 squared_third = dot_in_order(third, third);
    FaceFrame f;
    double3 near_end;
    bool is_right;
    const bool is_second = !(squared_first >= squared_second);
    if (squared_third > (is_second ? squared_second : squared_first)) {
        f.base_edge = 2;
        is_right = squared_first <= squared_second;
        set_axes(third, first, second, squared_third, is_right, &f);
        near_end = is_right ? a : c;
    } else if (is_second) {
        f.base_edge = 1;
        is_right = squared_third <= squared_first;
        set_axes(second, third, first, squared_second, is_right, &f);
        near_end = is_right ? c : b;
    } else {
        f.base_edge = 0;
        is_right = squared_second <= squared_third;
        set_axes(first, second, third, squared_first, is_right, &f);
        near_end = is_right ? b : a;
    }
    const double to_foot = is_right ? f.base.x : -f.base.y;
    f.foot = lattice.per_unit * (near_end - vload3(0, lattice.origin)) - to_foot * f.along;
    return f;
}

// Writes the integer origin, the foot and the constants.
INLINE void pack_origin(FaceLattice lattice, __private const FaceFrame* f, __global Polyhedron* record) {
    const double3 spacing = vload3(0, lattice.spacing);
    const double3 limit = (double)(1 << 30);
    const double3 origin = rint(clamp(f->foot / spacing, -limit, limit));
    record->origin_x = (int)origin.x;
    record->origin_y = (int)origin.y;
    record->origin_z = (int)origin.z;
    const double3 offset = f->foot - origin * spacing;
    vstore3(convert_float3(offset), 0, record->foot);
    const double3 at_origin =
        (double3)(-dot_in_order(f->along, offset), -dot_in_order(f->across, offset), -dot_in_order(f->normal, offset));
    vstore3(at_origin, 0, record->exact_constant_at_origin);
    vstore3(convert_float3(at_origin), 0, record->constant_at_origin);
}

INLINE void pack_gradient(double3 gradient, __global double* exact, __global float* rounded) {
    vstore3(gradient, 0, exact);
    vstore3(convert_float3(gradient), 0, rounded);
}

INLINE void pack_pair(double2 pair, __global double* exact, __global float* rounded) {
    vstore2(pair, 0, exact);
    vstore2(convert_float2(pair), 0, rounded);
}

// Writes the slopes by the polyhedron's edges; returns whether none is above 1.
INLINE bool pack_slopes(__global const float* slopes, uint base_edge, __global Polyhedron* record) {
    bool flat = true;
    for (uint k = 0; k < 3; ++k) {
        const uint edge = k >= base_edge ? k - base_edge : k + 3 - base_edge;
        const float above = slopes[k], below = slopes[3 + k];
        record->slope_above[edge] = above;
        record->slope_below[edge] = below;
        flat = flat && above <= 1.0f && below <= 1.0f;
    }
    return flat;
}

INLINE bool is_near(__private const FaceFrame* f, __global const Polyhedron* record) {
    const float length = CLSDF_NEAR_LENGTH;
    return f->base.x <= length && f->base.y <= length && f->altitude <= length && fabs(record->foot[0]) <= length &&
           fabs(record->foot[1]) <= length && fabs(record->foot[2]) <= length;
}

// Records [begin, end): those of CLSDF_RECORD_GROUP faces for each of `groups`, which are numbers of such groups; the
// mesh's last face fills up the last one.
__kernel void face_records(FaceLattice lattice, uint begin, uint end, uint face_count, __global const uint* groups,
                           __global const uint* triangles, __global const double* positions,
                           __global const float* slopes, __global const uint* names, __global Polyhedron* records) {
    const uint n = begin + get_global_id(0);
    if (n >= end) return;
    const uint face = min(groups[n / CLSDF_RECORD_GROUP] * CLSDF_RECORD_GROUP + n % CLSDF_RECORD_GROUP, face_count - 1);
    const uint3 corners = vload3(face, triangles);
    const FaceFrame f = frame_of_face(lattice, vload3(corners.x, positions), vload3(corners.y, positions),
                                      vload3(corners.z, positions));
    __global Polyhedron* record = records + n;
    pack_origin(lattice, &f, record);
    pack_gradient((double3)(f.along.x, f.across.x, f.normal.x) * lattice.spacing[0], record->exact_gradient_x,
                  record->gradient_x);
    pack_gradient((double3)(f.along.y, f.across.y, f.normal.y) * lattice.spacing[1], record->exact_gradient_y,
                  record->gradient_y);
    pack_gradient((double3)(f.along.z, f.across.z, f.normal.z) * lattice.spacing[2], record->exact_gradient_z,
                  record->gradient_z);
    pack_pair(f.base, record->exact_base, record->base);
    pack_pair(f.normal_along, record->exact_normal_along, record->normal_along);
    pack_pair(f.normal_across, record->exact_normal_across, record->normal_across);
    record->exact_altitude = f.altitude;
    const bool is_flat = pack_slopes(slopes + (size_t)6 * face, f.base_edge, record);
    const uint name = names[face];
    record->triangle = name & ~CLSDF_NAME_NON_MANIFOLD;
    record->flags = f.base_edge << CLSDF_POLYHEDRON_VERTEX_SHIFT |
                    (is_flat && f.normal_along.x > 0.15 && f.normal_along.y > 0.15 ? CLSDF_POLYHEDRON_COMPACT : 0u) |
                    (is_near(&f, record) ? CLSDF_POLYHEDRON_NEAR : 0u) |
                    (name & CLSDF_NAME_NON_MANIFOLD ? CLSDF_POLYHEDRON_NON_MANIFOLD : 0u);
}

// Moves `count` records that the host wrote to their places.
__kernel void place_records(uint count, __global const Polyhedron* written, __global const uint* places,
                            __global Polyhedron* records) {
    const uint n = get_global_id(0);
    if (n < count) records[places[n]] = written[n];
}

// The vertices of the sign's sweep, as lib/transform/sweep_mesh.cpp snaps them to multiples of 1 / scale samples. None
// is far from the lattice's sample (0, 0, 0).
__kernel void sweep_vertices(FaceLattice lattice, double scale_y, double scale_z, uint begin, uint end,
                             __global const double* positions, __global SweepVertex* vertices) {
    const uint n = begin + get_global_id(0);
    if (n >= end) return;
    const double3 samples = (vload3(n, positions) - vload3(0, lattice.origin)) / vload3(0, lattice.sample);
    const SweepVertex vertex = {(long)rint(samples.y * scale_y), (long)rint(samples.z * scale_z), samples.x};
    vertices[n] = vertex;
}
