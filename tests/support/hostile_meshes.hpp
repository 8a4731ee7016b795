#pragma once

#include <clsdf/mesh.hpp>

#include "support/random_meshes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

/// Meshes that have broken programs of this kind, and ways to make them from others.
namespace clsdf::test {

inline Mesh moved(const Mesh& mesh, const std::function<Vec3(const Vec3&)>& move) {
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& vertex : vertices) vertex = move(vertex);
    return {std::move(vertices), mesh.triangles(), mesh.name()};
}

inline Mesh scaled(const Mesh& mesh, double factor) {
    return moved(mesh, [&](const Vec3& v) { return Vec3{factor * v[0], factor * v[1], factor * v[2]}; });
}

inline Mesh shifted(const Mesh& mesh, const Vec3& by) {
    return moved(mesh, [&](const Vec3& v) { return Vec3{v[0] + by[0], v[1] + by[1], v[2] + by[2]}; });
}

/// Turned about an axis that is parallel to nothing.
inline Mesh tilted(const Mesh& mesh, double angle = 0.6) {
    return moved(mesh, [&](const Vec3& v) {
        const double c = std::cos(angle), s = std::sin(angle), c2 = std::cos(0.7 * angle), s2 = std::sin(0.7 * angle);
        const Vec3 once{c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]};
        return Vec3{once[0], c2 * once[1] - s2 * once[2], s2 * once[1] + c2 * once[2]};
    });
}

inline Mesh reversed(const Mesh& mesh) {
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles) std::swap(triangle[1], triangle[2]);
    return {mesh.vertices(), std::move(triangles), mesh.name() + " inside out"};
}

inline Mesh together(const std::vector<Mesh>& meshes, std::string name) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (const Mesh& mesh : meshes) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), mesh.vertices().begin(), mesh.vertices().end());
        for (const Triangle& t : mesh.triangles()) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

/// The same triangles in another order; triangle i of the result is triangle order[i] of the mesh.
inline Mesh reordered(const Mesh& mesh, Random& random) {
    std::vector<Triangle> triangles = mesh.triangles();
    for (std::size_t i = triangles.size(); i > 1; --i) std::swap(triangles[i - 1], triangles[random.index(i)]);
    return {mesh.vertices(), std::move(triangles), mesh.name() + " shuffled"};
}

/// Every triangle with vertices of its own, as in an STL file.
inline Mesh unwelded(const Mesh& mesh) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (const Triangle& t : mesh.triangles()) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        for (const std::uint32_t v : t) vertices.push_back(mesh.vertices()[v]);
        triangles.push_back({first, first + 1, first + 2});
    }
    return {std::move(vertices), std::move(triangles), mesh.name() + " unwelded"};
}

inline Mesh without_triangle(const Mesh& mesh, std::size_t index) {
    std::vector<Triangle> triangles = mesh.triangles();
    triangles.erase(triangles.begin() + static_cast<std::ptrdiff_t>(index));
    return {mesh.vertices(), std::move(triangles), mesh.name() + " with a hole"};
}

inline Mesh box(const Vec3& lower, const Vec3& upper, std::string name = "box") {
    std::vector<Vec3> vertices;
    vertices.reserve(8);
    for (int corner = 0; corner < 8; ++corner)
        vertices.push_back({(corner & 1) != 0 ? upper[0] : lower[0], (corner & 2) != 0 ? upper[1] : lower[1],
                            (corner & 4) != 0 ? upper[2] : lower[2]});
    return {std::move(vertices),
            {{0, 2, 3},
             {0, 3, 1},
             {4, 5, 7},
             {4, 7, 6},
             {0, 1, 5},
             {0, 5, 4},
             {2, 6, 7},
             {2, 7, 3},
             {0, 4, 6},
             {0, 6, 2},
             {1, 3, 7},
             {1, 7, 5}},
            std::move(name)};
}

inline Mesh cube(double half_side) {
    return box({-half_side, -half_side, -half_side}, {half_side, half_side, half_side}, "cube");
}

/// A plate of 2 x 2 units.
inline Mesh plate(double thickness) {
    return box({-1, -1, -0.5 * thickness}, {1, 1, 0.5 * thickness}, "plate of thickness " + std::to_string(thickness));
}

inline Mesh overlapping_cubes() {
    return together({cube(1), shifted(cube(1), {0.7, 0.6, 0.5}), reversed(shifted(cube(0.3), {0.35, 0.3, 0.25}))},
                    "overlapping cubes");
}

/// Four faces whose heights are a hundred-thousandth of their sides and less.
inline Mesh sliver() {
    return Mesh(std::vector<Vec3>{{0, 0, 0}, {5, 1e-6, 0}, {10, 0, 0}, {5, 3, 1}, {5, 1, -2}},
                std::vector<Triangle>{{0, 1, 3}, {1, 2, 3}, {0, 4, 1}, {1, 4, 2}, {0, 3, 4}, {2, 4, 3}}, "sliver");
}

/// Fins at one edge, one of them twice, a face without area and one with a repeated vertex.
inline Mesh fins() {
    return Mesh(std::vector<Vec3>{{0, 0, 0}, {0, 0, 1}, {1, 0, 0.3}, {-0.5, 0.8, 0.4}, {-0.5, -0.9, 0.6}, {0, 0, 0.5}},
                std::vector<Triangle>{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {0, 5, 1}, {0, 0, 2}, {0, 1, 2}}, "fins");
}

