#include "cutting/cut_points.hpp"

#include "core/refuse.hpp"

#include <CGAL/Quotient.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace clsdf::cutting {

namespace {

template <typename Number>
using Vector = std::array<Number, 3>;

int sign_of(const Exact& number) {
    return static_cast<int>(CGAL::sign(number));
}

template <typename Number>
Vector<Number> difference(const Vec3& a, const Vec3& b) {
    return {Number(a[0]) - Number(b[0]), Number(a[1]) - Number(b[1]), Number(a[2]) - Number(b[2])};
}

template <typename Number>
Vector<Number> cross(const Vector<Number>& a, const Vector<Number>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

template <typename Number>
Number dot(const Vector<Number>& a, const Vector<Number>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <typename Number>
struct Plane {
    Vec3 at;
    Vector<Number> normal;
};

template <typename Number>
Plane<Number> plane_of(const Triangle& face, std::span<const Vec3> vertices) {
    const Vec3 &a = vertices[face[0]], &b = vertices[face[1]], &c = vertices[face[2]];
    return {a, cross(difference<Number>(b, a), difference<Number>(c, a))};
}

/// The point with w > 0. Nothing is known of it if the sign of w is not.
HomogeneousPoint<FilteredNumber> made_positive(HomogeneousPoint<FilteredNumber> point) {
    const std::optional<int> sign = point.w.sign();
    if (!sign || *sign == 0)
        return {{FilteredNumber::unknown(), FilteredNumber::unknown(), FilteredNumber::unknown()},
                FilteredNumber::unknown()};
    if (*sign > 0) return point;
    return {{-point.at[0], -point.at[1], -point.at[2]}, -point.w};
}

HomogeneousPoint<Exact> made_positive(HomogeneousPoint<Exact> point) {
    if (sign_of(point.w) > 0) return point;
    return {{-point.at[0], -point.at[1], -point.at[2]}, -point.w};
}

template <typename Number>
Number determinant(const std::array<const HomogeneousPoint<Number>*, 3>& p, std::size_t u, std::size_t v) {
    const auto minor = [&](std::size_t i, std::size_t j) {
        return p[i]->at[u] * p[j]->at[v] - p[i]->at[v] * p[j]->at[u];
    };
    return minor(0, 1) * p[2]->w + minor(1, 2) * p[0]->w + minor(2, 0) * p[1]->w;
}

/// The sign of (b - a) x (c - a) in a plane, if it is certain: each coordinate is off by at most `off`.
std::optional<int> sign_in_plane(const std::array<double, 2>& a, const std::array<double, 2>& b,
                                 const std::array<double, 2>& c, double off) {
    const double bu = b[0] - a[0], bv = b[1] - a[1], cu = c[0] - a[0], cv = c[1] - a[1];
    const double left = bu * cv, right = bv * cu, value = left - right;
    // Differences are off by twice as much, and by their rounding, which is less.
    const double each = 3 * off;
    const double error = each * (std::abs(bu) + std::abs(bv) + std::abs(cu) + std::abs(cv) + 2 * each) +
                         0x1p-51 * (std::abs(left) + std::abs(right));
    if (std::abs(value) > error) return value > 0 ? 1 : -1;
    return std::nullopt;
}

/// More than half an ulp of each coordinate.
double rounding_of(const Vec3& a, const Vec3& b, const Vec3& c, std::size_t u, std::size_t v) {
    return 0x1p-52 *
           std::max({std::abs(a[u]), std::abs(a[v]), std::abs(b[u]), std::abs(b[v]), std::abs(c[u]), std::abs(c[v])});
}

/// The double nearest to x / w, of even ones in a tie. `near`: within few ulp of it, and finite.
double nearest_double(const Exact& x, const Exact& w, double near) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    // Whether x / w is above the middle of two doubles (1), below (-1) or there.
    const auto beside_middle = [&](double a, double b) { return sign_of(Exact(2) * x - (Exact(a) + Exact(b)) * w); };
    double value = near;
    for (;;) {
        const double above = std::nextafter(value, infinity), below = std::nextafter(value, -infinity);
        const int over = beside_middle(value, above), under = beside_middle(below, value);
        const bool is_even = (std::bit_cast<std::uint64_t>(value) & 1) == 0;
        if (over > 0 || (over == 0 && !is_even))
            value = above;
        else if (under < 0 || (under == 0 && !is_even))
            value = below;
        else
            return value + 0.0;
    }
}

/// The quotient, and a bound of its error.
std::pair<double, double> quotient(const FilteredNumber& x, const FilteredNumber& w) {
    const double first = x.high / w.high;
    const FilteredNumber rest = x - FilteredNumber(first) * w;
    const double second = (rest.high + rest.low) / (w.high + w.low);
    const double least = std::abs(w.high) - std::abs(w.low) - w.error;
    if (!(least > 0)) return {first, std::numeric_limits<double>::infinity()};
    // x / w = first + rest / w
    const double error = rest.error / least + std::abs(second) * (w.error / least + 0x1p-50);
    const double sum = first + second;
    return {sum, std::abs(second - (sum - first)) + error};
}

/// The double nearest to x / w, if that is certain.
std::optional<double> nearest_double(const FilteredNumber& x, const FilteredNumber& w) {
    if (const std::optional<int> sign = x.sign(); sign && *sign == 0) return 0.0;
    const auto [value, off] = quotient(x, w);
    const double smaller = std::nextafter(std::abs(value), 0.0);
    if (!(std::abs(value) > 0x1p-900)) return std::nullopt;
    return off < 0.49 * (std::abs(value) - smaller) ? std::optional<double>(value) : std::nullopt;
}

std::uint64_t hash_of(const Vec3& position) {
    std::uint64_t hash = 0x9E3779B97F4A7C15U;
    for (const double coordinate : position) {
        hash ^= std::bit_cast<std::uint64_t>(coordinate + 0.0);
        hash *= 0xD6E8FEB86659FD93U;
        hash ^= hash >> 32U;
    }
    return hash;
}

}  // namespace

Source Source::of_planes(std::array<Cutter, 3> cutters) {
    std::ranges::sort(cutters);
    return {planes, {}, cutters};
}

CutPoints::CutPoints(std::span<const Vec3> vertices, std::span<const Triangle> triangles)
    : vertices_(vertices), triangles_(triangles) {
    points_.reserve(vertices.size());
    for (std::uint32_t v = 0; v < vertices.size(); ++v) {
        const Vec3& at = vertices[v];
        points_.push_back(
            {Source::of_vertex(v), {{at[0], at[1], at[2]}, 1.0}, {at[0] + 0.0, at[1] + 0.0, at[2] + 0.0}});
    }
}

template <typename Number>
HomogeneousPoint<Number> CutPoints::homogeneous(const Source& source) const {
    const Vec3& from = vertices_[source.vertices[0]];
    if (source.kind == Source::vertex) return {{Number(from[0]), Number(from[1]), Number(from[2])}, Number(1)};
    const auto plane = [&](const Cutter& cutter) -> Plane<Number> {
        if (cutter.axis == Cutter::of_face) return plane_of<Number>(triangles_[cutter.first], vertices_);
        const Vec3 &a = vertices_[cutter.first], &b = vertices_[cutter.second];
        Vec3 along{};
        along[cutter.axis] = 1;
        return {a, cross(difference<Number>(b, a), difference<Number>(along, {}))};
    };
    if (source.kind == Source::edge) {
        const auto [at, normal] = plane(source.cutters[0]);
        const Vector<Number> along = difference<Number>(vertices_[source.vertices[1]], from);
        const Number w = dot(normal, along), way = dot(normal, difference<Number>(at, from));
        HomogeneousPoint<Number> point{{}, w};
        for (std::size_t axis = 0; axis < 3; ++axis) point.at[axis] = Number(from[axis]) * w + along[axis] * way;
        return made_positive(point);
    }
    const std::array<Plane<Number>, 3> planes{plane(source.cutters[0]), plane(source.cutters[1]),
                                              plane(source.cutters[2])};
    const Vec3& origin = planes[0].at;  // on the first plane
    const Vector<Number> first = cross(planes[2].normal, planes[0].normal),
                         second = cross(planes[0].normal, planes[1].normal);
    const Number w = dot(planes[2].normal, second),
                 of_first = dot(planes[1].normal, difference<Number>(planes[1].at, origin)),
                 of_second = dot(planes[2].normal, difference<Number>(planes[2].at, origin));
    HomogeneousPoint<Number> point{{}, w};
    for (std::size_t axis = 0; axis < 3; ++axis)
        point.at[axis] = Number(origin[axis]) * w + first[axis] * of_first + second[axis] * of_second;
    return made_positive(point);
}

CutPoints::Found CutPoints::find(const Source& source) const {
    if (source.kind == Source::vertex) return points_[source.vertices[0]];
    Found found{source, homogeneous<FilteredNumber>(source), {}};
    std::optional<HomogeneousPoint<Exact>> exact;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::optional<double> value = nearest_double(found.near.at[axis], found.near.w);
        if (!value) {
            if (!exact) exact = homogeneous<Exact>(source);
            const double near = CGAL::to_double(CGAL::Quotient<Exact>(exact->at[axis], exact->w));
            if (!std::isfinite(near)) refuse_unsupported("a point at which faces meet is out of the range of numbers");
            value = nearest_double(exact->at[axis], exact->w, near);
        }
        found.rounded[axis] = *value + 0.0;
    }
    return found;
}

