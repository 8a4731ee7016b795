#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"
#include "support/two_boxes.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <array>
#include <chrono>
#include <optional>
#include <thread>

// Plans of grids and boxes: their memory, how long they live, and what they refuse. That their runs have the bytes of
// the plain call: same_bytes.cpp; in what order runs end: runs.cpp.

using namespace clsdf;
using namespace clsdf::test;

namespace {

const Mesh& mesh() {
    static const Mesh shape = tilted(make_shape("knot"));
    return shape;
}
const Grid& grid() {
    static const Grid around = grid_around(mesh(), 40, 5);
    return around;
}
Band band() {
    return Band::symmetric(3 * grid().voxel());
}

const device::Context& context() {
    return device::context_of(test_device());
}
cl::CommandQueue callers_queue() {
    return {context().context(), context().device()};
}

struct Memory {
    DeviceMemory distance{test_device().context(), grid().sample_count()};
    DeviceMemory triangle{test_device().context(), grid().sample_count()};

    OutputTargets outputs() const {
        return {{Output::distance, distance.handle()}, {Output::triangle, triangle.handle()}};
    }
};

void run(Plan& plan, cl_command_queue queue) {
    enqueue(plan, queue).wait();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_plan_names_its_requests_and_its_sign) {
    const DistanceTransform transform(test_device(), mesh());
    const Plan plan = transform.plan(grid(), band(), Output::triangle);
    BOOST_TEST((plan.requests().front().grid == grid()));
    BOOST_TEST(name_of(plan.sign()) == "nonzero");
}

BOOST_AUTO_TEST_CASE(a_plan_outlives_its_transform) {
    const DistanceTransform expected(test_device(), mesh());
    const TwoBoxes boxes(grid());
    const DeviceMemory distance(test_device().context(), grid().sample_count());
    std::optional<DistanceTransform> transform(std::in_place, test_device(), mesh());
    Plan of_grid = transform->plan(grid(), band()), of_boxes = transform->plan(boxes.requests());
    transform.reset();
    Plan first = std::move(of_grid), second = std::move(of_boxes);
    enqueue(first, nullptr, distance.handle()).wait();
    BOOST_TEST((distance.read(callers_queue()) == bits_of(expected.compute(grid(), band()).distance())));
    run(second, nullptr);
    BOOST_TEST(boxes.have_fields_of(expected));
    check_throws(ErrorCode::invalid_argument, {"Plan was moved from"}, [&] { of_boxes.enqueue(nullptr); });
}

BOOST_AUTO_TEST_CASE(a_plan_that_ends_early_keeps_its_memory_until_its_work_is_done) {
    DistanceTransform transform(test_device(), mesh());
    const Memory memory, expected;
    Plan first = transform.plan(grid(), band(), Output::triangle);
    enqueue(first, nullptr, expected.outputs()).wait();
    cl::UserEvent gate(cl::Context(test_device().context(), true));
    const std::array<cl_event, 1> wait_list{gate()};
    std::thread opener([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        gate.setStatus(CL_COMPLETE);
    });
    cl::Event end;
    {
        Plan plan = transform.plan(grid(), band(), Output::triangle);
        end = enqueue(plan, nullptr, memory.outputs(), wait_list);
    }
    const Plan other = transform.plan(grid(), Band::symmetric(0.5 * band().outside));
    end.wait();
    opener.join();
    BOOST_TEST((memory.triangle.read(callers_queue()) == expected.triangle.read(callers_queue())));
}

BOOST_AUTO_TEST_CASE(the_memory_of_a_plan_of_boxes_is_known_before) {
    const DistanceTransform transform(test_device(), mesh());
    const TwoBoxes boxes(grid());
    const std::size_t bytes = transform.plan_bytes(boxes.requests());
    // A plan may take free buffers that are a little larger.
    BOOST_TEST(
        static_cast<double>(transform.plan(boxes.requests()).statistics().device_bytes) == static_cast<double>(bytes),
        boost::test_tools::tolerance(0.1));
    BOOST_TEST(bytes > grid().sample_count() * sizeof(float));
}

BOOST_AUTO_TEST_CASE(plans_take_the_memory_that_their_transform_may_take) {
    const Mesh mesh = make_shape("sphere3");
    const Device device = test_device().limited({.memory = 24 << 20});
    const DistanceTransform transform(device, mesh);
    const Grid grid = grid_around(mesh, 150, 2);
    const Band band = Band::symmetric(2 * grid.voxel());
    std::vector<cl::Buffer> memory;
    std::vector<Plan> plans;
    const auto add = [&] {
        memory.emplace_back(cl::Context(device.context(), true), CL_MEM_READ_WRITE,
                            2 * grid.sample_count() * sizeof(float));
        OutputArray target = memory.back()();
        target.strides = {8, 8 * grid.size[0], 8 * grid.size[0] * grid.size[1]};
        plans.push_back(transform.plan(std::vector<Request>{{grid, band, target}}));
    };
    add();
    BOOST_REQUIRE(plans.front().statistics().device_bytes > 2'000'000U);
    check_throws(ErrorCode::out_of_memory, {"25165824"}, [&] {
        for (int n = 0; n < 12; ++n) add();
    });
}

BOOST_AUTO_TEST_CASE(more_boxes_than_a_launch_has_groups_are_all_stored) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 34, 2);
    const Band band = Band::symmetric(2 * grid.voxel());
    const DeviceMemory memory(test_device().context(), grid.sample_count());
    std::vector<Request> requests;
    for (std::int64_t z = 0; z < grid.size[2]; ++z)
        for (std::int64_t y = 0; y < grid.size[1]; ++y)
            for (std::int64_t x = 0; x < grid.size[0]; ++x) {
                OutputArray target = memory.handle();
                target.offset = requests.size() * sizeof(float);
                requests.push_back({grid.part({x, y, z}, {1, 1, 1}), band, target});
            }
    BOOST_REQUIRE(requests.size() > 32768U);
    Plan plan = transform.plan(requests);
    run(plan, nullptr);
    BOOST_TEST((memory.read(callers_queue()) == bits_of(transform.compute(grid, band).distance())));
}

