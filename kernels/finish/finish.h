// Finishing: what a field holds beside the distance in float, from a sample's nearest polyhedron. A new output is a row
// of <clsdf/output_table.h> and a function here (docs/architecture.md, 'An output').
//
// The sample's coordinates in the triangle's frame (polyhedron.h) are formed in double, and tell the nearest of the
// seven sites, the closest point and the direction. The altitude divides the triangle in two right-angled halves; the
// half on the sample's side has the nearest point. Nothing is divided by the triangle's area: slivers are as exact as
// other triangles.
//
// A sample within SITE_TOLERANCE of the border between the regions of two sites belongs to the smaller one: a vertex
// comes before an edge, an edge before the face.
#ifndef CLSDF_FINISH_H
#define CLSDF_FINISH_H

#include "edge_offsets.h"
#include "frame.h"
#include "layout.h"
#include "outputs.h"
#include "simd.h"
#include "vectors.h"

// In units: above the rounding of frames, and far below what the outputs promise.
#define SITE_TOLERANCE 1.0e-10
// Relative to the coordinates that differences are taken of.
#define SITE_ROUNDING 1.0e-13
// The same of a distance: what is less is 0, so that samples on the surface have no sign.
#define DISTANCE_ROUNDING 4.0e-16
// In units, squared. A sample nearer than that to its closest point takes the site's pseudonormal: its own direction is
// within the rounding of frames of a mesh a billion voxels large, and nothing is promised of it.
#define SQUARE_OF_NO_DISTANCE 2.5e-13

// Sites as the frame numbers them: vertices left, right, apex; edges from each to the next; the face.
#define FRAME_LEFT 0u
#define FRAME_RIGHT 1u
#define FRAME_APEX 2u
#define FRAME_BASE 3u
#define FRAME_RIGHT_EDGE 4u
#define FRAME_LEFT_EDGE 5u

#define IS_WANTED(finishing, name) ((finishing)->how.wanted >> CLSDF_OUTPUT_##name & 1u)
#define IS_DOUBLE(finishing, name) ((finishing)->how.in_double >> CLSDF_OUTPUT_##name & 1u)

// The inputs of finishing, and its outputs: `of_name` is the first byte of output `name`.
typedef struct Finishing {
    Finish how;
    __global const Polyhedron* polyhedra;
    __global const TriangleSites* sites;  // of the triangles, in the mesh's order; for CLSDF_OUTPUTS_BY_NAME
    __global const float* normals;        // pseudonormals, six sites a triangle; for the gradient
    __global double* of_distance;         // if it is in double
#define OUTPUT_POINTER(name, content, element, components, number) __global uchar* of_##name;
    CLSDF_OUTPUTS(OUTPUT_POINTER)
#undef OUTPUT_POINTER
} Finishing;

// A site as its lowest triangle names it.
typedef struct NamedSite {
    uint triangle;
    uint site;
    bool is_reversed;  // of an edge: the named triangle's runs the other way
} NamedSite;
#define UNNAMED_SITE \
    { CLSDF_NO_TRIANGLE, 0xFFu, false }

// The nearest site of a sample, as the outputs need it.
typedef struct Nearest {
    double3 from;      // from the closest point to the sample, along the frame's axes, in units
    double3 axes[3];   // by axis of the mesh: that of the frame's three unit vectors
    uint frame_site;   // as the frame numbers it
    double sign;       // of the distance: 1 or -1
    double3 position;  // of the sample
    __global const Polyhedron* polyhedron;
    double2 foot;     // the closest point, in the frame's plane
    NamedSite named;  // for CLSDF_OUTPUTS_BY_NAME
} Nearest;

