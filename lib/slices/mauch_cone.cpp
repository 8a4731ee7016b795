#include "slices/mauch_cone.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::slices {

using polyhedra::ConvexPolyhedron;
using polyhedra::HalfSpace;
using polyhedra::Vector;

namespace {

constexpr std::size_t cube_caps = 6;
constexpr std::size_t most_walls = CLSDF_MOST_PLANES - cube_caps;

/// Time is proportional to the square of the half-spaces up to this number, and to the number above it.
constexpr std::size_t most_cuts_by_all = 256;
constexpr std::size_t most_deepest_cuts = 32;

ConvexPolyhedron part_of_cube(std::span<const HalfSpace> half_spaces) {
    return polyhedra::clip({{-1, -1, -1}, {1, 1, 1}}, half_spaces);
}

double height_over(const HalfSpace& half_space, const ConvexPolyhedron& solid) {
    double highest = 0;
    for (const Vector& vertex : solid.vertices) highest = std::max(highest, half_space.normal.dot(vertex));
    return highest;
}

/// A few of the half-spaces, which leave little more than all of them: each is the one that cuts most from what those
/// before it have left.
std::vector<HalfSpace> deepest_cuts(std::span<const HalfSpace> half_spaces) {
    std::vector<HalfSpace> chosen;
    ConvexPolyhedron solid = part_of_cube(chosen);
    while (chosen.size() < most_deepest_cuts && !solid.is_empty()) {
        double highest = 0;
        const HalfSpace* deepest = nullptr;
        for (const HalfSpace& half_space : half_spaces)
            if (const double height = height_over(half_space, solid); height > highest) {
                highest = height;
                deepest = &half_space;
            }
        if (deepest == nullptr) break;
        chosen.push_back(*deepest);
        solid = part_of_cube(chosen);
    }
    return chosen;
}

/// Rays to the far corners of what is left of a cube around the vertex.
std::vector<Vector> rays_of(const ConvexPolyhedron& solid) {
    constexpr double near = 0.5;
    std::vector<Vector> rays;
    for (const Vector& corner : solid.vertices)
        if (corner.norm() > near) rays.push_back(corner.normalized());
    return rays;
}

}  // namespace

void MauchCone::add_caps_around(const Vector& axis) {
    const Vector across = polyhedra::any_perpendicular(axis);
    const Vector third = axis.cross(across);
    for (const Vector& normal : {axis, across, third}) {
        add_cap(normal);
        add_cap(-normal);
    }
}

bool MauchCone::build() {
    bounds_.clear();
    if (half_spaces_.size() > most_cuts_by_all) half_spaces_ = deepest_cuts(half_spaces_);
    const ConvexPolyhedron solid = part_of_cube(half_spaces_);
    std::vector<std::size_t> walls;
    for (const ConvexPolyhedron::Face& face : solid.faces)
        if (face.half_space != ConvexPolyhedron::start_box) walls.push_back(face.half_space);
    if (solid.is_empty())
        for (std::size_t i = 0; i < half_spaces_.size(); ++i) walls.push_back(i);
    const bool is_whole = walls.size() <= most_walls;
    walls.resize(std::min(walls.size(), most_walls));
    for (const std::size_t wall : walls) bounds_.push_back({half_spaces_[wall].normal, false});

    const std::vector<Vector> rays = rays_of(solid);
    Vector sum = Vector::Zero();
    for (const Vector& ray : rays) sum += ray;
    const double length = sum.norm();
    const Vector axis = length > 1e-3 ? Vector(sum / length) : Vector::UnitX();
    constexpr double narrow = 0.955;  // cosine; the one cap is 5% too high at the rays
    const bool is_narrow = is_whole && !rays.empty() && std::all_of(rays.begin(), rays.end(), [&](const Vector& ray) {
                               return ray.dot(axis) > narrow;
                           });
    if (is_narrow)
        add_cap(axis);
    else
        add_caps_around(axis);
    return !solid.is_empty();
}

}  // namespace clsdf::slices
