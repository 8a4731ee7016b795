// Bounds on the calls and bytes of plans on a GPU.
#include "disguise/as_gpu.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include "device/buffer_pool.hpp"
#include "device/context.hpp"
#include "disguise/disguise.hpp"

#include <clsdf/fraction_plan.hpp>
#include <clsdf/fractions.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Nothing was waited for, allocated or moved since the counts began.
void check_nothing_moved() {
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST(counts.blocking_waits == 0U);
    BOOST_TEST(counts.allocations == 0U);
    BOOST_TEST(counts.first_uses == 0U);
    BOOST_TEST(counts.bytes_up == 0U);
    BOOST_TEST(counts.bytes_down == 0U);
}

/// Nothing moved; at the run's end the memory holds the field, behind `skipped` elements.
void check_quiet_run(const cl::Event& end, const DeviceMemory& memory, std::size_t skipped = 0) {
    check_nothing_moved();
    end.wait();
    std::vector<std::uint32_t> bits = memory.read(device::context_of(test_device()).queue());
    bits.erase(bits.begin(), bits.begin() + static_cast<std::ptrdiff_t>(skipped));
    BOOST_TEST((bits == bits_of(compute(mesh(), grid(), band()).distance())));
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_plan_neither_waits_nor_moves_what_it_has) {
    DistanceTransform transform(test_device(), mesh());
    for (const std::size_t skipped : {0U, 1U}) {  // in place, and by way of memory of the plan
        const DeviceMemory memory(test_device().context(), skipped + grid().sample_count());
        OutputArray target = memory.handle();
        target.offset = skipped * sizeof(float);
        Plan plan = skipped == 0 ? transform.plan(grid(), band()) : transform.plan({grid(), band(), target});
        disguise::restart();
        plan.enqueue(nullptr, target);
        cl::Event second;
        plan.enqueue(nullptr, target, {}, &second());
        check_quiet_run(second, memory, skipped);
    }
}

BOOST_AUTO_TEST_CASE(a_plan_of_boxes_neither_waits_nor_moves_what_it_has) {
    const DistanceTransform transform(test_device(), mesh());
    const DeviceMemory memory(test_device().context(), grid().sample_count());
    std::vector<Request> requests;
    for (std::int64_t z = 0; z < grid().size[2]; ++z) {
        const Grid slice = grid().part({0, 0, z}, {grid().size[0], grid().size[1], 1});
        OutputArray target = memory.handle();
        target.offset = sizeof(float) * slice.sample_count() * static_cast<std::size_t>(z);
        requests.push_back({slice, band(), target});
    }
    Plan plan = transform.plan(requests);
    disguise::restart();
    plan.enqueue(nullptr);
    cl::Event second;
    plan.enqueue(nullptr, std::span<const cl_event>(), &second());
    check_quiet_run(second, memory);
}

BOOST_AUTO_TEST_CASE(a_plan_of_a_sparse_field_neither_waits_nor_moves_what_it_has) {
    const DistanceTransform transform(test_device(), mesh());
    const SparseField field = transform.compute_sparse(grid(), band());
    const SparseCounts room{field.bricks.size(), field.inside.size() + 1};
    const DeviceMemory counts(test_device().context(), sizeof(DeviceSparseCounts) / sizeof(cl_uint)),
        bricks(test_device().context(), room.bricks * sizeof(Index3) / sizeof(cl_uint)),
        inside(test_device().context(), room.runs * sizeof(BrickRun) / sizeof(cl_uint)),
        distance(test_device().context(), room.bricks * brick_samples);
    const SparseDeviceTargets targets{{counts.handle()}, {bricks.handle()}, {inside.handle()}, distance.handle()};
    SparsePlan plan = transform.plan_sparse({grid(), band()}, room);
    disguise::restart();
    plan.enqueue(nullptr, targets);
    cl::Event end;
    plan.enqueue(nullptr, targets, {}, &end());
    check_nothing_moved();
    end.wait();
    BOOST_TEST((distance.read(device::context_of(test_device()).queue()) == bits_of(field.distance())));
}