std::uint32_t CutPoints::number(const Found& found) {
    if (by_rounded_.empty())  // most meshes have no cuts
        for (std::uint32_t v = 0; v < points_.size(); ++v) by_rounded_.emplace(hash_of(points_[v].rounded), v);
    const std::uint64_t hash = hash_of(found.rounded);
    const auto [first, last] = by_rounded_.equal_range(hash);
    std::optional<HomogeneousPoint<Exact>> exact_found;
    for (auto known = first; known != last; ++known) {
        const Found& other = points_[known->second];
        if (other.source == found.source) return known->second;
        if (other.rounded != found.rounded) continue;
        bool are_equal = true;
        for (std::size_t axis = 0; axis < 3 && are_equal; ++axis) {
            const FilteredNumber apart = other.near.at[axis] * found.near.w - found.near.at[axis] * other.near.w;
            std::optional<int> sign = apart.sign();
            if (!sign) {
                if (!exact_found) exact_found = homogeneous<Exact>(found.source);
                const HomogeneousPoint<Exact> exact_other = homogeneous<Exact>(other.source);
                sign = sign_of(exact_other.at[axis] * exact_found->w - exact_found->at[axis] * exact_other.w);
            }
            are_equal = *sign == 0;
        }
        if (are_equal) return known->second;
    }
    const auto number = static_cast<std::uint32_t>(points_.size());
    points_.push_back(found);
    by_rounded_.emplace(hash, number);
    return number;
}