// A record's exact numbers from its bases on: the bases, along and across by half, right and left; the altitude.
INLINE void load_halves(__global const Polyhedron* p, __private double* halves) {
    const double2 base = vload2(0, p->exact_base);
    const double4 normals = vload4(0, p->exact_normal_along);
    halves[0] = base.x;
    halves[1] = base.y;
    halves[2] = normals.x;
    halves[3] = normals.y;
    halves[4] = normals.z;
    halves[5] = normals.w;
    halves[6] = p->exact_altitude;
}

// The nearest site of a triangle as the frame numbers it, and how far the sample lies from its closest point in the
// frame's plane, along X and Y. (x, y, z): of the sample. p: of load_halves(). The same
// formula serves one sample and vectors of samples. (oclgrind gets the negation of a vector's mask wrong, which ?:
// makes of it; select() does not.)
#define DEFINE_FROM_SITE(name, EdgeOffsets, edge_offsets, Real, Mask)                                                 \
    INLINE void name(__private const Real* p, Real x, Real y, Real z, __private Real* from_x, __private Real* from_y, \
                     __private Real* site) {                                                                          \
        const Real right_base = p[0], left_base = p[1], altitude = p[6];                                              \
        const EdgeOffsets o = edge_offsets(x, y, right_base, left_base, p[2], p[3], p[4], p[5], altitude);            \
        const Real tolerance =                                                                                        \
            SITE_TOLERANCE + SITE_ROUNDING * ((o.away + fabs(y)) + (fabs(z) + altitude) + (right_base + left_base));  \
        const Mask at_base = y <= tolerance, is_apex = o.past >= -tolerance;                                          \
        const Mask is_end = select(o.before, o.beyond, at_base) >= -tolerance;                                        \
        const Mask is_face = (y > tolerance) & (o.outward < -tolerance);                                              \
        /* At the base the apex of a low triangle and the end of the other half may be as near as the own end. */     \
        const Mask at_apex = (o.away <= tolerance) & (altitude <= tolerance);                                         \
        const Real other_base = o.away + select(left_base, right_base, o.left);                                       \
        const Mask is_other_end = other_base <= tolerance;                                                            \
        /* A sliver's other half may be narrower than the rounding of x: its edge is within the tolerance, too. */    \
        const Real other_outward = select(p[5], p[4], o.left) * y - select(p[3], p[2], o.left) * other_base;          \
        const Real nothing = 0.0;                                                                                     \
        Real far_x = select(o.outward * o.along, o.away, is_apex),                                                    \
             far_y = select(o.outward * o.across, y - altitude, is_apex);                                             \
        Real number =                                                                                                 \
            select(select((Real)FRAME_RIGHT_EDGE, (Real)FRAME_LEFT_EDGE, o.left), (Real)FRAME_APEX, is_apex);         \
        far_x = select(select(far_x, nothing, at_base), o.beyond, is_end);                                            \
        far_y = select(far_y, y, at_base | is_end);                                                                   \
        Real of_base = select((Real)FRAME_BASE, (Real)FRAME_APEX, at_apex);                                           \
        of_base = select(of_base, select((Real)FRAME_LEFT, (Real)FRAME_RIGHT, o.left), is_other_end);                 \
        number = select(number, of_base, at_base);                                                                    \
        number = select(number, select((Real)FRAME_RIGHT, (Real)FRAME_LEFT, o.left), is_end);                         \
        *from_x = select(select(far_x, -far_x, o.left), nothing, is_face);                                            \
        *from_y = select(far_y, nothing, is_face);                                                                    \
        const Real other_edge = select((Real)FRAME_LEFT_EDGE, (Real)FRAME_RIGHT_EDGE, o.left);                        \
        const Mask is_on_other = other_outward >= -tolerance;                                                         \
        const Real of_face = select((Real)CLSDF_SITE_OF_FACE, other_edge, is_on_other);                               \
        *site = select(number, of_face, is_face);                                                                     \
    }
DEFINE_EDGE_OFFSETS(EdgeOffsets, edge_offsets, double, long)
DEFINE_FROM_SITE(from_site, EdgeOffsets, edge_offsets, double, long)

