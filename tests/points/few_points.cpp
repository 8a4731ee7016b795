#include "support/queries.hpp"

#include "device/context.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

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
