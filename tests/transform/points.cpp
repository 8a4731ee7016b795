#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/point_contract.hpp"
#include "support/random_meshes.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};
constexpr KernelBody by_vector = KernelBody::by_vector, by_group = KernelBody::by_group;
constexpr double no_limit = std::numeric_limits<double>::infinity();

double voxel_of(const Mesh& mesh) {
    return mesh.box().longest_side() / 256;
}

/// All outputs at a grid's samples as points, held against the reference with the measure of points.
void check_points(const DistanceTransform& transform, const Mesh& mesh, const Grid& grid,
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
Differences differences(const Field& one, std::size_t in_one, const Field& other, std::size_t in_other,
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

Vec3 corner(const Mesh& mesh, std::size_t triangle, std::size_t number) {
    return mesh.vertices()[mesh.triangles()[triangle][number]];
}

/// A point of the surface: w0, w1 and the rest are the weights of a triangle's vertices.
Vec3 on_triangle(const Mesh& mesh, std::size_t triangle, double w0, double w1) {
    Vec3 p{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] = w0 * corner(mesh, triangle, 0)[axis] + w1 * corner(mesh, triangle, 1)[axis] +
                  (1 - w0 - w1) * corner(mesh, triangle, 2)[axis];
    return p;
}

/// Vertices, points on edges and faces, and points beside them and far away.
std::vector<Vec3> points_around(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
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

std::vector<Mesh> meshes() {
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

}  // namespace

BOOST_AUTO_TEST_CASE(every_output_of_every_point_keeps_its_contract) {
    for (const Mesh& mesh : meshes()) {
        const double voxel = voxel_of(mesh);
        std::mt19937_64 generator(11);
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            const Grid around = grid_around(mesh, 14, 3);
            check_points(transform, mesh, around);
            check_points(transform, mesh, around, 2.5 * around.voxel());
            // Beside vertices and faces, at distances of voxels, and on them.
            for (int place = 0; place < 6; ++place) {
                const std::size_t triangle = generator() % mesh.triangles().size();
                const Vec3 centre = place % 2 == 0 ? corner(mesh, triangle, 0) : on_triangle(mesh, triangle, 0.3, 0.4);
                check_points(transform, mesh, grid_at(centre, (place < 3 ? 1 : 0.01) * voxel, 2), 3 * voxel);
            }
        }
    }
}

// So far away that a float cannot tell one triangle from another.
BOOST_AUTO_TEST_CASE(far_away_every_output_keeps_its_contract) {
    for (const Mesh& mesh : {tilted(make_shape("noisy")), shifted(make_shape("torus"), {3, -5, 7}), overlapping_cubes(),
                             without_triangle(make_shape("knot"), 7), reversed(tilted(cube(1)))}) {
        const double voxel = voxel_of(mesh);
        Random random(17);
        std::vector<Vec3> points;
        for (const double far : {1e3, 1e4, 1e6, 1e9, 1e11, 1e13})
            for (const Vec3& direction :
                 {Vec3{1, 0, 0}, Vec3{0, 0, -1}, Vec3{-0.6, 0.8, 0.01}, random.direction(), random.direction()})
                points.push_back(along(corner(mesh, random.index(mesh.triangles().size()), 0), far * voxel, direction));
        const std::size_t far_points = points.size();
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            const PointContract contract(mesh, transform.sign(), no_limit);
            const Field field = query(transform, points);
            for (std::size_t i = 0; i < far_points; ++i) {
                const std::string fault = contract.fault(points[i], field, i);
                BOOST_TEST(fault.empty(), mesh.name() << ", point " << i << ": " << fault);
                check_points(transform, mesh, grid_at(points[i], voxel, 0));
            }
            // Among so many that they are scanned in groups.
            std::vector<Vec3> many = points;
            for (const Vec3& p : points_around(mesh, 20000, 19)) many.push_back(p);
            const Field of_many = query(transform, many);
            for (const OutputInfo& info : output_table())
                BOOST_TEST(differences(field, 0, of_many, 0, far_points, info).count == 0U,
                           mesh.name() << ", " << info.name << " differs");
        }
    }
}

BOOST_AUTO_TEST_CASE(on_the_surface_the_distance_is_zero_and_positive) {
    for (const Mesh& mesh : {cube(1), reversed(cube(1)), without_triangle(cube(1), 3)})
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            const std::vector<Vec3> points{{1, 0.3, -0.2}, {-1, -1, 0.1}, {1, 1, 1}, {0.1, -1, 0.7}, {0.125, 0.5, 1}};
            const Field field = query(transform, points, 0);
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (field.triangle()[i] == no_triangle) continue;  // the hole
                BOOST_TEST(field.distance()[i] == 0);
                BOOST_TEST(!std::signbit(field.distance()[i]));
                const Vec3 gradient{field.gradient()[3 * i], field.gradient()[3 * i + 1], field.gradient()[3 * i + 2]};
                BOOST_TEST(std::hypot(gradient[0], gradient[1], gradient[2]) == 1.0,
                           boost::test_tools::tolerance(1e-6));
            }
            BOOST_TEST(std::ranges::count(field.triangle(), no_triangle) <= 1);
        }
}

