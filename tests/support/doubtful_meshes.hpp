#pragma once

#include <clsdf/mesh.hpp>

#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

/// Meshes whose sign nobody doubts, though they are not balanced or nothing would be inside: noise around zero, doubled
/// faces, faces that look the wrong way, sheets.
namespace clsdf::test {

/// A surface over parameters from 0 to 2 pi, ends included, as linspace() gives them: at the seams coordinates differ
/// by rounding. Each quadrilateral has vertices of its own.
template <typename Function>
Mesh parametric(std::uint32_t around, std::uint32_t across, double last, std::string name, const Function& at) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    const auto parameter = [](std::uint32_t i, std::uint32_t count, double end) { return i * (end / count); };
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const auto first = static_cast<std::uint32_t>(vertices.size());
            for (const auto& [di, dj] : {std::pair(0U, 0U), {1U, 0U}, {1U, 1U}, {0U, 1U}})
                vertices.push_back(
                    at(parameter(i + di, around, 2 * std::numbers::pi), parameter(j + dj, across, last)));
            triangles.push_back({first, first + 1, first + 2});
            triangles.push_back({first, first + 2, first + 3});
        }
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

inline Mesh seamed_torus(std::uint32_t around = 24, std::uint32_t across = 12) {
    return parametric(around, across, 2 * std::numbers::pi, "torus with seams", [](double u, double v) {
        const double radius = 1 + 0.4 * std::cos(v);
        return Vec3{radius * std::cos(u), radius * std::sin(u), 0.4 * std::sin(v)};
    });
}

/// The poles are rows of vertices of their own, 1e-16 apart.
inline Mesh seamed_ellipsoid(std::uint32_t around = 16, std::uint32_t across = 8) {
    return reversed(parametric(around, across, std::numbers::pi, "ellipsoid with seams", [](double u, double v) {
        return Vec3{std::cos(u) * std::sin(v), 0.7 * std::sin(u) * std::sin(v), 0.5 * std::cos(v)};
    }));
}

inline Mesh with_faces(const Mesh& mesh, const std::vector<Triangle>& more, std::string name) {
    std::vector<Triangle> triangles = mesh.triangles();
    triangles.insert(triangles.end(), more.begin(), more.end());
    return {mesh.vertices(), std::move(triangles), std::move(name)};
}

inline Triangle turned(const Triangle& triangle) {
    return {triangle[0], triangle[2], triangle[1]};
}

inline Mesh with_turned(const Mesh& mesh, const std::vector<std::size_t>& faces, std::string name) {
    std::vector<Triangle> triangles = mesh.triangles();
    for (const std::size_t face : faces) triangles[face] = turned(triangles[face]);
    return {mesh.vertices(), std::move(triangles), std::move(name)};
}

/// Two boxes that share a wall, which is there once.
inline Mesh boxes_with_membrane() {
    const Mesh two = weld(together({box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1})}, "two boxes"));
    std::vector<Triangle> triangles;
    std::size_t walls = 0;
    for (const Triangle& triangle : two.triangles()) {
        bool is_wall = true;
        for (const std::uint32_t vertex : triangle) is_wall = is_wall && two.vertices()[vertex][0] == 1;
        if (!is_wall || walls++ < 2) triangles.push_back(triangle);
    }
    return {two.vertices(), std::move(triangles), "two boxes with a membrane"};
}

/// Each has the sign of the other mesh.
struct DoubtfulMesh {
    Mesh mesh;
    Mesh meant;
};

inline std::vector<DoubtfulMesh> doubtful_meshes() {
    const auto exact = [](const Mesh& seamed) { return weld(seamed, 1e-9); };
    const Mesh sphere = make_shape("sphere3"), solid = tilted(cube(1));
    const Triangle face = sphere.triangles()[40];
    const Mesh pair = together({solid, shifted(tilted(make_shape("sphere3")), {0.8, 0.5, 0.3})}, "overlapping");
    const Mesh hollow =
        together({solid, reversed(scaled(tilted(make_shape("sphere2")), 0.5))}, "cube with a round cavity");
    std::vector<DoubtfulMesh> meshes{
        {seamed_torus(), exact(seamed_torus())},
        {seamed_ellipsoid(), exact(seamed_ellipsoid())},
        {with_faces(sphere, {face}, "a face twice"), sphere},
        {with_faces(sphere, {face, face}, "a face three times"), sphere},
        {with_faces(sphere,
                    {turned(face), face, turned(sphere.triangles()[7]), sphere.triangles()[7], sphere.triangles()[7]},
                    "faces with their opposites, and once more"),
         sphere},
        {with_turned(sphere, {3, 200, 201}, "a sphere with three turned faces"), sphere},
        {with_turned(pair, {2, 30, 31, 400}, "overlapping solids with turned faces"), pair},
        {with_turned(hollow, {1, 20, 21}, "a cavity with turned faces"), hollow}};
    // On both sides, and beside sheets.
    meshes.push_back({together({solid, reversed(solid)}, "a cube, every face both ways"), solid});
    meshes.push_back({boxes_with_membrane(), weld(box({0, 0, 0}, {2, 1, 1}))});
    const Mesh sheet({{-2, -2, -0.3}, {2, -2, 0.2}, {2, 2, 0.5}, {-2, 2, 0}}, {{0, 1, 2}, {0, 2, 3}}, "sheet");
    meshes.push_back({together({sphere, sheet}, "a sheet through a sphere"), sphere});
    // All three at once.
    Mesh all = seamed_torus();
    all = with_turned(all, {5, 100}, "all at once");
    meshes.push_back({with_faces(all, {all.triangles()[60], all.triangles()[5], all.triangles()[5]}, "all at once"),
                      exact(seamed_torus())});
    return meshes;
}

}  // namespace clsdf::test
