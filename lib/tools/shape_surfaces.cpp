#include "tools/shape_builders.hpp"

#include "core/vectors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

namespace clsdf::shapes {

namespace {

constexpr double full_turn = 2 * std::numbers::pi;

Vec3 scaled(const Vec3& a, double factor) {
    return {factor * a[0], factor * a[1], factor * a[2]};
}

Vec3 sum(const Vec3& a, const Vec3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

Vec3 unit(const Vec3& a) {
    return scaled(a, 1 / length(a));
}

/// Splits every triangle into four and moves the new vertices onto the unit sphere.
void subdivide(MeshArrays& mesh) {
    std::unordered_map<std::uint64_t, std::uint32_t> middles;
    middles.reserve(mesh.triangles.size() * 3 / 2);
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const std::uint64_t edge = std::uint64_t{std::min(a, b)} << 32U | std::max(a, b);
        const auto [entry, is_new] = middles.try_emplace(edge, static_cast<std::uint32_t>(mesh.vertices.size()));
        if (is_new) mesh.vertices.push_back(unit(sum(mesh.vertices[a], mesh.vertices[b])));
        return entry->second;
    };
    std::vector<Triangle> triangles;
    triangles.reserve(4 * mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::uint32_t ab = middle(a, b);
        const std::uint32_t bc = middle(b, c);
        const std::uint32_t ca = middle(c, a);
        triangles.insert(triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(triangles);
}

MeshArrays icosahedron() {
    const double g = std::numbers::phi;
    MeshArrays mesh{{{-1, g, 0},
                     {1, g, 0},
                     {-1, -g, 0},
                     {1, -g, 0},
                     {0, -1, g},
                     {0, 1, g},
                     {0, -1, -g},
                     {0, 1, -g},
                     {g, 0, -1},
                     {g, 0, 1},
                     {-g, 0, -1},
                     {-g, 0, 1}},
                    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
    for (Vec3& vertex : mesh.vertices) vertex = unit(vertex);
    return mesh;
}

enum class Diagonal { rising, falling };

/// The quadrilaterals between neighbouring rings of a tube, split in two; vertex(i, j) is the index of vertex j of ring
/// i, the outside on the left of the rings' direction. Rising: the diagonal runs from (i, j) to (i + 1, j + 1).
template <typename VertexIndex>
void add_tube(MeshArrays& mesh, std::uint32_t strips, std::uint32_t around, Diagonal diagonal, VertexIndex vertex) {
    for (std::uint32_t i = 0; i < strips; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const std::uint32_t a = vertex(i, j);
            const std::uint32_t b = vertex(i + 1, j);
            const std::uint32_t c = vertex(i + 1, j + 1);
            const std::uint32_t d = vertex(i, j + 1);
            if (diagonal == Diagonal::rising)
                mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
            else
                mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {b, c, d}});
        }
}

/// Numbers in [-1, 1), the same on every platform (Vigna's splitmix64).
class Noise {
public:
    double next() {
        state_ += 0x9E3779B97F4A7C15U;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
        z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
        z ^= z >> 31U;
        return static_cast<double>(z >> 11U) * 0x1p-52 - 1;
    }

private:
    std::uint64_t state_ = 0;
};

}  // namespace

MeshArrays subdivided_octahedron(int level) {
    MeshArrays mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                    {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
    for (int i = 0; i < level; ++i) subdivide(mesh);
    return mesh;
}

MeshArrays torus() {
    constexpr std::uint32_t rings = 100;
    constexpr std::uint32_t around = 30;
    // Six cells of turning over the whole torus keep every quadrilateral from being planar, so that no rounding error
    // decides which edges are convex, and make the 1788 saddle vertices of Peikert & Sigg's table 1. A quarter of a
    // cell keeps the vertices off the planes of symmetry.
    constexpr std::uint32_t turned_cells = 6;
    constexpr double first_cell = 0.25;
    constexpr double radius = 1.0 / 3;
    MeshArrays mesh;
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const double u = full_turn * i / rings;
            const double v = full_turn * (j + first_cell + static_cast<double>(turned_cells) * i / rings) / around;
            const double r = 1 + radius * std::cos(v);
            mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), radius * std::sin(v)});
        }
    add_tube(mesh, rings, around, Diagonal::falling, [](std::uint32_t i, std::uint32_t j) {
        if (i == rings) return (j + turned_cells) % around;
        return i * around + j % around;
    });
    return mesh;
}

