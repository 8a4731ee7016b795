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

#endif
