#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};
constexpr std::array<cl_command_queue_properties, 2> queue_kinds{0, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE};

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

/// A queue of the caller's on the tests' device.
cl::CommandQueue callers_queue(cl_command_queue_properties properties = 0) {
    const device::Context& context = device::context_of(test_device());
    return {context.context(), context.device(), properties};
}

struct Memory {
    DeviceMemory distance{test_device().context(), grid().sample_count()};
    DeviceMemory triangle{test_device().context(), grid().sample_count()};

    OutputTargets outputs() const {
        return {{Output::distance, distance.handle()}, {Output::triangle, triangle.handle()}};
    }

    void check(const Field& expected, const cl::CommandQueue& queue) const {
        BOOST_TEST((distance.read(queue) == bits_of(expected.distance())));
        BOOST_TEST(std::ranges::equal(triangle.read(queue), expected.triangle()));
    }
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_plan_writes_the_field_into_the_callers_memory) {
    for (const KernelBody body : both_bodies) {
        const Field expected = compute(mesh(), grid(), band(), body);
        DistanceTransform transform(test_device(), mesh(), {.body = body});
        Plan plan = transform.plan(grid(), band(), Output::triangle);
        BOOST_TEST((plan.requests().front().grid == grid()));
        BOOST_TEST(name_of(plan.sign()) == "nonzero");
        for (const cl_command_queue_properties properties : queue_kinds)
            for (int run = 0; run < 2; ++run) {
                const Memory memory;
                const cl::CommandQueue queue = callers_queue(properties);
                enqueue(plan, queue(), memory.outputs()).wait();
                memory.check(expected, queue);
            }
        const Memory memory;
        enqueue(plan, nullptr, memory.outputs()).wait();
        memory.check(expected, callers_queue());
    }
}

BOOST_AUTO_TEST_CASE(a_plan_waits_for_the_callers_events) {
    const Field expected = compute(mesh(), grid(), band());
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band(), Output::triangle);
    for (const cl_command_queue_properties properties : queue_kinds) {
        const Memory memory;
        const cl::CommandQueue queue = callers_queue(properties);
        cl::UserEvent begin(device::context_of(test_device()).context());
        const cl_event wait_list[] = {begin()};
        // Returns although nothing can begin: it does not block.
        const cl::Event end(enqueue(plan, queue(), memory.outputs(), wait_list));
        std::this_thread::sleep_for(std::chrono::milliseconds(200));  // many times what the field takes
        BOOST_TEST(end.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
        BOOST_TEST(
            (memory.distance.read(callers_queue()) == std::vector<std::uint32_t>(grid().sample_count(), untouched)));
        begin.setStatus(CL_COMPLETE);
        end.wait();
        memory.check(expected, callers_queue());
    }
}

/// How many objects hold a queue: each event of its commands is one, with drivers that count them.
cl_uint holders_of(const cl::CommandQueue& queue) {
    return queue.getInfo<CL_QUEUE_REFERENCE_COUNT>();
}

BOOST_AUTO_TEST_CASE(a_run_whose_end_nobody_asks_for_leaves_no_event) {
    constexpr cl_uint runs = 50;
    const DistanceTransform transform(test_device(), mesh());
    const Memory memory;
    const cl::CommandQueue queue = callers_queue();
    const cl::UserEvent before(cl::Context(test_device().context(), true));
    cl::UserEvent(before).setStatus(CL_COMPLETE);
    const std::array<cl_event, 1> wait_list{before()};
    const auto enqueue_runs = [&](cl_event* done) {
        Plan plan = transform.plan({grid(), band(), memory.outputs()});
        for (cl_uint run = 0; run < runs; ++run) {
            plan.enqueue(queue(), wait_list, done == nullptr ? nullptr : done + 2 * run);
            plan.enqueue(queue(), memory.outputs(), {}, done == nullptr ? nullptr : done + 2 * run + 1);
        }
        queue.finish();
    };
    enqueue_runs(nullptr);
    // A driver may keep a few of the last ones.
    BOOST_TEST(holders_of(queue) < runs);
    BOOST_TEST(before.getInfo<CL_EVENT_REFERENCE_COUNT>() == 1U);
    // The events of the caller are seen.
    std::array<cl_event, 2 * runs> ends{};
    enqueue_runs(ends.data());
    if (holders_of(queue) < 2 * runs) BOOST_TEST_MESSAGE("skipped: the driver does not count the events of a queue");
    for (const cl_event end : ends) BOOST_TEST(clReleaseEvent(end) == CL_SUCCESS);
    BOOST_TEST(holders_of(queue) < runs);
}

