// Whether the polyhedra of the faces around a vertex surely cover all directions, LANES vertices at once
// (docs/method.md, 'Gaps at saddle vertices'). Positions and the signed slope of each edge are enough: planes that lean
// cut less off.
#ifndef CLSDF_VERTEX_FANS_H
#define CLSDF_VERTEX_FANS_H

#include "face_frames.h"

// Above the rounding of a product of three vectors no longer than ten, 1e-12.
#define CERTAIN_PRODUCT 1.0e-9
// Vectors of steeper slopes, at sharp edges, would be longer than ten.
#define STEEPEST_SLOPE 8.0
// A direction that is rejected by less counts as covered: the margin but for the rounding of the conditions.
#define SURE_MARGIN (0.99 * CLSDF_REJECTION_MARGIN)

// Vertices with equally many faces, each of which is a closed fan, counter-clockwise. Face f lies between the edges f
// and f + 1.
typedef struct Fans {
    Vectors spokes[CLSDF_FAN_FACES + 1];  // unit vectors along the edges; the first once more behind the last
    Vectors normals[CLSDF_FAN_FACES];
    // Kinds of edges: > 0 convex, < 0 concave, 0 not sure, infinite: open, NaN: the host decides.
    doubleL signs[CLSDF_FAN_FACES + 1];
    Vectors middle;  // mean of the normals
} Fans;

// The fans of `places`: where the words of LANES vertices begin, each `stride` words after the one before (FanItem).
INLINE void load_fans(uint faces, __global const uint* words, __private const uint* places, uint stride,
                      __global const uint* triangles, __global const double* positions, __global const float* signs,
                      double per_unit, __private Fans* fans) {
    uint corners[LANES], vertices[LANES];
#define EDGE_OF(lane) (3 * (size_t)(corners[lane] >> 2))
    Vectors centre;
    for (uint f = 0; f < faces; ++f) {
#pragma unroll
        for (uint lane = 0; lane < LANES; ++lane) corners[lane] = LOAD(uint, words + places[lane] + stride * f);
        if (f == 0) {
#pragma unroll
            for (uint lane = 0; lane < LANES; ++lane)
                vertices[lane] = LOAD(uint, triangles + EDGE_OF(lane) + (corners[lane] & 3));
            centre = positions_of(positions, vertices);
        }
#pragma unroll
        for (uint lane = 0; lane < LANES; ++lane)
            vertices[lane] = LOAD(uint, triangles + EDGE_OF(lane) + NEXT_OF_THREE(corners[lane] & 3));
        const Vectors spoke = product(per_unit, difference(positions_of(positions, vertices), centre));
        fans->spokes[f] = product(1.0 / sqrt(dot_in_order(spoke, spoke)), spoke);
#define SIGN_OF(lane) LOAD(float, signs + EDGE_OF(lane) + (corners[lane] & 3))
        fans->signs[f] = TO_DOUBLES((floatL)EACH_LANE(SIGN_OF));
#undef SIGN_OF
    }
#undef EDGE_OF
    fans->spokes[faces] = fans->spokes[0];
    fans->signs[faces] = fans->signs[0];
    Vectors middle = vectors(0.0, 0.0, 0.0);
    for (uint f = 0; f < faces; ++f) {
        const Vectors area = cross_product(fans->spokes[f], fans->spokes[f + 1]);
        fans->normals[f] = product(1.0 / sqrt(dot_in_order(area, area)), area);
        middle = sum(middle, fans->normals[f]);
    }
    fans->middle = product(1.0 / (double)faces, middle);
}

// If face f rejects the direction u, v[f] . u >= 0. A call takes one edge of each face, the one that leaves the vertex
// or the one that arrives, and one side, above or below.
INLINE void set_conditions(__private const Fans* fans, uint faces, bool arriving, bool above, __private Vectors* v) {
    for (uint f = 0; f < faces; ++f) {
        const uint edge = arriving ? f + 1 : f;
        const Vectors normal = fans->normals[f], spoke = fans->spokes[edge];
        const doubleL sign = above ? fans->signs[edge] : -fans->signs[edge];
        const doubleL slope = sign > 0.0 ? sign : (doubleL)0.0;
        const doubleL tilt = above ? -slope : slope, lift = SURE_MARGIN * (1.0 + slope);
        const Vectors outward = arriving ? cross_product(normal, spoke) : cross_product(spoke, normal);
        v[f] = sum(outward, sum(product(tilt, normal), product(above ? -lift : lift, fans->middle)));
    }
}

// The least of the three factors by which conditions combine to sign * middle . u >= 0, and of their determinant:
//
//     middle . (b x c) a + middle . (c x a) b + middle . (a x b) c = det(a, b, c) middle
//
// Only those count that run counter-clockwise around `middle`, as the faces of a fan do around their mean normal.
INLINE doubleL least_factor(Vectors middle, double sign, Vectors a, Vectors b, Vectors c) {
    const Vectors cross = cross_product(b, c);
    const doubleL of_a = dot_in_order(middle, cross), of_b = dot_in_order(middle, cross_product(c, a)),
                  of_c = dot_in_order(middle, cross_product(a, b)), determinant = sign * dot_in_order(a, cross);
    return LESSER(LESSER(of_a, of_b), LESSER(of_c, determinant));
}

