// Slender polyhedra: selects those of a coarse brick's list, and bounds them layer by layer.
//
// If triangles are small, a polyhedron contains few of the samples of the sub-blocks that it overlaps. So a polyhedron
// with small sections is cut with layers of samples, and the samples within are listed one by one (slender_scan.h). The
// layers lie across the axis of the lattice along which the height over the face changes most.
//
// Each side of the face, as far as it reaches within the coarse brick, is bounded by two sections. Their six corners
// are projected along one of the other two axes. A line bounds the projections on each side, and gives each layer's
// first or last sample along the remaining axis. In these boxes the lateral planes decide. All is computed for LANES
// polyhedra at once, in samples from the coarse brick's first.
//
// The same for one polyhedron and one side, s = 1 above the face and s = -1 below it, in plain arithmetic:
//
// - height of a sample p, from a margin beneath the face: h(p) = s Z(p) + margin.
//
// - how far outward the plane of edge e lies at that height: w(e, h) = slope(s, e) h + margin.
//
// - p is listed if 0 <= h(p) <= bound + 2 margin and, for each edge e, outward(e, X(p), Y(p)) <= w(e, h(p)).
//
// - [h0, h1] are the heights of the coarse brick, clipped to [0, bound + 2 margin]; if it is empty, there are no
// layers.
//
// - corners (a, u, v): those of the triangles {(X, Y): outward(e, X, Y) <= w(e, h) for each e} at h0 and at h1, six in
// all.
//
// - lines: low(a) <= u <= high(a) at all six corners, and so everywhere between them; the same for v.
//
// - samples: layer a from the least corner to the greatest, within the coarse brick; in it u from ceil(low_u(a)) to
//   floor(high_u(a)) and v from ceil(low_v(a)) to floor(high_v(a)); of these, those on the inner side of the planes.
#ifndef CLSDF_SLENDER_POLYHEDRA_H
#define CLSDF_SLENDER_POLYHEDRA_H

#include "lane_polyhedra.h"
#include "polyhedron.h"

// Sections of a slender polyhedron have room for this many samples at most. Far from the surface polyhedra overlap, and
// the bricks' and sub-blocks' own bounds save more than lists of samples do.
#define SLENDER_SAMPLES_NEAR 30.0f
#define SLENDER_SAMPLES_FAR 6.0f

// Greatest length of a section, in samples. It keeps the rounding (slender_scan.h) as small as a brick's.
#define SLENDER_LENGTH 12.0f

// Greatest distance along an axis from the integer origin of a slender polyhedron to the coarse brick's centre, in
// samples. Within it the sums that slender_scan.h takes for exact are exact.
#define SLENDER_RANGE 200.0f

// at + step m, of layer m.
typedef struct Line {
    floatL at, step;
} Line;

// at + step_a m + step_u u + step_v v, of sample u, v of layer m: its distance beyond a plane.
typedef struct Plane {
    floatL at, step_a, step_u, step_v;
} Plane;

// columns_log: a vector with so many layers has room for 2^columns_log neighbours along u of each, four at most. (True
// is 1 for numbers, and -1 for vectors.)
#define TIMES_HALVED(layers) (((layers) <= LANES / 2) + ((layers) <= LANES / 4))
INLINE int columns_log_of(float layers) {
    return TIMES_HALVED(layers);
}
INLINE intL columns_log_of_lanes(floatL layers) {
    return -TIMES_HALVED(layers);
}

// The layers of samples of one side of the face, within a coarse brick.
typedef struct SideLayers {
    floatL first, last;  // layers; none if the last is less than the first
    intL columns_log;    // of all layers
    Line low_u, high_u, low_v, high_v;
    // Three lateral planes, by edge: samples beyond them are outside. The fourth plane lies half way between the ends:
    // samples farther from it than half the height are outside.
    Plane planes[4];
} SideLayers;

typedef struct SlenderPolyhedra {
    SideLayers sides[2];       // above, below
    intL axis;                 // of the layers; of the other two, u is the first and v the last
    intL columns_log_of_both;  // of both sides in one vector; -1 if they do not fit
} SlenderPolyhedra;