// Weights of the point (x, y) of a site of the frame. Edge: *first is that of its second end, from the way along it.
// Face: *first is that of the right end of the base, *second that of the apex, from heights over the base. Neither
// divides by the triangle's area. A vertex has none.
#define DEFINE_FRAME_WEIGHTS(name, Real, Mask)                                                          \
    INLINE void name(__private const Real* p, Real x, Real y, Real site, __private Real* first,         \
                     __private Real* second) {                                                          \
        const Mask is_base = site == (Real)FRAME_BASE, is_right = site == (Real)FRAME_RIGHT_EDGE;       \
        const Mask is_left = site == (Real)FRAME_LEFT_EDGE, is_face = site == (Real)CLSDF_SITE_OF_FACE; \
        const Real right = p[0], left = p[1], altitude = p[6];                                          \
        const Real base = select(left, right, is_right), away = select(-x, x, is_right);                \
        const Real along = select(p[3], p[2], is_right), across = select(p[5], p[4], is_right);         \
        const Real length = select(base * across + altitude * along, left + right, is_base);            \
        /* From the left end of the base, or from either end to the apex. */                            \
        const Real way = select((base - away) * across + y * along, x + left, is_base);                 \
        const Mask has_length = length > (Real)0.0;                                                     \
        const Real part = select((Real)0.0, way / length, has_length), apex = y / altitude;             \
        const Real at_right = (x + left * ((Real)1.0 - apex)) / (left + right);                         \
        *first = select(select(part, (Real)1.0 - part, is_left), at_right, is_face);                    \
        *second = apex;                                                                                 \
    }
DEFINE_FRAME_WEIGHTS(frame_weights, double, long)

// A vertex or an edge of the frame, as the polyhedron's triangle numbers it. Its vertex `first` is the left end of the
// base.
INLINE uint site_of_triangle(__global const Polyhedron* p, uint frame_site) {
    const uint first = p->flags >> CLSDF_POLYHEDRON_VERTEX_SHIFT & 3u;
    if (p->flags & CLSDF_POLYHEDRON_POINT) return first;
    const uint number = frame_site % 3u + first;
    return frame_site / 3u * 3u + (number >= 3u ? number - 3u : number);
}

// The piece of a face that a named site's triangle is; null if triangles are no pieces, or if there is none.
INLINE __global const FacePiece* piece_of(__private const Finishing* finishing, NamedSite named) {
    const uint pieces = finishing->how.pieces;
    if (pieces == 0 || named.triangle == CLSDF_NO_TRIANGLE) return 0;
    return (__global const FacePiece*)(finishing->sites + pieces) + named.triangle;
}

// A named site as the outputs tell it.
INLINE uint told_triangle(__private const Finishing* finishing, NamedSite named) {
    __global const FacePiece* piece = piece_of(finishing, named);
    return piece ? piece->face : named.triangle;
}
INLINE uint told_site(__private const Finishing* finishing, NamedSite named) {
    __global const FacePiece* piece = piece_of(finishing, named);
    return piece ? piece->site[named.site] : named.site;
}

static inline NamedSite name_site(__private const Finishing* finishing, __global const Polyhedron* p, uint frame_site) {
    // The triangles of a part of a mesh have other numbers in the whole.
    const uint renumbered = finishing->how.renumbered;
    __global const uint* numbers = (__global const uint*)(finishing->sites + renumbered);
    NamedSite named = {renumbered != 0 ? numbers[p->triangle] : p->triangle, CLSDF_SITE_OF_FACE, false};
    if (frame_site == CLSDF_SITE_OF_FACE) return named;
    const uint own = site_of_triangle(p, frame_site);
    __global const TriangleSites* sites = finishing->sites + p->triangle;
    named.triangle = sites->triangle[own];
    named.site = sites->site[own] & CLSDF_SITE_NUMBER;
    named.is_reversed = (sites->site[own] & CLSDF_SITE_REVERSED) != 0;
    return named;
}

