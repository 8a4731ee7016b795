// Whether the polyhedra of the faces around a vertex leave directions out (docs/method.md, 'Gaps at saddle vertices'),
// with one lane. The host compiles it, too (lib/engine/frusta/one_lane.hpp), so the kernel vertex_gaps answers as the
// host does: the same operations in the same order.
#ifndef CLSDF_GAP_TEST_H
#define CLSDF_GAP_TEST_H

#include "face_frames.h"

// Bounds the sum of a frame's roundings: some thirty of 2^-53 by count, 3e-15.
#define FRAME_ROUNDINGS 1.0e-13

INLINE double squared_length(Vectors a) {
    return dot_in_order(a, a);
}
INLINE Vectors normalized(Vectors a) {
    const double squared = squared_length(a);
    return squared > 0.0 ? quotient(a, sqrt(squared)) : a;
}

// Edges of two faces.

// Bounds the angle by which rounding turns a frame around its edges; the face is no box.
INLINE double turn_of(__private const FaceFrames* f) {
    return FRAME_ROUNDINGS * (f->right + f->left) / f->altitude;
}

typedef struct FacePair {
    Vectors first, second;  // unit vectors in the planes of a face and of the other one, from the edge inward
    bool is_folded;
    int side;  // of the first plane on which the second face lies: 1 above; 0: the exact orientation decides
} FacePair;

// normal: of the first face. turn: of both frames together.
INLINE FacePair face_pair(Vectors first, Vectors second, Vectors normal, double turn) {
    const Vectors apart = difference(first, second);
    const double sine = dot_in_order(second, normal);
    FacePair pair;
    pair.first = first;
    pair.second = second;
    pair.is_folded = squared_length(apart) < CLSDF_FOLD_ANGLE * CLSDF_FOLD_ANGLE;
    pair.side = pair.is_folded ? 0 : (sine > turn ? 1 : 0) - (sine < -turn ? 1 : 0);
    return pair;
}

// The tangent of half the angle by which the wedge between two faces exceeds a straight one, on the side where it does.
INLINE double wedge_slope(Vectors first, Vectors second) {
    const Vectors apart = difference(first, second), together = sum(first, second);
    const double wide = WIDENED(sqrt(squared_length(together)) / sqrt(divisor_of(squared_length(apart))));
    return wide < (double)CLSDF_OPEN_SLOPE ? wide : (double)CLSDF_OPEN_SLOPE;
}

// Sets the slopes of the first face; neither is a box. Returns marks (CLSDF_MARK_...).
INLINE uint set_pair_slopes(FacePair pair, __private double* above, __private double* below) {
    const uint kind = pair.side < 0 ? CLSDF_MARK_CONVEX : pair.side > 0 ? CLSDF_MARK_CONCAVE : 0u;
    if (pair.is_folded) {
        *above = *below = (double)CLSDF_OPEN_SLOPE;
        return kind | CLSDF_MARK_OPEN | CLSDF_MARK_FOLDED;
    }
    const double slope = pair.side != 0 ? wedge_slope(pair.first, pair.second) : 0.0;
    *above = pair.side < 0 ? slope : 0.0;
    *below = pair.side < 0 ? 0.0 : slope;
    return kind;
}

// Directions of a circle that satisfy conditions c . u >= 0: an arc of at most half a turn, from one end
// counter-clockwise to the other, once there is a condition. An end is kept as long as the condition that it comes
// from, so that most cuts need neither a root nor a division.

typedef struct ArcEnd {
    double x, y;
    double squared;  // its length's; rounding may have moved it by the tolerance
} ArcEnd;

typedef struct Arc {
    bool is_whole;
    ArcEnd first, last;
} Arc;

#define ARC_NOT_EMPTY 0
#define ARC_EMPTY 1
#define ARC_UNDECIDED 2
// Between the rounding of a product, 1e-15, and what decides anything about a mesh, 1e-6 (the margin of a gap).
#define ARC_TOLERANCE 1.0e-12
#define NEGLIGIBLE_CONDITION 1.0e-14

INLINE ArcEnd arc_end(double x, double y, double squared) {
    const ArcEnd end = {x, y, squared};
    return end;
}

