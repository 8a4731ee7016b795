#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <optional>
#include <thread>

// Plans of many boxes, into the caller's device memory: the bytes of compute(), run after run.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};
constexpr unsigned char blank = 0xAB;

const device::Context& context() {
    return device::context_of(test_device());
}
cl::CommandQueue callers_queue(cl_command_queue_properties properties = 0, const Device& device = test_device()) {
    return {device::context_of(device).context(), device::context_of(device).device(), properties};
}

/// A target in a buffer of its own, with room before and between the samples, and the bytes it should hold.
class Target {
public:
    Target(const Device& device, const Grid& grid, std::size_t components, std::size_t element, Random& random)
        : element_(element) {
        const auto width = static_cast<std::ptrdiff_t>(element);
        const bool is_packed = random.index(3) == 0, is_turned = random.index(2) == 0;
        const auto pad = [&] { return is_packed ? 0 : static_cast<std::ptrdiff_t>(random.index(3)); };
        // Samples, or components, lie side by side; z or x runs fastest.
        const bool is_split = components > 1 && !is_packed && is_turned;
        std::ptrdiff_t stride = width * (is_split ? 1 : static_cast<std::ptrdiff_t>(components)) + width * pad();
        const std::array<std::size_t, 3> order =
            is_turned && !is_packed ? std::array<std::size_t, 3>{2, 1, 0} : std::array<std::size_t, 3>{0, 1, 2};
        for (const std::size_t axis : order) {
            target.strides[axis] = stride;
            stride = stride * grid.size[axis] + width * pad();
        }
        target.component_stride = is_split ? stride : width;
        target.offset = is_packed ? 0 : element * (1 + random.index(50));
        const std::size_t bytes =
            target.offset + static_cast<std::size_t>(stride) * (is_split ? components : 1) + 16 * element;
        expected.assign(bytes, blank);
        memory_ = cl::Buffer(device::context_of(device).context(), CL_MEM_READ_WRITE, bytes);
        target.device = memory_();
        components_ = components;
    }

    /// doubles: the distances in double.
    void expect(const Field& field, std::span<const double> doubles, const OutputInfo& info) {
        const bool in_double = element_ != bytes_of(info.type);
        expect_elements(field.grid, in_double ? std::as_bytes(doubles) : field.bytes(info.output));
    }

    void expect_elements(const Grid& grid, std::span<const std::byte> values) {
        BOOST_REQUIRE(values.size() == grid.sample_count() * components_ * element_);
        std::fill(expected.begin(), expected.end(), blank);
        std::size_t n = 0;
        for (std::int64_t z = 0; z < grid.size[2]; ++z)
            for (std::int64_t y = 0; y < grid.size[1]; ++y)
                for (std::int64_t x = 0; x < grid.size[0]; ++x)
                    for (std::size_t c = 0; c < components_; ++c, ++n)
                        std::memcpy(expected.data() + target.offset + x * target.strides[0] + y * target.strides[1] +
                                        z * target.strides[2] +
                                        static_cast<std::ptrdiff_t>(c) * target.component_stride,
                                    &values[n * element_], element_);
    }

    void clear(const cl::CommandQueue& queue) const {
        queue.enqueueFillBuffer(memory_, blank, 0, expected.size());
        queue.finish();
    }
    bool is_right(const cl::CommandQueue& queue) const {
        std::vector<unsigned char> bytes(expected.size());
        queue.enqueueReadBuffer(memory_, CL_TRUE, 0, bytes.size(), bytes.data());
        return bytes == expected;
    }

    OutputArray target;
    std::vector<unsigned char> expected;

private:
    cl::Buffer memory_;
    std::size_t element_;
    std::size_t components_;
};

/// The distance, and the others that are asked for.
std::vector<OutputInfo> infos_of(OutputSet outputs) {
    std::vector<OutputInfo> infos;
    for (const OutputInfo& info : output_table())
        if (info.output == Output::distance || outputs.contains(info.output)) infos.push_back(info);
    return infos;
}

/// Boxes with their targets.
struct Boxes {
    struct Box {
        Grid grid;
        Band band;
        OutputSet outputs;
        std::vector<Target> targets;  // distance, then those of the outputs