INLINE floatL least_of_three(const floatL* a) {
    const floatL two = LESSER(a[0], a[1]);
    return LESSER(two, a[2]);
}
INLINE floatL greatest_of_three(const floatL* a) {
    const floatL two = GREATER(a[0], a[1]);
    return GREATER(two, a[2]);
}
INLINE floatL sum_of_three(const floatL* a) {
    return a[0] + a[1] + a[2];
}

// The triangles of the polyhedra, and their positions.
typedef struct LaneTriangles {
    floatL words[WORDS];
    floatL altitude;
    floatL length_right, length_left;  // of the slanted edges
    floatL x, y, z;                    // the frame's coordinates at the coarse brick's first sample
    floatL to_origin[3];               // from there to the integer origin, in samples
    floatL height, extent;  // of the coarse brick's centre, over the face; the half width of its samples there
} LaneTriangles;

INLINE void load_triangles(__global const Polyhedron* polyhedra, __private const uint* numbers, int3 first,
                           LaneTriangles* t) {
    load_words(polyhedra, numbers, t->words);
    const floatL* words = t->words;
    const int firsts[3] = {first.x, first.y, first.z};
    floatL rise = 0.0f, extent = 0.0f;
#pragma unroll
    for (uint axis = 0; axis < 3; ++axis) {
        const floatL gradient = words[NUMBER_GRADIENT_X + 3 * axis + 2];
        t->to_origin[axis] = convert_floatL(as_intL(words[WORD_ORIGIN + axis]) - firsts[axis]);
        rise += gradient;
        extent += fabs(gradient);
    }
    const floatL i = -t->to_origin[0], j = -t->to_origin[1], k = -t->to_origin[2];
    t->x = FRAME_AT(words, 0, i, j, k);
    t->y = FRAME_AT(words, 1, i, j, k);
    t->z = FRAME_AT(words, 2, i, j, k);
    t->height = t->z + rise * COARSE_CENTRE;
    t->extent = extent * COARSE_CENTRE;
    // The altitude follows from the longer half of the base: the other may be 0.
    const intL right = words[NUMBER_BASE] >= words[NUMBER_BASE + 1];
    t->altitude = (right ? words[NUMBER_NORMAL_ALONG] : words[NUMBER_NORMAL_ALONG + 1]) *
                  (right ? words[NUMBER_BASE] : words[NUMBER_BASE + 1]) /
                  (right ? words[NUMBER_NORMAL_ACROSS] : words[NUMBER_NORMAL_ACROSS + 1]);
    t->length_right = t->altitude / words[NUMBER_NORMAL_ALONG];
    t->length_left = t->altitude / words[NUMBER_NORMAL_ALONG + 1];
}

// The distance by which the lateral planes of a side move outward. Within the slack of the face, the planes of both
// sides bound the polyhedron. Slopes are at most 1, so the planes of one side suffice if they move by three slacks. The
// fourth slack covers rounding.
INLINE float margin_of(float slack) {
    return 4.0f * slack;
}

// Half of how far a side reaches from its margin beneath the face to that above the upper bound.
INLINE float half_height(float bound, float margin) {
    return 0.5f * bound + margin;
}

// The heights of a side within the coarse brick, counted from a margin beneath the face; none if the last is less than
// the first.
typedef struct Heights {
    floatL first, last;
} Heights;

// side: 1 above the face, -1 below it.
INLINE Heights heights_in_brick(const LaneTriangles* t, float side, float bound, float margin) {
    const floatL centre = side * t->height;
    Heights heights;
    heights.first = GREATER(centre - t->extent, 0.0f);
    heights.last = LESSER(centre + t->extent + 2.0f * margin, bound + 2.0f * margin);
    return heights;
}

// The distances of a side's lateral planes outward of the edges, at a height.
INLINE void widths_at(const LaneTriangles* t, uint slopes, floatL height, float margin, floatL* widths) {
#pragma unroll
    for (uint edge = 0; edge < 3; ++edge) widths[edge] = t->words[slopes + edge] * height + margin;
}