// Every triangle of a sphere is as near to its centre, and all corners of a cube to the middle.
BOOST_AUTO_TEST_CASE(on_the_medial_axis_one_of_the_nearest_triangles_is_named) {
    for (const Mesh& mesh : {make_shape("sphere4"), cube(1), make_shape("torus")})
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            check_points(transform, mesh, grid_at({0, 0, 0}, voxel_of(mesh) / 16, 1));
        }
}

BOOST_AUTO_TEST_CASE(a_result_does_not_depend_on_the_batch) {
    for (const Mesh& mesh : {tilted(make_shape("noisy")), overlapping_cubes(), without_triangle(make_shape("knot"), 7)})
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            for (const double half_width : {no_limit, 0.1 * mesh.box().longest_side()}) {
                const std::vector<Vec3> points = points_around(mesh, 3000, 21);
                const Field all = query(transform, points, half_width);
                const auto check_same = [&](const Field& part, const auto& number_of) {
                    for (const OutputInfo& info : output_table()) {
                        std::size_t different = 0;
                        for (std::size_t i = 0; i < part.distance().size(); ++i)
                            different += differences(all, number_of(i), part, i, 1, info).count;
                        BOOST_TEST(different == 0U, info.name << ": " << different << " points differ");
                    }
                };
                std::vector<std::size_t> shuffled(points.size());
                std::iota(shuffled.begin(), shuffled.end(), std::size_t{0});
                std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937_64(3));
                std::vector<Vec3> other(points.size());
                for (std::size_t i = 0; i < points.size(); ++i) other[i] = points[shuffled[i]];
                check_same(query(transform, other, half_width), [&](std::size_t i) { return shuffled[i]; });
                const std::span<const Vec3> span(points);
                check_same(query(transform, span.subspan(1700, 700), half_width),
                           [](std::size_t i) { return 1700 + i; });
                for (std::size_t i = 0; i < 60; ++i)
                    check_same(query(transform, span.subspan(i, 1), half_width), [i](std::size_t) { return i; });
                // At the same time from several threads.
                std::vector<Field> fields(2);
                std::vector<std::jthread> threads;
                for (Field& field : fields) threads.emplace_back([&] { field = query(transform, points, half_width); });
                threads.clear();
                for (const Field& field : fields) check_same(field, [](std::size_t i) { return i; });
            }
        }
}