        bool has_elements_of(const Box& other) const {
            return targets.front().target.type == other.targets.front().target.type;
        }
    };
    std::vector<Box> boxes;
    Device device = test_device();

    void add(const Grid& grid, const Band& band, OutputSet outputs, Random& random) {
        Box box{grid, band, outputs, {}};
        const bool in_double = random.index(3) == 0;
        for (const OutputInfo& info : infos_of(outputs)) {
            const bool has_doubles = in_double && info.output == Output::distance;
            Target& target = box.targets.emplace_back(device, grid, info.components,
                                                      has_doubles ? sizeof(double) : bytes_of(info.type), random);
            if (has_doubles) target.target.type = ElementType::float64;
        }
        boxes.push_back(std::move(box));
    }

    std::vector<Request> requests() const {
        std::vector<Request> result;
        for (const Box& box : boxes) {
            OutputTargets targets;
            std::size_t n = 0;
            for (const OutputInfo& info : infos_of(box.outputs)) targets[info.output] = box.targets[n++].target;
            result.push_back({box.grid, box.band, targets});
        }
        return result;
    }

    /// The same boxes with targets of the same elements in other memory, at other places in it.
    Boxes elsewhere(Random& random) const {
        Boxes others{{}, device};
        for (const Box& box : boxes) do {
                if (others.boxes.size() > static_cast<std::size_t>(&box - boxes.data())) others.boxes.pop_back();
                others.add(box.grid, box.band, box.outputs, random);
            } while (!others.boxes.back().has_elements_of(box));
        return others;
    }

    std::vector<OutputTargets> targets() const {
        std::vector<OutputTargets> all;
        for (const Request& request : requests()) all.push_back(request.targets);
        return all;
    }

    void expect(const DistanceTransform& transform) {
        for (Box& box : boxes) {
            const Field field = transform.compute(box.grid, box.band, box.outputs);
            std::vector<double> doubles(box.grid.sample_count());
            transform.compute(box.grid, box.band, doubles);
            std::size_t n = 0;
            for (const OutputInfo& info : infos_of(box.outputs)) box.targets[n++].expect(field, doubles, info);
        }
    }

    void clear() const {
        const cl::CommandQueue queue = callers_queue(0, device);
        for (const Box& box : boxes)
            for (const Target& target : box.targets) target.clear(queue);
    }
    void check() const {
        const cl::CommandQueue queue = callers_queue(0, device);
        for (std::size_t n = 0; n < boxes.size(); ++n)
            for (std::size_t t = 0; t < boxes[n].targets.size(); ++t)
                BOOST_TEST_CONTEXT("request " << n << ", target " << t)
        BOOST_TEST(boxes[n].targets[t].is_right(queue));
    }
};

Boxes boxes_of_three_levels(const Mesh& mesh, Random& random) {
    const Grid coarse = grid_around(mesh, 40, 4);
    Boxes boxes;
    for (int n = 0; n < 24; ++n) {
        const Grid level = n % 3 == 0 ? coarse : n % 3 == 1 ? coarse.refined(2) : coarse.refined_cells(4);
        Index3 first{}, size{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            size[axis] = 1 + static_cast<std::int64_t>(random.index(24));
            first[axis] = level.first[axis] - 8 +
                          static_cast<std::int64_t>(random.index(static_cast<std::size_t>(level.size[axis]) + 8));
        }
        OutputSet outputs;
        if (n % 4 == 0) outputs = Output::triangle | Output::site;
        if (n % 8 == 0) outputs = all_outputs();
        boxes.add(level.block(first, size), Band::symmetric(3 * level.voxel()), outputs, random);
    }
    return boxes;
}

void run(Plan& plan, cl_command_queue queue) {
    const cl::Event end(enqueue(plan, queue));
    end.wait();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_plan_of_boxes_writes_the_bytes_of_calls_of_their_own) {
    constexpr std::uint64_t seed = 20261123;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = make_shape("knot");
    for (const KernelBody body : both_bodies) {
        const DistanceTransform transform(test_device(), mesh, {.body = body});
        Boxes boxes = boxes_of_three_levels(mesh, random);
        boxes.expect(transform);
        Plan plan = transform.plan(boxes.requests());
        BOOST_TEST(plan.requests().size() == boxes.boxes.size());
        for (const cl_command_queue_properties properties : {0U, unsigned{CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE}}) {
            const cl::CommandQueue queue = callers_queue(properties);
            for (int turn = 0; turn < 2; ++turn) {
                boxes.clear();
                run(plan, queue());
                boxes.check();
            }
        }
        // The same by a call.
        boxes.clear();
        transform.compute(boxes.requests());
        boxes.check();
    }
}