// The samples of a coarse brick whose bricks lie in the part, in units from its first sample, limits included.
typedef struct PartOfCoarse {
    bool is_whole;
    float3 from, to;
} PartOfCoarse;

static inline PartOfCoarse part_of_coarse(Layout layout, int3 coarse) {
    const int3 begin = (vload3(0, layout.brick_first) - coarse * CLSDF_BRICKS_PER_COARSE) * CLSDF_BRICK,
               end = begin + vload3(0, layout.bricks) * CLSDF_BRICK;
    const int3 low = max(begin, (int3)(0)), high = min(end, (int3)(CLSDF_COARSE)) - 1;
    PartOfCoarse part;
    part.is_whole = all(low == 0) && all(high == CLSDF_COARSE - 1);
    part.from = convert_float3(low) * vload3(0, layout.spacing);
    part.to = convert_float3(high) * vload3(0, layout.spacing);
    return part;
}

// Selects the triangles that may be within the bound of a sample of the part, by balls around the feet of their
// altitudes.
INLINE intL is_near_part(Layout layout, const LaneTriangles* t, const PartOfCoarse* part, float bound, float margin) {
    const floatL right = t->words[NUMBER_BASE + CLSDF_HALF_RIGHT], left = t->words[NUMBER_BASE + CLSDF_HALF_LEFT];
    const floatL longer = GREATER(right, left), slanted = 0.8661f * (right + left);
    const floatL far = GREATER(longer, slanted) * (1.0f + 1.0e-4f) + (bound * (1.0f + 1.0e-4f) + margin);
    const float from[3] = {part->from.x, part->from.y, part->from.z}, to[3] = {part->to.x, part->to.y, part->to.z};
    floatL squared = 0.0f;
#pragma unroll
    for (uint axis = 0; axis < 3; ++axis) {
        const floatL foot = t->to_origin[axis] * layout.spacing[axis] + t->words[WORD_FOOT + axis];
        const floatL below = from[axis] - foot, above = foot - to[axis], beyond = GREATER(below, above);
        const floatL gap = GREATER(beyond, (floatL)0.0f);
        squared += gap * gap;
    }
    return squared <= far * far;
}

// Returns which polyhedra of a coarse brick are slender; sets `absent` to those without samples in the part. bound: of
// the coarse brick's distances.
INLINE uint choose_slender(Layout layout, __global const Polyhedron* polyhedra, __private const uint* numbers,
                           int3 first, const PartOfCoarse* part, float bound, float slack, uint* absent) {
    LaneTriangles t;
    load_triangles(polyhedra, numbers, first, &t);
    const float margin = margin_of(slack);
    const float spacing = longest_spacing(layout);
    const float samples = bound <= 1.5f * layout.coarse_radius ? SLENDER_SAMPLES_NEAR : SLENDER_SAMPLES_FAR;
    const float most_area = samples * spacing * spacing, longest = SLENDER_LENGTH * spacing;
    const floatL base = t.words[NUMBER_BASE] + t.words[NUMBER_BASE + 1], twice_area = base * t.altitude;
    intL present = 0, wide = 0;
#pragma unroll
    for (uint side = 0; side < 2; ++side) {
        const Heights heights = heights_in_brick(&t, side == 0 ? 1.0f : -1.0f, bound, margin);
        const intL has_layers = heights.first <= heights.last;
        floatL widths[3];
        widths_at(&t, side == 0 ? WORD_SLOPE_ABOVE : WORD_SLOPE_BELOW, heights.last, margin, widths);
        // A section is similar to the triangle: of any point, the distances outward from the edges times their lengths
        // add up to minus twice the area.
        const floatL section =
            twice_area + (base * widths[CLSDF_EDGE_BASE] + t.length_right * widths[CLSDF_EDGE_RIGHT] +
                          t.length_left * widths[CLSDF_EDGE_LEFT]);
        present |= has_layers;
        // A polyhedron whose triangle has no area, a point site, is not slender.
        wide |= has_layers &
                ~((section * section < twice_area * (2.0f * most_area)) & (section * base < twice_area * longest));
    }
    // If two faces coincide, the lower index is the result. Both must round alike, so neither may be slender.
    const int needed = (int)(CLSDF_POLYHEDRON_COMPACT | CLSDF_POLYHEDRON_NEAR);
    intL regular = (as_intL(t.words[WORD_FLAGS]) & (int)(needed | CLSDF_POLYHEDRON_NON_MANIFOLD)) == needed;
    *absent = lanes_to_bits(regular & ~present);
#pragma unroll
    for (uint axis = 0; axis < 3; ++axis) regular &= fabs(t.to_origin[axis] - COARSE_CENTRE) <= SLENDER_RANGE;
    const intL slender = regular & present & ~wide;
    if (part->is_whole) return lanes_to_bits(slender);
    const intL near = is_near_part(layout, &t, part, bound, margin);
    *absent |= lanes_to_bits(slender & ~near);
    return lanes_to_bits(slender & near);
}

