#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include "core/parallel.hpp"
#include "device/context.hpp"

#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
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

BOOST_AUTO_TEST_CASE(a_device_whose_queue_is_out_of_order_computes_the_same_bytes) {
    const Mesh mesh = make_shape("knot");
    const Grid grid = grid_around(mesh, 64, 6);
    const Band band = Band::symmetric(5 * grid.voxel());
    const Field expected = compute(mesh, grid, band);
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    const Device device = Device::from_handles(context.context()(), context.device()(), queue());
    DistanceTransform transform(device, mesh);
    for (int repetition = 0; repetition < 20; ++repetition)
        BOOST_TEST((transform(grid, band).distance == expected.distance));
}

BOOST_AUTO_TEST_CASE(a_callback_may_ask_the_device_while_it_compiles) {
    const Device device = Device::best();
    device.set_program_cache("");
    std::size_t calls = 0;
    CallOptions call;
    call.compiling = [&](const Compilation&) {
        ++calls;
        BOOST_TEST(device.program_cache().empty());
    };
    const DistanceTransform transform(device, make_shape("tetrahedron"), {}, call);
    transform.compile(unit_grid(), Band::full(), {}, call);
    BOOST_TEST(calls > 0U);
}

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

BOOST_AUTO_TEST_CASE(a_queue_of_another_context_is_refused) {
    const device::Context& context = device::context_of(test_device());
    const cl::Context other(context.device());
    const cl::CommandQueue queue(other, context.device());
    check_throws(ErrorCode::invalid_argument, {"another context"},
                 [&] { Device::from_handles(context.context()(), context.device()(), queue()); });
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
        BOOST_TEST((field.distance == FieldArray<float>(grid.sample_count(), 0.2F)));
    }
}

BOOST_AUTO_TEST_CASE(a_soup_costs_what_the_welded_mesh_costs) {
    const Mesh mesh = make_shape("torus");
    const Mesh soup = as_soup(mesh);
    const Grid grid = grid_around(mesh, 64, 6);
    const Band band = Band::symmetric(5 * grid.voxel());
    const auto lanes = [&](const Mesh& of) {
        TransformStatistics statistics;
        DistanceTransform(test_device(), of)(grid, band, {}, {.count = true, .statistics = &statistics});
        return statistics.lanes_evaluated;
    };
    BOOST_TEST(lanes(soup) == lanes(mesh));
    BOOST_TEST((compute(soup, grid, band).distance == compute(mesh, grid, band).distance));
}

BOOST_AUTO_TEST_CASE(triangles_of_ten_billion_voxels_are_found) {
    constexpr double size = 1e10;
    const Mesh mesh({{size, size, size}, {-size, -size, size}, {-size, size, -size}, {size, -size, -size}},
                    {{0, 1, 3}, {0, 3, 2}, {0, 2, 1}, {1, 2, 3}}, "tetrahedron of 1e10 voxels");
    const double middle = -size / 3 - 20;  // of the last face, seen from the origin
    check_exact(mesh, Grid{{middle, middle, middle}, {1, 1, 1}, {40, 40, 40}, {}}, Band::symmetric(8), guaranteed);
}

BOOST_AUTO_TEST_CASE(a_band_that_was_not_set_gives_no_field) {
    check_throws(ErrorCode::invalid_argument, {"band", "not set", "Band::full()"},
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
        [&] { from.move(std::vector<Vec3>(8)); },
        [&] { from.compile(grid, band); },
        [&] { from(grid, band); },
        [&] { from.compute(grid, band, {.distance = distance}); },
        [&] { from.compute_slabs(grid, band, {}, [](const Grid&, const FieldSlab&) {}); },
        [&] { from.plan(grid, band); }};
    for (const auto& call : calls) check_throws(ErrorCode::invalid_argument, {"DistanceTransform", "moved from"}, call);
    BOOST_TEST((to.sign() == SignRule::nonzero));
    from = std::move(to);
    BOOST_TEST(from(grid, band).distance.size() == grid.sample_count());
    // NOLINTEND(bugprone-use-after-move)
}

BOOST_AUTO_TEST_CASE(plans_and_devices_that_were_moved_from_answer_with_an_error) {
    DistanceTransform transform(test_device(), make_shape("cube"));
    Plan from = transform.plan(unit_grid(), Band::symmetric(0.2));
    const Plan to = std::move(from);
    // NOLINTBEGIN(bugprone-use-after-move)
    for (const std::function<void()>& call :
         std::vector<std::function<void()>>{[&] { from.grid(); }, [&] { from.band(); }, [&] { from.sign(); },
                                            [&] { from.statistics(); }, [&] { from.enqueue(nullptr, {}); }})
        check_throws(ErrorCode::invalid_argument, {"Plan", "moved from"}, call);
    BOOST_TEST((to.grid() == unit_grid()));

    Device device = test_device();
    const Device other = std::move(device);
    for (const std::function<void()>& call : std::vector<std::function<void()>>{
             [&] { device.name(); }, [&] { device.platform(); }, [&] { device.context(); }, [&] { device.id(); },
             [&] { device.queue(); }, [&] { device.program_cache(); }, [&] { device.set_program_cache(""); },
             [&] { DistanceTransform(device, make_shape("cube")); }})
        check_throws(ErrorCode::invalid_argument, {"Device", "moved from"}, call);
    BOOST_TEST(other.name() == test_device().name());
    // NOLINTEND(bugprone-use-after-move)
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
