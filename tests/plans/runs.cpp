#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"
#include "support/two_boxes.hpp"

#include "device/context.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

// Runs of plans and calls, and the caller's events: in what order they end, events that fail, that stay pending, and
// threads beside them.
namespace clsdf::test {
namespace {

/// False for Intel's runtime. It fails only the command that waits for the failed event, not the commands after it. If
/// a command of an out-of-order queue has failed, the queue's next command ends the process.
boost::test_tools::assertion_result takes_failing_events(boost::unit_test::test_unit_id) {
    const cl::Platform platform(device::context_of(test_device()).device().getInfo<CL_DEVICE_PLATFORM>());
    return platform.getInfo<CL_PLATFORM_NAME>().find("Intel(R) OpenCL") == std::string::npos;
}

cl::CommandQueue callers_queue(cl_command_queue_properties properties = 0) {
    const device::Context& context = device::context_of(test_device());
    return {context.context(), context.device(), properties};
}

}  // namespace

BOOST_AUTO_TEST_CASE(runs_begin_after_the_callers_events_and_follow_one_another) {
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 40, 4);
    const cl::CommandQueue in_order = callers_queue(),
                           out_of_order = callers_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    for (const bool is_in_order : {true, false}) {
        const TwoBoxes boxes(grid);
        const std::vector<Request> requests = boxes.requests();
        Plan of_boxes = transform.plan(requests), of_grid = transform.plan(grid, requests[0].band);
        cl::UserEvent gate(cl::Context(test_device().context(), true));
        const std::array wait_list{gate()};
        const cl_command_queue queue = is_in_order ? in_order() : out_of_order();
        // They return although nothing can begin.
        const cl::Event first = enqueue(of_boxes, queue, wait_list), second = enqueue(of_boxes, out_of_order()),
                        third = enqueue(of_boxes, in_order());
        const DeviceMemory distance(test_device().context(), grid.sample_count());
        const cl::Event alone = enqueue(of_grid, queue, distance.handle(), wait_list);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));  // many times what the fields take
        for (const cl::Event* event : {&first, &second, &third, &alone})
            BOOST_TEST(event->getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
        if (!is_in_order) BOOST_TEST((distance.read(callers_queue()).front() == untouched));
        gate.setStatus(CL_COMPLETE);
        third.wait();
        BOOST_TEST(first.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() == CL_COMPLETE);
        BOOST_TEST(boxes.have_fields_of(transform));
        alone.wait();
        BOOST_TEST((distance.read(callers_queue()) == bits_of(transform.compute(grid, requests[0].band).distance())));
    }
}

BOOST_AUTO_TEST_CASE(a_call_for_device_memory_begins_after_the_callers_events) {
    const Mesh mesh = make_shape("knot");
    const DistanceTransform transform(test_device(), mesh);
    const TwoBoxes boxes(grid_around(mesh, 40, 4));
    const std::vector<Request> requests = boxes.requests();
    const cl::Context context(test_device().context(), true);
    for (const bool one_by_one : {false, true}) {
        const cl::UserEvent gate(context);
        const std::array wait_list{gate()};
        std::atomic<bool> is_open = false;
        std::thread opener([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            is_open = true;
            cl::UserEvent(gate).setStatus(CL_COMPLETE);
        });
        if (one_by_one)
            transform.compute(requests[0].grid, requests[0].band, requests[0].targets, {.wait_list = wait_list});
        else
            transform.compute(requests, {.wait_list = wait_list});
        BOOST_TEST(is_open.load());
        opener.join();
        BOOST_TEST(boxes.have_fields_of(transform));
    }
    // One for the host waits for them, too.
    const cl::UserEvent failed(context);
    cl::UserEvent(failed).setStatus(-5);
    const std::array wait_list{failed()};
    std::vector<float> distance(requests[0].grid.sample_count());
    check_throws(ErrorCode::device_failure, {},
                 [&] { transform.compute(requests[0].grid, requests[0].band, distance, {.wait_list = wait_list}); });
}

