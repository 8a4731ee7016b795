#pragma once

#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

/// Random meshes of some ten voxels, of every kind that is known to be hard for bounding polyhedra.
namespace clsdf::test {

/// A polygon in x and z, counter-clockwise, drawn out along y; its ends are closed by fans from the first vertex, which
/// is a triangulation only if the polygon is star-shaped from there, and a self-intersecting closed surface else.
inline Mesh extruded(std::string name, const std::vector<std::array<double, 2>>& profile, double width) {
    const auto count = static_cast<std::uint32_t>(profile.size());
    std::vector<Vec3> vertices;
    for (const double y : {0.0, width})
        for (const auto& [x, z] : profile) vertices.push_back({x, y, z});
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t next = (i + 1) % count;
        triangles.push_back({i, count + next, next});
        triangles.push_back({i, count + i, count + next});
    }
    for (std::uint32_t i = 1; i + 1 < count; ++i) {
        triangles.push_back({0, i, i + 1});
        triangles.push_back({count, count + i + 1, count + i});
    }
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

/// Steps of random width and height, many of them lower than a voxel.
inline Mesh random_stairs(Random& random) {
    std::vector<std::array<double, 2>> profile{{0, -8}};
    double x = 0;
    double z = 0;
    std::vector<std::array<double, 2>> steps;
    for (std::uint32_t i = 0, count = 1 + random.index(4); i < count; ++i) {
        steps.push_back({x, z});
        x += random.uniform(0.1, 8);
        steps.push_back({x, z});
        z += random.uniform(-1, 1) * std::pow(10, random.uniform(-3, 1));
    }
    steps.push_back({x, z});
    x += random.uniform(0.1, 8);
    steps.push_back({x, z});
    profile.push_back({x, -8});
    profile.insert(profile.end(), steps.rbegin(), steps.rend());
    return extruded("stairs", profile, random.uniform(1, 20));
}

/// The counterexample a3 (docs/method.md) with a flap of random size and lean.
inline Mesh random_leaning_flap(Random& random) {
    const double height = std::pow(10, random.uniform(-3, 1));
    const double lean = random.uniform(-2, 2);
    return extruded("flap", {{0, -5}, {20, -5}, {20, 0}, {10.01, 0}, {10 + lean, height}, {10, 0}, {0, 0}},
                    random.uniform(1, 20));
}

/// An octahedron subdivided twice, each vertex moved along its radius.
inline Mesh random_sphere(Random& random) {
    std::vector<Vec3> vertices{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<Triangle> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < 2; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [place, is_new] = middles.try_emplace(std::minmax(a, b), vertices.size());
            if (is_new) {
                const Vec3& p = vertices[a];
                const Vec3& q = vertices[b];
                const Vec3 m{p[0] + q[0], p[1] + q[1], p[2] + q[2]};
                const double length = std::sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
                vertices.push_back({m[0] / length, m[1] / length, m[2] / length});
            }
            return place->second;
        };
        std::vector<Triangle> finer;
        for (const auto& [a, b, c] : triangles) {
            const std::uint32_t ab = middle(a, b);
            const std::uint32_t bc = middle(b, c);
            const std::uint32_t ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        triangles = std::move(finer);
    }
    const double noise = random.uniform(0, 0.9);
    const double radius = random.uniform(2, 20);
    for (Vec3& vertex : vertices) {
        const double factor = radius * (1 + random.uniform(-noise, noise));
        for (double& coordinate : vertex) coordinate *= factor;
    }
    return {std::move(vertices), std::move(triangles), "sphere"};
}

/// Two random apexes over one ring of 3 to 12 vertices.
inline Mesh random_fan(Random& random) {
    std::vector<Vec3> ring(3 + random.index(10));
    for (Vec3& vertex : ring) vertex = random.point(-5, 5);
    return closed_fan("fan", ring);
}

/// Like the counterexample h6 (docs/method.md): a fan folded into nearly one plane and a half.
inline Mesh random_folded_sheet(Random& random) {
    const double thickness = std::pow(10, random.uniform(-6, 0));
    std::vector<Vec3> vertices{{0, 0, 0}};
    const std::uint32_t ring = 3 + random.index(6);
    for (std::uint32_t i = 0; i < ring; ++i) {
        const double angle = random.uniform(0, 4);
        const double length = random.uniform(1, 8);
        vertices.push_back({length * std::cos(angle), length * std::sin(angle), thickness * random.uniform(-4, 4)});
    }
    vertices.push_back(along({0, 0, 0}, random.uniform(1, 12), random.direction()));
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < ring; ++i) {
        const std::uint32_t next = 1 + (i + 1) % ring;
        triangles.push_back({0, 1 + i, next});
        triangles.push_back({ring + 1, next, 1 + i});
    }
    return {std::move(vertices), std::move(triangles), "folded sheet"};
}