MeshArrays knot() {
    constexpr std::uint32_t rings = 240;
    constexpr std::uint32_t around = 6;
    constexpr double radius = 0.3;
    MeshArrays mesh;
    for (std::uint32_t i = 0; i < rings; ++i) {
        // The curve and its two derivatives.
        const double t = full_turn * i / rings;
        const double c2 = std::cos(2 * t);
        const double s2 = std::sin(2 * t);
        const double c3 = std::cos(3 * t);
        const double s3 = std::sin(3 * t);
        const double r = 2 + c3;
        const Vec3 centre{r * c2, r * s2, s3};
        const Vec3 velocity{-3 * s3 * c2 - 2 * r * s2, -3 * s3 * s2 + 2 * r * c2, 3 * c3};
        const Vec3 acceleration{-9 * c3 * c2 + 12 * s3 * s2 - 4 * r * c2, -9 * c3 * s2 - 12 * s3 * c2 - 4 * r * s2,
                                -9 * s3};
        const Vec3 binormal = unit(cross(velocity, acceleration));
        const Vec3 normal = unit(cross(binormal, velocity));
        for (std::uint32_t j = 0; j < around; ++j) {
            const double v = full_turn * j / around;
            mesh.vertices.push_back(
                sum(centre, sum(scaled(normal, radius * std::cos(v)), scaled(binormal, -radius * std::sin(v)))));
        }
    }
    add_tube(mesh, rings, around, Diagonal::rising,
             [](std::uint32_t i, std::uint32_t j) { return i % rings * around + j % around; });
    return mesh;
}

MeshArrays seashell() {
    constexpr std::uint32_t rings = 83;
    constexpr std::uint32_t around = 11;
    constexpr double whorls = 3.2;
    constexpr double growth = 1.9;
    constexpr double turned_cells = 4;
    MeshArrays mesh;
    for (std::uint32_t i = 0; i < rings; ++i) {
        const double t = static_cast<double>(i) / (rings - 1);
        const double u = full_turn * whorls * t;
        const double size = std::exp(growth * (t - 1));
        for (std::uint32_t j = 0; j < around; ++j) {
            const double v = full_turn * (j + turned_cells * t) / around;
            const double r = size * (1.1 + 0.5 * std::cos(v));
            mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), size * (2.4 + 0.5 * std::sin(v))});
        }
    }
    const auto vertex = [](std::uint32_t i, std::uint32_t j) { return i * around + j % around; };
    add_tube(mesh, rings - 1, around, Diagonal::rising, vertex);
    for (const std::uint32_t ring : {std::uint32_t{0}, rings - 1}) {
        Vec3 middle{};
        for (std::uint32_t j = 0; j < around; ++j)
            middle = sum(middle, scaled(mesh.vertices[vertex(ring, j)], 1.0 / around));
        const auto cap = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(middle);
        for (std::uint32_t j = 0; j < around; ++j) {
            const std::uint32_t a = vertex(ring, j);
            const std::uint32_t b = vertex(ring, j + 1);
            mesh.triangles.push_back(ring == 0 ? Triangle{cap, a, b} : Triangle{cap, b, a});
        }
    }
    return mesh;
}

MeshArrays noisy_sphere() {
    constexpr int level = 5;
    MeshArrays mesh = icosahedron();
    for (int i = 0; i < level; ++i) subdivide(mesh);
    constexpr double edge = 1.107 / (1 << level);
    Noise noise;
    for (Vec3& vertex : mesh.vertices) vertex = scaled(vertex, 1 + 0.6 * edge * noise.next());
    return mesh;
}

MeshArrays nested_spheres() {
    const MeshArrays sphere = subdivided_octahedron(4);
    MeshArrays mesh;
    for (const double radius : {1.0, 0.7, 0.4}) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        for (const Vec3& vertex : sphere.vertices) mesh.vertices.push_back(scaled(vertex, radius));
        const bool inwards = radius == 0.7;
        for (const auto& [a, b, c] : sphere.triangles)
            mesh.triangles.push_back({first + a, first + (inwards ? c : b), first + (inwards ? b : c)});
    }
    return mesh;
}

}  // namespace clsdf::shapes
