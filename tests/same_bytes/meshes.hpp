#pragma once

#include <clsdf/mesh.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

/// Meshes that are the same in every build.
namespace clsdf::test {

struct Arrays {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;

    /// Adds the other one's triangles and vertices.
    void append(const Arrays& other) {
        const auto before = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
        for (const Triangle& t : other.triangles) triangles.push_back({t[0] + before, t[1] + before, t[2] + before});
    }
};

/// Numbers in [0, 1).
class Random {
public:
    double operator()() {
        state_ = state_ * 6364136223846793005U + 1442695040888963407U;
        return static_cast<double>(state_ >> 11U) * 0x1p-53;
    }

private:
    std::uint64_t state_ = 1;
};

/// A torus around the z axis whose surface has bumps, with saddle vertices. It has 2 around across triangles.
inline Arrays bumpy_torus(std::uint32_t around, std::uint32_t across, double size = 1) {
    Arrays arrays;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
            const double radius = size * (0.4 + 0.05 * std::sin(5 * u) * std::cos(3 * v));
            const double to_axis = size + radius * std::cos(v);
            arrays.vertices.push_back({to_axis * std::cos(u), to_axis * std::sin(u), radius * std::sin(v)});
            const auto vertex = [&](std::uint32_t di, std::uint32_t dj) {
                return (i + di) % around * across + (j + dj) % across;
            };
            arrays.triangles.push_back({vertex(0, 0), vertex(1, 0), vertex(1, 1)});
            arrays.triangles.push_back({vertex(0, 0), vertex(1, 1), vertex(0, 1)});
        }
    return arrays;
}

/// A box that is parallel to no axis: 12 triangles.
inline Arrays tilted_box() {
    Arrays arrays;
    for (unsigned k = 0; k < 8; ++k) {
        const double x = k & 1U ? 1 : -1, y = k & 2U ? 0.6 : -0.6, z = k & 4U ? 0.3 : -0.3;
        arrays.vertices.push_back({0.8 * x - 0.6 * y, 0.48 * x + 0.64 * y - 0.6 * z, 0.36 * x + 0.48 * y + 0.8 * z});
    }
    arrays.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                        {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return arrays;
}

/// Waves over the unit square, with a border: no winding number tells its sides.
inline Arrays open_sheet() {
    constexpr std::uint32_t side = 30;
    Arrays arrays;
    for (std::uint32_t j = 0; j <= side; ++j)
        for (std::uint32_t i = 0; i <= side; ++i) {
            const double x = 1.0 * i / side, y = 1.0 * j / side;
            arrays.vertices.push_back({x, y, 0.05 * std::sin(9 * x + 4 * y)});
            if (i == side || j == side) continue;
            const std::uint32_t corner = j * (side + 1) + i;
            arrays.triangles.push_back({corner, corner + 1, corner + side + 2});
            arrays.triangles.push_back({corner, corner + side + 2, corner + side + 1});
        }
    return arrays;
}

/// Triangles that share no vertex.
inline Arrays soup_of(const Arrays& arrays) {
    Arrays soup;
    for (const Triangle& triangle : arrays.triangles) {
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        for (const std::uint32_t vertex : triangle) soup.vertices.push_back(arrays.vertices[vertex]);
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    return soup;
}

struct NamedMesh {
    const char* name = "";
    Arrays arrays;
};

/// A GPU makes the topology of those that have at least 1,024 triangles.
inline std::vector<NamedMesh> fixed_meshes() {
    const Arrays torus = bumpy_torus(48, 24);
    std::vector<NamedMesh> meshes{{"torus", torus}, {"box", tilted_box()}, {"sheet", open_sheet()}};
    const auto add = [&](const char* name) -> Arrays& {
        meshes.push_back({name, torus});
        return meshes.back().arrays;
    };

    add("open").triangles.resize(torus.triangles.size() - 20);  // the winding number decides the sign
    add("soup") = soup_of(torus);
    Arrays& doubled = add("doubled");
    doubled.triangles.insert(doubled.triangles.end(), torus.triangles.begin(), torus.triangles.begin() + 200);
    Arrays& turned = add("turned");
    for (std::size_t t = 0; t < turned.triangles.size(); t += 37)
        std::swap(turned.triangles[t][0], turned.triangles[t][1]);

    // A fin of two sides on a ring of edges, each of which has four faces then.
    Arrays& non_manifold = add("non-manifold");
    for (std::uint32_t k = 0; k < 24; ++k) {
        const std::uint32_t a = k, b = (k + 1) % 24, tip = static_cast<std::uint32_t>(non_manifold.vertices.size());
        const Vec3 &p = torus.vertices[a], &q = torus.vertices[b];
        non_manifold.vertices.push_back({0.5 * (p[0] + q[0]), p[1] + 0.2, 0.6 * (p[2] + q[2])});
        non_manifold.triangles.push_back({a, b, tip});
        non_manifold.triangles.push_back({b, a, tip});
    }

    // Faces that are a segment or a point, or repeat a vertex; vertices in no face.
    Arrays& degenerate = add("degenerate");
    for (std::uint32_t k = 0; k < 40; ++k) {
        const auto next = static_cast<std::uint32_t>(degenerate.vertices.size());
        const Vec3 &p = torus.vertices[20 * k], &q = torus.vertices[20 * k + 1];
        degenerate.vertices.push_back({0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])});
        degenerate.vertices.push_back({3, 3, 3});
        degenerate.triangles.push_back({20 * k, 20 * k + 1, next});
        degenerate.triangles.push_back({20 * k, 20 * k, next});
    }

    Arrays& far = add("far");
    for (Vec3& p : far.vertices) p = {p[0] + 6e6, p[1] - 3e6, p[2] + 1e6};

    // One within the other: a nested part, and one that looks inwards.
    Arrays& nested = add("nested");
    Arrays inner = bumpy_torus(30, 12, 0.9);
    nested.append(inner);
    for (Vec3& p : inner.vertices) p = {p[0], p[1], p[2] + 2};
    for (Triangle& triangle : inner.triangles) std::swap(triangle[0], triangle[1]);
    nested.append(inner);
    return meshes;
}

/// The position of a vertex after a step of a body that bends about `middle`. Equal positions stay equal.
inline Vec3 bent(const Vec3& p, const Vec3& middle, int step) {
    const double x = p[0] - middle[0], y = p[1] - middle[1];
    return {p[0] + 0.03 * step * x, p[1] + 0.05 * step * std::sin(2 * x), p[2] - 0.04 * step * x * y};
}

}  // namespace clsdf::test
