#pragma once

#include <Eigen/Core>

namespace clsdf::bench {

/// The part of a triangle that has the closest point: vertex 0 to 2, edge 0 to 2 (from vertex k to vertex k + 1), or
/// the face.
enum class TriangleSite { vertex0, vertex1, vertex2, edge0, edge1, edge2, face };

template <typename Real>
struct ClosestPoint {
    Eigen::Matrix<Real, 3, 1> point;
    TriangleSite site;
};

/// The usual decision by regions (Ericson, Real-Time Collision Detection, 5.1.5), which users of the peers would write.
template <typename Real>
inline ClosestPoint<Real> closest_point(const Eigen::Matrix<Real, 3, 1>& query, const Eigen::Matrix<Real, 3, 1>& a,
                                        const Eigen::Matrix<Real, 3, 1>& b, const Eigen::Matrix<Real, 3, 1>& c) {
    using Vector = Eigen::Matrix<Real, 3, 1>;
    const Vector ab = b - a, ac = c - a;
    const Vector ap = query - a;
    const Real d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return {a, TriangleSite::vertex0};
    const Vector bp = query - b;
    const Real d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return {b, TriangleSite::vertex1};
    const Real vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, TriangleSite::edge0};
    const Vector cp = query - c;
    const Real d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return {c, TriangleSite::vertex2};
    const Real vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, TriangleSite::edge2};
    const Real va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6)
        return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), TriangleSite::edge1};
    const Real scale = 1 / (va + vb + vc);
    return {a + vb * scale * ab + vc * scale * ac, TriangleSite::face};
}

}  // namespace clsdf::bench