BOOST_AUTO_TEST_CASE(a_plan_may_have_no_request_and_every_plan_is_updated_on_its_own_device) {
    const DistanceTransform transform(test_device(), mesh());
    const TwoBoxes boxes(grid());
    Plan plan = transform.plan(boxes.requests());
    plan.update(transform, std::span<const Request>());
    BOOST_TEST(plan.requests().empty());
    run(plan, nullptr);
    BOOST_TEST(boxes.are_untouched());
    const Device other = one_compute_unit();
    const DistanceTransform of_other(other, mesh());
    if (device::context_of(other).context()() == context().context()()) return;
    check_throws(ErrorCode::invalid_argument, {"another device"},
                 [&] { plan.update(of_other, std::span<const Request>()); });
    SparsePlan sparse = transform.plan_sparse({grid(), band(), {}}, {1, 1});
    check_throws(ErrorCode::invalid_argument, {"another device"}, [&] { sparse.update(of_other); });
    PointPlan of_points = transform.plan_points(1, 1);
    check_throws(ErrorCode::invalid_argument, {"another device"}, [&] { of_points.update(of_other); });
}

BOOST_AUTO_TEST_CASE(targets_that_do_not_fit_the_outputs_of_a_plan_of_a_grid_are_refused) {
    const DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band()), of_triangles = transform.plan(grid(), band(), Output::triangle);
    const Memory memory;
    check_throws(ErrorCode::invalid_argument, {"has no targets", "give this run targets"},
                 [&] { plan.enqueue(nullptr); });
    check_throws(ErrorCode::invalid_argument, {"triangle has a target", "make the plan with triangle"},
                 [&] { plan.enqueue(nullptr, memory.outputs()); });
    BOOST_TEST((memory.triangle.read(callers_queue()) == std::vector<std::uint32_t>(grid().sample_count(), untouched)));
    const cl::Buffer small(cl::Context(test_device().context(), true), CL_MEM_READ_WRITE, 16);
    check_throws(ErrorCode::invalid_argument, {"output distance", "16 bytes"}, [&] {
        plan.enqueue(nullptr, {{Output::distance, small()}});
    });
    check_throws(ErrorCode::invalid_argument, {"distance has no target"},
                 [&] { of_triangles.enqueue(nullptr, OutputTargets{}); });
    check_throws(ErrorCode::invalid_argument, {"triangle has no target"}, [&] {
        of_triangles.enqueue(nullptr, {{Output::distance, memory.distance.handle()}});
    });
    // With targets of its own from now on.
    plan.update(transform, std::vector<Request>{{grid(), band(), memory.distance.handle()}});
    run(plan, nullptr);
    BOOST_TEST((memory.distance.read(callers_queue()) == bits_of(transform.compute(grid(), band()).distance())));
}

