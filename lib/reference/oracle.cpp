#include <clsdf/reference.hpp>

#include "core/lifetime.hpp"
#include "core/refuse.hpp"
#include "triangle.hpp"
#include "triangle_tree.hpp"

#include <cmath>
#include <utility>

namespace clsdf::reference {

Nearest nearest_on_triangle(const Vec3& query, const Vec3& a, const Vec3& b, const Vec3& c) {
    const TriangleFrame::Closest closest = TriangleFrame(a, b, c).closest({query, {}});
    return {closest.distance, 0, closest.site, closest.point};
}

Nearest nearest_by_brute_force(const Mesh& mesh, const Vec3& query) {
    Nearest nearest;
    nearest.distance = std::numeric_limits<double>::infinity();
    for (std::uint32_t index = 0; index < mesh.triangles().size(); ++index) {
        const Triangle& triangle = mesh.triangles()[index];
        const Nearest candidate = nearest_on_triangle(query, mesh.vertices()[triangle[0]], mesh.vertices()[triangle[1]],
                                                      mesh.vertices()[triangle[2]]);
        if (candidate.distance < nearest.distance) {
            nearest = candidate;
            nearest.triangle = index;
        }
    }
    return nearest;
}

namespace {

void require_finite(const Vec3& query) {
    if (!std::isfinite(query[0]) || !std::isfinite(query[1]) || !std::isfinite(query[2])) {
        refuse("the point ({}, {}, {}) is not finite: ask for a finite one", query[0], query[1], query[2]);
    }
}

}  // namespace

struct Oracle::State {
    explicit State(Mesh given) : mesh(std::move(given)), tree(mesh), rays(tree) {}

    Mesh mesh;
    TriangleTree tree;
    RayCounter rays;
};

Oracle::Oracle(const Mesh& mesh) : state_(std::make_unique<State>(mesh)) {}
Oracle::Oracle(Oracle&&) noexcept = default;
Oracle& Oracle::operator=(Oracle&&) noexcept = default;
Oracle::~Oracle() = default;

Nearest Oracle::nearest(const Vec3& query) const {
    require_finite(query);
    return *held_by(state_, "Oracle").tree.nearest({query, {}});
}

std::optional<Nearest> Oracle::nearest_within(const Vec3& query, double bound) const {
    require_finite(query);
    return held_by(state_, "Oracle").tree.nearest({query, {}}, bound);
}

std::optional<int> Oracle::winding_number(const Vec3& query) const {
    const std::optional<RayCount> count = count_along_row({query.data(), 1}, query[1], query[2]).front();
    return count ? std::optional(count->winding) : std::nullopt;
}

std::optional<int> Oracle::crossings(const Vec3& query) const {
    const std::optional<RayCount> count = count_along_row({query.data(), 1}, query[1], query[2]).front();
    return count ? std::optional(count->crossings) : std::nullopt;
}

std::vector<std::optional<RayCount>> Oracle::count_along_row(std::span<const double> x, double y, double z) const {
    for (const double at : x) {
        require_finite({at, y, z});
    }
    return held_by(state_, "Oracle").rays.count_along_row(x, y, z);
}

}  // namespace clsdf::reference