BOOST_AUTO_TEST_CASE(a_plan_without_requests_waits_for_the_callers_events) {
    const DistanceTransform transform(test_device(), make_shape("tetrahedron"));
    Plan plan = transform.plan(std::span<const Request>());
    const cl::UserEvent before(cl::Context(test_device().context(), true));
    const cl_event event = before();
    const cl::CommandQueue queue = callers_queue();
    const cl::Event end(enqueue(plan, queue(), {&event, 1}));
    BOOST_TEST(end.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
    cl::UserEvent(before).setStatus(CL_COMPLETE);
    end.wait();
}

namespace {

/// How many objects hold a queue: each event of its commands is one, with drivers that count them.
cl_uint holders_of(const cl::CommandQueue& queue) {
    return queue.getInfo<CL_QUEUE_REFERENCE_COUNT>();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_run_whose_end_nobody_asks_for_leaves_no_event) {
    constexpr cl_uint runs = 50;
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const TwoBoxes boxes(grid_around(mesh, 24, 3));
    const cl::CommandQueue queue = callers_queue();
    const cl::UserEvent before(cl::Context(test_device().context(), true));
    cl::UserEvent(before).setStatus(CL_COMPLETE);
    const std::array<cl_event, 1> wait_list{before()};
    const auto enqueue_runs = [&](cl_event* done) {
        Plan plan = transform.plan(boxes.requests());
        for (cl_uint run = 0; run < runs; ++run) {
            plan.enqueue(queue(), wait_list, done == nullptr ? nullptr : done + 2 * run);
            plan.enqueue(queue(), boxes.targets(), {}, done == nullptr ? nullptr : done + 2 * run + 1);
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

// A run that fails ends before those that it was to follow.
BOOST_AUTO_TEST_CASE(a_run_that_fails_hides_no_run_that_is_under_way,
                     *boost::unit_test::precondition(takes_failing_events)) {
    const DistanceTransform transform(test_device(), make_shape("sphere2"));
    const cl::Context context(test_device().context(), true);
    const TwoBoxes boxes(grid_around(make_shape("sphere2"), 24, 3));
    const cl::CommandQueue queue = callers_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    for (const bool is_updated : {true, false}) {
        std::optional<Plan> plan(transform.plan(boxes.requests()));
        cl::UserEvent pending(context), failed(context);
        const std::array first{pending()}, second{failed()};
        const cl::Event end = enqueue(*plan, queue(), first);
        plan->enqueue(queue(), second);
        failed.setStatus(-1);
        std::atomic<bool> has_begun = false;
        std::thread device([&, pending]() mutable {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            has_begun = true;
            pending.setStatus(CL_COMPLETE);
        });
        // Both wait for what is under way.
        is_updated ? plan->update(transform) : plan.reset();
        BOOST_TEST(has_begun);
        device.join();
        BOOST_TEST(end.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() == CL_COMPLETE);
        BOOST_TEST(boxes.have_fields_of(transform));
    }
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

// A command that fails takes those behind it in its queue along.
BOOST_AUTO_TEST_CASE(a_call_behind_a_run_that_fails_is_computed,
                     *boost::unit_test::precondition(takes_failing_events)) {
    const Mesh mesh = make_shape("sphere3");
    DistanceTransform transform(test_device(), mesh);
    const device::Context& context = device::context_of(test_device());
    const Grid grid = grid_around(mesh, 40, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const Field expected = transform.compute(grid, band);
    const std::vector<Vec3>& points = mesh.vertices();
    const auto distances = [&] {
        std::vector<float> values(points.size());
        transform.query(points, 1, {{Output::distance, values}});
        return values;
    };
    const std::vector<float> expected_distances = distances();
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, grid.sample_count() * sizeof(float));
    Plan plan = transform.plan(Request{grid, band, OutputArray(memory())});
    const auto is_kept = [&] { return same_bytes(transform.compute(grid, band), expected); };
    const auto is_made_anew = [&] {
        transform.set_motion({{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {});
        return is_kept();
    };
    const auto is_answered = [&] { return distances() == expected_distances; };
    for (const std::function<bool()>& is_right : {std::function(is_kept), std::function(is_made_anew),
                                                  std::function(is_made_anew), std::function(is_answered)}) {
        cl::UserEvent gate(context.context());
        const std::array wait_list{gate()};
        const cl::Event failed(enqueue(plan, nullptr, wait_list));
        std::thread device([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
            gate.setStatus(-5);
        });
        BOOST_TEST(is_right());
        device.join();
        BOOST_TEST(failed.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() < 0);
        BOOST_TEST(is_right());
    }
}

BOOST_AUTO_TEST_CASE(a_run_that_fails_stores_nothing_and_the_next_one_has_its_own_targets,
                     *boost::unit_test::precondition(takes_failing_events)) {
    const Mesh mesh = make_shape("sphere3");
    const DistanceTransform transform(test_device(), mesh);
    const TwoBoxes planned(grid_around(mesh, 40, 3)), other(grid_around(mesh, 40, 3));
    Plan plan = transform.plan(planned.requests());
    const cl::CommandQueue queue = callers_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    cl::UserEvent gate(cl::Context(test_device().context(), true));
    const std::array wait_list{gate()};
    const cl::Event failed = enqueue(plan, queue(), other.targets(), wait_list);
    gate.setStatus(-5);
    const cl_event handle = failed();
    BOOST_TEST(clWaitForEvents(1, &handle) == CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST);
    check_throws(ErrorCode::device_failure, {"event 0 of the wait list's 1 has failed"},
                 [&] { plan.enqueue(queue(), wait_list); });
    BOOST_TEST(other.are_untouched());
    enqueue(plan, queue()).wait();
    BOOST_TEST(planned.have_fields_of(transform));
    BOOST_TEST(other.are_untouched());
    enqueue(plan, queue(), other.targets()).wait();
    BOOST_TEST(other.have_fields_of(transform));
}

}  // namespace clsdf::test
