#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include "core/parallel.hpp"
#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

/// Callers' objects and numbers that are legal, or nearly so, and have broken this library or others.
namespace clsdf::test {
namespace {

Grid unit_grid(double spacing = 0.1) {
    return {{-1.2 * spacing, -1.2 * spacing, -1.2 * spacing}, {spacing, spacing, spacing}, {12, 12, 12}, {}};
}

Mesh enlarged(const Mesh& mesh, double factor) {
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& v : vertices) v = {v[0] * factor, v[1] * factor, v[2] * factor};
    return {std::move(vertices), mesh.triangles(), mesh.name()};
}

/// Every triangle with corners of its own.
Mesh as_soup(const Mesh& mesh) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (const Triangle& triangle : mesh.triangles()) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        for (const std::uint32_t corner : triangle) vertices.push_back(mesh.vertices()[corner]);
        triangles.push_back({first, first + 1, first + 2});
    }
    return {std::move(vertices), std::move(triangles), mesh.name() + " as a soup"};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_callback_may_ask_the_device_while_it_compiles) {
    const Device device = Device::strongest();
    std::size_t calls = 0;
    CallOptions call;
    call.progress = [&](const Progress& progress) {
        if (progress.stage == Progress::Stage::compiling) ++calls;
        BOOST_TEST(device.record_folder().empty());
    };
    const DistanceTransform transform(device, make_shape("tetrahedron"), {}, call);
    transform.compile(unit_grid(), Band::full(), {}, call);
    BOOST_TEST(calls > 0U);
}

BOOST_AUTO_TEST_CASE(a_callback_that_uses_another_transform_of_the_device_does_not_wait_for_its_own_call) {
    const Mesh mesh = make_shape("tetrahedron");
    const Grid grid = unit_grid();
    for (const Progress::Stage stage : {Progress::Stage::compiling, Progress::Stage::testing}) {
        const Device device = Device::strongest();
        const DistanceTransform transform(device, mesh), other(device, mesh);
        CallOptions call;
        call.progress = [&](const Progress& progress) {
            if (progress.stage == stage) other.compute(grid, Band::full());
        };
        check_throws(ErrorCode::invalid_argument, {"a transform of the call's device", "when the call has returned"},
                     [&] { transform.compute(grid, Band::full(), Output::distance, call); });
        BOOST_TEST(transform.compute(grid, Band::full()).distance().size() == grid.sample_count());
    }
}

BOOST_AUTO_TEST_CASE(a_call_on_another_thread_waits_while_programs_are_built_and_tested) {
    const Mesh mesh = make_shape("tetrahedron");
    const Grid grid = unit_grid();
    for (const Progress::Stage stage : {Progress::Stage::compiling, Progress::Stage::testing}) {
        const Device device = Device::strongest();
        const DistanceTransform transform(device, mesh), other(device, mesh);
        std::optional<Field> of_other;
        std::jthread thread;
        CallOptions call;
        call.progress = [&](const Progress& progress) {
            if (progress.stage != stage || thread.joinable()) return;
            thread = std::jthread([&] { of_other = other.compute(grid, Band::full()); });
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        };
        const Field field = transform.compute(grid, Band::full(), Output::distance, call);
        BOOST_TEST_REQUIRE(thread.joinable());
        thread.join();
        BOOST_TEST_REQUIRE(of_other.has_value());
        BOOST_TEST((bits_of(of_other->distance()) == bits_of(field.distance())));
    }
}

