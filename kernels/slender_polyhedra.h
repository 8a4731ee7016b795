// Slender polyhedra: which of a coarse brick's list are, and what bounds them layer by layer.
//
// Where triangles are small, few samples of the sub-blocks that a polyhedron touches lie in it: of sphere6's, in a narrow
// band at 256^3, one in five. Polyhedra with small sections are therefore intersected with the layers of samples across
// one axis of the lattice, the one nearest to the face's normal, and the samples within are listed one by one
// (slender_scan.h). (Measured, with AVX2: sphere6's and the bunny's bricks take a quarter and a fifth less time.)
//
// Each side of the face, as far as it reaches within the coarse brick, is the frustum between two sections. In the plane
// of the layers' axis and of another one, what bounds their six corners on one side is a line: it gives each layer's
// first or last sample along the other axis. In these boxes the lateral planes decide. All is computed for LANES
// polyhedra at once, in samples from the coarse brick's first.
#ifndef CLSDF_SLENDER_POLYHEDRA_H
#define CLSDF_SLENDER_POLYHEDRA_H

#include "lane_polyhedra.h"
#include "record_numbers.h"

// Sections of a slender polyhedron have room for this many samples at most. Far from the surface, where polyhedra
// overlap, the bricks' and sub-blocks' own caps save more than lists of samples do. (Measured: near it, 12 to 30 differ
// by 3%; with 30 everywhere the bunny's whole field takes a third longer than without.)
#define SLENDER_SAMPLES_NEAR 30.0f
#define SLENDER_SAMPLES_FAR 6.0f

// Along each axis, how far the integer origin of a slender polyhedron is from a coarse brick's centre, at most, in
// samples: sums that slender_scan.h takes for exact are.
#define SLENDER_REACH 200.0f

// at + step m, of layer m.
typedef struct Line {
    floatL at, step;
} Line;

// at + step_a m + step_u u + step_v v <= 0: sample u, v of layer m lies on the polyhedron's side.
typedef struct Plane {
    floatL at, step_a, step_u, step_v;
} Plane;

typedef struct Frustum {
    floatL first, last;  // layers; none where the last comes before the first
    Line low_u, high_u, low_v, high_v;
    Plane planes[4];  // the lateral ones, by edge; the one half way between the ends
} Frustum;