const HomogeneousPoint<Exact>& CutPoints::exact(std::uint32_t point, Cache& cache) const {
    const auto known = cache.find(point);
    if (known != cache.end()) return known->second;
    return cache.emplace(point, homogeneous<Exact>(points_[point].source)).first->second;
}

int CutPoints::orientation(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::size_t axis, Cache& cache) const {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Vec3 &p = points_[a].rounded, &q = points_[b].rounded, &r = points_[c].rounded;
    if (const std::optional<int> sign =
            sign_in_plane({p[u], p[v]}, {q[u], q[v]}, {r[u], r[v]}, rounding_of(p, q, r, u, v)))
        return *sign;
    const FilteredNumber near =
        determinant<FilteredNumber>({&points_[a].near, &points_[b].near, &points_[c].near}, u, v);
    if (const std::optional<int> sign = near.sign()) return *sign;
    return sign_of(determinant<Exact>({&exact(a, cache), &exact(b, cache), &exact(c, cache)}, u, v));
}

int CutPoints::compare(std::uint32_t a, std::uint32_t b, std::size_t axis, Cache& cache) const {
    if (a == b) return 0;
    const double first = points_[a].rounded[axis], second = points_[b].rounded[axis];
    if (first != second) return first > second ? 1 : -1;
    const FilteredNumber near =
        points_[a].near.at[axis] * points_[b].near.w - points_[b].near.at[axis] * points_[a].near.w;
    if (const std::optional<int> sign = near.sign()) return *sign;
    const HomogeneousPoint<Exact>&p = exact(a, cache), &q = exact(b, cache);
    return sign_of(p.at[axis] * q.w - q.at[axis] * p.w);
}