// Packed and with strides, from any offset; on a device with little memory the box is computed in several blocks.
BOOST_AUTO_TEST_CASE(a_plan_of_one_request_takes_other_targets_from_run_to_run) {
    constexpr std::uint64_t seed = 20261122;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = make_shape("knot");
    const Grid grid = grid_around(mesh, 100, 4);
    const Band band = Band::symmetric(3 * grid.voxel());
    for (const KernelBody body : both_bodies)
        for (const bool is_small : {false, true}) {
            const OutputSet outputs = is_small ? Output::triangle | Output::site : all_outputs();
            const Device device = is_small ? test_device().limited({.memory = std::size_t{6} << 20}) : test_device();
            const DistanceTransform transform(device, mesh, {.body = body});
            Boxes first{{}, device}, others{{}, device};
            while (first.boxes.empty() || first.boxes.front().targets.front().target.offset == 0) {
                first.boxes.clear();
                first.add(grid, band, outputs, random);
            }
            while (others.boxes.size() < 3) {
                others.add(grid, band, outputs, random);
                if (!others.boxes.back().has_elements_of(first.boxes.front())) others.boxes.pop_back();
            }
            others.boxes.insert(others.boxes.begin(), first.boxes.front());
            others.expect(DistanceTransform(test_device(), mesh, {.body = body}));
            others.clear();
            const std::vector<Request> requests = others.requests();
            Plan plan = transform.plan(requests.front());
            BOOST_TEST((plan.statistics().slabs > 1) == is_small);
            const cl::CommandQueue queue = callers_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, device);
            std::vector<cl::Event> ends;
            for (const Request& request : requests) ends.emplace_back(enqueue(plan, queue(), request.targets));
            cl::Event::waitForEvents(ends);
            others.check();
        }
}

// Codes that keep the old and the new state of a step swap two sets of arrays.
BOOST_AUTO_TEST_CASE(a_plan_of_boxes_takes_other_targets_from_run_to_run) {
    constexpr std::uint64_t seed = 20261124;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = make_shape("knot");
    for (const KernelBody body : both_bodies) {
        DistanceTransform transform(test_device(), mesh, {.body = body});
        Boxes planned = boxes_of_three_levels(mesh, random);
        // All are copied: a box that is computed in place takes packed targets only.
        for (Boxes::Box& box : planned.boxes)
            while (box.targets.front().target.offset == 0) {
                Boxes again{{}, planned.device};
                again.add(box.grid, box.band, box.outputs, random);
                box = again.boxes.front();
            }
        Boxes other = planned.elsewhere(random);
        Plan plan = transform.plan(planned.requests());
        const cl::CommandQueue queue = callers_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
        for (int turn = 0; turn < 2; ++turn) {
            for (Boxes* boxes : {&planned, &other}) {
                boxes->expect(transform);
                boxes->clear();
            }
            // Both are under way at once.
            const cl::Event first(enqueue(plan, queue(), other.targets()));
            const cl::Event second(enqueue(plan, queue()));
            cl::Event::waitForEvents({first, second});
            other.check();
            planned.check();
            std::vector<Vec3> positions = mesh.vertices();
            for (Vec3& p : positions) p[0] += 0.1 * p[1];
            transform.set_positions(positions);
            plan.update(transform);
        }

        // A run that fails stores nothing, and leaves no place behind for the next one.
        cl::UserEvent gate(context().context());
        const std::array wait_list{gate()};
        const cl::Event failed(enqueue(plan, queue(), other.targets(), wait_list));
        gate.setStatus(-5);
        const cl_event handle = failed();
        BOOST_TEST(clWaitForEvents(1, &handle) == CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST);
        check_throws(ErrorCode::device_failure, {"event 0 of the wait list's 1 has failed"},
                     [&] { plan.enqueue(queue(), wait_list); });
        for (Boxes* boxes : {&other, &planned}) {
            boxes->clear();
            boxes->expect(transform);
        }
        enqueue(plan, queue(), other.targets()).wait();
        other.check();
        run(plan, queue());
        planned.check();
    }
}