// Rounding may leave it a little outside.
INLINE double within_0_and_1(double weight) {
    const double positive = GREATER(weight, 0.0);
    return LESSER(positive, 1.0);
}

// Weights of the vertices 1 and 2 of the triangle that is told that make the closest point. first, second: of
// frame_weights().
INLINE double2 told_weights(__private const Finishing* finishing, __global const Polyhedron* p, NamedSite named,
                            double first, double second) {
    double weights[3] = {0.0, 0.0, 0.0};
    if (named.site < 3u) {
        weights[named.site] = 1.0;
    } else if (named.site < CLSDF_SITE_OF_FACE) {
        const double way = named.is_reversed ? 1.0 - first : first;
        weights[named.site - 3u] = 1.0 - way;
        weights[(named.site - 2u) % 3u] = way;
    } else {
        const uint left = p->flags >> CLSDF_POLYHEDRON_VERTEX_SHIFT & 3u;
        weights[left] = 1.0 - second - first;
        weights[(left + 1u) % 3u] = first;
        weights[(left + 2u) % 3u] = second;
    }
    const double2 own = DOUBLE2(within_0_and_1(weights[1]), within_0_and_1(weights[2]));
    __global const FacePiece* piece = piece_of(finishing, named);
    if (!piece) return own;
    const double rest = within_0_and_1(1.0 - own.x - own.y);
    const double2 in_face =
        vload2(0, piece->weights) * rest + vload2(1, piece->weights) * own.x + vload2(2, piece->weights) * own.y;
    return DOUBLE2(within_0_and_1(in_face.x), within_0_and_1(in_face.y));
}

// sample: in samples of the lattice, which need not be whole numbers.
static inline void find_nearest_at(__private const Finishing* finishing, double3 sample, uint polyhedron, bool negative,
                                   __private Nearest* nearest) {
    __global const Polyhedron* p = finishing->polyhedra + polyhedron;
    const Finish how = finishing->how;
    const double4 at = frame_at(p, sample.x, sample.y, sample.z);
    double from_x, from_y, frame_site;
    double halves[7];
    load_halves(p, halves);
    from_site(halves, at.x, at.y, at.z, &from_x, &from_y, &frame_site);
    nearest->frame_site = (uint)frame_site;
    nearest->from = DOUBLE3(from_x, from_y, at.z);
    nearest->axes[0] = vload3(0, p->exact_gradient_x) * how.per_spacing[0];
    nearest->axes[1] = vload3(0, p->exact_gradient_y) * how.per_spacing[1];
    nearest->axes[2] = vload3(0, p->exact_gradient_z) * how.per_spacing[2];
    nearest->sign = negative ? -1.0 : 1.0;
    nearest->position = DOUBLE3(how.origin[0] + sample.x * how.spacing[0], how.origin[1] + sample.y * how.spacing[1],
                                how.origin[2] + sample.z * how.spacing[2]);
    nearest->polyhedron = p;
    nearest->foot = DOUBLE2(at.x - from_x, at.y - from_y);
    // Set in each case: PoCL 7 crashes if one branch alone sets it (docs/devices.md).
    const NamedSite unnamed = UNNAMED_SITE;
    nearest->named = unnamed;
    if ((how.wanted & CLSDF_OUTPUTS_BY_NAME) != 0) nearest->named = name_site(finishing, p, nearest->frame_site);
}

// From the closest point to the sample, along the mesh's axes, in units.
INLINE double3 offset_of(__private const Nearest* nearest) {
    return DOUBLE3(scalar_product(nearest->axes[0], nearest->from), scalar_product(nearest->axes[1], nearest->from),
                   scalar_product(nearest->axes[2], nearest->from));
}

