#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"
#include "transform/runs.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

// Runs of plans and calls that wait for the caller's events: events that fail, that stay pending, and threads beside
// them.
namespace clsdf::test {
namespace {

/// False for Intel's runtime. It fails only the command that waits for the failed event, not the commands after it. If
/// a command of an out-of-order queue has failed, the queue's next command ends the process.
boost::test_tools::assertion_result takes_failing_events(boost::unit_test::test_unit_id) {
    const cl::Platform platform(device::context_of(test_device()).device().getInfo<CL_DEVICE_PLATFORM>());
    return platform.getInfo<CL_PLATFORM_NAME>().find("Intel(R) OpenCL") == std::string::npos;
}

}  // namespace

// A run that fails ends before those that it was to follow.
BOOST_AUTO_TEST_CASE(a_run_that_fails_hides_no_run_that_is_under_way,
                     *boost::unit_test::precondition(takes_failing_events)) {
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    cl::UserEvent pending(context.context()), failed(context.context());
    transform::Runs runs;
    const auto run_after = [&](const cl::Event& event) {
        scan::CommandChain chain(queue, {event});
        chain.then([](const auto& to, auto* wait, auto* end) { to.enqueueMarkerWithWaitList(wait, end); });
        queue.flush();
        runs.add(chain);
        return chain.last();
    };
    const cl::Event first = run_after(pending), second = run_after(failed);
    BOOST_TEST((runs.latest()() == second()));
    failed.setStatus(-1);
    BOOST_TEST((runs.latest()() == first()));
    std::atomic<bool> has_ended = false;
    std::thread device([&, pending]() mutable {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        has_ended = true;
        pending.setStatus(CL_COMPLETE);
    });
    BOOST_TEST(runs.wait() == CL_SUCCESS);
    BOOST_TEST(has_ended);
    device.join();
    BOOST_TEST((runs.latest()() == nullptr));
    // A failure is an end, too.
    cl::UserEvent fails(context.context());
    run_after(fails);
    fails.setStatus(-1);
    BOOST_TEST(runs.wait() == CL_SUCCESS);
}

// Commands of a failed run are listed in the events that they waited for and that are pending. If such an event ends
// when the commands' own events were released, PoCL 3.1 ends the process.
BOOST_AUTO_TEST_CASE(an_event_may_fail_while_others_of_its_wait_list_are_pending,
                     *boost::unit_test::precondition(takes_failing_events)) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    const Grid grid = grid_around(mesh, 24, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, grid.sample_count() * sizeof(float));
    const Request request{grid, band, {{Output::distance, memory()}}};
    const auto fail = [](cl::UserEvent& event) { event.setStatus(-1); };
    const auto end = [](cl::UserEvent& event) { event.setStatus(CL_COMPLETE); };
    for (const bool is_made_anew : {false, true}) {
        Plan plan = transform.plan(request);
        cl::UserEvent late(context.context()), failing(context.context());
        const std::array both{late(), failing()};
        const cl::Event failed(enqueue(plan, queue(), both));
        fail(failing);
        if (is_made_anew) plan = transform.plan(request);
        enqueue(plan, queue()).wait();
        end(late);
        enqueue(plan, queue()).wait();
        BOOST_TEST(failed.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() < 0);
    }
    {
        Plan plan = transform.plan(request);
        cl::UserEvent late(context.context()), failing(context.context());
        const std::array first{late()}, second{failing()};
        const cl::Event waits(enqueue(plan, queue(), first));
        enqueue(plan, queue(), second);
        fail(failing);
        const cl::Event third(enqueue(plan, queue()));
        end(late);
        third.wait();
    }
    cl::UserEvent late(context.context()), failing(context.context());
    const std::array both{late(), failing()};
    std::thread device([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        fail(failing);
    });
    BOOST_CHECK_THROW(transform.compute({&request, 1}, {.wait_list = both}), Error);
    device.join();
    end(late);
    transform.compute({&request, 1});
}

namespace {

/// Sets an event after some seconds, unless its test has done so: then a wait that should not be ends, too.
class Watchdog {
public:
    explicit Watchdog(cl::UserEvent event)
        : thread_([this, event]() mutable {
              for (int step = 0; step < 100 && !is_done_; ++step)
                  std::this_thread::sleep_for(std::chrono::milliseconds(100));
              if (is_done_) return;
              has_barked_ = true;
              event.setStatus(CL_COMPLETE);
          }) {}
    Watchdog(const Watchdog&) = delete;
    Watchdog& operator=(const Watchdog&) = delete;
    ~Watchdog() {
        is_done_ = true;
        thread_.join();
    }
    bool has_barked() const { return has_barked_; }

private:
    std::atomic<bool> is_done_ = false, has_barked_ = false;
    std::thread thread_;
};

}  // namespace