BOOST_AUTO_TEST_CASE(a_plan_of_a_grid_moves_and_takes_its_targets_from_run_to_run) {
    const Mesh mesh = make_shape("knot");
    DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 40, 4);
    const Band band = Band::symmetric(3 * grid.voxel());
    Plan plan = transform.plan(grid, band, Output::triangle);
    check_throws(ErrorCode::invalid_argument, {"has no targets", "give this run targets"},
                 [&] { plan.enqueue(nullptr); });
    std::vector<Vec3> positions = mesh.vertices();
    for (Vec3& p : positions) p = {p[0], 1.1 * p[1], p[2] + 0.2 * p[0]};
    transform.set_positions(positions);
    const std::array places{grid.block({5, -3, 2}, grid.size).grown(1)};
    plan.update(transform, places);
    BOOST_TEST((plan.requests().front().grid == places.front()));
    const DeviceMemory distance(test_device().context(), places.front().sample_count()),
        triangle(test_device().context(), places.front().sample_count());
    enqueue(plan, nullptr, {{Output::distance, distance.handle()}, {Output::triangle, triangle.handle()}}).wait();
    const Field expected = transform.compute(places.front(), band, Output::triangle);
    BOOST_TEST((distance.read(callers_queue()) == bits_of(expected.distance())));
    BOOST_TEST(std::ranges::equal(triangle.read(callers_queue()), expected.triangle()));
    // With targets of its own from now on.
    plan.update(transform, std::vector<Request>{{grid, band, {{Output::distance, distance.handle()}}}});
    run(plan, nullptr);
    std::vector<std::uint32_t> bits = distance.read(callers_queue());
    bits.resize(grid.sample_count());
    BOOST_TEST((bits == bits_of(transform.compute(grid, band).distance())));
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

BOOST_AUTO_TEST_CASE(runs_of_a_plan_of_boxes_follow_one_another_and_the_callers_events) {
    Random random(3);
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    Boxes boxes = boxes_of_three_levels(mesh, random);
    boxes.expect(transform);
    Plan plan = transform.plan(boxes.requests());
    boxes.clear();
    const cl::CommandQueue out_of_order = callers_queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE),
                           in_order = callers_queue();
    cl::UserEvent gate(context().context());
    const cl_event wait_list[] = {gate()};
    const cl::Event first(enqueue(plan, out_of_order(), wait_list));
    // They return although nothing can begin.
    const cl::Event second(enqueue(plan, out_of_order())), third(enqueue(plan, in_order()));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    for (const cl::Event* event : {&first, &second, &third})
        BOOST_TEST(event->getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
    gate.setStatus(CL_COMPLETE);
    third.wait();
    BOOST_TEST(first.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() == CL_COMPLETE);
    boxes.check();
}

BOOST_AUTO_TEST_CASE(a_plan_of_boxes_moves_with_the_vertices_and_to_other_places) {
    Random random(4);
    const Mesh mesh = make_shape("knot");
    DistanceTransform transform(test_device(), mesh);
    Boxes boxes = boxes_of_three_levels(mesh, random);
    Plan plan = transform.plan(boxes.requests());
    std::vector<Vec3> positions = mesh.vertices();
    for (Vec3& p : positions) p = {1.1 * p[0] + 0.1, p[1] - 0.05 * p[0], 0.9 * p[2]};
    transform.set_positions(positions);
    // Until it is moved, the plan has the positions it was made with.
    boxes.expect(DistanceTransform(test_device(), mesh));
    boxes.clear();
    run(plan, nullptr);
    boxes.check();
    plan.update(transform);
    boxes.expect(transform);
    boxes.clear();
    run(plan, nullptr);
    boxes.check();

    std::vector<Grid> places;
    for (Boxes::Box& box : boxes.boxes) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            box.grid.first[axis] += static_cast<std::int64_t>(random.index(20));
        places.push_back(box.grid);
    }
    plan.update(transform, places);
    boxes.expect(transform);
    boxes.clear();
    run(plan, nullptr);
    boxes.check();
    BOOST_TEST((plan.requests().front().grid == places.front()));
}