// The lines below and above six points (a, u), three in each of two sections. Any step gives a valid bound; the one
// between the middles of the sections is close to the tightest. per_layer: 1 / layers between the sections.
INLINE void set_lines(const floatL* a, const floatL* u, floatL per_layer, Line* low, Line* high) {
    const floatL step = (sum_of_three(u + 3) - sum_of_three(u)) * (per_layer * (1.0f / 3.0f));
    floatL shift[6];
#pragma unroll
    for (uint n = 0; n < 6; ++n) shift[n] = u[n] - step * a[n];
    low->step = step + (least_of_three(shift + 3) - least_of_three(shift)) * per_layer;
    high->step = step + (greatest_of_three(shift + 3) - greatest_of_three(shift)) * per_layer;
#pragma unroll
    for (uint n = 0; n < 6; ++n) shift[n] = u[n] - low->step * a[n];
    const floatL low_first = least_of_three(shift), low_last = least_of_three(shift + 3);
    low->at = LESSER(low_first, low_last);
#pragma unroll
    for (uint n = 0; n < 6; ++n) shift[n] = u[n] - high->step * a[n];
    const floatL high_first = greatest_of_three(shift), high_last = greatest_of_three(shift + 3);
    high->at = GREATER(high_first, high_last);
}

// Clips the range of layers to those where the line is at most the limit, or at least the limit if `sense` is -1. A
// nearly level line clips nothing.
INLINE void clip_layers(const Line* line, float limit, float sense, floatL* first, floatL* last) {
    const floatL step = sense * line->step, where = (limit - line->at) / line->step;
    *first = ((step < -1.0e-4f) & (where > *first)) ? where : *first;
    *last = ((step > 1.0e-4f) & (where < *last)) ? where : *last;
}

// Along the axes a, u and v: the gradients; in samples, the frame's axes and its origin, the altitude's foot.
typedef struct LayerAxes {
    intL axis;  // of the layers
    floatL gradients[3][3], axes[3][3], foot[3];
} LayerAxes;

INLINE void set_axes(Layout layout, const LaneTriangles* t, LayerAxes* axes) {
    const floatL* gx = t->words + NUMBER_GRADIENT_X;
    const floatL* gy = t->words + NUMBER_GRADIENT_Y;
    const floatL* gz = t->words + NUMBER_GRADIENT_Z;
    const floatL* to_foot = t->words + WORD_FOOT;
    const float3 per_spacing = 1.0f / vload3(0, layout.spacing);
    const floatL rise_x = fabs(gx[2]), rise_y = fabs(gy[2]), rise_z = fabs(gz[2]);
    const intL is_x = (rise_x >= rise_y) & (rise_x >= rise_z), is_z = ~is_x & (rise_z >= rise_y);
    axes->axis = is_x ? (intL)0 : is_z ? (intL)2 : (intL)1;
#define ALONG_A(x, y, z) (is_x ? (x) : is_z ? (z) : (y))
#define ALONG_U(x, y, z) (is_x ? (y) : (x))
#define ALONG_V(x, y, z) (is_z ? (y) : (z))
#define SET_AXIS(n, ALONG)                                                                               \
    {                                                                                                    \
        const floatL scale = ALONG((floatL)per_spacing.x, (floatL)per_spacing.y, (floatL)per_spacing.z); \
        axes->foot[n] = ALONG(t->to_origin[0], t->to_origin[1], t->to_origin[2]) +                       \
                        ALONG(to_foot[0], to_foot[1], to_foot[2]) * scale;                               \
        _Pragma("unroll") for (uint along = 0; along < 3; ++along) {                                     \
            axes->gradients[n][along] = ALONG(gx[along], gy[along], gz[along]);                          \
            axes->axes[n][along] = axes->gradients[n][along] * (scale * scale);                          \
        }                                                                                                \
    }
    SET_AXIS(0, ALONG_A)
    SET_AXIS(1, ALONG_U)
    SET_AXIS(2, ALONG_V)
#undef SET_AXIS
#undef ALONG_A
#undef ALONG_U
#undef ALONG_V
}

