#include "scenes/union_test.hpp"

#include "core/vectors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace clsdf::scenes {

namespace {

/// How far beside a point a face is looked at, in units of rounding(): far enough that two faces at an angle of 1e-4
/// are apart there.
constexpr double beside = 1e4;
/// A face that extends less far to one side does not continue there.
constexpr double least_extent = 8;

Vec3 moved(const Vec3& p, double by, const Vec3& direction) {
    return {p[0] + by * direction[0], p[1] + by * direction[1], p[2] + by * direction[2]};
}

Vec3 unit(const Vec3& v) {
    const double size = length(v);
    return {v[0] / size, v[1] / size, v[2] / size};
}

}  // namespace

Corners corners_of(const SearchedBody& body, std::uint32_t face) {
    Corners corners = mesh_of(body).corners(face);
    for (Vec3& corner : corners) corner = body.frame->to_scene(corner);
    return corners;
}

Vec3 normal_of(const Corners& corners) {
    return unit(cross(difference(corners[1], corners[0]), difference(corners[2], corners[0])));
}

double extent(const Corners& corners, const Vec3& normal, const Vec3& p, const Vec3& direction) {
    double most = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 inward = unit(cross(normal, difference(corners[(i + 1) % 3], corners[i])));
        const double outwards = -dot(direction, inward);
        if (outwards > 0) most = std::min(most, std::max(dot(difference(p, corners[i]), inward), 0.0) / outwards);
    }
    return most;
}

UnionTest::UnionTest(const SearchedScene& scene) : scene_(scene), largest_of_body_(scene.bodies.size()) {
    for (std::size_t i = 0; i < largest_of_body_.size(); ++i) {
        if (scene.bodies[i].shape == nullptr) continue;
        largest_of_body_[i] = largest_of(scene.bodies[i]);
        largest_ = std::max(largest_, largest_of_body_[i]);
    }
}

double UnionTest::rounding(std::uint32_t body, std::uint32_t other, const Vec3& p) const {
    return relative_rounding * std::max({largest_of_body_[body], largest_of_body_[other], largest_of(p)});
}

bool UnionTest::is_on_union(const Vec3& p, std::uint32_t body, const Corners& corners) const {
    bool is_hidden = false, is_touched = false;
    visit_near(p, 0, [&](std::uint32_t other) {
        if (other == body) return true;
        const PlaceInBody place = place_in(scene_.bodies[other], p, 4 * rounding(body, other, p));
        is_touched = is_touched || place == PlaceInBody::on;
        is_hidden = place == PlaceInBody::inside;
        return !is_hidden;
    });
    if (is_hidden || !is_touched) return !is_hidden;
    const Vec3 normal = normal_of(corners);
    if (is_free(p, normal, body)) return true;
    const Vec3 first = unit(difference(corners[1], corners[0])), second = cross(normal, first);
    constexpr int directions = 8;
    for (int i = 0; i < directions; ++i) {
        const double angle = (i + 0.25) * 2 * std::numbers::pi / directions;
        const Vec3 direction = moved({}, std::cos(angle), first);
        if (is_free_towards(p, moved(direction, std::sin(angle), second), normal, body, corners)) return true;
    }
    const Vec3 centre{(corners[0][0] + corners[1][0] + corners[2][0]) / 3,
                      (corners[0][1] + corners[1][1] + corners[2][1]) / 3,
                      (corners[0][2] + corners[1][2] + corners[2][2]) / 3};
    return is_free_towards(p, unit(difference(centre, p)), normal, body, corners);
}

bool UnionTest::is_on_union_beside(const Vec3& p, const Vec3& along, std::uint32_t body, const Corners& corners) const {
    const Vec3 normal = normal_of(corners), across = cross(normal, along);
    return is_free_towards(p, across, normal, body, corners) ||
           is_free_towards(p, {-across[0], -across[1], -across[2]}, normal, body, corners);
}

bool UnionTest::is_free_towards(const Vec3& p, const Vec3& direction, const Vec3& normal, std::uint32_t body,
                                const Corners& corners) const {
    const double all = extent(corners, normal, p, direction), least = rounding(body, body, p);
    return all > least_extent * least && is_free(moved(p, std::min(beside * least, all / 2), direction), normal, body);
}

bool UnionTest::is_free(const Vec3& p, const Vec3& normal, std::uint32_t body) const {
    bool is_free = true;
    visit_near(p, 0, [&](std::uint32_t other) {
        if (other != body) {
            const Vec3 in_front = moved(p, rounding(body, other, p), normal);
            is_free = place_in(scene_.bodies[other], in_front, 0) == PlaceInBody::outside;
        }
        return is_free;
    });
    return is_free;
}

}  // namespace clsdf::scenes
