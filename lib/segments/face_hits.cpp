#include "segments/face_hits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::segments {

namespace {

using engine::CrossedFaces;

struct Vector {
    double x, y, z;
};

Vector operator-(const Vec3& a, const Vec3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector cross(const Vector& a, const Vector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot(const Vector& a, const Vector& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
double size_of(const Vector& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

enum class Answer { missed, met, unknown };

// A determinant of differences is off by less than 2^-50 of its six products' sum (expansions.h), each of which is at
// most the product of the greatest components.
constexpr double rounding = 6 * 0x1p-50;

Answer by_doubles(const Line& line, const CrossedFaces::Corners& corners, FaceHit& hit) {
    const Vector along{line.along[0], line.along[1], line.along[2]};
    const Vector a = corners[0] - line.from, b = corners[1] - line.from, c = corners[2] - line.from;
    const double size = std::max({size_of(a), size_of(b), size_of(c)});
    const double of_first = dot(along, cross(a, b)), of_second = dot(along, cross(b, c)),
                 of_third = dot(along, cross(c, a));
    const double error = rounding * line.greatest * size * size;
    const double least = std::min({of_first, of_second, of_third}), most = std::max({of_first, of_second, of_third});
    if (least < -error && most > error) return Answer::missed;
    if (!(least > error || most < -error)) return Answer::unknown;

    const Vector ab = corners[1] - corners[0], ac = corners[2] - corners[0], normal = cross(ab, ac);
    const double side = std::max(size_of(ab), size_of(ac)), per_factor = rounding * side * side;
    const double distance = dot(normal, a), distance_error = per_factor * size;
    if (!(std::abs(distance) > distance_error)) return Answer::unknown;
    const bool is_towards_front = least > error;
    if ((distance > 0) != is_towards_front) return Answer::missed;  // it lies behind the begin
    if (!line.exact.is_ray) {
        const Vector rest = corners[0] - Vec3{line.exact.to.x, line.exact.to.y, line.exact.to.z};
        const double rest_distance = dot(normal, rest), rest_error = per_factor * size_of(rest);
        if (!(std::abs(rest_distance) > rest_error)) return Answer::unknown;
        if ((rest_distance > 0) == (distance > 0)) return Answer::missed;
    }
    hit.side = is_towards_front ? -1 : 1;
    hit.looks = CLSDF_ALL_LOOKS;
    const double approach = dot(normal, along), approach_error = per_factor * line.greatest;
    hit.place = distance / approach;
    const double certain = std::abs(approach) - approach_error;
    hit.error = certain > 0 ? (distance_error + hit.place * approach_error) / certain + 0x1p-50 * hit.place
                            : std::numeric_limits<double>::infinity();
    return Answer::met;
}

/// Whether a closed triangle has a point of the line, to which it is not parallel.
bool touches(const crossing::Segment& segment, const CrossedFaces::Corners& corners, FaceHit& hit) {
    using crossing::exact_difference, crossing::sign_of_determinant, crossing::ExactVector;
    const crossing::double3 a = crossing::vector(corners[0]), b = crossing::vector(corners[1]),
                            c = crossing::vector(corners[2]);
    const ExactVector from_a = exact_difference(a, segment.from), from_b = exact_difference(b, segment.from),
                      from_c = exact_difference(c, segment.from), ab = exact_difference(b, a),
                      ac = exact_difference(c, a);
    const int turns[3] = {sign_of_determinant(segment.along, from_a, from_b),
                          sign_of_determinant(segment.along, from_b, from_c),
                          sign_of_determinant(segment.along, from_c, from_a)};
    const auto [least, most] = std::minmax_element(turns, turns + 3);
    if (*least < 0 && *most > 0) return false;
    const int approach = sign_of_determinant(ab, ac, segment.along);
    if (approach == 0) return false;
    const int ahead = sign_of_determinant(ab, ac, from_a);
    if (ahead * approach < 0) return false;
    if (!segment.is_ray && ahead * sign_of_determinant(ab, ac, exact_difference(a, segment.to)) > 0) return false;
    hit.side = static_cast<std::int8_t>(-approach);
    return true;
}

[[gnu::noinline]] bool meets_exactly(const Line& line, const CrossedFaces::Corners& corners, Hits hits, FaceHit& hit) {
    if (hits == Hits::faces) {
        if (!touches(line.exact, corners, hit)) return false;
    } else {
        const crossing::FaceCrossing crossing = crossing::crossing_of(corners, line.exact);
        if (crossing.looks == 0) return false;
        hit.side = static_cast<std::int8_t>(crossing.side);
        hit.looks = static_cast<std::uint8_t>(crossing.looks);
    }
    hit.place = crossing::place_of(corners, line.exact);
    hit.error = std::numeric_limits<double>::epsilon() * hit.place;
    return true;
}

}  // namespace

Line::Line(const crossing::Segment& exact_in, const Vec3& along_in)
    : exact(exact_in), from{exact.from.x, exact.from.y, exact.from.z}, along(along_in) {
    for (const double x : along) greatest = std::max(greatest, std::abs(x));
}

Line Line::segment(const Vec3& from, const Vec3& to) {
    const crossing::Segment segment = crossing::segment(from, to);
    return {segment, {segment.along.x.high, segment.along.y.high, segment.along.z.high}};
}

bool is_in_plane(const crossing::Segment& segment, const CrossedFaces::Corners& corners) {
    using crossing::exact_difference, crossing::sign_of_determinant;
    const crossing::double3 a = crossing::vector(corners[0]);
    const crossing::ExactVector ab = exact_difference(crossing::vector(corners[1]), a),
                                ac = exact_difference(crossing::vector(corners[2]), a);
    return sign_of_determinant(ab, ac, segment.along) == 0 &&
           sign_of_determinant(ab, ac, exact_difference(a, segment.from)) == 0;
}

bool meets(const Line& line, const CrossedFaces::Corners& corners, Hits hits, FaceHit& hit) {
    const Answer answer = by_doubles(line, corners, hit);
    return answer == Answer::unknown ? meets_exactly(line, corners, hits, hit) : answer == Answer::met;
}

}  // namespace clsdf::segments