#ifndef __SANITIZE_THREAD__  // oneTBB is not instrumented, and starts threads here
// A task of the caller that began within one of the library's loops could lock a mutex that its own thread holds.
BOOST_AUTO_TEST_CASE(no_task_of_the_caller_runs_within_a_loop_of_the_library) {
    using namespace std::chrono_literals;
    thread_local bool is_in_loop = false;
    std::atomic<int> nested = 0, begun = 0, asked = 0, ended = 0;
    std::atomic<bool> is_done = false;
    tbb::task_arena arena(2);
    std::thread caller([&] {
        for (; !is_done; std::this_thread::sleep_for(1ms)) {
            ++asked;
            arena.enqueue([&] {
                nested += is_in_loop ? 1 : 0;
                ++ended;
            });
        }
    });
    arena.execute([&] {
        is_in_loop = true;
        // Another thread takes one of the two indices, and this one waits for it.
        for_each_index(
            2,
            [&](std::size_t i) {
                ++begun;
                for (int k = 0; k < 1000 && begun < 2; ++k) std::this_thread::sleep_for(1ms);
                if (i == 1) std::this_thread::sleep_for(50ms);
            },
            1);
        is_in_loop = false;
    });
    is_done = true;
    caller.join();
    while (ended < asked) arena.execute([] { std::this_thread::sleep_for(1ms); });
    BOOST_TEST(begun == 2);
    BOOST_TEST(nested == 0);
}
#endif

BOOST_AUTO_TEST_CASE(a_queue_of_another_context_is_refused) {
    const device::Context& context = device::context_of(test_device());
    const cl::Context other(context.device());
    const cl::CommandQueue queue(other, context.device());
    check_throws(ErrorCode::invalid_argument, {"another context"},
                 [&] { Device::from_handles(context.context()(), context.device()(), queue()); });
}

BOOST_AUTO_TEST_CASE(queues_events_and_memory_that_are_of_no_use_are_refused) {
    const Mesh mesh = make_shape("cube");
    const DistanceTransform transform(test_device(), mesh);
    const device::Context& context = device::context_of(test_device());
    const Grid grid = grid_around(mesh, 8, 1);
    const Band band = Band::symmetric(grid.voxel());
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, grid.sample_count() * sizeof(float));
    const OutputTargets targets{{Output::distance, OutputArray(memory())}};
    Plan plan = transform.plan(grid, band);
    Plan of_requests = transform.plan(std::vector<Request>{{grid, band, targets}});
    const auto refused = [&](cl_command_queue queue, const std::vector<cl_event>& events,
                             const std::vector<std::string>& words) {
        check_throws(ErrorCode::invalid_argument, words, [&] { plan.enqueue(queue, targets, events); });
        check_throws(ErrorCode::invalid_argument, words, [&] { of_requests.enqueue(queue, events); });
    };
    const cl::Context other(context.device());
    const cl::CommandQueue queue_of_other(other, context.device());
    refused(queue_of_other(), {}, {"queue", "another OpenCL context"});
    const cl::UserEvent ours(context.context()), event_of_other(other);
    refused(nullptr, {ours(), event_of_other()}, {"event 1 of the wait list's 2", "another OpenCL context"});
    refused(nullptr, {nullptr}, {"event 0", "null"});
    check_throws(ErrorCode::invalid_argument, {"event 0", "null"}, [&] {
        const std::vector<cl_event> events{nullptr};
        transform.compute(grid, band, targets, {.wait_list = events});
    });
    std::vector<cl::ImageFormat> formats;
    if (context.device().getInfo<CL_DEVICE_IMAGE_SUPPORT>())
        context.context().getSupportedImageFormats(CL_MEM_READ_WRITE, CL_MEM_OBJECT_IMAGE2D, &formats);
    if (!formats.empty()) {
        const cl::Image2D image(context.context(), CL_MEM_READ_WRITE, formats.front(), 64, 64);
        const OutputTargets on_image{{Output::distance, OutputArray(image())}};
        const std::vector<std::string> words{"output distance", "image", "give it a buffer"};
        check_throws(ErrorCode::invalid_argument, words, [&] { plan.enqueue(nullptr, on_image); });
        const std::vector<Vec3> points(5);
        check_throws(ErrorCode::invalid_argument, words, [&] { transform.query(points, 1, on_image); });
    }
    // The plans are as good as new.
    enqueue(plan, nullptr, targets).wait();
    enqueue(of_requests, nullptr).wait();
}