BOOST_AUTO_TEST_CASE(a_plan_of_fractions_neither_waits_nor_moves_what_it_has) {
    const OuterSurface surface = outer(mesh());
    const Fractions known = fractions(surface, grid());
    const std::size_t rows = known.cells.size();
    const DeviceMemory count(test_device().context(), sizeof(DeviceFractionCount) / sizeof(cl_uint)),
        volumes(test_device().context(), rows), full(test_device().context(), grid().sample_count());
    FractionRows targets;
    targets.room = rows;
    targets.volume = {volumes.handle(), ElementType::float32};
    targets.full = {full.handle(), ElementType::uint8};
    FractionPlan plan(test_device(), surface, grid(), rows);
    disguise::restart();
    plan.enqueue(nullptr, targets, {count.handle()});
    cl::Event end;
    plan.enqueue(nullptr, targets, {count.handle()}, {}, &end());
    check_nothing_moved();
    // 21, three for each eight bits of the keys, which have at most 24, one for the volumes, two for the full cells.
    BOOST_TEST(disguise::counts().launches <= 2 * (21U + 9U + 1U + 2U));
    end.wait();
    std::vector<float> expected;
    for (const CellFraction& cell : known.cells) expected.push_back(static_cast<float>(cell.volume));
    BOOST_TEST((volumes.read(device::context_of(test_device()).queue()) == bits_of(expected)));
}

// Drivers that allocate a buffer at its first use would fail when a plan is enqueued.
BOOST_AUTO_TEST_CASE(a_lack_of_memory_appears_when_a_plan_is_made) {
    const DeviceMemory memory(test_device().context(), grid().sample_count());
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    device::context_of(test_device()).arena().release();
    disguise::Settings settings = as_gpu;
    settings.memory = 0;
    disguise::set(settings);
    const DistanceTransform transform(test_device(), mesh());  // the host makes the topology
    check_throws(ErrorCode::out_of_memory, {"CL_MEM_OBJECT_ALLOCATION_FAILURE", "smaller part"},
                 [&] { pool->lease(1000, "test"); });
    BOOST_TEST(!pool->lease_if_it_fits(1000, "test"));
    check_throws(ErrorCode::out_of_memory, {"smaller part"}, [&] { transform.plan(grid(), band()); });
    disguise::set(as_gpu);
    Plan plan = transform.plan(grid(), band());
    disguise::restart();
    cl::Event end;
    plan.enqueue(nullptr, memory.handle(), {}, &end());
    check_quiet_run(end, memory);
}

// The call that fails is named, and the plan computes the same field afterwards.
BOOST_AUTO_TEST_CASE(a_plan_survives_each_call_that_fails_while_it_is_enqueued) {
    DistanceTransform transform(test_device(), mesh());
    const DeviceMemory memory(test_device().context(), grid().sample_count());
    const cl::CommandQueue queue(device::context_of(test_device()).context(),
                                 device::context_of(test_device()).device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    // In place, and by way of memory of the plan.
    const auto run = [&](Plan& plan, const OutputArray& to) {
        cl::Event end;
        plan.enqueue(queue(), to, {}, &end());
        end.wait();
    };
    OutputArray turned;
    const auto rows = static_cast<std::ptrdiff_t>(sizeof(float)) * grid().size[2];
    turned.strides = {rows * grid().size[1], rows, sizeof(float)};
    for (const bool in_place : {true, false}) {
        const auto target = [&](const DeviceMemory& of) {
            OutputArray result = in_place ? OutputArray() : turned;
            result.device = of.handle();
            return result;
        };
        Plan plan = in_place ? transform.plan(grid(), band()) : transform.plan({grid(), band(), target(memory)});
        disguise::restart();
        run(plan, target(memory));
        const std::uint64_t calls = disguise::counts().all_calls - 1;  // without the wait
        const std::vector<std::uint32_t> expected = memory.read(queue);
        for (std::uint64_t number = 1; number <= calls; ++number) {
            disguise::restart({.number = number});
            try {
                run(plan, target(memory));
                // Without the event's state the plan waits for the event.
                BOOST_TEST(disguise::counts().failed == "clGetEventInfo");
            } catch (const Error& error) {
                BOOST_TEST_CONTEXT(error.what())
                BOOST_TEST(std::string(error.what()).find(disguise::counts().failed) != std::string::npos);
            }
            disguise::restart();
            const DeviceMemory other(test_device().context(), grid().sample_count());
            run(plan, target(other));
            BOOST_TEST((other.read(queue) == expected));
        }
    }
}