INLINE bool is_half_turn(__private const Arc* arc) {
    const double along = arc->first.x * arc->last.x + arc->first.y * arc->last.y;
    return along < 0.0 && along * along > (1.0 - 2.0e-12) * arc->first.squared * arc->last.squared;
}

INLINE ArcEnd middle_of(__private const Arc* arc) {
    if (arc->is_whole) return arc_end(1.0, 0.0, 1.0);
    // The ends of half a turn cancel; its middle is a quarter turn after the first one.
    if (is_half_turn(arc)) return arc_end(-arc->first.y, arc->first.x, arc->first.squared);
    const double first = sqrt(arc->first.squared), last = sqrt(arc->last.squared);
    return arc_end(arc->first.x / first + arc->last.x / last, arc->first.y / first + arc->last.y / last, 0.0);
}

// Whether a product of a condition with an end is not 0 by rounding: the tolerance times the sum of their lengths.
INLINE bool is_certain_product(double along, double squared, __private const ArcEnd* end) {
    return along * along > 2.0 * ARC_TOLERANCE * ARC_TOLERANCE * (squared + end->squared);
}

// Cuts the arc by a condition (x, y). An arc that is undecided stays as it is: too large.
INLINE int cut_arc(__private Arc* arc, double x, double y) {
    const double squared = x * x + y * y;
    // The circle is nearly that condition's own.
    if (!(squared > NEGLIGIBLE_CONDITION * NEGLIGIBLE_CONDITION)) return ARC_NOT_EMPTY;
    // Of the half turn that satisfies the condition.
    const ArcEnd first = arc_end(y, -x, squared), last = arc_end(-y, x, squared);
    if (arc->is_whole) {
        arc->is_whole = false;
        arc->first = first;
        arc->last = last;
        return ARC_NOT_EMPTY;
    }
    const double at_first = x * arc->first.x + y * arc->first.y, at_last = x * arc->last.x + y * arc->last.y;
    if (at_first >= 0.0 && at_last >= 0.0) {
        // So all of the arc satisfies the condition. An arc of half a turn on the other side is the exception: rounding
        // decides whether its ends are left.
        if (!is_half_turn(arc)) return ARC_NOT_EMPTY;
        const ArcEnd middle = middle_of(arc);
        return x * middle.x + y * middle.y < 0.0 ? ARC_UNDECIDED : ARC_NOT_EMPTY;
    }
    if (at_first < 0.0 && at_last < 0.0)
        return is_certain_product(at_first, squared, &arc->first) && is_certain_product(at_last, squared, &arc->last)
                   ? ARC_EMPTY
                   : ARC_UNDECIDED;
    if (at_first < 0.0)
        arc->first = first;
    else
        arc->last = last;
    return ARC_NOT_EMPTY;
}

// Looks for a direction u with g_i . u >= 0 for every condition g_i added so far: a linear programme on the sphere,
// solved incrementally. It has no chart and so no direction at infinity.
//
// A condition that holds at the present direction costs one product. If it fails, a solution, if there is any, lies on
// the great circle of that condition: the directions of the earlier conditions are convex and reach from the present
// direction to the other side. In random order this happens log n times.
//
// The answer "none" is certain. If the answer depends on rounding, the search gives up and says that there may be a
// direction.
typedef struct ConeSearch {
    __private Vectors* conditions;
    uint count;
    Vectors direction;  // a unit vector that satisfies all conditions, up to rounding, unless the search is undecided
    bool is_undecided;
} ConeSearch;

#define CONDITION_ROUNDING 1.0e-14  // of a condition's product with a direction

INLINE Vectors any_perpendicular_to(Vectors v) {
    const bool is_near_y = !(fabs(v.x) < 0.6);
    return normalized(cross_product(v, vectors(is_near_y ? 0.0 : 1.0, is_near_y ? 1.0 : 0.0, 0.0)));
}

