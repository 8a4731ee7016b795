#pragma once

#include <clsdf/mesh.hpp>

#include <cmath>
#include <random>

/// Random points and meshes for tests; the seed is the caller's, who prints it.
namespace clsdf::test {

class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}

    double uniform(double lower, double upper) {
        return lower + (upper - lower) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
    }
    std::uint32_t index(std::size_t count) { return static_cast<std::uint32_t>(engine_() % count); }
    Vec3 point(double lower, double upper) {
        return {uniform(lower, upper), uniform(lower, upper), uniform(lower, upper)};
    }
    Vec3 direction() {
        for (;;) {
            const Vec3 v = point(-1, 1);
            const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            if (length > 0.1 && length <= 1) {
                return {v[0] / length, v[1] / length, v[2] / length};
            }
        }
    }

private:
    std::mt19937_64 engine_;
};

inline Vec3 along(const Vec3& from, double distance, const Vec3& direction) {
    return {from[0] + distance * direction[0], from[1] + distance * direction[1], from[2] + distance * direction[2]};
}

/// Triangles between random vertices: not manifold, self-intersecting, open.
inline Mesh random_soup(Random& random, std::size_t vertex_count, std::size_t triangle_count) {
    std::vector<Vec3> vertices(vertex_count);
    for (Vec3& vertex : vertices) {
        vertex = random.point(-1, 1);
    }
    std::vector<Triangle> triangles(triangle_count);
    for (Triangle& triangle : triangles) {
        triangle = {random.index(vertex_count), random.index(vertex_count), random.index(vertex_count)};
    }
    return {std::move(vertices), std::move(triangles), "soup"};
}

/// A soup whose triangles are slivers, segments and points as often as not; its vertices are shared by many.
inline Mesh random_slivers(Random& random, std::size_t triangle_count) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < triangle_count; ++i) {
        const Vec3 a = random.point(-1, 1);
        const Vec3 b = along(a, std::pow(10, random.uniform(-6, 0)), random.direction());
        const double t = random.uniform(-0.5, 1.5);
        const Vec3 on_line{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
        vertices.insert(vertices.end(),
                        {a, b, along(on_line, std::pow(10, random.uniform(-14, 0)), random.direction())});
        const std::uint32_t first = 3 * i;
        const std::uint32_t other = random.index(vertices.size());
        switch (i % 5) {
            case 0:
                triangles.push_back({first, first + 1, first + 1});
                break;
            case 1:
                triangles.push_back({first, first, first});
                break;
            case 2:
                triangles.push_back({first, first + 1, other});
                break;
            default:
                triangles.push_back({first, first + 1, first + 2});
        }
    }
    return {std::move(vertices), std::move(triangles), "slivers"};
}

/// A tetrahedron with vertices on a lattice: samples of the same lattice tie with its planes, edges and vertices.
inline Mesh random_lattice_tetrahedron(Random& random, double step) {
    std::vector<Vec3> vertices(4);
    for (Vec3& vertex : vertices) {
        for (double& coordinate : vertex) {
            coordinate = step * std::round(random.uniform(-4, 4));
        }
    }
    return {std::move(vertices), {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, "tetrahedron"};
}

/// Closed and balanced, of several random closed fans of outward or inward triangles that may intersect one another.
inline Mesh random_closed(Random& random, std::size_t components) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < components; ++i) {
        const auto apex = static_cast<std::uint32_t>(vertices.size());
        const std::uint32_t ring = 3 + random.index(6);
        const Vec3 centre = random.point(-1, 1);
        for (std::uint32_t k = 0; k < ring + 2; ++k) {
            vertices.push_back(along(centre, random.uniform(0.2, 1), random.direction()));
        }
        const bool reversed = random.index(4) == 0;
        for (std::uint32_t k = 0; k < ring; ++k) {
            const std::uint32_t a = apex + 2 + k;
            const std::uint32_t b = apex + 2 + (k + 1) % ring;
            triangles.push_back(reversed ? Triangle{apex, b, a} : Triangle{apex, a, b});
            triangles.push_back(reversed ? Triangle{apex + 1, a, b} : Triangle{apex + 1, b, a});
        }
    }
    return {std::move(vertices), std::move(triangles), "closed"};
}

}  // namespace clsdf::test
