#include "support/float_width.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/tuning.hpp>

#include <tbb/task_group.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <span>
#include <thread>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// So much work that one compute unit takes several launches for it.
const Mesh& dense() {
    static const Mesh mesh = make_shape("sphere7");
    return mesh;
}
/// Takes several launches on one core of a processor, and one on a GPU.
Grid around_dense() {
    return grid_around(dense(), 72, 3);
}

const Mesh& mesh() {
    static const Mesh shape = tilted(make_shape("knot"));
    return shape;
}
Grid around_mesh() {
    return grid_around(mesh(), 40, 5);
}

/// Samples of the band are those that have a triangle.
std::size_t samples_with_triangle(const Field& field) {
    return field.triangle().size() -
           static_cast<std::size_t>(std::count(field.triangle().begin(), field.triangle().end(), no_triangle));
}

/// The memory of this process, by the system's account; 0 if there is none.
std::size_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t all = 0, resident = 0;
    file >> all >> resident;
    return resident * 4096;
}

}  // namespace

BOOST_AUTO_TEST_CASE(transforms_on_threads_of_their_own_are_independent) {
    std::vector<Mesh> meshes;
    meshes.reserve(4);
    for (const char* name : {"knot", "torus", "seashell", "noisy"}) meshes.push_back(make_shape(name));
    const auto field_of = [&](std::size_t i) {
        const Grid grid = grid_around(meshes[i], 36, 4);
        return compute(meshes[i], grid, i % 2 == 0 ? Band::symmetric(3 * grid.voxel()) : Band::full());
    };
    std::vector<Field> together(meshes.size());
    std::vector<int> differences(meshes.size());
    std::vector<std::thread> threads;
    threads.reserve(meshes.size());
    for (std::size_t i = 0; i < meshes.size(); ++i)
        threads.emplace_back([&, i] {
            together[i] = field_of(i);
            for (int run = 0; run < 3; ++run) differences[i] += same_bytes(together[i], field_of(i)) ? 0 : 1;
        });
    for (std::thread& thread : threads) thread.join();
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        BOOST_TEST(differences[i] == 0);
        BOOST_TEST(same_bytes(together[i], field_of(i)));
    }
}

BOOST_AUTO_TEST_CASE(a_call_in_tasks_that_are_cancelled_is_complete) {
    const Field expected = compute(dense(), around_dense(), Band::full());
    const auto distances_by = [](const DistanceTransform& transform) {
        std::vector<float> values(dense().vertices().size());
        transform.query(dense().vertices(), 1, {{Output::distance, values}});
        return values;
    };
    const std::vector<float> expected_distances = distances_by(DistanceTransform(test_device(), dense()));
    // Thousands of links that meet four faces.
    const Mesh ball = make_shape("sphere3");
    const Mesh onion = together({ball, scaled(ball, 0.99), scaled(ball, 0.98), scaled(ball, 0.97)}, "onion");
    const auto links_of_onion = [&] {
        return DistanceTransform(test_device(), onion)
            .links(grid_around(onion, 30, 2), stencil("D3Q19"), {.hits = Hits::faces});
    };
    const Links expected_links = links_of_onion();
    BOOST_TEST(std::ranges::count(expected_links.counts, 4U) > 1000);
    tbb::task_group tasks;
    tasks.run_and_wait([&] {
        tasks.cancel();
        const DistanceTransform transform(test_device(), dense());
        BOOST_TEST(same_bytes(transform.compute(around_dense(), Band::full(), all_outputs()), expected));
        BOOST_TEST((distances_by(transform) == expected_distances));
        const Links links = links_of_onion();
        BOOST_TEST((links.q == expected_links.q && links.triangles == expected_links.triangles &&
                    links.counts == expected_links.counts));
    });
}

BOOST_AUTO_TEST_CASE(progress_runs_from_0_to_1) {
    std::vector<double> seen;
    const std::thread::id caller = std::this_thread::get_id();
    DistanceTransform transform(one_compute_unit(), dense());
    transform.compute(around_dense(), Band::full(), Output::distance,
                      {.progress = when_computing([&](double fraction) {
                           BOOST_TEST((std::this_thread::get_id() == caller));
                           seen.push_back(fraction);
                       })});
    BOOST_TEST(seen.size() >= (is_processor() ? 4U : 2U));
    BOOST_TEST(seen.front() == 0);
    BOOST_TEST(seen.back() == 1);
    BOOST_TEST(std::is_sorted(seen.begin(), seen.end()));
}

