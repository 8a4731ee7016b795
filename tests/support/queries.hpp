#pragma once

#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/point_contract.hpp"
#include "support/random_meshes.hpp"

#include <clsdf/clsdf.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace clsdf::test {

inline constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};
inline constexpr KernelBody by_vector = KernelBody::by_vector, by_group = KernelBody::by_group;
inline constexpr double no_limit = std::numeric_limits<double>::infinity();

inline double voxel_of(const Mesh& mesh) {
    return mesh.box().longest_side() / 256;
}

/// All outputs at a grid's samples as points, held against the reference with the measure of points.
inline void check_points(const DistanceTransform& transform, const Mesh& mesh, const Grid& grid,
                         double half_width = no_limit) {
    Field field = query(transform, samples_of(grid), half_width);
    field.grid = grid;
    field.band = {half_width, half_width};
    field.sign = transform.sign();
    check_exact(mesh, field, {1e-5 * voxel_of(mesh) / grid.voxel(), 2});
}

struct Differences {
    std::size_t count = 0, first = 0;
};

/// The bytes of `count` points' output in one field and in another one, from these points on.
inline Differences differences(const Field& one, std::size_t in_one, const Field& other, std::size_t in_other,
                               std::size_t count, const OutputInfo& info) {
    const std::size_t bytes = info.sample_bytes();
    Differences found;
    for (std::size_t i = 0; i < count; ++i)
        if (std::memcmp(&one.bytes(info.output)[bytes * (in_one + i)],
                        &other.bytes(info.output)[bytes * (in_other + i)], bytes) != 0 &&
            found.count++ == 0)
            found.first = i;
    return found;
}

inline Vec3 corner(const Mesh& mesh, std::size_t triangle, std::size_t number) {
    return mesh.vertices()[mesh.triangles()[triangle][number]];
}

/// A point of the surface: w0, w1 and the rest are the weights of a triangle's vertices.
inline Vec3 on_triangle(const Mesh& mesh, std::size_t triangle, double w0, double w1) {
    Vec3 p{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] = w0 * corner(mesh, triangle, 0)[axis] + w1 * corner(mesh, triangle, 1)[axis] +
                  (1 - w0 - w1) * corner(mesh, triangle, 2)[axis];
    return p;
}

/// Vertices, points on edges and faces, and points beside them and far away.
inline std::vector<Vec3> points_around(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
    std::mt19937_64 generator(seed);
    std::uniform_real_distribution<double> part(0, 1);
    const double side = mesh.box().longest_side();
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t triangle = generator() % mesh.triangles().size();
        const double w0 = part(generator), w1 = i % 3 == 0 ? 1 - w0 : (1 - w0) * part(generator);
        Vec3 p = i % 7 == 0 ? corner(mesh, triangle, i % 3) : on_triangle(mesh, triangle, w0, w1);
        const double reach = std::array{0.0, 0.01, 0.3, 1.0, 0.05}[i % 5] * side;
        for (double& x : p) x += reach * (2 * part(generator) - 1);
        points.push_back(p);
    }
    return points;
}

inline std::vector<Mesh> meshes() {
    Random random(5);
    return {cube(1),
            reversed(cube(1)),
            unwelded(cube(1)),
            without_triangle(cube(1), 3),
            overlapping_cubes(),
            sliver(),
            fins(),
            random_slivers(random, 40),
            random_soup(random, 30, 60),
            make_shape("knot"),
            tilted(make_shape("noisy"))};
}

/// Surfaces whose sides are hard to tell: that touch, nearly touch, lie upon each other, or fold to almost nothing.
inline std::vector<Mesh> meshes_with_near_sides() {
    std::vector<Mesh> meshes{together({cube(1), shifted(cube(1), {2, 0, 0})}, "with a common face"),
                             together({cube(1), shifted(cube(1), {2, 2, 0})}, "with a common edge"),
                             together({cube(1), shifted(cube(1), {2, 2, 2})}, "with a common vertex"),
                             together({cube(1), cube(1)}, "twice"),
                             together({cube(1), reversed(shifted(cube(1), {1e-3, 2e-3, 3e-3}))}, "a shell")};
    for (const double gap : {1e-3, 1e-6, 1e-9, 1e-13})
        meshes.push_back(together({cube(1), shifted(cube(1), {2 + gap, 0.1, 0})}, fmt::format("a gap of {}", gap)));
    for (const double thickness : {1e-2, 1e-5, 1e-8})
        meshes.push_back(Mesh(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0.4, 0.3, thickness}},
                              std::vector<Triangle>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}},
                              fmt::format("thin by {}", thickness)));
    meshes.push_back(Mesh(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0.3, 20}},
                          std::vector<Triangle>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, "a needle"));
    return meshes;
}