// The event of the run may be set by a thread that uses the transform first.
BOOST_AUTO_TEST_CASE(a_plan_that_waits_for_its_run_keeps_no_thread_from_the_transform) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device());
    const Grid grid = grid_around(mesh, 24, 3);
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, grid.sample_count() * sizeof(float));
    Plan plan = transform.plan(Request{grid, Band::symmetric(grid.voxel()), {{Output::distance, memory()}}});
    cl::UserEvent event(context.context());
    const std::array wait_list{event()};
    const cl::Event run(enqueue(plan, queue(), wait_list));
    const Watchdog watchdog(event);
    std::thread other([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        transform.memory();
        if (!watchdog.has_barked()) event.setStatus(CL_COMPLETE);
    });
    plan.update(transform);
    other.join();
    BOOST_TEST(!watchdog.has_barked());
    enqueue(plan, queue()).wait();
}

// A plan may outlive the transform, and keeps its positions.
BOOST_AUTO_TEST_CASE(a_transform_moves_and_ends_while_a_run_of_its_plan_waits) {
    const Mesh mesh = make_shape("sphere2");
    const device::Context& context = device::context_of(test_device());
    const Grid grid = grid_around(mesh, 24, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    std::vector<float> values(grid.sample_count());
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, values.size() * sizeof(float));
    auto transform = std::make_unique<DistanceTransform>(test_device(), mesh);
    const Field expected = transform->compute(grid, band);
    Plan plan = transform->plan(Request{grid, band, {{Output::distance, memory()}}});
    cl::UserEvent event(context.context());
    const std::array wait_list{event()};
    const cl::Event run(enqueue(plan, nullptr, wait_list));
    {
        const Watchdog watchdog(event);
        transform->set_positions(moved(mesh, [](const Vec3& v) {
                                     return Vec3{2 * v[0], 2 * v[1], 2 * v[2]};
                                 }).vertices());
        transform.reset();
        BOOST_TEST(!watchdog.has_barked());
    }
    event.setStatus(CL_COMPLETE);
    run.wait();
    context.callers_queue().enqueueReadBuffer(memory, CL_TRUE, 0, values.size() * sizeof(float), values.data());
    BOOST_TEST((bits_of(values) == bits_of(expected.distance())));
}

// The call before it compiles and prepares, so that this one waits for its event when that fails.
BOOST_AUTO_TEST_CASE(an_event_that_fails_during_a_call_is_an_error_of_the_call) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const device::Context& context = device::context_of(test_device());
    const Grid grid = grid_around(mesh, 24, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, grid.sample_count() * sizeof(float));
    const OutputTargets targets{{Output::distance, OutputArray(memory())}};
    transform.compute(grid, band, targets);
    cl::UserEvent event(context.context());
    std::thread failing([&] {
        std::this_thread::sleep_for(std::chrono::seconds(2));
        event.setStatus(-5);
    });
    check_throws(ErrorCode::device_failure, {}, [&] {
        const std::array wait_list{static_cast<cl_event>(event())};
        transform.compute(grid, band, targets, {.wait_list = wait_list});
    });
    failing.join();
}

// All commands of a run wait for the event, one after the other.
BOOST_AUTO_TEST_CASE(an_event_of_the_caller_that_fails_ends_the_run_and_nothing_else,
                     *boost::unit_test::precondition(takes_failing_events)) {
    const Mesh mesh = make_shape("sphere3");
    const DistanceTransform transform(test_device(), mesh);
    const device::Context& context = device::context_of(test_device());
    const Grid grid = grid_around(mesh, 40, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const Field expected = transform.compute(grid, band);
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, 2 * grid.sample_count() * sizeof(float));
    OutputArray spread(memory());
    spread.strides = {2 * sizeof(float), 0, 0};
    spread.strides[1] = spread.strides[0] * grid.size[0];
    spread.strides[2] = spread.strides[1] * grid.size[1];
    for (const OutputArray& target : {OutputArray(memory()), spread}) {
        Plan plan = transform.plan(std::vector<Request>{{grid, band, target}});
        cl::UserEvent gate(context.context());
        const std::array wait_list{gate()};
        const cl::Event failed(enqueue(plan, nullptr, wait_list)), after(enqueue(plan, nullptr));
        gate.setStatus(-5);
        for (const cl::Event& event : {failed, after}) {
            const cl_event handle = event();
            BOOST_TEST(clWaitForEvents(1, &handle) == CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST);
        }
        enqueue(plan, nullptr).wait();
        const std::size_t step = target.strides[0] == 0 ? 1 : 2;
        std::vector<float> values(step * grid.sample_count()), distance;
        context.callers_queue().enqueueReadBuffer(memory, CL_TRUE, 0, values.size() * sizeof(float), values.data());
        for (std::size_t i = 0; i < values.size(); i += step) distance.push_back(values[i]);
        BOOST_TEST((bits_of(distance) == bits_of(expected.distance())));
    }
}

}  // namespace clsdf::test