// The corners of two sections, three and three, along a, u and v, in samples.
typedef struct Corners {
    floatL a[6], u[6], v[6];
} Corners;

// The n-th section's corners, at a height of a side.
INLINE void set_corners(const LaneTriangles* t, const LayerAxes* axes, float side, uint slopes, floatL height,
                        float margin, uint n, Corners* corners) {
    const floatL along_right = t->words[NUMBER_NORMAL_ALONG], along_left = t->words[NUMBER_NORMAL_ALONG + 1];
    const floatL across_right = t->words[NUMBER_NORMAL_ACROSS], across_left = t->words[NUMBER_NORMAL_ACROSS + 1];
    floatL widths[3];
    widths_at(t, slopes, height, margin, widths);
    const floatL below = widths[CLSDF_EDGE_BASE], right = widths[CLSDF_EDGE_RIGHT], left = widths[CLSDF_EDGE_LEFT];
    const floatL per_apex = 1.0f / (along_right * across_left + along_left * across_right);
    const floatL x[3] = {t->words[NUMBER_BASE] + (right + across_right * below) / along_right,
                         -t->words[NUMBER_BASE + 1] - (left + across_left * below) / along_left,
                         (across_left * right - across_right * left) * per_apex};
    const floatL y[3] = {-below, -below, t->altitude + (along_left * right + along_right * left) * per_apex};
    const floatL z = side * (height - margin);
#define PLACE(n) (axes->foot[n] + (x[k] * axes->axes[n][0] + (y[k] * axes->axes[n][1] + z * axes->axes[n][2])))
#pragma unroll
    for (uint k = 0; k < 3; ++k) {
        corners->a[3 * n + k] = PLACE(0);
        corners->u[3 * n + k] = PLACE(1);
        corners->v[3 * n + k] = PLACE(2);
    }
#undef PLACE
}

// Sets the boxes of the layers, and the range of layers that have a box within the coarse brick.
INLINE void set_boxes(const Corners* corners, intL present, __private SideLayers* layers) {
    const floatL* a = corners->a;
    const floatL distance = (sum_of_three(a + 3) - sum_of_three(a)) * (1.0f / 3.0f);
    const floatL per_layer = fabs(distance) < 0.5f ? (floatL)0.0f : 1.0f / distance;
    set_lines(a, corners->u, per_layer, &layers->low_u, &layers->high_u);
    set_lines(a, corners->v, per_layer, &layers->low_v, &layers->high_v);
    const floatL least[2] = {least_of_three(a), least_of_three(a + 3)};
    const floatL greatest[2] = {greatest_of_three(a), greatest_of_three(a + 3)};
    floatL first = LESSER(least[0], least[1]), last = GREATER(greatest[0], greatest[1]);
    first = GREATER(first, 0.0f);
    last = LESSER(last, (float)(CLSDF_COARSE - 1));
    clip_layers(&layers->low_u, CLSDF_COARSE - 1, 1.0f, &first, &last);
    clip_layers(&layers->low_v, CLSDF_COARSE - 1, 1.0f, &first, &last);
    clip_layers(&layers->high_u, 0.0f, -1.0f, &first, &last);
    clip_layers(&layers->high_v, 0.0f, -1.0f, &first, &last);
    layers->first = CEIL(first);
    layers->last = present ? FLOOR(last) : (floatL)-1.0f;
}