BOOST_AUTO_TEST_CASE(spacings_beyond_floats_are_refused) {
    for (const double scale : {1e-45, 1e-309, 1e41}) {
        const Mesh mesh = enlarged(make_shape("cube"), scale);
        check_throws(ErrorCode::invalid_argument, {"scale the mesh"},
                     [&] { compute(mesh, unit_grid(0.1 * scale), Band::symmetric(0.2 * scale)); });
    }
    check_throws(ErrorCode::invalid_argument, {"scale the mesh"},
                 [&] { compute(make_shape("cube"), unit_grid(), Band::symmetric(1e40)); });
}

BOOST_AUTO_TEST_CASE(spacings_that_differ_beyond_reason_are_refused) {
    Grid grid = unit_grid();
    grid.spacing[2] = 1e10 * grid.spacing[0];
    check_throws(ErrorCode::invalid_argument, {"factor of 1e9"},
                 [&] { compute(make_shape("cube"), grid, Band::symmetric(0.2)); });
}

BOOST_AUTO_TEST_CASE(an_unsigned_field_beyond_the_mesh_is_outside_by_either_body) {
    const Mesh mesh = make_shape("tetrahedron");
    Grid grid = unit_grid();
    grid.origin = {100, 100, 100};
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const Field field = compute(mesh, grid, {0.1, 0.2}, TransformOptions{.sign = SignRule::none, .body = body});
        BOOST_TEST(std::ranges::count(field.distance(), 0.2F) == static_cast<std::ptrdiff_t>(grid.sample_count()));
    }
}

BOOST_AUTO_TEST_CASE(a_soup_costs_what_the_welded_mesh_costs) {
    const Mesh mesh = make_shape("torus");
    const Mesh soup = as_soup(mesh);
    const Grid grid = grid_around(mesh, 64, 6);
    const Band band = Band::symmetric(5 * grid.voxel());
    const auto lanes = [&](const Mesh& of) {
        TransformStatistics statistics;
        DistanceTransform(test_device(), of).compute(grid, band, Output::distance, {.count_work = true}, &statistics);
        return statistics.work->lanes_evaluated;
    };
    BOOST_TEST(lanes(soup) == lanes(mesh));
    BOOST_TEST((bits_of(compute(soup, grid, band).distance()) == bits_of(compute(mesh, grid, band).distance())));
}

BOOST_AUTO_TEST_CASE(triangles_of_ten_billion_voxels_are_found) {
    constexpr double size = 1e10;
    const Mesh mesh({{size, size, size}, {-size, -size, size}, {-size, size, -size}, {size, -size, -size}},
                    {{0, 1, 3}, {0, 3, 2}, {0, 2, 1}, {1, 2, 3}}, "tetrahedron of 1e10 voxels");
    const double middle = -size / 3 - 20;  // of the last face, seen from the origin
    check_exact(mesh, Grid{{middle, middle, middle}, {1, 1, 1}, {40, 40, 40}, {}}, Band::symmetric(8), guaranteed);
}

BOOST_AUTO_TEST_CASE(a_band_that_was_not_set_gives_no_field) {
    check_throws(ErrorCode::invalid_argument, {"band", "not set", "full band"},
                 [&] { compute(make_shape("cube"), unit_grid(), Band{}); });
}