typedef struct SlenderPolyhedra {
    Frustum sides[2];  // above, below
    intL axis;  // of the layers; of the other two, u is the first and v the last
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

// The triangles of the polyhedra, and where they are.
typedef struct LaneTriangles {
    floatL words[WORDS];
    floatL altitude;
    floatL length_right, length_left;  // of the slanted edges
    floatL x, y, z;                    // the frame's coordinates at the coarse brick's first sample
    floatL to_origin[3];               // from there to the integer origin, in samples
    floatL height, reach;              // of the coarse brick's centre, over the face; how far its samples reach from it
} LaneTriangles;

INLINE void load_triangles(__global const Polyhedron* polyhedra, __private const uint* numbers, int3 first,
                           LaneTriangles* t) {
    load_words(polyhedra, numbers, t->words);
    const floatL* words = t->words;
    const int firsts[3] = {first.x, first.y, first.z};
    floatL across = 0.0f, reach = 0.0f;
#pragma unroll
    for (uint axis = 0; axis < 3; ++axis) {
        const floatL gradient = words[NUMBER_GRADIENT_X + 3 * axis + 2];
        t->to_origin[axis] = convert_floatL(as_intL(words[WORD_ORIGIN + axis]) - firsts[axis]);
        across += gradient;
        reach += fabs(gradient);
    }
    const floatL i = -t->to_origin[0], j = -t->to_origin[1], k = -t->to_origin[2];
    t->x = FRAME_AT(words, 0, i, j, k);
    t->y = FRAME_AT(words, 1, i, j, k);
    t->z = FRAME_AT(words, 2, i, j, k);
    t->height = t->z + across * (0.5f * (CLSDF_COARSE - 1));
    t->reach = reach * (0.5f * (CLSDF_COARSE - 1));
    // From the longer half of the base: the other may be nothing.
    const intL right = words[NUMBER_BASE] >= words[NUMBER_BASE + 1];
    t->altitude = (right ? words[NUMBER_NORMAL_ALONG] : words[NUMBER_NORMAL_ALONG + 1]) *
                  (right ? words[NUMBER_BASE] : words[NUMBER_BASE + 1]) /
                  (right ? words[NUMBER_NORMAL_ACROSS] : words[NUMBER_NORMAL_ACROSS + 1]);
    t->length_right = t->altitude / words[NUMBER_NORMAL_ALONG];
    t->length_left = t->altitude / words[NUMBER_NORMAL_ALONG + 1];
}

// Where a sample is within the slack of the face, the lateral planes of either side bound it: as slopes are at most 1,
// with thrice the slack those of one side do. Once more, and it is beyond what follows rounds.
INLINE float margin_of(float slack) {
    return 4.0f * slack;
}

// Half the height of a side
INLINE float half_height(float cap, float margin) {
    return 0.5f * cap + margin;
}

// The heights of a side within the coarse brick, counted from a margin beneath the face; none where the last is less
// than the first.
typedef struct Heights {
    floatL first, last;
} Heights;

// side: 1 above the face, -1 below it.
INLINE Heights heights_in_brick(const LaneTriangles* t, float side, float cap, float margin) {
    const floatL centre = side * t->height;
    Heights heights;
    heights.first = GREATER(centre - t->reach, 0.0f);
    heights.last = LESSER(centre + t->reach + 2.0f * margin, cap + 2.0f * margin);
    return heights;
}

// Of a side, at a height: how far the lateral planes lie outward of the edges.
INLINE void widths_at(const LaneTriangles* t, uint slopes, floatL height, float margin, floatL* widths) {
#pragma unroll
    for (uint edge = 0; edge < 3; ++edge) widths[edge] = t->words[slopes + edge] * height + margin;
}

// Which of a coarse brick's polyhedra are slender; `absent`: which have no samples there. cap: of its distances.
INLINE uint choose_slender(Layout layout, __global const Polyhedron* polyhedra, __private const uint* numbers,
                           int3 first, float cap, float slack, uint* absent) {
    LaneTriangles t;
    load_triangles(polyhedra, numbers, first, &t);
    const float margin = margin_of(slack);
    const float spacing = longest_spacing(layout);
    const float samples = cap <= 1.5f * layout.coarse_radius ? SLENDER_SAMPLES_NEAR : SLENDER_SAMPLES_FAR;
    const float most_area = samples * spacing * spacing;
    const floatL base = t.words[NUMBER_BASE] + t.words[NUMBER_BASE + 1], twice_area = base * t.altitude;
    intL present = 0, wide = 0;
#pragma unroll
    for (uint side = 0; side < 2; ++side) {
        const Heights heights = heights_in_brick(&t, side == 0 ? 1.0f : -1.0f, cap, margin);
        const intL some = heights.first <= heights.last;
        floatL widths[3];
        widths_at(&t, side == 0 ? WORD_SLOPE_ABOVE : WORD_SLOPE_BELOW, heights.last, margin, widths);
        // A section is similar to the triangle: of any point, the distances outward from the edges times their lengths
        // add up to minus twice the area.
        const floatL section = twice_area + (base * widths[CLSDF_EDGE_BASE] + t.length_right * widths[CLSDF_EDGE_RIGHT] +
                                             t.length_left * widths[CLSDF_EDGE_LEFT]);
        present |= some;
        wide |= some & ~(section * section <= twice_area * (2.0f * most_area));
    }
    // Of two faces upon each other the first of the caller's is named: both take the same way, rounding alike.
    const int needed = (int)(CLSDF_POLYHEDRON_COMPACT | CLSDF_POLYHEDRON_NEAR);
    intL regular = (as_intL(t.words[WORD_FLAGS]) & (int)(needed | CLSDF_POLYHEDRON_NON_MANIFOLD)) == needed;
    *absent = lanes_to_bits(regular & ~present);
#pragma unroll
    for (uint axis = 0; axis < 3; ++axis)
        regular &= fabs(t.to_origin[axis] - 0.5f * (CLSDF_COARSE - 1)) <= SLENDER_REACH;
    return lanes_to_bits(regular & present & ~wide);
}

// The lines below and above six points (a, u), of which three are a section. Any step will do; tight is that of the least,
// or greatest, from section to section. per_layer: one by how many layers they lie apart.
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

// The layers where the line is at most, with `sense` -1 at least, the limit; as they are where it hardly rises.
INLINE void clip_layers(const Line* line, float limit, float sense, floatL* first, floatL* last) {
    const floatL step = sense * line->step, where = (limit - line->at) / line->step;
    *first = (step < -1.0e-4f) & (where > *first) ? where : *first;
    *last = (step > 1.0e-4f) & (where < *last) ? where : *last;
}

// What bounds slender polyhedra. Returns which of them may have samples.
INLINE uint bound_slender(Layout layout, __global const Polyhedron* polyhedra, __private const uint* numbers, int3 first,
                          float cap, float slack, __private SlenderPolyhedra* slender) {
    LaneTriangles t;
    load_triangles(polyhedra, numbers, first, &t);
    const float margin = margin_of(slack);
    const floatL* words = t.words;
    const floatL right = words[NUMBER_BASE], left = words[NUMBER_BASE + 1];
    const floatL along_right = words[NUMBER_NORMAL_ALONG], along_left = words[NUMBER_NORMAL_ALONG + 1];
    const floatL across_right = words[NUMBER_NORMAL_ACROSS], across_left = words[NUMBER_NORMAL_ACROSS + 1];
    const floatL per_along_right = 1.0f / along_right, per_along_left = 1.0f / along_left;
    const floatL per_apex = 1.0f / (along_right * across_left + along_left * across_right);

    // Along a, u and v: the gradients; the frame's axes, and its origin, the altitude's foot, in samples.
    const float3 per_spacing = 1.0f / vload3(0, layout.spacing);
    const floatL* gx = words + NUMBER_GRADIENT_X;
    const floatL* gy = words + NUMBER_GRADIENT_Y;
    const floatL* gz = words + NUMBER_GRADIENT_Z;
    const floatL normal_x = fabs(gx[2]), normal_y = fabs(gy[2]), normal_z = fabs(gz[2]);
    const intL is_x = (normal_x >= normal_y) & (normal_x >= normal_z), is_z = ~is_x & (normal_z >= normal_y);
    slender->axis = is_x ? (intL)0 : is_z ? (intL)2 : (intL)1;
#define ALONG_A(x, y, z) (is_x ? (x) : is_z ? (z) : (y))
#define ALONG_U(x, y, z) (is_x ? (y) : (x))
#define ALONG_V(x, y, z) (is_z ? (y) : (z))
    floatL gradients[3][3], axes[3][3], foot[3];
#define SET_AXIS(axis, ALONG)                                                                            \
    {                                                                                                    \
        const floatL scale = ALONG((floatL)per_spacing.x, (floatL)per_spacing.y, (floatL)per_spacing.z); \
        foot[axis] = ALONG(t.to_origin[0], t.to_origin[1], t.to_origin[2]) +                             \
                     ALONG(words[WORD_FOOT], words[WORD_FOOT + 1], words[WORD_FOOT + 2]) * scale;        \
        _Pragma("unroll") for (uint n = 0; n < 3; ++n) {                                                 \
            gradients[axis][n] = ALONG(gx[n], gy[n], gz[n]);                                             \
            axes[axis][n] = gradients[axis][n] * (scale * scale);                                        \
        }                                                                                                \
    }
    SET_AXIS(0, ALONG_A)
    SET_AXIS(1, ALONG_U)
    SET_AXIS(2, ALONG_V)
#undef SET_AXIS
#undef ALONG_A
#undef ALONG_U
#undef ALONG_V

    intL present = 0;
#pragma unroll
    for (uint n = 0; n < 2; ++n) {
        const float side = n == 0 ? 1.0f : -1.0f;
        const uint slopes = n == 0 ? WORD_SLOPE_ABOVE : WORD_SLOPE_BELOW;
        __private Frustum* frustum = slender->sides + n;
        const Heights heights = heights_in_brick(&t, side, cap, margin);
        if (!lanes_to_bits(heights.first <= heights.last)) {
            frustum->first = 0.0f;
            frustum->last = -1.0f;
            continue;
        }

        floatL a[6], u[6], v[6];  // the corners
#pragma unroll
        for (uint end = 0; end < 2; ++end) {
            const floatL height = end == 0 ? heights.first : heights.last;
            floatL widths[3];
            widths_at(&t, slopes, height, margin, widths);
            const floatL base = widths[CLSDF_EDGE_BASE], to_right = widths[CLSDF_EDGE_RIGHT],
                         to_left = widths[CLSDF_EDGE_LEFT];
            const floatL x[3] = {right + (to_right + across_right * base) * per_along_right,
                                 -left - (to_left + across_left * base) * per_along_left,
                                 (across_left * to_right - across_right * to_left) * per_apex};
            const floatL y[3] = {-base, -base,
                                 t.altitude + (along_left * to_right + along_right * to_left) * per_apex};
            const floatL z = side * (height - margin);
#pragma unroll
            for (uint corner = 0; corner < 3; ++corner) {
#define PLACE(axis) \
    (foot[axis] + (x[corner] * axes[axis][0] + (y[corner] * axes[axis][1] + z * axes[axis][2])))
                a[3 * end + corner] = PLACE(0);
                u[3 * end + corner] = PLACE(1);
                v[3 * end + corner] = PLACE(2);
#undef PLACE
            }
        }
        const floatL apart = (sum_of_three(a + 3) - sum_of_three(a)) * (1.0f / 3.0f);
        const floatL per_layer = fabs(apart) < 0.5f ? (floatL)0.0f : 1.0f / apart;
        set_lines(a, u, per_layer, &frustum->low_u, &frustum->high_u);
        set_lines(a, v, per_layer, &frustum->low_v, &frustum->high_v);

        const floatL least_below = least_of_three(a), least_above = least_of_three(a + 3);
        const floatL greatest_below = greatest_of_three(a), greatest_above = greatest_of_three(a + 3);
        floatL begin = LESSER(least_below, least_above), end = GREATER(greatest_below, greatest_above);
        begin = GREATER(begin, 0.0f);
        end = LESSER(end, (float)(CLSDF_COARSE - 1));
        clip_layers(&frustum->low_u, CLSDF_COARSE - 1, 1.0f, &begin, &end);
        clip_layers(&frustum->low_v, CLSDF_COARSE - 1, 1.0f, &begin, &end);
        clip_layers(&frustum->high_u, 0.0f, -1.0f, &begin, &end);
        clip_layers(&frustum->high_v, 0.0f, -1.0f, &begin, &end);
        const intL some = heights.first <= heights.last;
        frustum->first = ceil(begin);
        frustum->last = some ? floor(end) : (floatL)-1.0f;
        present |= frustum->first <= frustum->last;

        // along X + across Y - slope (height + margin) <= beyond + margin
        const floatL along[4] = {0.0f, along_right, -along_left, 0.0f}, across[4] = {-1.0f, across_right, across_left, 0.0f};
        const floatL beyond[4] = {0.0f, along_right * right, along_left * left, half_height(cap, margin) - margin};
#pragma unroll
        for (uint edge = 0; edge < 4; ++edge) {
            const floatL slope = edge == 3 ? (floatL)-1.0f : words[slopes + edge];
#define LATERAL(x, y, z) (along[edge] * (x) + (across[edge] * (y)-slope * (z)))
#define STEP(axis) LATERAL(gradients[axis][0], gradients[axis][1], side* gradients[axis][2])
            __private Plane* plane = frustum->planes + edge;
            plane->at = LATERAL(t.x, t.y, side * t.z + margin) - beyond[edge] - margin;
            plane->step_a = STEP(0);
            plane->step_u = STEP(1);
            plane->step_v = STEP(2);
#undef STEP
#undef LATERAL
        }
    }
    return lanes_to_bits(present);
}

#endif
