// On which side of a triangle's edge, seen along x, a sample lies: exact integers, of 128 bits if the triangle is
// large.
#ifndef CLSDF_SWEEP_EDGES_H
#define CLSDF_SWEEP_EDGES_H

#include "simd.h"
#include "sweep.h"

typedef struct Wide {  // hi 2^64 + lo
    long hi;
    ulong lo;
} Wide;

static inline Wide wide_product(long a, long b) {
    Wide w;
    w.hi = mul_hi(a, b);
    w.lo = (ulong)a * (ulong)b;
    return w;
}

static inline Wide wide_difference(Wide a, Wide b) {
    Wide w;
    w.lo = a.lo - b.lo;
    w.hi = a.hi - b.hi - (a.lo < b.lo ? 1 : 0);
    return w;
}

static inline double wide_to_double(Wide w) {
    return (double)w.hi * 18446744073709551616.0 + (double)w.lo;
}

static inline Wide twice_area(SweepVertex a, SweepVertex b, SweepVertex c) {
    return wide_difference(wide_product(b.y - a.y, c.z - a.z), wide_product(b.z - a.z, c.y - a.y));
}

// Whether the symbolic displacement of a sample on the line p -> q is left of it.
INLINE bool is_displaced_left(SweepVertex p, SweepVertex q) {
    return q.z < p.z || (q.z == p.z && q.y > p.y);
}

// Whether the sample (y, z), or its displacement if it lies on the line, is left of p -> q; the edge function is
// returned through `weight`.
static inline bool left_of(SweepVertex p, SweepVertex q, long y, long z, __private double* weight) {
    const Wide e = wide_difference(wide_product(q.y - p.y, z - p.z), wide_product(q.z - p.z, y - p.y));
    *weight = wide_to_double(e);
    return e.hi > 0 || (e.hi == 0 && e.lo > 0) || (e.hi == 0 && e.lo == 0 && is_displaced_left(p, q));
}

// The edge function of a small triangle, in 64 bits, for consecutive samples along y. If samples on the line do not
// count as left of it, the value is lessened by one: the sample is left of the line if the value is not negative. The
// type is unsigned, because the last step may leave the triangle's box and the range of a long.
typedef struct Edge {
    ulong value, step;
    bool lessened;
} Edge;

INLINE Edge edge_at(SweepVertex p, SweepVertex q, long y, long z, int bits_y) {
    Edge edge;
    edge.lessened = !is_displaced_left(p, q);
    edge.step = (ulong)(q.z - p.z) << bits_y;
    edge.value = (ulong)(q.y - p.y) * (ulong)(z - p.z) - (ulong)(q.z - p.z) * (ulong)(y - p.y) - edge.lessened;
    return edge;
}

INLINE double weight_of(Edge edge) {
    return (double)(long)(edge.value + edge.lessened);
}

#if LANES == 8
// The same for LANES triangles at once.
typedef struct LaneVertices {
    longL y, z;
    doubleL x;
} LaneVertices;

INLINE LaneVertices lane_vertices(__global const SweepVertex* vertices, __private const uint* numbers) {
#define Y_OF(lane) yz[lane].x
#define Z_OF(lane) yz[lane].y
#define X_OF(lane) LOAD(double, &vertices[numbers[lane]].x)
    long2 yz[LANES];
#pragma unroll
    for (uint lane = 0; lane < LANES; ++lane) yz[lane] = vload2(0, (__global const long*)(vertices + numbers[lane]));
    LaneVertices v;
    v.y = (longL)EACH_LANE(Y_OF);
    v.z = (longL)EACH_LANE(Z_OF);
    v.x = (doubleL)EACH_LANE(X_OF);
    return v;
#undef X_OF
#undef Z_OF
#undef Y_OF
}

INLINE LaneVertices chosen_vertices(longL condition, LaneVertices a, LaneVertices b) {
    LaneVertices v;
    v.y = condition ? a.y : b.y;
    v.z = condition ? a.z : b.z;
    v.x = condition ? a.x : b.x;
    return v;
}

// The product of numbers of 32 bits.
INLINE longL product_of_ints(longL a, longL b) {
    return TO_LONGS(TO_INTS(a)) * TO_LONGS(TO_INTS(b));
}

typedef struct LaneEdges {
    ulongL value, along_y, to_next_row;  // what the next sample along y adds, and the first sample of the next row
    longL lessened;                      // -1 or 0
} LaneEdges;

// Samples (y, z) begin rows of last + 1 samples.
INLINE LaneEdges lane_edges_at(LaneVertices p, LaneVertices q, longL y, longL z, longL last, int bits_y, int bits_z) {
    const longL to_y = q.y - p.y, to_z = q.z - p.z;
    LaneEdges edges;
    edges.lessened = !(to_z < 0 || (to_z == 0 && to_y > 0));
    edges.value = as_ulong8(product_of_ints(to_y, z - p.z) - product_of_ints(to_z, y - p.y) + edges.lessened);
    edges.along_y = -(as_ulong8(to_z) << bits_y);
    edges.to_next_row = (as_ulong8(to_y) << bits_z) - as_ulong8(last) * edges.along_y;
    return edges;
}

INLINE doubleL lane_weights_of(LaneEdges edges) {
    return TO_DOUBLES(as_long8(edges.value) - edges.lessened);
}
#endif

#endif