BOOST_AUTO_TEST_CASE(a_plan_of_boxes_moves_to_any_number_of_other_boxes) {
    Random random(14);
    const Mesh mesh = make_shape("knot");
    const DistanceTransform transform(test_device(), mesh);
    Boxes few = boxes_of_three_levels(mesh, random), many = boxes_of_three_levels(mesh, random);
    few.boxes.resize(5);
    for (Boxes* boxes : {&few, &many}) boxes->expect(transform);
    Plan plan = transform.plan(few.requests());
    for (const Boxes* boxes : {&many, &few, &many}) {
        plan.update(transform, boxes->requests());
        BOOST_TEST(plan.requests().size() == boxes->boxes.size());
        boxes->clear();
        run(plan, nullptr);
        boxes->check();
    }
    plan.update(transform, std::span<const Request>());
    BOOST_TEST(plan.requests().empty());
    few.clear();
    run(plan, nullptr);
    const Device other = one_compute_unit();
    const DistanceTransform of_other(other, mesh);
    if (device::context_of(other).context()() != context().context()())
        check_throws(ErrorCode::invalid_argument, {"another device"},
                     [&] { plan.update(of_other, std::span<const Request>()); });
}

BOOST_AUTO_TEST_CASE(a_call_for_device_memory_begins_after_the_callers_events) {
    Random random(15);
    const Mesh mesh = make_shape("knot");
    const DistanceTransform transform(test_device(), mesh);
    Boxes boxes = boxes_of_three_levels(mesh, random);
    boxes.expect(transform);
    boxes.clear();
    const std::vector<Request> requests = boxes.requests();
    for (const bool one_by_one : {false, true}) {
        const cl::UserEvent gate(context().context());
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
        boxes.check();
    }
    // One for the host waits for them, too.
    const cl::UserEvent failed(context().context());
    cl::UserEvent(failed).setStatus(-5);
    const std::array wait_list{failed()};
    std::vector<float> distance(requests[0].grid.sample_count());
    check_throws(ErrorCode::device_failure, {},
                 [&] { transform.compute(requests[0].grid, requests[0].band, distance, {.wait_list = wait_list}); });
}

BOOST_AUTO_TEST_CASE(the_memory_of_a_plan_of_boxes_is_known_before) {
    Random random(5);
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    const Boxes boxes = boxes_of_three_levels(mesh, random);
    const std::size_t bytes = transform.plan_bytes(boxes.requests());
    const Plan plan = transform.plan(boxes.requests());
    // A plan may take free buffers that are a little larger.
    BOOST_TEST(static_cast<double>(plan.statistics().device_bytes) == static_cast<double>(bytes),
               boost::test_tools::tolerance(0.1));
    std::size_t largest = 0;
    for (const Boxes::Box& box : boxes.boxes) largest = std::max(largest, box.grid.sample_count() * sizeof(float));
    BOOST_TEST(bytes > largest);
}

BOOST_AUTO_TEST_CASE(a_plan_of_boxes_outlives_its_transform) {
    Random random(6);
    const Mesh mesh = make_shape("sphere3");
    Boxes boxes = boxes_of_three_levels(mesh, random);
    boxes.expect(DistanceTransform(test_device(), mesh));
    std::optional<DistanceTransform> transform(std::in_place, test_device(), mesh);
    Plan first = transform->plan(boxes.requests());
    transform.reset();
    Plan plan = std::move(first);
    boxes.clear();
    run(plan, nullptr);
    boxes.check();
    check_throws(ErrorCode::invalid_argument, {"Plan was moved from"}, [&] { first.enqueue(nullptr); });
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

BOOST_AUTO_TEST_CASE(a_plan_without_requests_waits_for_the_callers_events) {
    const DistanceTransform transform(test_device(), make_shape("tetrahedron"));
    Plan plan = transform.plan(std::span<const Request>());
    const cl::UserEvent before(context().context());
    const cl_event event = before();
    const cl::CommandQueue queue = callers_queue();
    const cl::Event end(enqueue(plan, queue(), {&event, 1}));
    BOOST_TEST(end.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
    cl::UserEvent(before).setStatus(CL_COMPLETE);
    end.wait();
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