std::array<double, 2> CutPoints::weights(std::uint32_t point, std::uint32_t face, std::size_t axis,
                                         Cache& cache) const {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Triangle& corners = triangles_[face];
    std::array<double, 2> weights{};
    for (std::size_t i = 0; i < 2; ++i) {
        // Areas, seen along the axis; the vertices have w = 1.
        const std::uint32_t first = corners[(i + 2) % 3], second = corners[i];
        const auto area = [&]<typename Number>(const HomogeneousPoint<Number>& at) {
            const HomogeneousPoint<Number> a = homogeneous<Number>(points_[first].source),
                                           b = homogeneous<Number>(points_[second].source);
            return determinant<Number>({&at, &a, &b}, u, v);
        };
        const auto all = [&]<typename Number>() { return area(homogeneous<Number>(points_[corners[i + 1]].source)); };
        const FilteredNumber whole = all.template operator()<FilteredNumber>() * points_[point].near.w;
        const auto [near, off] = quotient(area(points_[point].near), whole);
        if (off <= 0x1p-54) {
            weights[i] = near;
        } else {
            const HomogeneousPoint<Exact>& at = exact(point, cache);
            weights[i] = CGAL::to_double(CGAL::Quotient<Exact>(area(at), all.template operator()<Exact>() * at.w));
        }
        weights[i] = std::clamp(weights[i], 0.0, 1.0);
    }
    return weights;
}

CutPoints::Inner::Inner(const CutPoints& points, const std::array<std::uint32_t, 3>& corners, const Vec3& weights)
    : points_(points), corners_(corners), weights_(weights), near_(made_positive(homogeneous<FilteredNumber>())) {
    const double all = weights_[0] + weights_[1] + weights_[2];
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < 3; ++i) {
            const double coordinate = points_.rounded(corners_[i])[axis];
            middle_[axis] += weights_[i] / all * coordinate;
            off_ = std::max(off_, 0x1p-48 * std::abs(coordinate));
        }
    off_ += std::numeric_limits<double>::min();
}

Box CutPoints::Inner::box() const {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = middle_[axis] - off_;
        box.upper[axis] = middle_[axis] + off_;
    }
    return box;
}

template <typename Number>
HomogeneousPoint<Number> CutPoints::Inner::homogeneous() const {
    std::array<HomogeneousPoint<Number>, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
        corners[i] = points_.template homogeneous<Number>(points_.points_[corners_[i]].source);
    HomogeneousPoint<Number> point{{Number(0), Number(0), Number(0)}, Number(0)};
    for (std::size_t i = 0; i < 3; ++i) {
        const Number share = Number(weights_[i]) * corners[(i + 1) % 3].w * corners[(i + 2) % 3].w;
        for (std::size_t axis = 0; axis < 3; ++axis) point.at[axis] = point.at[axis] + share * corners[i].at[axis];
        point.w = point.w + share * corners[i].w;
    }
    return point;
}

const HomogeneousPoint<Exact>& CutPoints::Inner::exact() {
    if (exact_.empty()) exact_.push_back(homogeneous<Exact>());
    return exact_.front();
}

int CutPoints::Inner::orientation(std::uint32_t a, std::uint32_t b, std::size_t axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Vec3 &p = points_.vertex(a), &q = points_.vertex(b);
    if (const std::optional<int> sign = sign_in_plane({p[u], p[v]}, {q[u], q[v]}, {middle_[u], middle_[v]},
                                                      off_ + rounding_of(p, q, middle_, u, v)))
        return *sign;
    const auto value = [&]<typename Number>(const HomogeneousPoint<Number>& point) {
        const Vec3 &from = points_.vertex(a), &to = points_.vertex(b);
        return (Number(to[u]) - Number(from[u])) * (point.at[v] - Number(from[v]) * point.w) -
               (Number(to[v]) - Number(from[v])) * (point.at[u] - Number(from[u]) * point.w);
    };
    if (const std::optional<int> sign = value(near_).sign()) return *sign;
    return sign_of(value(exact()));
}

int CutPoints::Inner::side(const Triangle& face) {
    const auto value = [&]<typename Number>(const HomogeneousPoint<Number>& point) {
        const auto [at, normal] = plane_of<Number>(face, points_.vertices());
        Vector<Number> from;
        for (std::size_t axis = 0; axis < 3; ++axis) from[axis] = point.at[axis] - Number(at[axis]) * point.w;
        return dot(normal, from);
    };
    if (const std::optional<int> sign = value(near_).sign()) return *sign;
    return sign_of(value(exact()));
}

}  // namespace clsdf::cutting
