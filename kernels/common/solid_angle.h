// The part of the winding number that the open edges of a surface have (docs/method.md, 'Sign of open meshes').
//
// The generalised winding number is w = n + T. n counts the crossings of the ray towards -x. T is the sum over the open
// edges a -> b of arg(z) / 2 pi, where z = conj(c_a) c_b + conj(q_a) q_b: the signed spherical triangle of the edge and
// the direction +x. (c, q) is the stereographic place of a vertex seen from the point. A product of complex numbers and
// a count of half turns take the place of the sum of angles. So the decision takes + - * and a correctly rounded root,
// and has the same bits everywhere if multiply and add are not fused.
#ifndef CLSDF_SOLID_ANGLE_H
#define CLSDF_SOLID_ANGLE_H

#ifndef __OPENCL_VERSION__
#include <cmath>
namespace clsdf {
using std::fabs;
using std::sqrt;
#endif

// A vertex seen from a point; a common factor of both numbers, also a complex one, means the same place.
typedef struct SeenVertex {
    double cr, ci;  // c
    double qy, qz;  // q
} SeenVertex;

// halves / 2 + arg(re + i im) / 2 pi turns, re >= 0.
typedef struct Turns {
    double re, im;
    int halves;
} Turns;

static inline Turns no_turns(void) {
    Turns none;
    none.re = 1.0;
    none.im = 0.0;
    none.halves = 0;
    return none;
}

// A direction across the ray, of any length but 0.
typedef struct Phase {
    double y, z;
} Phase;

static inline Phase phase_of(double sy, double sz) {
    const double ay = fabs(sy), az = fabs(sz), most = ay > az ? ay : az;
    Phase phase;
    phase.y = sy;
    phase.z = sz;
    if (most == 0.0) {
        phase.y = -1.0;
        phase.z = 0.0;
    } else if (most < 0x1p-66) {  // products would underflow
        phase.y *= 0x1p66;
        phase.z *= 0x1p66;
        if (most < 0x1p-132) {
            phase.y /= most * 0x1p66;
            phase.z /= most * 0x1p66;
        }
    }
    return phase;
}

// (x, y, z): the vertex minus the point. (sy, sz): the offset across the ray as the crossings' predicate sees it: of
// the snapped vertex for samples, (y, z) for points. If it is 0, the point counts as moved by (e, e^2). If the vertex
// lies on the ray's side of the point's plane, that offset is the phase of (c, q): so the sum changes where the
// crossings do.
static inline SeenVertex seen_vertex(double x, double y, double z, double sy, double sz) {
    SeenVertex seen;
    const double length = sqrt(x * x + (y * y + z * z));
    if (x >= 0.0) {
        seen.cr = length + x;
        seen.ci = 0.0;
        seen.qy = y;
        seen.qz = z;
    } else {
        const Phase phase = phase_of(sy, sz);
        const double d = length - x;
        seen.cr = y * phase.y + z * phase.z;
        seen.ci = y * phase.z - z * phase.y;
        seen.qy = d * phase.y;
        seen.qz = d * phase.z;
    }
    return seen;
}

// conj(c_a) c_b + conj(q_a) q_b.
static inline double edge_re(SeenVertex a, SeenVertex b) {
    return (a.cr * b.cr + a.ci * b.ci) + (a.qy * b.qy + a.qz * b.qz);
}
static inline double edge_im(SeenVertex a, SeenVertex b) {
    return (a.cr * b.ci - a.ci * b.cr) + (a.qy * b.qz - a.qz * b.qy);
}

// Turns by an edge with these parts of z. side: 1 if the crossings' predicate has the point left of the edge, else -1;
// it matters only if re < 0. A z of 0 turns nothing: the point is on the edge.
static inline Turns turned(Turns turns, double re, double im, int side) {
    double pr, pi, size;
    if (re == 0.0 && im == 0.0) return turns;
    if (re < 0.0) {
        re = -re;
        im = -im;
        turns.halves += side;
    }
    pr = turns.re * re - turns.im * im;
    pi = turns.re * im + turns.im * re;
    if (pr < 0.0) {  // both were on one side of the real axis
        turns.halves += im > 0.0 ? 1 : -1;
        pr = -pr;
        pi = -pi;
    }
    size = pr + fabs(pi);
    if (size > 0x1p200) {
        pr *= 0x1p-400;
        pi *= 0x1p-400;
    } else if (size < 0x1p-200) {
        pr *= 0x1p400;
        pi *= 0x1p400;
    }
    turns.re = pr;
    turns.im = pi;
    return turns;
}

// M: the least integer above T - 1/2 + 2^-30, so that n + M is the winding number rounded to an integer, a half up.
static inline int rounded_turns(Turns turns) {
    const double tangent = 5.8516723170686385e-9;  // of 2 pi 2^-30
    if ((turns.halves & 1) == 0) return turns.halves / 2;
    return (turns.halves + 1) / 2 - (turns.im < -tangent * turns.re ? 1 : 0);
}

// arg(re + i im) / 2 pi for re >= 0: the angle is halved twice, the rest is a polynomial; the error is 1e-16.
static inline double fraction_of(Turns turns) {
    const double r = fabs(turns.im);
    const int is_steep = r > turns.re;
    double t, s, p, turn;
    if (!(turns.re + r > 0.0)) return 0.0;
    t = is_steep ? turns.re / r : r / turns.re;
    t = t / (1.0 + sqrt(1.0 + t * t));
    t = t / (1.0 + sqrt(1.0 + t * t));  // at most tan(pi / 16)
    s = t * t;
    p = 1.0 / 19 - s * (1.0 / 21);
    p = 1.0 / 17 - s * p;
    p = 1.0 / 15 - s * p;
    p = 1.0 / 13 - s * p;
    p = 1.0 / 11 - s * p;
    p = 1.0 / 9 - s * p;
    p = 1.0 / 7 - s * p;
    p = 1.0 / 5 - s * p;
    p = 1.0 / 3 - s * p;
    p = 1.0 - s * p;
    turn = 4.0 * t * p * 0.15915494309189533577;
    if (is_steep) turn = 0.25 - turn;
    return turns.im < 0.0 ? -turn : turn;
}

// T.
static inline double turns_of(Turns turns) {
    return 0.5 * turns.halves + fraction_of(turns);
}

#ifndef __OPENCL_VERSION__
}  // namespace clsdf
#endif

#endif