INLINE bool move_to_circle_of_last(__private ConeSearch* search) {
    // x and y are perpendicular to the last condition, about equally long, and not short; no more is needed.
    const Vectors pole = search->conditions[search->count - 1];
    Vectors x =
        difference(search->direction, product(dot_in_order(search->direction, pole) / squared_length(pole), pole));
    if (squared_length(x) < 0.01) x = any_perpendicular_to(normalized(pole));
    const Vectors y = cross_product(pole, x);
    Arc arc;
    arc.is_whole = true;
    arc.first = arc.last = arc_end(0.0, 0.0, 0.0);
    for (uint i = 0; i + 1 < search->count; ++i) {
        const Vectors condition = search->conditions[i];
        const int answer = cut_arc(&arc, dot_in_order(condition, x), dot_in_order(condition, y));
        if (answer == ARC_EMPTY) return false;
        // The conditions that follow may still prove the arc empty.
        if (answer == ARC_UNDECIDED) search->is_undecided = true;
    }
    if (search->is_undecided) return true;
    const ArcEnd middle = middle_of(&arc);
    search->direction = normalized(sum(product(middle.x, x), product(middle.y, y)));
    return true;
}

// Adds a condition of about unit length. Returns false if no direction satisfies all of them; then no more may be
// added.
INLINE bool add_condition(__private ConeSearch* search, Vectors condition) {
    search->conditions[search->count++] = condition;
    return search->is_undecided || dot_in_order(condition, search->direction) >= -CONDITION_ROUNDING ||
           move_to_circle_of_last(search);
}

// The gap test.

// A unit vector. per_unit: of lengths, which are then of the order of one.
INLINE Vectors direction_to(Vectors from, Vectors to, double per_unit) {
    const Vectors edge = product(per_unit, difference(to, from));
    return product(1.0 / sqrt(squared_length(edge)), edge);
}

// Widens the normal cone, so that rounding cannot close one that has no thickness.
#define CONE_TOLERANCE 1.0e-8
// Sine of the steepest spoke to a face's plane if the faces around a vertex are taken for flat ground.
#define FLAT_GROUND 1.0e-9
#define LARGE_FAN 32u
#define REJECTION_ROUNDS 4  // a flat vertex has normals on both sides; more than that is left undecided
#define GAP_CONDITIONS (2 * REJECTION_ROUNDS)  // of each face

// A face's lateral planes at its two edges at the vertex: at the edge that it shares with the face before, and at that
// shared with the face after.
typedef struct FacePlanes {
    Vectors normal;
    Vectors inward[2];
    double above[2], below[2];
} FacePlanes;

// A vertex whose faces are `fans` closed fans, in cyclic order each. Without a fan, the spokes alone count.
typedef struct GapVertex {
    uint fans;
    __private const uint* starts;  // of each fan among the faces, and the end
    __private const FacePlanes* faces;
    uint spoke_count;
    __private const Vectors* spokes;  // unit vectors to the neighbours; of each face that at its edge before
    Vectors normal;                   // of one of the faces
    __private uint* order;            // room for as many as there are spokes
    ConeSearch search;                // its conditions have room for all spokes and GAP_CONDITIONS of each face
    bool is_undecided;                // whether a search that succeeded hangs on rounding
} GapVertex;

// Sets the order in which [first, last) are gone through: thirds of the way round, because opposite conditions
// contradict each other soonest. In large fans random, so that no fan can make every condition fail in turn.
INLINE void set_order(__private uint* order, uint first, uint last) {
    const uint count = last - first, third = (count + 2) / 3;
    uint n = 0;
    for (uint start = 0; start < third; ++start)
        for (uint i = start; i < count; i += third) order[n++] = first + i;
    if (count <= LARGE_FAN) return;
    ulong random = 1;
    for (uint i = count - 1; i > 0; --i) {
        random = random * (ulong)6364136223846793005 + (ulong)1442695040888963407;
        const uint other = (uint)((random >> 33) % (i + 1)), moved = order[i];
        order[i] = order[other];
        order[other] = moved;
    }
}

// u . spoke <= 0 for all spokes.
INLINE bool add_normal_cone(__private GapVertex* vertex, Vectors axis) {
    vertex->search.count = 0;
    vertex->search.direction = axis;
    vertex->search.is_undecided = false;
    set_order(vertex->order, 0, vertex->spoke_count);
    for (uint i = 0; i < vertex->spoke_count; ++i)
        if (!add_condition(&vertex->search,
                           difference(product(CONE_TOLERANCE, axis), vertex->spokes[vertex->order[i]])))
            return false;
    vertex->is_undecided = vertex->is_undecided || vertex->search.is_undecided;
    return true;
}