BOOST_AUTO_TEST_CASE(a_computation_stops_when_asked_and_begins_anew_when_asked) {
    const Field expected = compute(dense(), around_dense(), Band::full());
    bool stop = false;
    std::vector<double> seen;
    DistanceTransform transform(one_compute_unit(), dense());
    const CallOptions call{.progress = when_computing([&](double fraction) {
                               seen.push_back(fraction);
                               if (fraction > 0) stop = true;
                           }),
                           .should_stop = [&] { return stop; }};
    if (is_processor()) {
        check_throws(ErrorCode::cancelled, {"cancelled"},
                     [&] { transform.compute(around_dense(), Band::full(), Output::distance, call); });
        BOOST_TEST(seen.back() < 1);
    } else {
        transform.compute(around_dense(), Band::full(), Output::distance, call);
    }
    BOOST_TEST(seen.size() == 2U);
    // A call that is to stop at once computes nothing.
    check_throws(ErrorCode::cancelled, {"cancelled"},
                 [&] { transform.compute(around_dense(), Band::full(), Output::distance, call); });
    BOOST_TEST(seen.size() == 2U);
    BOOST_TEST(same_bytes(expected, transform.compute(around_dense(), Band::full(), all_outputs())));
}

// One row's end and the next one's begin lie beside each other in memory, both in empty bricks, with different signs.
BOOST_AUTO_TEST_CASE(rows_may_begin_outside_and_end_inside) {
    const Mesh solid = cube(1);
    const Grid grid = grid_at({0.01, 0.02, 0.03}, 0.05, 40).part({0, 10, 10}, {41, 61, 20});
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const Field field = compute(solid, grid, Band::symmetric(0.1), body);
        BOOST_TEST(!std::signbit(field.distance().front()));
        BOOST_TEST(check_exact(solid, field).band_samples > 0U);
    }
}

BOOST_AUTO_TEST_CASE(arrays_of_another_size_are_refused) {
    const Grid grid = around_mesh();
    DistanceTransform transform(test_device(), mesh());
    std::vector<float> distance(grid.sample_count() + 1);
    std::vector<std::uint32_t> triangle(grid.sample_count() + 1);
    const std::span<float> all(distance);
    const auto refuse = [&](const OutputTargets& targets, const std::string& name, std::size_t size) {
        check_throws(ErrorCode::invalid_argument,
                     {std::to_string(grid.sample_count()) + " samples", name, std::to_string(size) + " values"},
                     [&] { transform.compute(grid, Band::full(), targets); });
    };
    const std::size_t count = grid.sample_count();
    refuse(all, "distance", count + 1);
    refuse(all.first(count - 1), "distance", count - 1);
    refuse({{Output::distance, all.first(count)}, {Output::triangle, triangle}}, "triangle", count + 1);
    refuse({{Output::distance, all.first(count)}, {Output::triangle, std::span(triangle).first(1)}}, "triangle", 1);
    check_throws(ErrorCode::invalid_argument, {"distance has no target"},
                 [&] { transform.compute(grid, Band::full(), OutputTargets()); });
}

BOOST_AUTO_TEST_CASE(samples_of_the_band_are_counted_where_the_grid_cuts_bricks) {
    for (const auto& [shape, whole] : {std::pair(&mesh(), around_mesh()), std::pair(&dense(), around_dense())})
        for (const auto& [device, body] :
             {std::pair(test_device(), KernelBody::by_vector), std::pair(with_float_width(8), KernelBody::by_vector),
              std::pair(test_device(), KernelBody::by_group)}) {
            const Grid grid = whole.part({3, 5, 6}, {24, 26, 21});
            TransformStatistics statistics;
            const Field field = DistanceTransform(device, *shape, {.body = body})
                                    .compute(grid, Band::symmetric(3 * grid.voxel()), Output::triangle,
                                             {.count_work = true}, &statistics);
            BOOST_TEST(samples_with_triangle(field) > 1000U);
            BOOST_TEST(statistics.work->band_samples == samples_with_triangle(field));
        }
}