// With one lane, a search ends when its product is certain. Several lanes seldom agree, and to ask takes time.
#if LANES == 1
#define IS_ENOUGH(products) ((products) > CERTAIN_PRODUCT)
#define IS_TOO_LITTLE(products, best) (!((products) > (best)))
#else
#define IS_ENOUGH(products) false
#define IS_TOO_LITTLE(products, best) false
#endif

// Tries conditions a third of the fan apart; for most vertices they suffice.
INLINE doubleL best_of_thirds(__private const Vectors* v, uint faces, Vectors middle, double sign) {
    doubleL best = 0.0;
    const uint third = (faces + 1) / 3;
    for (uint f = 0; f < third && !IS_ENOUGH(best); ++f) {
        const doubleL least = least_factor(middle, sign, v[f], v[f + third], v[min(f + 2 * third, faces - 1)]);
        best = GREATER(best, least);
    }
    return best;
}

// Tries all sets of three. Products of two of the vectors are computed once for all third ones: middle . (c x a) =
// (middle x c) . a.
INLINE doubleL best_of_all(__private const Vectors* v, uint faces, Vectors middle, double sign) {
    doubleL best = 0.0;
    for (uint k = 2; k < faces; ++k) {
        const Vectors c = v[k], from_middle = cross_product(middle, c);
        for (uint j = 1; j < k && !IS_ENOUGH(best); ++j) {
            const Vectors b = v[j], cross = cross_product(b, c), to_middle = cross_product(b, middle);
            const doubleL of_a = dot_in_order(middle, cross);
            if (IS_TOO_LITTLE(of_a, best)) continue;
            for (uint i = 0; i < j; ++i) {
                const Vectors a = v[i];
                const doubleL of_b = dot_in_order(from_middle, a), of_c = dot_in_order(to_middle, a),
                              determinant = sign * dot_in_order(a, cross);
                const doubleL least = LESSER(LESSER(of_a, of_b), LESSER(of_c, determinant));
                best = GREATER(best, least);
            }
        }
    }
    return best;
}

// True if three of the conditions surely contradict each other, at both edges and on both sides. try_all: all sets of
// three are tried. One lane tries those a third of the fan apart first.
OUT_OF_LINE longL are_covered(__private const Fans* fans, uint faces, bool try_all) {
    doubleL least = 1.0;
#if LANES == 1  // a copy for each turn takes compilers seconds
#pragma unroll 1
#else
#pragma unroll
#endif
    for (uint which = 0; which < 4; ++which) {
        if (IS_TOO_LITTLE(least, CERTAIN_PRODUCT)) continue;
        Vectors v[CLSDF_FAN_FACES];
        const bool arriving = which & 1, above = which < 2;
        set_conditions(fans, faces, arriving, above, v);
        const double sign = above ? -1.0 : 1.0;
        doubleL best = 0.0;
        if (LANES == 1 || !try_all) best = best_of_thirds(v, faces, fans->middle, sign);
        if (try_all && !IS_ENOUGH(best)) best = GREATER(best, best_of_all(v, faces, fans->middle, sign));
        least = LESSER(least, best);
    }
    return least > CERTAIN_PRODUCT;
}

// The kinds of edges around the vertices.
typedef struct EdgeKinds {
    longL is_saddle;        // convex and concave ones, surely
    longL is_mixed;         // so they may be, and none is open: an open edge is cut by no plane
    longL is_left_to_host;  // the host decides: a face is a sliver's, or an edge of a mixed vertex too steep
} EdgeKinds;

INLINE EdgeKinds edge_kinds(__private const Fans* fans, uint faces) {
    doubleL greatest = -INFINITY, least = INFINITY, unsure = 1.0, known = 1.0;
    for (uint f = 0; f < faces; ++f) {
        const doubleL sign = fans->signs[f];
        greatest = sign > greatest ? sign : greatest;
        least = sign < least ? sign : least;
        unsure = sign == 0.0 ? (doubleL)0.0 : unsure;
        known = sign == sign ? known : (doubleL)0.0;
    }
    const longL is_open = greatest == (double)INFINITY, has_unsure = unsure == 0.0, has_unknown = known == 0.0;
    const doubleL steepest = GREATER(greatest, -least);
    EdgeKinds kinds;
    kinds.is_saddle = greatest > 0.0 && least < 0.0;
    kinds.is_mixed = (greatest > 0.0 || has_unsure) && (least < 0.0 || has_unsure) && !is_open;
    kinds.is_left_to_host = has_unknown || (kinds.is_mixed && steepest > STEEPEST_SLOPE);
    return kinds;
}

#endif