/// A box whose top has vertices along one edge, where the wall below has none. Faces without area close the gaps.
inline Mesh box_with_fillers() {
    const Mesh box = cube(1);
    std::vector<Vec3> vertices = box.vertices();
    std::vector<Triangle> triangles;
    const Triangle& cut = box.triangles().front();
    for (std::size_t n = 1; n < box.triangles().size(); ++n) triangles.push_back(box.triangles()[n]);
    constexpr std::uint32_t parts = 8;
    const Vec3 from = vertices[cut[0]], to = vertices[cut[1]];
    std::vector<std::uint32_t> rim{cut[0]};
    for (std::uint32_t i = 1; i < parts; ++i) {
        Vec3 p;
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = from[axis] + (to[axis] - from[axis]) * i / parts;
        rim.push_back(static_cast<std::uint32_t>(vertices.size()));
        vertices.push_back(p);
    }
    rim.push_back(cut[1]);
    for (std::uint32_t i = 0; i < parts; ++i) triangles.push_back({rim[i], rim[i + 1], cut[2]});
    for (std::uint32_t i = 1; i < parts; ++i) triangles.push_back({rim[0], rim[i + 1], rim[i]});
    return Mesh(vertices, triangles, "box with fillers");
}

/// The outputs of points, those that have real numbers in double.
struct DoubleOutputs {
    std::vector<double> distance, closest, gradient, barycentric, offset;

    DoubleOutputs(const DistanceTransform& transform, std::span<const Vec3> points, double half_width)
        : distance(points.size()),
          closest(3 * points.size()),
          gradient(3 * points.size()),
          barycentric(2 * points.size()),
          offset(3 * points.size()) {
        transform.query(points, half_width,
                        {{Output::distance, distance},
                         {Output::closest, closest},
                         {Output::gradient, gradient},
                         {Output::barycentric, barycentric},
                         {Output::offset, offset}});
    }

    /// Whether points of this from number `first` on have the bytes of the other.
    bool has_from(std::size_t first, const DoubleOutputs& part) const {
        const auto is_same = [first, count = part.distance.size()](const auto& all, const auto& some) {
            const std::size_t components = some.size() / count;
            return std::memcmp(all.data() + first * components, some.data(), some.size() * sizeof(double)) == 0;
        };
        return is_same(distance, part.distance) && is_same(closest, part.closest) && is_same(gradient, part.gradient) &&
               is_same(barycentric, part.barycentric) && is_same(offset, part.offset);
    }
};

/// Points around a mesh; all of its vertices and points of its edges, or some; points next to these; points far away;
/// zeros with a sign.
inline std::vector<Vec3> points_on_and_around(const Mesh& mesh, std::uint64_t seed) {
    std::vector<Vec3> points = points_around(mesh, 300, seed);
    std::mt19937_64 generator(seed);
    for (std::size_t i = 0; i < 100; ++i) {
        const std::size_t triangle = generator() % mesh.triangles().size();
        points.push_back(corner(mesh, triangle, i % 3));
        points.push_back(on_triangle(mesh, triangle, 0.5, i % 2 == 0 ? 0.5 : 0.25));
        for (const double distance : {1e-3, 1e-9, 1e-15}) {
            Vec3 p = points[points.size() - 1 - i % 2];
            p[i % 3] += distance * mesh.box().longest_side();
            points.push_back(p);
        }
    }
    for (const double far : {1e3, 1e6, 1e10, 1e13})
        for (const Vec3& direction : {Vec3{1, 0, 0}, Vec3{0.6, -0.8, 0}, Vec3{0.5, 0.5, -0.7}})
            points.push_back(along(corner(mesh, 0, 0), far * voxel_of(mesh), direction));
    points.push_back({-0.0, 0.0, -0.0});
    return points;
}

}  // namespace clsdf::test