/// A profile in (x, z), counter-clockwise seen from -y, drawn along y from 0 to `width`; `caps` triangulates it.
inline Mesh extruded(const std::vector<std::array<double, 2>>& profile, const std::vector<Triangle>& caps, double width,
                     std::string name) {
    const auto n = static_cast<std::uint32_t>(profile.size());
    std::vector<Vec3> vertices;
    for (const double y : {0.0, width})
        for (const auto& [x, z] : profile) vertices.push_back({x, y, z});
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t next = (i + 1) % n;
        triangles.push_back({i, next + n, next});
        triangles.push_back({i, i + n, next + n});
    }
    for (const Triangle& t : caps) {
        triangles.push_back(t);
        triangles.push_back({t[0] + n, t[2] + n, t[1] + n});
    }
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

/// A sharp flap over a floor, as low as a thousandth of its length; it may intersect the floor.
inline Mesh random_flap(Random& random) {
    const double root = random.uniform(0.001, 0.5), tip = random.uniform(-4, 4),
                 height = std::pow(10, random.uniform(-3, 0.3));
    return extruded({{0, -5}, {20, -5}, {20, 0}, {10 + root, 0}, {10 + tip, height}, {10, 0}, {0, 0}},
                    {{0, 1, 5}, {1, 3, 5}, {1, 2, 3}, {3, 4, 5}, {0, 5, 6}}, 20, "flap");
}

/// Steps of random heights and widths. The side walls are fans; a triangle is degenerate if a lower neighbour ends on a
/// higher step's edge.
inline Mesh random_stairs(Random& random, std::size_t steps) {
    std::vector<double> x{0}, height;
    for (std::size_t i = 0; i < steps; ++i) {
        x.push_back(x.back() + std::pow(10, random.uniform(-2, 0)));
        height.push_back(1 + std::pow(10, random.uniform(-3, 0)) * (random.index(2) == 0 ? -0.9 : 1.0));
    }
    // Below, from left to right, then the steps from right to left: two points each.
    std::vector<std::array<double, 2>> profile;
    profile.reserve(3 * steps + 1);
    for (const double at : x) profile.push_back({at, 0});
    const auto lower = [&](std::size_t i) { return static_cast<std::uint32_t>(i); };
    std::vector<std::uint32_t> upper_right(steps), upper_left(steps);
    for (std::size_t i = steps; i-- > 0;) {
        upper_right[i] = static_cast<std::uint32_t>(profile.size());
        profile.push_back({x[i + 1], height[i]});
        upper_left[i] = static_cast<std::uint32_t>(profile.size());
        profile.push_back({x[i], height[i]});
    }
    std::vector<Triangle> caps;
    for (std::size_t i = 0; i < steps; ++i) {
        std::vector<std::uint32_t> column{lower(i), lower(i + 1)};
        if (i + 1 < steps && height[i + 1] < height[i]) column.push_back(upper_left[i + 1]);
        column.push_back(upper_right[i]);
        column.push_back(upper_left[i]);
        if (i > 0 && height[i - 1] < height[i]) column.push_back(upper_right[i - 1]);
        for (std::size_t c = 1; c + 1 < column.size(); ++c) caps.push_back({column[0], column[c], column[c + 1]});
    }
    return extruded(profile, caps, 2, "stairs");
}

/// A sphere whose vertices are moved along their radii by up to `noise` of the radius.
inline Mesh random_sphere(Random& random, const char* shape, double noise) {
    return moved(make_shape(shape), [&](const Vec3& v) {
        const double factor = 1 + random.uniform(-noise, noise);
        return Vec3{factor * v[0], factor * v[1], factor * v[2]};
    });
}

/// A cone of `count` sides and as many triangles below, its tip at (0, 0, 1).
inline Mesh cone(std::uint32_t count) {
    std::vector<Vec3> vertices{{0, 0, 1}, {0, 0, 0}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count;
        vertices.push_back({0.3 * std::cos(angle), 0.3 * std::sin(angle), 0});
        const std::uint32_t here = 2 + i, next = 2 + (i + 1) % count;
        triangles.push_back({0, here, next});
        triangles.push_back({1, next, here});
    }
    return {std::move(vertices), std::move(triangles), "cone"};
}

/// A band of `count` quads with half a twist: open, not orientable.
inline Mesh moebius_strip(std::uint32_t count) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double u = 2 * std::numbers::pi * i / count;
        for (const double side : {-0.4, 0.4}) {
            const double radius = 1 + side * std::cos(u / 2);
            vertices.push_back({radius * std::cos(u), radius * std::sin(u), side * std::sin(u / 2)});
        }
        const std::uint32_t a = 2 * i, b = a + 1;
        const std::uint32_t c = i + 1 < count ? a + 2 : 1, d = i + 1 < count ? a + 3 : 0;
        triangles.push_back({a, c, d});
        triangles.push_back({a, d, b});
    }
    return {std::move(vertices), std::move(triangles), "Moebius strip"};
}

}  // namespace clsdf::test