BOOST_AUTO_TEST_CASE(targets_that_a_run_of_a_plan_of_boxes_cannot_write_to_are_named) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 20, 2), fine = grid.refined(2);
    const Band band = Band::symmetric(2 * grid.voxel());
    const DeviceMemory of_grid(test_device().context(), 2 * grid.sample_count()),
        of_fine(test_device().context(), 2 * fine.sample_count()),
        unplanned(test_device().context(), fine.sample_count());
    const OutputArray packed = of_grid.handle(), doubles(of_fine.handle(), ElementType::float64);
    OutputArray shifted = packed;
    shifted.offset = sizeof(float);
    // Two lattices: the first box is computed in place, the second is copied.
    Plan plan = transform.plan(std::vector<Request>{{grid, band, packed}, {fine, band, doubles}});
    const auto run_with = [&](const OutputTargets& first, const OutputTargets& second) {
        const std::array targets{first, second};
        enqueue(plan, nullptr, targets).wait();
    };
    check_throws(ErrorCode::unsupported, {"request 0 of 2", "begins at byte 4"}, [&] { run_with(shifted, doubles); });
    check_throws(ErrorCode::unsupported, {"request 1 of 2", "another type of elements"}, [&] {
        run_with(packed, {{Output::distance, of_fine.handle()}});
    });
    check_throws(ErrorCode::invalid_argument, {"request 1 of 2", "distance has no target"},
                 [&] { run_with(packed, {}); });
    check_throws(ErrorCode::invalid_argument, {"request 1 of 2", "triangle has a target"}, [&] {
        run_with(packed, {{Output::distance, doubles}, {Output::triangle, unplanned.handle()}});
    });
    check_throws(ErrorCode::invalid_argument, {"2 requests", "the targets of 1"},
                 [&] { plan.enqueue(nullptr, packed); });
    // Nothing was enqueued; the plan still works.
    run_with(packed, doubles);
    std::vector<std::uint32_t> bits = of_grid.read(callers_queue());
    bits.resize(grid.sample_count());
    BOOST_TEST((bits == bits_of(transform.compute(grid, band).distance())));
}

BOOST_AUTO_TEST_CASE(targets_that_a_plan_of_one_grid_cannot_write_to_are_named) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 20, 2);
    const Band band = Band::symmetric(2 * grid.voxel());
    const DeviceMemory memory(test_device().context(), 3 * grid.sample_count()),
        unplanned(test_device().context(), grid.sample_count());
    Plan plan = transform.plan(grid, band);
    OutputArray strided = memory.handle(), shifted = memory.handle(), doubles(memory.handle(), ElementType::float64);
    const auto row = static_cast<std::ptrdiff_t>(sizeof(float)) * (grid.size[0] + 1);
    strided.strides = {sizeof(float), row, row * grid.size[1]};
    shifted.offset = sizeof(float);
    for (const auto& [target, why] :
         {std::pair(strided, "has strides"), std::pair(shifted, "begins at byte 4"), std::pair(doubles, "doubles")}) {
        check_throws(ErrorCode::unsupported, {"output distance", why, "of a request with such a target"},
                     [&] { plan.enqueue(nullptr, target); });
    }
    Plan copying = transform.plan({grid, band, shifted});
    check_throws(ErrorCode::unsupported, {"output distance", "another type of elements"},
                 [&] { copying.enqueue(nullptr, doubles); });
    check_throws(ErrorCode::invalid_argument, {"triangle has a target"}, [&] {
        copying.enqueue(nullptr, {{Output::distance, shifted}, {Output::triangle, unplanned.handle()}});
    });
    check_throws(ErrorCode::invalid_argument, {"no target"}, [&] { transform.plan(Request{grid, band, {}}); });
    enqueue(copying, nullptr, strided).wait();
    enqueue(plan, nullptr, {{Output::distance, memory.handle()}}).wait();
}

