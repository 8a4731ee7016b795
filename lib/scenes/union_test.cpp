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

}  // namespace

PlacedFace::PlacedFace(const SearchedBody& body, std::uint32_t face) : corners(mesh_of(body).corners(face)) {
    normal =
        body.frame->turned(normalized(cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]))));
    for (Vec3& corner : corners) corner = body.frame->to_scene(corner);
}

double extent(const PlacedFace& face, const Vec3& p, const Vec3& direction) {
    double most = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 inward = normalized(cross(face.normal, difference(face.corners[(i + 1) % 3], face.corners[i])));
        const double outwards = -dot(direction, inward);
        if (outwards > 0) most = std::min(most, std::max(dot(difference(p, face.corners[i]), inward), 0.0) / outwards);
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

bool UnionTest::is_on_union(const Vec3& p, std::uint32_t body, const PlacedFace& face) const {
    bool is_hidden = false, is_touched = false;
    visit_near(p, 0, [&](std::uint32_t other) {
        if (other == body) return true;
        const PlaceInBody place = place_in(scene_.bodies[other], p, 4 * rounding(body, other, p));
        is_touched = is_touched || place == PlaceInBody::on;
        is_hidden = place == PlaceInBody::inside;
        return !is_hidden;
    });
    if (is_hidden || !is_touched) return !is_hidden;
    if (is_free(p, body, face)) return true;
    const auto& [corners, normal] = face;
    const Vec3 first = normalized(difference(corners[1], corners[0])), second = cross(normal, first);
    constexpr int directions = 8;
    for (int i = 0; i < directions; ++i) {
        const double angle = (i + 0.25) * 2 * std::numbers::pi / directions;
        const Vec3 direction = moved(moved({}, std::cos(angle), first), std::sin(angle), second);
        if (is_free_towards(p, direction, body, face)) return true;
    }
    // From a corner of a small angle.
    const Vec3 centre{(corners[0][0] + corners[1][0] + corners[2][0]) / 3,
                      (corners[0][1] + corners[1][1] + corners[2][1]) / 3,
                      (corners[0][2] + corners[1][2] + corners[2][2]) / 3};
    return is_free_towards(p, normalized(difference(centre, p)), body, face);
}

bool UnionTest::is_on_union_beside(const Vec3& p, const Vec3& along, std::uint32_t body, const PlacedFace& face) const {
    const Vec3 across = cross(face.normal, along);
    return is_free_towards(p, across, body, face) ||
           is_free_towards(p, {-across[0], -across[1], -across[2]}, body, face);
}

bool UnionTest::is_free_towards(const Vec3& p, const Vec3& direction, std::uint32_t body,
                                const PlacedFace& face) const {
    const double all = extent(face, p, direction), least = rounding(body, body, p);
    // It has no end if the direction or the normal is not a number.
    return all > least_extent * least && std::isfinite(all) &&
           is_free(moved(p, std::min(beside * least, all / 2), direction), body, face);
}

bool UnionTest::is_free(const Vec3& p, std::uint32_t body, const PlacedFace& face) const {
    if (!is_finite(face.normal)) return false;
    bool is_free = true;
    visit_near(p, 0, [&](std::uint32_t other) {
        if (other != body) {
            // Two other bodies that touch each other leave no gap: a point on their common wall is not free.
            const double height = rounding(body, other, p);
            is_free = place_in(scene_.bodies[other], moved(p, height, face.normal), height / 2) == PlaceInBody::outside;
        }
        return is_free;
    });
    return is_free;
}

}  // namespace clsdf::scenes