BOOST_AUTO_TEST_CASE(a_transform_that_was_moved_from_answers_with_an_error) {
    const Mesh mesh = make_shape("cube");
    const Grid grid = unit_grid();
    const Band band = Band::symmetric(0.2);
    DistanceTransform from(test_device(), mesh);
    DistanceTransform to = std::move(from);
    std::vector<float> distance(grid.sample_count());
    // NOLINTBEGIN(bugprone-use-after-move)
    const std::vector<std::function<void()>> calls{
        [&] { from.sign(); },
        [&] { from.topology(); },
        [&] { from.memory(); },
        [&] { from.box(); },
        [&] { from.device(); },
        [&] { from.set_positions(mesh.vertices()); },
        [&] {
            from.set_motion({Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}, {});
        },
        [&] {
            from.restrict_to({mesh.box(), 0.1, 0.1});
        },
        [&] { from.compile(grid, band); },
        [&] { from.compute(grid, band); },
        [&] { from.compute(BlockSet{}); },
        [&] { from.query(mesh.vertices(), 1, distance); },
        [&] { from.compute(grid, band, distance); },
        [&] { from.compute(grid, band, Output::distance, [](const Grid&, const FieldSlab&) {}); },
        [&] { from.plan(grid, band); }};
    for (const auto& call : calls) check_throws(ErrorCode::invalid_argument, {"DistanceTransform", "moved from"}, call);
    BOOST_TEST((to.sign() == SignRule::nonzero));
    from = std::move(to);
    BOOST_TEST(from.compute(grid, band).distance().size() == grid.sample_count());
    // NOLINTEND(bugprone-use-after-move)
}

BOOST_AUTO_TEST_CASE(plans_and_devices_that_were_moved_from_answer_with_an_error) {
    DistanceTransform transform(test_device(), make_shape("cube"));
    Plan from = transform.plan(unit_grid(), Band::symmetric(0.2));
    const Plan to = std::move(from);
    // NOLINTBEGIN(bugprone-use-after-move)
    for (const std::function<void()>& call : std::vector<std::function<void()>>{
             [&] { from.requests(); }, [&] { from.sign(); }, [&] { from.statistics(); }, [&] { from.enqueue(nullptr); },
             [&] { from.enqueue(nullptr, OutputTargets{}); }})
        check_throws(ErrorCode::invalid_argument, {"Plan", "moved from"}, call);
    BOOST_TEST((to.requests().front().grid == unit_grid()));

    Device device = test_device();
    const Device other = std::move(device);
    for (const std::function<void()>& call : std::vector<std::function<void()>>{
             [&] { device.name(); }, [&] { device.platform(); }, [&] { device.context(); }, [&] { device.id(); },
             [&] { device.queue(); }, [&] { device.info(); }, [&] { device.record_folder(); },
             [&] { device.keep_records(""); }, [&] { device.forget_records(); }, [&] { device.read_programs(""); },
             [&] { device.write_programs(""); }, [&] { DistanceTransform(device, make_shape("cube")); }})
        check_throws(ErrorCode::invalid_argument, {"Device", "moved from"}, call);
    BOOST_TEST(other.name() == test_device().name());
    // NOLINTEND(bugprone-use-after-move)
}

BOOST_AUTO_TEST_CASE(a_plan_moves_with_transforms_of_its_device_alone) {
    const Mesh mesh = make_shape("cube");
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device());
    const Device other = Device::from_handles(context.context()(), context.device()(), queue());
    const DistanceTransform transform(test_device(), mesh), of_other(other, mesh);
    Plan plan = transform.plan(unit_grid(), Band::symmetric(0.2));
    check_throws(ErrorCode::invalid_argument, {"another device"}, [&] { plan.update(of_other); });
    plan.update(transform);
}

BOOST_AUTO_TEST_CASE(a_part_of_a_soup_does_not_move) {
    const Mesh soup = as_soup(make_shape("sphere2"));
    const DistanceTransform whole(test_device(), soup);
    DistanceTransform part = whole.restrict_to({{{0.5, 0.5, 0.5}, {1, 1, 1}}, 0.1, 0.05});
    check_throws(ErrorCode::unsupported, {"set the positions of the whole one"},
                 [&] { part.set_positions(soup.vertices()); });
    check_throws(ErrorCode::unsupported, {"set the positions of the whole one"}, [&] {
        part.set_motion({Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}, {0, 0, 1});
    });
}

