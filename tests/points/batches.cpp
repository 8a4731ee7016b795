#include "support/queries.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

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