// The pseudonormal of a vertex or an edge, not turned for a mesh that is inside out.
INLINE double3 pseudonormal_of(__private const Finishing* finishing, __private const Nearest* nearest) {
    __global const Polyhedron* p = nearest->polyhedron;
    return convert_double3(
        vload3(6 * (size_t)p->triangle + site_of_triangle(p, nearest->frame_site), finishing->normals));
}

#ifdef __OPENCL_VERSION__
// The distance of a sample beyond the band.
INLINE double distance_beyond(__private const Finishing* finishing, bool negative) {
    return negative ? finishing->how.inside_fill : finishing->how.outside_fill;
}

// The square of a distance in units, without what is rounding. (x, y, z), p: as in DEFINE_FROM_SITE.
#define DEFINE_WITHOUT_ROUNDING(name, Real)                                                                 \
    INLINE Real name(__private const Real* p, Real x, Real y, Real z, Real squared) {                       \
        const Real rounding = DISTANCE_ROUNDING * ((fabs(x) + fabs(y)) + (fabs(z) + p[6]) + (p[0] + p[1])); \
        return squared <= rounding * rounding ? (Real)0.0 : squared;                                        \
    }
DEFINE_WITHOUT_ROUNDING(without_rounding, double)

// The distance of a sample of a grid; at most the half width.
INLINE double finished_distance(__private const Finishing* finishing, __private const Nearest* nearest) {
    const bool negative = nearest->sign < 0.0;
    double halves[7];
    load_halves(nearest->polyhedron, halves);
    const double2 in_plane = nearest->foot + nearest->from.xy;
    const double squared =
        without_rounding(halves, in_plane.x, in_plane.y, nearest->from.z, scalar_product(nearest->from, nearest->from));
    const double root = sqrt(squared) * finishing->how.unit;
    const double most = fabs(distance_beyond(finishing, negative));
    const double length = LESSER(root, most), least = finishing->how.least_inside;
    return negative ? 0.0 - GREATER(length, least) : length;  // 0 - 0 is +0
}
#endif

// Each other output's value, by its name in the table. ----------------------------------------------------------------

INLINE uint finished_triangle(__private const Finishing* finishing, __private const Nearest* nearest) {
    return told_triangle(finishing, nearest->named);
}

INLINE uchar finished_site(__private const Finishing* finishing, __private const Nearest* nearest) {
    return (uchar)told_site(finishing, nearest->named);
}

INLINE double3 finished_closest(__private const Finishing* finishing, __private const Nearest* nearest) {
    return nearest->position - offset_of(nearest) * finishing->how.unit;
}

// Its accuracy does not depend on the size of the coordinates.
INLINE double3 finished_offset(__private const Finishing* finishing, __private const Nearest* nearest) {
    return -(offset_of(nearest) * finishing->how.unit);
}

INLINE double3 finished_gradient(__private const Finishing* finishing, __private const Nearest* nearest) {
    const double squared = scalar_product(nearest->from, nearest->from);
    if (squared > SQUARE_OF_NO_DISTANCE) return offset_of(nearest) * (nearest->sign / sqrt(squared));
    double outward = finishing->how.outward;
    if (nearest->frame_site != CLSDF_SITE_OF_FACE) return outward * pseudonormal_of(finishing, nearest);
    const uint turned = finishing->how.turned;
    if (turned != 0) outward *= finishing->normals[18 * (size_t)turned + nearest->polyhedron->triangle];
    return outward * DOUBLE3(nearest->axes[0].z, nearest->axes[1].z, nearest->axes[2].z);
}

INLINE double2 finished_barycentric(__private const Finishing* finishing, __private const Nearest* nearest) {
    double halves[7], first, second;
    load_halves(nearest->polyhedron, halves);
    frame_weights(halves, nearest->foot.x, nearest->foot.y, (double)nearest->frame_site, &first, &second);
    return told_weights(finishing, nearest->polyhedron, nearest->named, first, second);
}