BOOST_AUTO_TEST_CASE(statistics_say_what_was_computed) {
    const Grid grid = around_mesh();
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        TransformStatistics statistics;
        const Field field =
            DistanceTransform(test_device(), mesh(), {.body = body})
                .compute(grid, Band::symmetric(3 * grid.voxel()), Output::triangle, {.count_work = true}, &statistics);
        const std::size_t in_band = samples_with_triangle(field);
        BOOST_TEST(statistics.work->triangles == mesh().triangles().size());
        BOOST_TEST(statistics.work->band_samples == in_band);
        BOOST_TEST(statistics.work->samples_covered >= in_band);
        BOOST_TEST(statistics.work->lanes_evaluated >= statistics.work->samples_covered);
        BOOST_TEST(statistics.work->brick_pairs >= statistics.work->coarse_pairs);
        BOOST_TEST(statistics.work->coarse_pairs >= statistics.work->triangles);
        BOOST_TEST(statistics.work->coarse_bricks > 0U);
        BOOST_TEST(statistics.work->saddle_vertices > 1000U);
        BOOST_TEST(statistics.device_bytes >= statistics.work->triangles * 256);
        BOOST_TEST(statistics.work->box_polyhedra == 0U);
        BOOST_TEST(statistics.polyhedra_seconds > 0);
        BOOST_TEST(statistics.work->lists_seconds > 0);
        BOOST_TEST(statistics.field_seconds > 0);
    }
}

BOOST_AUTO_TEST_CASE(compile_leaves_nothing_to_compile) {
    const Device device = Device::automatic();
    const DistanceTransform transform(device, mesh());
    const Grid grid = around_mesh();
    const Band band = Band::symmetric(3 * grid.voxel());
    const TransformStatistics compiled = transform.compile(grid, band);
    BOOST_TEST(compiled.first_use);
    BOOST_TEST(compiled.compile_seconds > 0);
    TransformStatistics statistics;
    transform.compute(grid, band, {}, CallOptions(), &statistics);
    BOOST_TEST(!statistics.first_use);
    BOOST_TEST(statistics.compile_seconds < 0.1 * compiled.compile_seconds);
}

BOOST_AUTO_TEST_CASE(a_transform_names_its_device_and_the_box_of_its_positions) {
    std::vector<Vec3> vertices = mesh().vertices();
    vertices.push_back({1e6, 0, 0});  // which no triangle uses
    const Mesh with_unused(vertices, mesh().triangles());
    DistanceTransform transform(test_device(), with_unused);
    BOOST_TEST((transform.device().id() == test_device().id()));
    BOOST_TEST((transform.device().context() == test_device().context()));
    const auto check_box = [](const DistanceTransform& found, const Box& expected) {
        BOOST_TEST((found.box().lower == expected.lower));
        BOOST_TEST((found.box().upper == expected.upper));
    };
    check_box(transform, mesh().box());
    for (Vec3& x : vertices) x = {2 * x[0] + 1, x[1], -x[2]};
    transform.set_positions(vertices);
    const Mesh moved_mesh(vertices, mesh().triangles());
    check_box(transform, moved_mesh.box());
    // Of a part, it is that of the whole.
    check_box(transform.restrict_to({{moved_mesh.box().lower, moved_mesh.vertices()[0]}, 0.1, 0.1}), moved_mesh.box());
    // A motion is one of the first positions.
    transform.set_motion({Vec3{0, -1, 0}, Vec3{1, 0, 0}, Vec3{0, 0, 1}}, {0.5, 0, 0});
    std::vector<Vec3> turned = mesh().vertices();
    for (Vec3& x : turned) x = {0.5 - x[1], x[0], x[2]};
    check_box(transform, Mesh(turned, mesh().triangles()).box());
}

BOOST_AUTO_TEST_CASE(nothing_is_counted_on_the_device_unless_asked_for) {
    const Grid grid = around_mesh();
    TransformStatistics statistics;
    DistanceTransform(test_device(), mesh())
        .compute(grid, Band::symmetric(3 * grid.voxel()), Output::distance, {}, &statistics);
    BOOST_TEST(statistics.work->triangles == mesh().triangles().size());
    BOOST_TEST(statistics.work->lanes_evaluated == 0U);
    BOOST_TEST(statistics.work->band_samples == 0U);
}

