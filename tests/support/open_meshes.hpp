#pragma once

#include "hostile_meshes.hpp"
#include "winding.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

/// Meshes with open edges.
namespace clsdf::test {

/// A box without one of its sides: -x, +x, -y, +y, -z, +z. turn: 1 divides the sides along their other diagonals.
inline Mesh open_box(const Vec3& lower, const Vec3& upper, std::size_t side, std::size_t turn = 0) {
    std::vector<Vec3> vertices;
    for (std::uint32_t i = 0; i < 8; ++i)
        vertices.push_back({(i & 1U) != 0 ? upper[0] : lower[0], (i & 2U) != 0 ? upper[1] : lower[1],
                            (i & 4U) != 0 ? upper[2] : lower[2]});
    constexpr std::array<std::array<std::uint32_t, 4>, 6> sides{
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    std::vector<Triangle> triangles;
    for (std::size_t k = 0; k < sides.size(); ++k) {
        if (k == side) continue;
        const auto corner = [&](std::size_t i) { return sides[k][(i + turn) % 4]; };
        triangles.push_back({corner(0), corner(1), corner(2)});
        triangles.push_back({corner(0), corner(2), corner(3)});
    }
    return {std::move(vertices), std::move(triangles), "box without side " + std::to_string(side)};
}

/// A sphere of rings, or its upper half, open below.
inline Mesh round_mesh(std::uint32_t rings, double radius, const Vec3& centre, bool is_half, std::string name) {
    const std::uint32_t around = 2 * rings;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i <= rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const double polar = (is_half ? 0.5 : 1) * std::numbers::pi * i / rings,
                         turn = 2 * std::numbers::pi * j / around;
            const bool is_pole = i == 0 || (!is_half && i == rings);
            const double side = is_pole ? 0 : radius * std::sin(polar);
            vertices.push_back({centre[0] + side * std::cos(turn), centre[1] + side * std::sin(turn),
                                centre[2] + (is_half && i == rings ? 0 : radius * std::cos(polar))});
        }
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const std::uint32_t a = i * around + j, b = i * around + (j + 1) % around, c = a + around, d = b + around;
            if (i > 0) triangles.push_back({a, c, b});
            if (is_half || i + 1 < rings) triangles.push_back({b, c, d});
        }
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

template <typename Choose>
Mesh with_chosen_faces(const Mesh& mesh, std::string name, const Choose& choose) {
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < mesh.triangles().size(); ++i)
        if (choose(i)) triangles.push_back(mesh.triangles()[i]);
    return {mesh.vertices(), std::move(triangles), std::move(name)};
}

/// Triangles with corners of a lattice of whole numbers in [2, 11]; or anywhere there.
inline Mesh triangle_soup(std::uint32_t count, bool on_lattice, Random& random) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            Vec3 corner = random.point(2, 12);
            if (on_lattice)
                for (double& x : corner) x = std::floor(x);
            vertices.push_back(corner);
        }
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return {std::move(vertices), std::move(triangles), on_lattice ? "soup on the lattice" : "soup"};
}

/// A box whose lid has vertices on its edges that the sides do not have: cracks without width.
inline Mesh cracked_box() {
    const Mesh open = open_box({3, 3, 3}, {10, 9, 8}, 5);
    std::vector<Vec3> vertices = open.vertices();
    std::vector<Triangle> triangles = open.triangles();
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), {{6, 3, 8}, {5, 9, 8}, {3, 5, 8}, {6, 6, 8}});
    const std::array<std::uint32_t, 7> ring{4, first, 5, 7, first + 1, 6, first + 2};
    for (std::size_t k = 0; k < ring.size(); ++k)
        triangles.push_back({first + 3, ring[k], ring[(k + 1) % ring.size()]});
    return {std::move(vertices), std::move(triangles), "box with T-junctions"};
}

/// In or about the cube from 2 to 12; many of their planes and edges lie on whole numbers.
inline std::vector<Mesh> open_meshes(std::uint64_t seed) {
    Random random(seed);
    std::vector<Mesh> meshes;
    for (std::size_t side = 0; side < 6; ++side) {
        meshes.push_back(open_box({3, 3, 3}, {10, 9, 8}, side));
        meshes.push_back(open_box({3.3, 2.7, 3.1}, {9.6, 9.2, 8.4}, side));
    }
    meshes.push_back(cracked_box());
    const Mesh sphere = round_mesh(8, 5, {6.5, 6.5, 6.5}, false, "sphere");
    meshes.push_back(with_chosen_faces(sphere, "sphere with slits", [](std::size_t i) { return i % 37 != 5; }));
    meshes.push_back(with_chosen_faces(sphere, "sphere with a third of its faces missing",
                                       [&](std::size_t) { return random.uniform(0, 1) > 0.33; }));
    meshes.push_back(round_mesh(6, 5, {6, 6, 6}, true, "half sphere"));
    std::vector<Mesh> shells;
    for (const double radius : {1.5, 2.5, 3.5, 4.5})
        shells.push_back(round_mesh(5, radius, {7, 7, 5}, true, "half sphere"));
    meshes.push_back(together(shells, "nested half spheres"));
    meshes.push_back(together(
        {open_box({3, 3, 3}, {10, 9, 8}, 5), open_box({4, 4, 4}, {8, 8, 8}, 5), open_box({3, 3, 3}, {10, 9, 8}, 5, 1)},
        "nested open boxes, one twice"));
    meshes.push_back(reversed(open_box({3, 3, 3}, {10, 9, 8}, 1)));
    meshes.push_back(triangle_soup(40, true, random));
    meshes.push_back(triangle_soup(40, false, random));
    return meshes;
}

}  // namespace clsdf::test