BOOST_AUTO_TEST_CASE(targets_that_a_plan_of_boxes_cannot_write_to_are_named) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 20, 2);
    const Band band = Band::symmetric(2 * grid.voxel());
    const DeviceMemory memory(test_device().context(), grid.sample_count());
    const auto plan_with = [&](const OutputTargets& second) {
        const std::vector<Request> requests{{grid, band, {{Output::distance, memory.handle()}}}, {grid, band, second}};
        transform.plan(requests);
    };
    std::vector<float> host(grid.sample_count());
    check_throws(ErrorCode::unsupported, {"request 1 of 2", "output distance", "memory of the host"},
                 [&] { plan_with(host); });
    OutputArray shifted = memory.handle();
    shifted.offset = 4;
    check_throws(ErrorCode::invalid_argument, {"request 1 of 2", "reaches from byte"}, [&] { plan_with(shifted); });
    shifted.offset = 2;
    shifted.strides = {4, 4, 4};
    check_throws(ErrorCode::invalid_argument, {"request 1 of 2", "no multiple"}, [&] { plan_with(shifted); });
    check_throws(ErrorCode::invalid_argument, {"request 1 of 2", "distance has no target"}, [&] { plan_with({}); });

    const std::vector<Request> one{{grid, band, {{Output::distance, memory.handle()}}}};
    Plan plan = transform.plan(one);
    const std::vector<Grid> two(2, grid);
    check_throws(ErrorCode::invalid_argument, {"1 requests", "2 grids"}, [&] { plan.update(transform, two); });
    // A move to grids that are refused changes nothing.
    const std::vector<Grid> larger(1, grid.grown(1));
    check_throws(ErrorCode::invalid_argument, {"output distance"}, [&] { plan.update(transform, larger); });
    BOOST_TEST((plan.requests().front().grid == grid));
    run(plan, nullptr);
    BOOST_TEST((memory.read(callers_queue()) == bits_of(transform.compute(grid, band).distance())));
    // One that fails later leaves nothing to enqueue, and the places as they were; the next one mends it.
    CallOptions stopped;
    stopped.should_stop = [calls = 0]() mutable { return ++calls > 1; };
    const std::vector<Grid> other(1, grid.block({1, 0, 0}, grid.size));
    check_throws(ErrorCode::cancelled, {}, [&] { plan.update(transform, other, stopped); });
    check_throws(ErrorCode::invalid_argument, {"last update failed"}, [&] { plan.enqueue(nullptr); });
    plan.update(transform);
    run(plan, nullptr);
    BOOST_TEST((memory.read(callers_queue()) == bits_of(transform.compute(grid, band).distance())));
}

BOOST_AUTO_TEST_CASE(memory_that_values_would_share_or_kernels_may_not_write_is_refused) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 12, 2);
    const Band band = Band::symmetric(2 * grid.voxel());
    std::vector<float> host(64 * grid.sample_count());
    OutputArray target(host);
    const auto check = [&](const char* what) {
        check_throws(ErrorCode::invalid_argument, {"output distance", what, "overlap"},
                     [&] { transform.compute(grid, band, target); });
    };
    target.strides = {8, 0, 0};
    check("along y");
    target.strides = {8, 8 * grid.size[0], 16};
    check("along z");
    const cl::Buffer read_only(context().context(), CL_MEM_READ_ONLY, host.size() * sizeof(float));
    const std::vector<Request> requests{{grid, band, {{Output::distance, OutputArray(read_only())}}}};
    check_throws(ErrorCode::invalid_argument, {"CL_MEM_READ_ONLY"}, [&] { transform.plan(requests); });
}