// They share the plan's buffers: each waits for the one before, in any order of the queues.
BOOST_AUTO_TEST_CASE(computations_of_a_plan_follow_one_another) {
    for (const KernelBody body : both_bodies) {
        const Field expected = compute(mesh(), grid(), band(), body);
        DistanceTransform transform(test_device(), mesh(), {.body = body});
        Plan plan = transform.plan(grid(), band(), Output::triangle);
        const cl::CommandQueue out_of_order = callers_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
        const cl::CommandQueue in_order = callers_queue();
        const std::array<Memory, 4> memory;
        const std::array<cl_command_queue, 4> queues{out_of_order(), out_of_order(), in_order(), nullptr};
        std::array<cl::Event, 4> ended;
        for (std::size_t run = 0; run < ended.size(); ++run)
            ended[run] = enqueue(plan, queues[run], memory[run].outputs());
        for (std::size_t run = 0; run < ended.size(); ++run) {
            ended[run].wait();
            memory[run].check(expected, in_order);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_plan_outlives_its_transform) {
    const Field expected = compute(mesh(), grid(), band());
    std::optional<DistanceTransform> transform(std::in_place, test_device(), mesh());
    Plan first = transform->plan(grid(), band(), Output::triangle);
    Plan second = transform->plan(grid().part({3, 4, 5}, {20, 21, 22}), Band::full());
    transform.reset();
    Plan moved = std::move(first);
    const Memory memory;
    enqueue(moved, nullptr, memory.outputs()).wait();
    memory.check(expected, callers_queue());
    const DeviceMemory part(test_device().context(), second.requests().front().grid.sample_count());
    enqueue(second, nullptr, {{Output::distance, part.handle()}}).wait();
    BOOST_TEST((part.read(callers_queue()) ==
                bits_of(compute(mesh(), second.requests().front().grid, Band::full()).distance())));
}

// The plans of a transform keep their buffers to themselves.
BOOST_AUTO_TEST_CASE(plans_do_not_disturb_one_another) {
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band(), Output::triangle);
    Plan other = transform.plan(grid(), Band::full(), Output::triangle);
    const Field between = transform.compute(grid().part({0, 0, 0}, {30, 30, 30}), band());
    const Memory memory, other_memory;
    const cl::CommandQueue queue = callers_queue(), other_queue = callers_queue();
    const cl::Event ended = enqueue(plan, queue(), memory.outputs());
    enqueue(other, other_queue(), other_memory.outputs()).wait();
    ended.wait();
    memory.check(compute(mesh(), grid(), band()), queue);
    other_memory.check(compute(mesh(), grid(), Band::full()), queue);
    check_exact(mesh(), between);
}

BOOST_AUTO_TEST_CASE(memory_for_triangles_that_were_not_planned_is_refused) {
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band());
    const Memory memory;
    check_throws(ErrorCode::invalid_argument, {"triangle has a target", "make the plan with triangle"},
                 [&] { plan.enqueue(nullptr, memory.outputs()); });
    BOOST_TEST((memory.triangle.read(callers_queue()) == std::vector<std::uint32_t>(grid().sample_count(), untouched)));
}

BOOST_AUTO_TEST_CASE(memory_that_is_too_small_is_refused) {
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band());
    const cl::Buffer small(cl::Context(test_device().context(), true), CL_MEM_READ_WRITE, 16);
    check_throws(ErrorCode::invalid_argument, {"output distance", "16 bytes"}, [&] {
        plan.enqueue(nullptr, {{Output::distance, small()}});
    });
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

BOOST_AUTO_TEST_CASE(memory_that_is_missing_is_an_error) {
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band(), Output::triangle);
    const Memory memory;
    check_throws(ErrorCode::invalid_argument, {"distance has no target"},
                 [&] { plan.enqueue(nullptr, OutputTargets{}); });
    check_throws(ErrorCode::invalid_argument, {"triangle has no target"}, [&] {
        plan.enqueue(nullptr, {{Output::distance, memory.distance.handle()}});
    });
}