// The numbers of a scene's bodies are known to the host alone.
INLINE uint finished_body(__private const Finishing* finishing, __private const Nearest* nearest) {
    return 0u;
}

// Stores, by the type of an output's elements.
// -------------------------------------------------------------------------

#define STORE_uint32(value, components, at, to, is_double) ((__global uint*)(to))[at] = value
#define STORE_uint8(value, components, at, to, is_double) (to)[at] = value
#define STORE_real(value, components, at, to, is_double)       \
    if (is_double)                                             \
        vstore##components(value, at, (__global double*)(to)); \
    else                                                       \
        vstore##components(convert_float##components(value), at, (__global float*)(to))
#define STORE_float32 STORE_real
#define STORE_float64(value, components, at, to, is_double) vstore##components(value, at, (__global double*)(to))

// Every bit set.
#define LEAVE_uint32(components, at, to, is_double) ((__global uint*)(to))[at] = 0xFFFFFFFFu
#define LEAVE_uint8(components, at, to, is_double) (to)[at] = 0xFFu
#define LEAVE_real(components, at, to, is_double)                                      \
    if (is_double)                                                                     \
        vstore##components((ulong##components)(~(ulong)0), at, (__global ulong*)(to)); \
    else                                                                               \
        vstore##components((uint##components)(0xFFFFFFFFu), at, (__global uint*)(to))
#define LEAVE_float32 LEAVE_real
#define LEAVE_float64(components, at, to, is_double) \
    vstore##components((ulong##components)(~(ulong)0), at, (__global ulong*)(to))

// Stores what a sample of the band holds beside the distance. at: its place among the results, in samples.
static inline void store_outputs(__private const Finishing* finishing, __private const Nearest* nearest, size_t at) {
#define FINISH(name, content, element, components, number)                                         \
    if (IS_WANTED(finishing, name)) {                                                              \
        STORE_##element(finished_##name(finishing, nearest), components, at, finishing->of_##name, \
                        IS_DOUBLE(finishing, name));                                               \
    }
    CLSDF_OUTPUTS(FINISH)
#undef FINISH
}

#ifdef __OPENCL_VERSION__
// The same from the sample's nearest polyhedron, and its distance in double. at: its place in the part.
static inline void finish_sample(__private const Finishing* finishing, int3 sample, uint polyhedron, bool negative,
                                 size_t at) {
    Nearest nearest;
    find_nearest_at(finishing, convert_double3(sample), polyhedron, negative, &nearest);
    if (IS_DOUBLE(finishing, distance)) finishing->of_distance[at] = finished_distance(finishing, &nearest);
    store_outputs(finishing, &nearest, at);
}
#endif

// Stores the same of a sample beyond the band.
static inline void leave_sample(__private const Finishing* finishing, size_t at) {
#define LEAVE(name, content, element, components, number)                                  \
    if (IS_WANTED(finishing, name)) {                                                      \
        LEAVE_##element(components, at, finishing->of_##name, IS_DOUBLE(finishing, name)); \
    }
    CLSDF_OUTPUTS(LEAVE)
#undef LEAVE
}

// Parameters of a kernel that finishes samples, which follow that of the distance, and their use.
#define FINISHING_POINTER(name, content, element, components, number) , __global uchar* to_##name
#define FINISHING_PARAMETERS \
    Finish how, __global const TriangleSites *sites, __global const float *normals CLSDF_OUTPUTS(FINISHING_POINTER)
#define SET_POINTER(name, content, element, components, number) finishing.of_##name = to_##name;
#define SET_FINISHING(finishing)                        \
    Finishing finishing;                                \
    finishing.how = how;                                \
    finishing.polyhedra = polyhedra;                    \
    finishing.sites = sites;                            \
    finishing.normals = normals;                        \
    finishing.of_distance = (__global double*)distance; \
    CLSDF_OUTPUTS(SET_POINTER)

#endif