// The plane along X + across Y + high (height + margin) = beyond.
INLINE void set_plane(const LaneTriangles* t, const LayerAxes* axes, float side, float margin, floatL along,
                      floatL across, floatL high, floatL beyond, __private Plane* plane) {
#define SUM(x, y, z) (along * (x) + (across * (y) + high * (z)))
#define STEP(n) SUM(axes->gradients[n][0], axes->gradients[n][1], side * axes->gradients[n][2])
    plane->at = SUM(t->x, t->y, side * t->z + margin) - beyond;
    plane->step_a = STEP(0);
    plane->step_u = STEP(1);
    plane->step_v = STEP(2);
#undef STEP
#undef SUM
}

INLINE void set_planes(const LaneTriangles* t, const LayerAxes* axes, float side, uint slopes, float bound,
                       float margin, __private SideLayers* layers) {
    const floatL* words = t->words;
    const floatL along[3] = {0.0f, words[NUMBER_NORMAL_ALONG], -words[NUMBER_NORMAL_ALONG + 1]};
    const floatL across[3] = {-1.0f, words[NUMBER_NORMAL_ACROSS], words[NUMBER_NORMAL_ACROSS + 1]};
    const floatL edges[3] = {0.0f, along[1] * words[NUMBER_BASE], -along[2] * words[NUMBER_BASE + 1]};
#pragma unroll
    for (uint edge = 0; edge < 3; ++edge)
        set_plane(t, axes, side, margin, along[edge], across[edge], -words[slopes + edge], edges[edge] + margin,
                  layers->planes + edge);
    set_plane(t, axes, side, margin, 0.0f, 0.0f, 1.0f, half_height(bound, margin), layers->planes + 3);
}

// Sets the bounds of slender polyhedra. Returns which of them may have samples. (It loads their records once more:
// these lanes come from several vectors of the list.)
INLINE uint bound_slender(Layout layout, __global const Polyhedron* polyhedra, __private const uint* numbers,
                          int3 first, float bound, float slack, __private SlenderPolyhedra* slender) {
    LaneTriangles t;
    load_triangles(polyhedra, numbers, first, &t);
    LayerAxes axes;
    set_axes(layout, &t, &axes);
    slender->axis = axes.axis;
    const float margin = margin_of(slack);
    intL present = 0;
#pragma unroll
    for (uint n = 0; n < 2; ++n) {
        const float side = n == 0 ? 1.0f : -1.0f;
        const uint slopes = n == 0 ? WORD_SLOPE_ABOVE : WORD_SLOPE_BELOW;
        __private SideLayers* layers = slender->sides + n;
        const Heights heights = heights_in_brick(&t, side, bound, margin);
        const intL has_layers = heights.first <= heights.last;
        layers->first = 0.0f;
        layers->last = -1.0f;
        if (!lanes_to_bits(has_layers)) continue;
        Corners corners;
        set_corners(&t, &axes, side, slopes, heights.first, margin, 0, &corners);
        set_corners(&t, &axes, side, slopes, heights.last, margin, 1, &corners);
        set_boxes(&corners, has_layers, layers);
        set_planes(&t, &axes, side, slopes, bound, margin, layers);
        present |= layers->first <= layers->last;
    }
    floatL counts[2];
#pragma unroll
    for (uint n = 0; n < 2; ++n) {
        __private SideLayers* layers = slender->sides + n;
        counts[n] = layers->last - layers->first + 1.0f;
        layers->columns_log = columns_log_of_lanes(counts[n]);
    }
    const floatL of_both = counts[0] + counts[1];
    slender->columns_log_of_both =
        ((counts[0] > 0.0f) & (counts[1] > 0.0f) & (of_both <= LANES)) ? columns_log_of_lanes(of_both) : (intL)-1;
    return lanes_to_bits(present);
}

#endif