/// A double cone whose sharp tips have many faces.
inline Mesh random_spike(Random& random) {
    std::vector<Vec3> vertices{{0, 0, random.uniform(2, 30)}};
    const std::uint32_t ring = 3 + random.index(20);
    const double radius = std::pow(10, random.uniform(-3, 1));
    for (std::uint32_t i = 0; i < ring; ++i) {
        const double angle = 6.283185307179586 * i / ring;
        const double r = radius * random.uniform(0.5, 1);
        vertices.push_back({r * std::cos(angle), r * std::sin(angle), random.uniform(-1, 1) * radius});
    }
    vertices.push_back({0, 0, -random.uniform(0, 10)});
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < ring; ++i) {
        const std::uint32_t next = 1 + (i + 1) % ring;
        triangles.push_back({0, 1 + i, next});
        triangles.push_back({ring + 1, next, 1 + i});
    }
    return {std::move(vertices), std::move(triangles), "spike"};
}

/// Half of the faces of a mesh divided in three at a point very near to one of their edges, or on it.
inline Mesh with_caps(const Mesh& mesh, Random& random) {
    std::vector<Vec3> vertices = mesh.vertices();
    std::vector<Triangle> triangles;
    for (const auto& [a, b, c] : mesh.triangles()) {
        if (random.index(2) == 0) {
            triangles.push_back({a, b, c});
            continue;
        }
        const double height = random.index(4) == 0 ? 0 : std::pow(10, random.uniform(-14, -1));
        const double t = random.uniform(0.01, 0.99);
        Vec3 point{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] =
                (1 - height) * ((1 - t) * vertices[a][axis] + t * vertices[b][axis]) + height * vertices[c][axis];
        const auto middle = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(point);
        triangles.insert(triangles.end(), {{a, b, middle}, {b, c, middle}, {c, a, middle}});
    }
    return {std::move(vertices), std::move(triangles), mesh.name() + " with caps"};
}

/// Changes that meshes suffer in files and programs.
inline Mesh spoiled(const Mesh& mesh, Random& random) {
    std::vector<Vec3> vertices = mesh.vertices();
    std::vector<Triangle> triangles = mesh.triangles();
    std::string name = mesh.name();
    const auto each = [&](std::uint32_t one_in, const auto& change) {
        for (std::size_t i = triangles.size(); i-- > 0;)
            if (random.index(one_in) == 0) change(i);
    };
    const auto swap_two = [](Triangle triangle) { return Triangle{triangle[1], triangle[0], triangle[2]}; };
    switch (random.index(9)) {
        case 0:
            name += ", vertices on samples";
            for (Vec3& vertex : vertices)
                for (double& coordinate : vertex) coordinate = std::round(coordinate);
            break;
        case 1:
            name += ", holes";
            each(4, [&](std::size_t i) {
                if (triangles.size() > 1) triangles.erase(triangles.begin() + static_cast<std::ptrdiff_t>(i));
            });
            break;
        case 2:
            name += ", faces twice";
            each(4, [&](std::size_t i) { triangles.push_back(triangles[i]); });
            break;
        case 3:
            name += ", faces twice, reversed";
            each(4, [&](std::size_t i) { triangles.push_back(swap_two(triangles[i])); });
            break;
        case 4:
            name += ", faces reversed";
            each(3, [&](std::size_t i) { triangles[i] = swap_two(triangles[i]); });
            break;
        case 5:
            name += ", vertices merged";
            each(8, [&](std::size_t i) { triangles[i][0] = random.index(vertices.size()); });
            break;
        case 6: {
            name += ", unwelded";
            std::vector<Vec3> corners;
            for (Triangle& triangle : triangles)
                for (std::uint32_t& vertex : triangle) {
                    corners.push_back(vertices[vertex]);
                    vertex = static_cast<std::uint32_t>(corners.size() - 1);
                }
            vertices = std::move(corners);
            break;
        }
        case 7:
            name += ", fins";
            each(6, [&](std::size_t i) {
                vertices.push_back(random.point(-8, 8));
                triangles.push_back(
                    {triangles[i][0], triangles[i][1], static_cast<std::uint32_t>(vertices.size() - 1)});
            });
            break;
        default:
            break;
    }
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

inline Mesh awkward_mesh(Random& random) {
    const auto base = [&]() -> Mesh {
        switch (random.index(11)) {
            case 0:
                return scaled(random_lattice_tetrahedron(random, 0.5), random.uniform(0.5, 5));
            case 1:
                return random_stairs(random);
            case 2:
                return random_leaning_flap(random);
            case 3:
                return random_sphere(random);
            case 4:
                return random_folded_sheet(random);
            case 5:
                return random_spike(random);
            case 6:
                return scaled(random_soup(random, 4 + random.index(20), 1 + random.index(40)), 10);
            case 7:
                return scaled(random_slivers(random, 20), 10);
            case 8:
                return scaled(random_closed(random, 1 + random.index(3)), 6);
            default:
                return random_fan(random);
        }
    }();
    return spoiled(random.index(5) == 0 ? with_caps(base, random) : base, random);
}

}  // namespace clsdf::test