BOOST_AUTO_TEST_CASE(what_is_kept_on_the_host_does_not_grow_with_use) {
    const Mesh large = make_shape("sphere8");
    const Grid grid = grid_around(large, 72, 3);
    const auto triangles = large.triangles().size();
    DistanceTransform transform(test_device(), large);
    const auto bytes_after_use = [&](double half_width) {
        transform.compute(grid, Band::symmetric(half_width * grid.voxel()));
        return transform.memory().host_bytes;
    };
    const std::size_t bytes = bytes_after_use(1);
    BOOST_TEST(bytes > 20 * triangles);
    BOOST_TEST(bytes < 100 * triangles);
    for (const double half_width : {1.0, 2.0, 1.0}) BOOST_TEST(bytes_after_use(half_width) == bytes);
}

BOOST_AUTO_TEST_CASE(memory_does_not_grow_from_move_to_move) {
    const Mesh first = make_shape("sphere6");
    const Grid grid = grid_around(first, 40, 3);
    DistanceTransform transform(test_device(), first);
    std::vector<Vec3> positions = first.vertices();
    const auto memory_after_move = [&](int step) {
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i][0] = first.vertices()[i][0] * (1 + 1e-3 * step * first.vertices()[i][1]);
        transform.set_positions(positions);
        transform.compute(grid, Band::symmetric(grid.voxel()));
        return transform.memory();
    };
    const KeptMemory memory = memory_after_move(1);
    BOOST_TEST(memory.host_bytes < 250 * first.triangles().size());
    for (int step = 2; step <= 50; ++step) {
        const KeptMemory later = memory_after_move(step);
        BOOST_TEST_REQUIRE(later.host_bytes <= memory.host_bytes + 4096);
        BOOST_TEST_REQUIRE(later.device_bytes <= memory.device_bytes * 11 / 10);
    }
}

// As many steps as CLSDF_STEPS says, or 500.
BOOST_AUTO_TEST_CASE(steps_of_a_moving_body_leave_memory_as_it_was) {
    const char* const asked = std::getenv("CLSDF_STEPS");
    const int steps = asked != nullptr ? std::atoi(asked) : 500;
    const Mesh body = make_shape("sphere3");
    DistanceTransform transform(test_device(), body);
    const Grid grid = grid_around(body, 24, 4);
    const Band band = Band::symmetric(3 * grid.voxel());
    const std::vector<Vec3> points(100, {1.1, 0.2, 0.3});
    std::vector<float> distance(grid.sample_count()), of_points(points.size());
    const auto step = [&](int number) {
        const double angle = 0.01 * number, c = std::cos(angle), s = std::sin(angle);
        transform.set_motion({{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}, {0.01 * s, 0, 0});
        transform.compute(grid, band, distance);
        transform.query(points, 1, of_points);
    };
    // Threads' stacks and the allocator's caches grow in the first steps.
    const int warm = steps / 5;
    for (int number = 0; number < warm; ++number) step(number);
    const KeptMemory kept = transform.memory();
    [[maybe_unused]] const std::size_t resident = resident_bytes();
    for (int number = warm; number < steps; ++number) step(number);
    BOOST_TEST(transform.memory().host_bytes == kept.host_bytes);
    BOOST_TEST(transform.memory().device_bytes == kept.device_bytes);
    [[maybe_unused]] const std::size_t now = resident_bytes();
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which keep memory that was freed
    BOOST_TEST(now < resident + (std::size_t{4} << 20), "from " << resident << " to " << now << " bytes");
#endif
}

BOOST_AUTO_TEST_CASE(faces_without_area_are_counted_as_boxes) {
    std::vector<Triangle> triangles = cube(1).triangles();
    triangles.push_back({0, 1, 1});
    const Mesh with_segment(cube(1).vertices(), triangles, "cube with a segment");
    TransformStatistics statistics;
    DistanceTransform(test_device(), with_segment)
        .compute(grid_at({0, 0, 0}, 0.5, 4), Band::symmetric(1), Output::distance, {}, &statistics);
    BOOST_TEST(statistics.work->box_polyhedra == 1U);
}