/// Surfaces whose sides are hard to tell: that touch, nearly touch, lie upon each other, or fold to almost nothing.
std::vector<Mesh> meshes_with_near_sides() {
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
Mesh box_with_fillers() {
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

// Memory that is short makes queries slower, and no call that can be made fails.
BOOST_AUTO_TEST_CASE(points_of_a_device_with_little_memory_have_the_same_bytes) {
    const Mesh mesh = make_shape("sphere4");
    const std::vector<Vec3> points = points_around(mesh, 40000, 81);
    const Field expected = query(DistanceTransform(test_device(), mesh), points);
    std::size_t kept = 0;
    for (const std::size_t memory : {4'500'000U, 3'000'000U, 2'000'000U, 1'400'000U}) {
        const DistanceTransform transform(test_device().limited({.memory = memory}), mesh);
        for (int call = 0; call < 2; ++call) BOOST_TEST(same_bytes(query(transform, points), expected));
        // More and more points in all: the sides of faces would be found.
        const Field few = query(transform, std::span(points).first(5000));
        BOOST_TEST(std::equal(few.distance().begin(), few.distance().end(), expected.distance().begin()));
        kept = transform.memory().device_bytes;
    }
    const DistanceTransform unlimited(test_device(), mesh);
    query(unlimited, points);
    BOOST_TEST(kept < unlimited.memory().device_bytes, "memory was not short");
}

// At a great distance both sides of a thin wall are equally near.
BOOST_AUTO_TEST_CASE(points_far_from_a_thin_wall_are_outside) {
    const Mesh sphere = make_shape("sphere3");
    std::vector<Vec3> vertices = sphere.vertices();
    std::vector<Triangle> triangles = sphere.triangles();
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (std::uint32_t i = 0; i < first; ++i) {
        Vec3 v = vertices[i];
        for (double& x : v) x *= 1 - 4e-8;
        vertices.push_back(v);
    }
    for (const Triangle& t : sphere.triangles()) triangles.push_back({first + t[0], first + t[2], first + t[1]});
    const DistanceTransform transform(test_device(), Mesh(vertices, triangles, "thin wall"));
    std::mt19937_64 generator(83);
    std::normal_distribution<double> normal;
    std::vector<Vec3> points;
    for (const double distance : {1e2, 1e4, 1e6, 1e9, 1e11})
        for (int i = 0; i < 4000; ++i) {
            const Vec3 v{normal(generator), normal(generator), normal(generator)};
            const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            points.push_back({v[0] / length * distance, v[1] / length * distance, v[2] / length * distance});
        }
    for (int call = 0; call < 2; ++call) {  // the sides of faces are known in the second one
        std::vector<float> distances(points.size());
        transform.query(points, no_limit, {{Output::distance, distances}});
        BOOST_TEST(std::ranges::count_if(distances, [](float d) { return !(d > 0); }) == 0);
    }
}

// All faces at a vertex are nearly equally far from a point far away. If each of them asked for all others again, this
// would take minutes.
BOOST_AUTO_TEST_CASE(many_points_far_from_a_vertex_of_thousands_of_faces_are_as_fast_as_others) {
    constexpr std::uint32_t sectors = 8000;
    std::vector<Vec3> vertices{{0, 0, 64}, {0, 0, 0}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < sectors; ++i) {
        const double angle = 2 * std::numbers::pi * i / sectors;
        vertices.push_back({128 * std::cos(angle), 128 * std::sin(angle), 0});
        const std::uint32_t a = 2 + i, b = 2 + (i + 1) % sectors;
        triangles.push_back({0, a, b});
        triangles.push_back({1, b, a});
    }
    const Mesh mesh(vertices, triangles, "cone");
    std::mt19937_64 generator(85);
    std::uniform_real_distribution<double> aside(-1e5, 1e5), above(5e5, 1e6);
    std::vector<Vec3> points;
    for (int i = 0; i < 17'000; ++i) points.push_back({aside(generator), aside(generator), above(generator)});
    const DistanceTransform transform(test_device(), mesh);
    const Field many = query(transform, points), few = query(transform, std::span(points).first(90));
    for (const OutputInfo& info : output_table()) {
        const std::span<const std::byte> bytes = few.bytes(info.output);
        BOOST_TEST(std::ranges::equal(bytes, many.bytes(info.output).first(bytes.size())), info.name << " differs");
    }
}

// A query that is short of memory releases what fields have kept, while others use it.
BOOST_AUTO_TEST_CASE(queries_and_fields_on_two_threads_share_too_little_memory) {
    const Mesh mesh = make_shape("sphere4");
    const std::vector<Vec3> points = points_around(mesh, 20000, 79);
    const Grid grid = grid_around(mesh, 40, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const DistanceTransform plenty(test_device(), mesh);
    const Field expected = plenty.compute(grid, band), expected_answers = query(plenty, points);
    const DistanceTransform transform(test_device().limited({.memory = 3'000'000}), mesh);
    std::atomic<bool> is_answered = false;
    std::atomic<int> differences = 0;
    std::thread other([&] {
        while (!is_answered) differences += same_bytes(transform.compute(grid, band), expected) ? 0 : 1;
    });
    for (int call = 0; call < 4; ++call) BOOST_TEST(same_bytes(query(transform, points), expected_answers));
    is_answered = true;
    other.join();
    BOOST_TEST(differences == 0);
}

// Many points are scanned in groups, few are looked up one by one; many have signs by the sides of faces, few by
// crossings. On a grid around a symmetric mesh many triangles are equally near.
BOOST_AUTO_TEST_CASE(many_points_give_the_bytes_of_few) {
    std::vector<Mesh> all = meshes();
    for (const char* shape : {"sphere4", "torus"}) all.push_back(make_shape(shape));
    for (Mesh& mesh : meshes_with_near_sides()) all.push_back(std::move(mesh));
    all.push_back(box_with_fillers());
    for (const Mesh& mesh : all)
        for (const double half_width : {no_limit, 0.05 * mesh.box().longest_side()}) {
            std::vector<Vec3> points = samples_of(grid_around(mesh, 24, 2));
            for (const Vec3& p : points_around(mesh, 20011, 71)) points.push_back(p);
            points.push_back({1e9, -1e7, 3});
            std::mt19937_64 generator(73);
            for (const double distance : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15})
                for (int i = 0; i < 200; ++i) {
                    Vec3 p = points[generator() % points.size()];
                    for (double& x : p) x += distance * (std::uniform_real_distribution<double>(-1, 1)(generator));
                    points.push_back(p);
                }
            const Field many = query(DistanceTransform(test_device(), mesh), points, half_width);
            std::optional<DistanceTransform> transform;
            constexpr std::size_t few = 1511;
            for (std::size_t begin = 0; begin < points.size(); begin += few) {
                // A transform that has had few points counts crossings for their signs.
                if (begin / few % 8 == 0) transform.emplace(test_device(), mesh);
                const std::size_t count = std::min(few, points.size() - begin);
                const Field some = query(*transform, std::span(points).subspan(begin, count), half_width);
                for (const OutputInfo& info : output_table()) {
                    const Differences found = differences(many, begin, some, 0, count, info);
                    BOOST_TEST(found.count == 0U, mesh.name() << ", " << info.name << ": " << found.count
                                                              << " points differ, first " << begin + found.first);
                }
            }
        }
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
std::vector<Vec3> points_on_and_around(const Mesh& mesh, std::uint64_t seed) {
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

// The host answers queries of few points, the device those of many.
BOOST_AUTO_TEST_CASE(few_points_have_the_bytes_of_many) {
    std::vector<Mesh> all = meshes();
    for (Mesh& mesh : meshes_with_near_sides()) all.push_back(std::move(mesh));
    all.push_back(box_with_fillers());
    all.push_back(make_shape("sphere4"));
    all.push_back(reversed(shifted(make_shape("torus"), {1e3, -7, 1e-3})));
    all.push_back(Mesh(std::vector<Vec3>{{1, 2, 3}, {4, 2, 3}}, std::vector<Triangle>{{0, 0, 0}, {0, 1, 1}},
                       "a point and a segment"));
    for (const Mesh& mesh : all) {
        const std::vector<Vec3> points = points_on_and_around(mesh, 91);
        const std::span<const Vec3> span(points);
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            for (const double half_width : {no_limit, 0.05 * mesh.box().longest_side(), 0.0}) {
                const Field many = query(transform, points, half_width);
                const DoubleOutputs many_doubles(transform, points, half_width);
                std::size_t different = 0, first = points.size();
                const auto compare = [&](std::size_t begin, std::size_t count) {
                    const Field few = query(transform, span.subspan(begin, count), half_width);
                    bool is_same = many_doubles.has_from(begin, {transform, span.subspan(begin, count), half_width});
                    for (const OutputInfo& info : output_table())
                        is_same = is_same && differences(many, begin, few, 0, count, info).count == 0;
                    if (is_same) return;
                    ++different;
                    first = std::min(first, begin);
                };
                for (std::size_t i = 0; i < points.size(); ++i) compare(i, 1);
                for (std::size_t begin = 0; begin < points.size(); begin += 37)
                    compare(begin, std::min<std::size_t>(37, points.size() - begin));
                BOOST_TEST(different == 0U, mesh.name() << " within " << half_width << ": " << different
                                                        << " calls differ, first at point " << first);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(any_number_of_threads_ask_for_few_points_at_once) {
    const Mesh mesh = tilted(make_shape("knot"));
    const std::vector<Vec3> points = points_around(mesh, 800, 97);
    const Field expected = query(DistanceTransform(test_device(), mesh), points);
    for (int round = 0; round < 3; ++round) {
        DistanceTransform transform(test_device(), mesh);  // the first points of all threads prepare it
        std::atomic<std::size_t> different = 0;
        {
            std::vector<std::jthread> threads;
            for (std::size_t thread = 0; thread < 8; ++thread)
                threads.emplace_back([&, thread] {
                    for (std::size_t i = thread % 4; i < points.size(); i += 4) {
                        const Field few = query(transform, std::span(points).subspan(i, 1));
                        for (const OutputInfo& info : output_table())
                            different += differences(expected, i, few, 0, 1, info).count;
                    }
                });
            const Grid grid = grid_around(mesh, 60, 4);
            BOOST_TEST(transform.compute(grid, Band::symmetric(3 * grid.voxel())).distance().size() > 0U);
        }
        BOOST_TEST(different == 0U);
        // Then they move.
        const Mesh last = moved(mesh, [](const Vec3& p) { return Vec3{1.5 * p[0], p[1], p[2] - p[0]}; });
        transform.set_positions(last.vertices());
        const std::span<const Vec3> few = std::span(points).first(20);
        BOOST_TEST(same_bytes(query(transform, few), query(DistanceTransform(test_device(), last), few)));
    }
}

BOOST_AUTO_TEST_CASE(few_points_have_the_errors_of_many) {
    const DistanceTransform transform(test_device(), cube(1));
    const DistanceTransform part = transform.restrict_to({{{0, 0, 0}, {1, 1, 1}}, 0.5, 0});
    const auto message = [](const DistanceTransform& asked, std::size_t count, const Vec3& last, double half_width) {
        std::vector<Vec3> points(count, {0.5, 0.5, 0.5});
        points[2] = last;
        std::vector<float> distance(count);
        try {
            asked.query(points, half_width, distance, {.refuse_unusable_points = true});
        } catch (const Error& error) {
            return fmt::format("{}: {}", static_cast<int>(error.code()), error.what());
        }
        return std::string("none");
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Vec3& wrong : {Vec3{0, nan, 0}, Vec3{no_limit, 0, 0}, Vec3{0, 0, -1e300}}) {
        BOOST_TEST(message(transform, 3, wrong, 1) != "none");
        BOOST_TEST(message(transform, 3, wrong, 1) == message(transform, 3000, wrong, 1));
    }
    BOOST_TEST(message(transform, 3, {0, 0, 0}, nan) == message(transform, 3000, {0, 0, 0}, nan));
    BOOST_TEST(message(part, 3, {5, 0, 0}, 0.5) != "none");
    BOOST_TEST(message(part, 3, {5, 0, 0}, 0.5) == message(part, 3000, {5, 0, 0}, 0.5));
    BOOST_TEST(message(part, 3, {0.1, 0, 0}, 0.7) == message(part, 3000, {0.1, 0, 0}, 0.7));
}

// No kernel is compiled for them.
BOOST_AUTO_TEST_CASE(the_first_of_few_points_compile_nothing) {
    const Device device = Device::strongest();
    std::size_t compiled = 0;
    device::context_of(device).set_text_edit([&](std::string_view, std::string&) { ++compiled; });
    const DistanceTransform transform(device, cube(1));
    const std::vector<Vec3> points(100, {0.5, 0, 0});
    std::vector<float> distance(points.size());
    transform.query(std::span(points).first(1), 1, std::span(distance).first(1));
    BOOST_TEST(distance[0] == -0.5F);
    BOOST_TEST(compiled == 0U);
    transform.query(points, 1, distance);
    BOOST_TEST(compiled > 0U);
}

BOOST_AUTO_TEST_CASE(few_points_do_not_depend_on_how_many_were_asked_for_before) {
    for (const KernelBody body : both_bodies)
        for (const Mesh& mesh : {make_shape("knot"), overlapping_cubes()}) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            const std::vector<Vec3> points = points_around(mesh, 1009, 83);
            const Field first = query(transform, points);
            // From some number on, the sides of faces tell the signs.
            const std::vector<Vec3> others = points_around(mesh, 4001, 89);
            for (std::size_t asked = 0; asked < std::max<std::size_t>(mesh.triangles().size(), 20000);
                 asked += others.size())
                query(transform, others);
            const Field last = query(transform, points);
            for (const OutputInfo& info : output_table())
                BOOST_TEST(same_bytes(first.slab(), last.slab(), info.output), mesh.name()
                                                                                   << ", " << info.name << " differs");
        }
}

BOOST_AUTO_TEST_CASE(the_sign_follows_the_rule_at_the_very_point) {
    const Mesh mesh = overlapping_cubes();
    const reference::Oracle oracle(mesh);
    const std::vector<Vec3> points = points_around(mesh, 4000, 31);
    for (const SignRule rule : {SignRule::nonzero, SignRule::parity, SignRule::none}) {
        const DistanceTransform transform(test_device(), mesh, {.sign = rule});
        const Field field = query(transform, points, 0.2);
        std::size_t wrong = 0, inside = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::optional<int> winding = oracle.winding_number(points[i]);
            const bool is_inside = winding && (rule == SignRule::nonzero  ? *winding != 0
                                               : rule == SignRule::parity ? *oracle.crossings(points[i]) % 2 != 0
                                                                          : false);
            // Exactly on the surface it is +0.
            wrong += std::signbit(field.distance()[i]) != is_inside || (!winding && field.distance()[i] != 0) ? 1U : 0U;
            inside += is_inside ? 1U : 0U;
        }
        BOOST_TEST(wrong == 0U);
        BOOST_TEST((inside > 300U || rule == SignRule::none));
    }
}

// The lower corner of the mesh's box is the origin of its points. The sign of a zero there must not depend on the order
// of vertices.
BOOST_AUTO_TEST_CASE(a_move_to_the_same_positions_changes_nothing) {
    std::vector<Vec3> points;
    for (int i = -4; i < 12; ++i)
        for (int j = -4; j < 12; ++j)
            for (const double z : {0.0, -0.0}) points.push_back({0.13 * i, 0.11 * j, z});
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Random random(seed);
        const Mesh flat = reordered(moved(random_soup(random, 6, 8),
                                          [&](const Vec3& p) {
                                              return Vec3{p[0], p[1], random.uniform(0, 1) < 0.5 ? -0.0 : 0.0};
                                          }),
                                    random);
        DistanceTransform transform(test_device(), flat, {.sign = SignRule::none});
        const Field first = query(transform, points);
        transform.set_positions(flat.vertices());
        BOOST_TEST(same_bytes(first, query(transform, points)), "seed " << seed);
    }
}

BOOST_AUTO_TEST_CASE(moved_vertices_give_what_a_new_mesh_gives) {
    const Mesh first = make_shape("knot");
    const Mesh last = moved(first, [](const Vec3& p) {
        return Vec3{p[0] + 0.2 * p[1] * p[1], 1.3 * p[1], p[2] - p[0]};
    });
    const std::vector<Vec3> points = points_around(last, 2000, 41);
    DistanceTransform transform(test_device(), first);
    query(transform, points);
    transform.set_positions(last.vertices());
    BOOST_TEST(same_bytes(query(transform, points), query(DistanceTransform(test_device(), last), points)));
}

BOOST_AUTO_TEST_CASE(targets_have_strides_and_some_or_all_outputs) {
    const Mesh mesh = make_shape("torus");
    const DistanceTransform transform(test_device(), mesh);
    const std::vector<Vec3> points = points_around(mesh, 700, 61);
    const Field all = query(transform, points);
    struct Particle {
        double position[3];
        float distance;
        float offset[3];
        std::uint32_t triangle;
    };
    std::vector<Particle> particles(points.size(), {{}, 7, {7, 7, 7}, 7});
    const auto target = [&](auto& member, ElementType element) {
        OutputArray result;
        result.host = &particles[0];
        result.bytes = particles.size() * sizeof(Particle);
        result.offset =
            static_cast<std::size_t>(reinterpret_cast<char*>(&member) - reinterpret_cast<char*>(&particles[0]));
        result.type = element;
        result.strides[0] = sizeof(Particle);
        return result;
    };
    OutputTargets targets;
    targets[Output::distance] = target(particles[0].distance, ElementType::float32);
    targets[Output::offset] = target(particles[0].offset, ElementType::float32);
    transform.query(points, no_limit, targets);
    for (std::size_t i = 0; i < points.size(); ++i) {
        BOOST_REQUIRE(particles[i].distance == all.distance()[i]);
        for (std::size_t axis = 0; axis < 3; ++axis)
            BOOST_REQUIRE_SMALL(
                static_cast<double>(particles[i].offset[axis]) - (all.closest()[3 * i + axis] - points[i][axis]), 1e-6);
        BOOST_REQUIRE(particles[i].triangle == 7U);
    }
    std::vector<float> distance(points.size());
    double latest = 0;
    const TransformStatistics statistics = transform.query(
        points, no_limit, distance, {.progress = when_computing([&](double fraction) { latest = fraction; })});
    BOOST_TEST(std::ranges::equal(distance, all.distance()));
    BOOST_TEST(latest == 1.0);
    BOOST_TEST(statistics.work->triangles == mesh.triangles().size());
    BOOST_TEST(transform.memory().device_bytes > 0U);
    transform.query({}, 1, std::span(distance).first(0));
    std::vector<float> nothing;
    const std::vector<Vec3> no_points;
    transform.query(no_points, 1, {{Output::distance, nothing}, {Output::gradient, nothing}});
}

BOOST_AUTO_TEST_CASE(a_mesh_without_extent_has_points_around_it) {
    const Mesh mesh(std::vector<Vec3>{{1, 2, 3}}, std::vector<Triangle>{{0, 0, 0}}, "a point");
    const std::vector<Vec3> points{{1, 2, 3}, {1, 2, 5}, {-3, 5, 3}};
    const Field field = query(DistanceTransform(test_device(), mesh), points);
    BOOST_TEST(field.distance()[0] == 0);
    BOOST_TEST(field.distance()[1] == 2);
    BOOST_TEST(field.distance()[2] == 5);
    BOOST_TEST(field.closest()[6] == 1, boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(small_meshes_have_distances_below_the_normal_floats) {
    for (const double side : {4e-36, 1e-32}) {
        const Mesh mesh = box({0, 0, 0}, {side, side, side});
        std::vector<Vec3> points;
        for (const double voxels : {1e-4, 0.01, 0.3}) points.push_back({side / 2, side / 2, -voxels * side / 256});
        const Field field = query(DistanceTransform(test_device(), mesh), points);
        for (std::size_t i = 0; i < points.size(); ++i)
            BOOST_TEST(std::abs(static_cast<double>(field.distance()[i]) + points[i][2]) <= 1e-5 * side / 256);
    }
}

BOOST_AUTO_TEST_CASE(points_may_be_1e14_voxels_from_the_box) {
    for (const double side : {1.0, 1.5, 1.99}) {
        const DistanceTransform transform(test_device(), box({0, 0, 0}, {side, side, side}));
        const double far = 0.99e14 * side / 256;
        std::vector<Vec3> points{{side + far, 0.5, 0.5}, {0.5, -far, 0.5}};
        const Field field = query(transform, points);
        for (const float distance : field.distance())
            BOOST_TEST(std::abs(static_cast<double>(distance) / far - 1) < 1e-6);
        points[1][1] = -1.02 * far;
        std::vector<float> distance(2);
        check_throws(ErrorCode::invalid_argument, {"point 1", "1e14 voxels"},
                     [&] { transform.query(points, no_limit, distance, {.refuse_unusable_points = true}); });
    }
}

BOOST_AUTO_TEST_CASE(points_whose_distance_may_be_beyond_the_floats_are_refused) {
    const DistanceTransform transform(test_device(), cube(1e30));
    std::vector<Vec3> points{{5e37, 0, 0}};
    BOOST_TEST(std::isfinite(query(transform, points).distance()[0]));
    points[0][0] = 1e40;
    std::vector<float> distance(1);
    check_throws(ErrorCode::invalid_argument, {"point 0", "1e+40", "beyond the floats", "leave it out"},
                 [&] { transform.query(points, no_limit, distance, {.refuse_unusable_points = true}); });
    BOOST_TEST(std::isnan(query(transform, points).distance()[0]));
}

BOOST_AUTO_TEST_CASE(points_that_are_not_finite_or_too_far_have_no_distance_and_change_no_other_point) {
    const Mesh mesh = make_shape("knot");
    const DistanceTransform transform(test_device(), mesh);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const std::size_t count : {std::size_t{1}, std::size_t{5}, std::size_t{96}, std::size_t{5000}})
        for (const double half_width : {0.0, 0.05, no_limit})
            for (const std::size_t every : {std::size_t{1}, std::size_t{3}}) {
                BOOST_TEST_CONTEXT(count << " points, half width " << half_width << ", every " << every) {
                    std::vector<Vec3> points = points_around(mesh, count, 5), marked = points;
                    points.resize(count);
                    marked.resize(count);
                    const std::array marks{Vec3{nan, nan, nan}, Vec3{0, no_limit, 0}, Vec3{1e30, 0, 0}};
                    std::size_t not_finite = 0, far = 0;
                    for (std::size_t i = 0; i < count; i += every) {
                        marked[i] = marks[i % 4 % 3];
                        ++(std::isfinite(marked[i][0] + marked[i][1]) ? far : not_finite);
                    }
                    const Field expected = query(transform, points, half_width);
                    std::vector<std::string> warnings;
                    Field found = expected;
                    const TransformStatistics statistics =
                        transform.query(marked, half_width, found.targets(),
                                        {.log = [&](const std::string& warning) { warnings.push_back(warning); }});
                    BOOST_TEST(statistics.unusable_points == not_finite + far);
                    BOOST_TEST_REQUIRE(warnings.size() == 1U);
                    BOOST_TEST(warnings[0].starts_with(std::to_string(not_finite) + " of " + std::to_string(count)));
                    for (std::size_t i = 0; i < count; ++i) {
                        const bool is_marked = i % every == 0, is_far = is_marked && marked[i][0] == 1e30;
                        if (is_far && half_width < no_limit)
                            BOOST_REQUIRE(found.distance()[i] == static_cast<float>(half_width));
                        else if (is_marked)
                            BOOST_REQUIRE(std::isnan(found.distance()[i]));
                        for (const OutputInfo& info : output_table()) {
                            if (!is_marked) {
                                BOOST_REQUIRE(differences(found, i, expected, i, 1, info).count == 0U);
                            } else if (info.output != Output::distance) {
                                const auto bytes =
                                    found.bytes(info.output).subspan(i * info.sample_bytes(), info.sample_bytes());
                                BOOST_REQUIRE(std::ranges::count(bytes, std::byte{0xFF}) ==
                                              static_cast<std::ptrdiff_t>(bytes.size()));
                            }
                        }
                    }
                }
            }
}

BOOST_AUTO_TEST_CASE(points_that_are_not_finite_or_too_far_need_no_region_of_a_part) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const DistanceTransform whole(test_device(), cube(1));
    const DistanceTransform part = whole.restrict_to(Region{{{0, -1, -1}, {2, 1, 1}}, 0.5, 0});
    for (const std::vector<Vec3>& points : {std::vector<Vec3>{{nan, 0, 0}, {0.75, 0, 0}, {1e30, 0, 0}, {0.5, 0.9, 0}},
                                            {{nan, 0, 0}, {1e30, 0, 0}},
                                            {{1e30, 0, 0}}})
        for (const std::size_t copies : {1U, 100U}) {
            std::vector<Vec3> all;
            for (std::size_t i = 0; i < copies; ++i) all.insert(all.end(), points.begin(), points.end());
            const Field expected = query(whole, all, 0.5), found = query(part, all, 0.5);
            for (const OutputInfo& info : output_table())
                BOOST_TEST(differences(found, 0, expected, 0, all.size(), info).count == 0U);
        }
    const std::vector<Vec3> outside{{nan, 0, 0}, {-1, 0, 0}};
    check_throws(ErrorCode::invalid_argument, {"point 1"}, [&] { query(part, outside, 0.5); });
}

BOOST_AUTO_TEST_CASE(errors_name_the_point_and_the_argument) {
    const Mesh mesh = cube(1);
    const DistanceTransform transform(test_device(), mesh);
    std::vector<Vec3> points(5, {0.5, 0, 0});
    std::vector<float> distance(5);
    points[3][1] = std::numeric_limits<double>::quiet_NaN();
    check_throws(ErrorCode::invalid_argument, {"point 3", "nan", "not finite"},
                 [&] { transform.query(points, 1, distance, {.refuse_unusable_points = true}); });
    points[3][1] = 1e300;
    check_throws(ErrorCode::invalid_argument, {"point 3", "1e+300", "1e14 voxels"},
                 [&] { transform.query(points, 1, distance, {.refuse_unusable_points = true}); });
    points[3][1] = 0;
    for (const double half_width : {-1.0, std::numeric_limits<double>::quiet_NaN()})
        check_throws(ErrorCode::invalid_argument, {"half width"},
                     [&] { transform.query(points, half_width, distance); });
    check_throws(ErrorCode::invalid_argument, {"5 points", "distance", "4 values"},
                 [&] { transform.query(points, 1, std::span(distance).first(4)); });
    check_throws(ErrorCode::invalid_argument, {"distance has no target"},
                 [&] { transform.query(points, 1, OutputTargets()); });
    OutputArray in_layers = distance;
    in_layers.strides = {4, 0, 20};
    check_throws(ErrorCode::invalid_argument, {"distance", "(4, 0, 20)", "set strides[0] alone"},
                 [&] { transform.query(points, 1, in_layers); });
    check_throws(ErrorCode::cancelled, {},
                 [&] { transform.query(points, 1, distance, {.should_stop = [] { return true; }}); });
    transform.query(points, 1, distance);
    BOOST_TEST(distance[0] == -0.5F);
}

// Each changed line stands for wrong code that a compiler makes of a right one.
BOOST_AUTO_TEST_CASE(a_device_that_finds_wrong_triangles_is_refused) {
    struct Change {
        const char* file;
        const char* from;
        const char* to;
        std::vector<KernelBody> bodies{both_bodies.begin(), both_bodies.end()};
    };
    const std::vector<Change> changes{
        {"points.cl", "(y - altitude) - o.across * o.away", "(y - altitude) + o.across * o.away", {by_vector}},
        {"points.cl", "return most * most", "return 0.9f * most * most", {by_vector}},
        {"points.cl", "((1u << children) - 1u)", "((1u << children) - 2u)", {by_vector}},
        {"nearest_by_group.cl", "(y - altitude) - o.across * o.away", "(y - altitude) + o.across * o.away", {by_group}},
        {"nearest_by_group.cl", "farther <= bound_of(query)", "farther <= 0.9f * bound_of(query)", {by_group}},
        {"nearest_by_group.cl", "if (upper < found->low)", "if (upper < found->low + 1.0f)", {by_group}},
        {"point_signs.cl", "entry >> CLSDF_PLACE_SHIFT != 0", "entry >> CLSDF_PLACE_SHIFT > 1u", {by_group}},
        {"binary_tree.cl", "(end - 1u - i) <<", "(end - 1u - i) / 2u <<", {by_group}},
        {"binary_tree.cl", "GREATER(other->upper[axis], box->upper[axis])", "box->upper[axis]", {by_group}},
        {"points.cl", "inside ? -rounded : rounded", "rounded"},
        {"point_scan.cl", "chosen[length] = list ? list[k] : k", "chosen[length] = list ? list[i] : i", {by_vector}},
        {"point_scan.cl", "outward * outward + z * z", "outward * outward", {by_vector}},
        {"point_scan.cl",
         "lowest_face(all_faces, brick->face[i])",
         "lowest_face(all_faces, brick->face[0])",
         {by_vector}},
        {"point_scan.cl", "o.across * o.beyond - o.along * y", "o.across * o.beyond + o.along * y", {by_vector}}};
    for (const auto& [file, from, to, bodies] : changes)
        for (const KernelBody body : bodies) {
            const TemporaryFolder folder;
            const Device device = Device::strongest();
            device.keep_records(folder.file("cache"));
            bool is_found = false;
            device::context_of(device).set_text_edit([&](std::string_view name, std::string& text) {
                const std::size_t at = text.find(from);
                if (name != file || at == std::string::npos) return;
                is_found = true;
                text.replace(at, std::strlen(from), to);
            });
            const DistanceTransform transform(device, cube(1), {.body = body});
            const bool are_many = std::string(file) == "point_scan.cl";
            const std::vector<Vec3> points(are_many ? 20000 : 500, {0.5, 0, 0});
            std::vector<float> distance(points.size());
            BOOST_TEST_CONTEXT(file << ": " << to)
            check_throws(ErrorCode::wrong_results, {"computes wrong fields", "points"},
                         [&] { transform.query(points, 1, distance); });
            BOOST_TEST(is_found, from);
        }
}