// g with g . u > 0 where the plane, on one side of the face, has u outside. Scaled such that g . u counts in units by
// which the slack widens that plane.
INLINE Vectors rejection(__private const FacePlanes* face, uint edge, bool above) {
    const double slope = above ? face->above[edge] : face->below[edge];
    return product(-1.0 / (1.0 + slope), sum(face->inward[edge], product(above ? slope : -slope, face->normal)));
}

// Whether every face rejects some unit vector u by the margin at its edge before, or at that after: g . u >= margin.
// The plane of an edge is the higher one of two, above the face and below, so that is a condition for each side; first
// that of the side on which the normals lie, which mostly decides.
//
// A linear condition can only ask for g . u >= margin (m . u) with a unit vector m, which is weaker, and least so where
// u is near m. If the direction that is found does not have the margin, it becomes the next m.
INLINE bool add_rejections(__private GapVertex* vertex, uint faces, uint edge) {
#pragma unroll 1
    for (uint round = 0; round < REJECTION_ROUNDS; ++round) {
        const Vectors middle = vertex->search.direction;
#pragma unroll 1
        for (uint other_side = 0; other_side < 2; ++other_side)
            for (uint i = 0; i < faces; ++i) {
                __private const FacePlanes* const face = vertex->faces + vertex->order[i];
                const bool above = (dot_in_order(face->normal, middle) >= 0.0) == (other_side == 0);
                if (!add_condition(&vertex->search,
                                   difference(rejection(face, edge, above), product(CLSDF_REJECTION_MARGIN, middle))))
                    return false;
            }
        if (vertex->search.is_undecided || 2.0 * dot_in_order(middle, vertex->search.direction) > 1.0) break;
    }
    vertex->is_undecided = vertex->is_undecided || vertex->search.is_undecided;
    return true;
}

// Every edge of a fan rejects a direction for one of its two faces at most, so if all faces reject one, all do at their
// edge with the face before, or all at their edge with the face after.
INLINE bool leaves_out_near(__private GapVertex* vertex, Vectors axis) {
    if (!add_normal_cone(vertex, axis)) return false;
    const uint normals = vertex->search.count;
    const Vectors direction = vertex->search.direction;
    const bool is_undecided = vertex->search.is_undecided;
    for (uint fan = 0; fan < vertex->fans; ++fan) {
        const uint start = vertex->starts[fan], end = vertex->starts[fan + 1];
        set_order(vertex->order, start, end);
        bool is_rejected = false;
#pragma unroll 1
        for (uint edge = 0; edge < 2 && !is_rejected; ++edge) {
            vertex->search.count = normals;
            vertex->search.direction = direction;
            vertex->search.is_undecided = is_undecided;
            is_rejected = add_rejections(vertex, end - start, edge);
        }
        if (!is_rejected) return false;
    }
    return true;
}

// Whether there is a normal u of the vertex, u . spoke <= 0 for all spokes, that every fan leaves out. It is looked for
// from one of several axes: unit vectors such that every normal has axis . u >= 0 for one of them. The sum of the
// spokes, reversed, is such an axis. If it vanishes, or all normals are nearly perpendicular to it, as on flat ground,
// a face's normal and its opposite are.
INLINE bool leaves_directions_out(__private GapVertex* vertex) {
    Vectors total = vectors(0.0, 0.0, 0.0);
    double height = 0.0;
    for (uint i = 0; i < vertex->spoke_count; ++i) {
        const Vectors spoke = vertex->spokes[i];
        const double own = fabs(dot_in_order(spoke, vertex->normal));
        total = difference(total, spoke);
        height = height < own ? own : height;
    }
    const double length = sqrt(squared_length(total));
    const bool has_axis = height > FLAT_GROUND && length > 1.0e-6 * (double)vertex->spoke_count;
#pragma unroll 1
    for (uint attempt = has_axis ? 0 : 1; attempt < 3; ++attempt) {
        vertex->is_undecided = false;
        const Vectors axis =
            attempt == 0 ? quotient(total, length) : product(attempt == 1 ? 1.0 : -1.0, vertex->normal);
        const bool is_found = leaves_out_near(vertex, axis);
        if (is_found ? attempt > 0 || !vertex->is_undecided : attempt == 0) return is_found;
    }
    return false;
}

#endif