BOOST_AUTO_TEST_CASE(the_band_of_an_unsigned_part_has_no_inside) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform whole(test_device(), mesh, {.sign = SignRule::none});
    const DistanceTransform part = whole.restrict_to({{{0, 0, 0}, {1, 1, 1}}, 0.3, 0.1});
    Grid grid = unit_grid();
    grid.origin = {0.1, 0.1, 0.1};
    grid.size = {8, 8, 8};
    const Band band{std::numeric_limits<double>::infinity(), 0.3};
    BOOST_TEST((bits_of(part.compute(grid, band).distance()) == bits_of(whole.compute(grid, band).distance())));
}

BOOST_AUTO_TEST_CASE(a_lattice_for_each_call_keeps_no_more_after_many) {
    const DistanceTransform transform(test_device(), make_shape("sphere2"));
    std::size_t after_some = 0;
    for (int call = 0; call < 160; ++call) {
        Grid grid = unit_grid();
        grid.size = {3, 3, 3};
        grid.origin[0] += 1e-3 * call;
        transform.compute(grid, Band::symmetric(0.1));
        if (call == 79) after_some = transform.memory().host_bytes;
    }
    BOOST_TEST(transform.memory().host_bytes == after_some);
}

BOOST_AUTO_TEST_CASE(outputs_may_go_where_the_points_lie) {
    const DistanceTransform transform(test_device(), make_shape("sphere3"));
    std::vector<Vec3> points(40'000);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> coordinate(-1.3, 1.3);
    for (Vec3& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
    const double no_limit = std::numeric_limits<double>::infinity();
    std::vector<float> expected(points.size());
    transform.query(points, no_limit, expected);
    for (const double place : {0.0, 0.5, 0.8}) {
        std::vector<Vec3> shared = points;
        float* const first = &reinterpret_cast<float*>(
            shared.data())[static_cast<std::size_t>(place * 5 * static_cast<double>(points.size()))];
        transform.query(shared, no_limit, std::span(first, points.size()));
        BOOST_TEST(std::equal(expected.begin(), expected.end(), first), "at " << place);
    }
}

BOOST_AUTO_TEST_CASE(boxes_at_a_distance_beyond_floats_are_near) {
    const DistanceTransform transform(test_device(), make_shape("sphere1"));
    for (const double far : {1e17, 1e18, 1e30, 1e100}) {
        const std::vector<Box> boxes{{{far, 0, 0}, {far, 1, 1}}, {{1.5 * far, 0, 0}, {1.5 * far, 1, 1}}};
        std::vector<BoxPlace> places(2);
        transform.classify(boxes, 1.2 * far, places);
        BOOST_TEST((places[0] == BoxPlace::within), "a box from " << far);
        BOOST_TEST((places[1] == BoxPlace::outside), "a box from " << 1.5 * far);
    }
}

BOOST_AUTO_TEST_CASE(strides_of_a_packed_field_may_be_given_in_larger_memory) {
    const DistanceTransform transform(test_device(), make_shape("sphere1"));
    Grid grid = unit_grid();
    grid.size = {8, 8, 8};
    const Field expected = transform.compute(grid, Band::full());
    std::vector<float> memory(600, -7.0F);
    OutputArray target = memory;
    target.strides = {4, 32, 256};
    transform.compute(grid, Band::full(), target);
    BOOST_TEST(std::equal(expected.distance().begin(), expected.distance().end(), memory.begin()));
    BOOST_TEST(std::all_of(memory.begin() + 512, memory.end(), [](float value) { return value == -7.0F; }));
    target.strides = {};
    check_throws(ErrorCode::invalid_argument, {"has 512 samples", "600 values"},
                 [&] { transform.compute(grid, Band::full(), target); });
    // The components of packed samples may not lie beyond the memory, or on others.
    std::vector<float> distance(512), gradients(3 * 512);
    for (const std::ptrdiff_t stride : {std::ptrdiff_t{4 * 3 * 512}, std::ptrdiff_t{-4}, std::ptrdiff_t{8}}) {
        OutputArray apart = gradients;
        apart.component_stride = stride;
        check_throws(ErrorCode::invalid_argument, {"gradient"}, [&] {
            transform.compute(grid, Band::full(), {{Output::distance, distance}, {Output::gradient, apart}});
        });
    }
}

BOOST_AUTO_TEST_CASE(a_vertex_that_no_triangle_uses_may_lie_anywhere) {
    Mesh mesh = make_shape("sphere1");
    std::vector<Vec3> vertices = mesh.vertices();
    vertices.push_back({0, 1e30, 0});
    Grid grid = unit_grid();
    grid.first = {100'000'000, 0, 0};
    grid.origin[0] -= grid.spacing[0] * 1e8;
    check_exact(Mesh(vertices, mesh.triangles()), grid, Band::full());
}

BOOST_AUTO_TEST_CASE(minus_zero_is_zero) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const Field plus = transform.compute(unit_grid(), {0.0, 0.2});
    const Field minus = DistanceTransform(test_device(), mesh).compute(unit_grid(), {-0.0, 0.2});
    BOOST_TEST((bits_of(plus.distance()) == bits_of(minus.distance())));
    const std::vector<Vec3> points{{0, 0, 0}, {2, 0, 0}};
    std::vector<float> of_plus(2), of_minus(2);
    transform.query(points, 0.0, of_plus);
    transform.query(points, -0.0, of_minus);
    BOOST_TEST(std::signbit(of_plus[0]) == std::signbit(of_minus[0]));
    BOOST_TEST(std::signbit(of_plus[1]) == std::signbit(of_minus[1]));
}

BOOST_AUTO_TEST_CASE(a_vertex_that_moves_beyond_all_numbers_is_named_by_the_callers_index) {
    const Mesh soup = as_soup(make_shape("cube"));
    DistanceTransform transform(test_device(), soup);
    std::vector<Vec3> positions = soup.vertices();
    positions[17][1] = std::numeric_limits<double>::quiet_NaN();
    check_throws(ErrorCode::invalid_mesh, {"vertex 17", "not finite"}, [&] { transform.set_positions(positions); });
}

BOOST_AUTO_TEST_CASE(grids_beyond_whole_numbers_are_refused) {
    const Grid grid = unit_grid();
    check_throws(ErrorCode::invalid_argument, {"2^53"},
                 [&] { static_cast<void>(grid.refined(std::int64_t{1} << 61)); });
    check_throws(ErrorCode::invalid_argument, {"2^53"},
                 [&] { static_cast<void>(grid.grown(std::numeric_limits<std::int64_t>::max() / 2)); });
    Grid long_one = grid;
    long_one.size = {1, 1, std::int64_t{1} << 50};
    const DistanceTransform transform(test_device(), make_shape("cube"));
    const auto sink = [](const Grid&, const FieldSlab&) {};
    check_throws(ErrorCode::invalid_argument, {},
                 [&] { transform.compute(long_one, Band::full(), Output::distance, sink); });
    check_throws(ErrorCode::invalid_argument, {}, [&] { static_cast<void>(DistanceTransform::slabs_of(long_one)); });
}

BOOST_AUTO_TEST_CASE(an_oracle_that_was_moved_from_answers_with_an_error) {
    reference::Oracle from(make_shape("cube"));
    const reference::Oracle to = std::move(from);
    // NOLINTBEGIN(bugprone-use-after-move)
    for (const std::function<void()>& call : std::vector<std::function<void()>>{[&] {
                                                                                    from.nearest({0, 0, 0});
                                                                                },
                                                                                [&] {
                                                                                    from.winding_number({0, 0, 0});
                                                                                }})
        check_throws(ErrorCode::invalid_argument, {"Oracle", "moved from"}, call);
    BOOST_TEST(to.nearest({5, 5, 5}).distance > 0);
    // NOLINTEND(bugprone-use-after-move)
}

}  // namespace clsdf::test
