#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

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

    OutputTargets outputs() const { return {distance.handle(), triangle.handle()}; }

    void check(const Field& expected, const cl::CommandQueue& queue) const {
        BOOST_TEST((distance.read(queue) == bits_of(expected.distance)));
        BOOST_TEST(std::ranges::equal(triangle.read(queue), expected.triangle));
    }
};

void wait_and_release(cl_event event) {
    const cl::Event owned(event);
    owned.wait();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_plan_writes_the_field_into_the_callers_memory) {
    for (const KernelBody body : both_bodies) {
        const Field expected = compute(mesh(), grid(), band(), body);
        DistanceTransform transform(test_device(), mesh(), {.body = body});
        Plan plan = transform.plan(grid(), band(), {.triangle = true});
        BOOST_TEST((plan.requests().front().grid == grid()));
        BOOST_TEST(name_of(plan.sign()) == "nonzero");
        for (const cl_command_queue_properties properties : queue_kinds)
            for (int run = 0; run < 2; ++run) {
                const Memory memory;
                const cl::CommandQueue queue = callers_queue(properties);
                wait_and_release(plan.enqueue(queue(), memory.outputs()));
                memory.check(expected, queue);
            }
        const Memory memory;
        wait_and_release(plan.enqueue(nullptr, memory.outputs()));
        memory.check(expected, callers_queue());
    }
}

BOOST_AUTO_TEST_CASE(a_plan_waits_for_the_callers_events) {
    const Field expected = compute(mesh(), grid(), band());
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band(), {.triangle = true});
    for (const cl_command_queue_properties properties : queue_kinds) {
        const Memory memory;
        const cl::CommandQueue queue = callers_queue(properties);
        cl::UserEvent begin(device::context_of(test_device()).context());
        const cl_event wait_list[] = {begin()};
        // Returns although nothing can begin: it does not block.
        const cl::Event end(plan.enqueue(queue(), memory.outputs(), wait_list));
        std::this_thread::sleep_for(std::chrono::milliseconds(200));  // many times what the field takes
        BOOST_TEST(end.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
        BOOST_TEST(
            (memory.distance.read(callers_queue()) == std::vector<std::uint32_t>(grid().sample_count(), untouched)));
        begin.setStatus(CL_COMPLETE);
        end.wait();
        memory.check(expected, callers_queue());
    }
}

// They share the plan's buffers: each waits for the one before, in any order of the queues.
BOOST_AUTO_TEST_CASE(computations_of_a_plan_follow_one_another) {
    for (const KernelBody body : both_bodies) {
        const Field expected = compute(mesh(), grid(), band(), body);
        DistanceTransform transform(test_device(), mesh(), {.body = body});
        Plan plan = transform.plan(grid(), band(), {.triangle = true});
        const cl::CommandQueue out_of_order = callers_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
        const cl::CommandQueue in_order = callers_queue();
        const std::array<Memory, 4> memory;
        const std::array<cl_command_queue, 4> queues{out_of_order(), out_of_order(), in_order(), nullptr};
        std::array<cl_event, 4> ended{};
        for (std::size_t run = 0; run < ended.size(); ++run)
            ended[run] = plan.enqueue(queues[run], memory[run].outputs());
        for (std::size_t run = 0; run < ended.size(); ++run) {
            wait_and_release(ended[run]);
            memory[run].check(expected, in_order);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_plan_outlives_its_transform) {
    const Field expected = compute(mesh(), grid(), band());
    std::optional<DistanceTransform> transform(std::in_place, test_device(), mesh());
    Plan first = transform->plan(grid(), band(), {.triangle = true});
    Plan second = transform->plan(grid().part({3, 4, 5}, {20, 21, 22}), Band::full());
    transform.reset();
    Plan moved = std::move(first);
    const Memory memory;
    wait_and_release(moved.enqueue(nullptr, memory.outputs()));
    memory.check(expected, callers_queue());
    const DeviceMemory part(test_device().context(), second.requests().front().grid.sample_count());
    wait_and_release(second.enqueue(nullptr, {.distance = part.handle()}));
    BOOST_TEST((part.read(callers_queue()) ==
                bits_of(compute(mesh(), second.requests().front().grid, Band::full()).distance)));
}

// The plans of a transform keep their buffers to themselves.
BOOST_AUTO_TEST_CASE(plans_do_not_disturb_one_another) {
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band(), {.triangle = true});
    Plan other = transform.plan(grid(), Band::full(), {.triangle = true});
    const Field between = transform(grid().part({0, 0, 0}, {30, 30, 30}), band());
    const Memory memory, other_memory;
    const cl::CommandQueue queue = callers_queue(), other_queue = callers_queue();
    cl_event ended = plan.enqueue(queue(), memory.outputs());
    wait_and_release(other.enqueue(other_queue(), other_memory.outputs()));
    wait_and_release(ended);
    memory.check(compute(mesh(), grid(), band()), queue);
    other_memory.check(compute(mesh(), grid(), Band::full()), queue);
    check_exact(mesh(), between);
}

BOOST_AUTO_TEST_CASE(memory_for_triangles_that_were_not_planned_is_refused) {
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band());
    const Memory memory;
    check_throws(ErrorCode::invalid_argument, {"triangle has a target", "Outputs{.triangle = true}"},
                 [&] { plan.enqueue(nullptr, memory.outputs()); });
    BOOST_TEST((memory.triangle.read(callers_queue()) == std::vector<std::uint32_t>(grid().sample_count(), untouched)));
}

BOOST_AUTO_TEST_CASE(memory_that_is_too_small_is_refused) {
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band());
    const cl::Buffer small(cl::Context(test_device().context(), true), CL_MEM_READ_WRITE, 16);
    check_throws(ErrorCode::invalid_argument, {"output distance", "16 bytes"},
                 [&] { plan.enqueue(nullptr, {.distance = small()}); });
}

BOOST_AUTO_TEST_CASE(a_plan_that_ends_early_keeps_its_memory_until_its_work_is_done) {
    DistanceTransform transform(test_device(), mesh());
    const Memory memory, expected;
    Plan first = transform.plan(grid(), band(), {.triangle = true});
    wait_and_release(first.enqueue(nullptr, expected.outputs()));
    cl::UserEvent gate(cl::Context(test_device().context(), true));
    const std::array<cl_event, 1> wait_list{gate()};
    std::thread opener([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        gate.setStatus(CL_COMPLETE);
    });
    cl_event end = nullptr;
    {
        Plan plan = transform.plan(grid(), band(), {.triangle = true});
        end = plan.enqueue(nullptr, memory.outputs(), wait_list);
    }
    const Plan other = transform.plan(grid(), Band::symmetric(0.5 * band().outside));
    wait_and_release(end);
    opener.join();
    BOOST_TEST((memory.triangle.read(callers_queue()) == expected.triangle.read(callers_queue())));
}

BOOST_AUTO_TEST_CASE(memory_that_is_missing_is_an_error) {
    DistanceTransform transform(test_device(), mesh());
    Plan plan = transform.plan(grid(), band(), {.triangle = true});
    const Memory memory;
    check_throws(ErrorCode::invalid_argument, {"distance has no target"},
                 [&] { plan.enqueue(nullptr, OutputTargets{}); });
    check_throws(ErrorCode::invalid_argument, {"triangle has no target"},
                 [&] { plan.enqueue(nullptr, {.distance = memory.distance.handle()}); });
}
