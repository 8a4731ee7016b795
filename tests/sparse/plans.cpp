#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include "core/outputs.hpp"
#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <array>
#include <chrono>
#include <cstring>
#include <map>
#include <optional>
#include <thread>
#include <vector>

// Sparse fields in memory of the device have the bytes of those on the host.

using namespace clsdf;
using namespace clsdf::test;

namespace {

const Mesh& mesh() {
    static const Mesh shape = tilted(box({0, 0, 0}, {1, 2, 3}));
    return shape;
}
const Grid& grid() {
    static const Grid around = [] {
        Grid grid = grid_around(mesh(), 100, 5);
        grid.first = {-21, 5, 3};
        for (std::size_t axis = 0; axis < 3; ++axis)
            grid.origin[axis] -= grid.spacing[axis] * static_cast<double>(grid.first[axis]);
        return grid;
    }();
    return around;
}
Band band() {
    return Band::symmetric(3 * grid().voxel());
}
SparseRequest request(OutputSet outputs = Output::distance) {
    return {grid(), band(), outputs};
}

const device::Context& context() {
    return device::context_of(test_device());
}

/// Buffers of the caller for so many bricks and runs, which begin behind `before` bytes, and have 8 bytes more that
/// must stay as they are.
class Memory {
public:
    Memory(const SparseCounts& room, OutputSet outputs, std::size_t before = 0) : room_(room), before_(before) {
        counts_ = buffer(sizeof(DeviceSparseCounts));
        bricks_ = buffer(room.bricks * sizeof(Index3));
        inside_ = buffer(room.runs * sizeof(BrickRun));
        for (const OutputInfo& info : infos_of(outputs | Output::distance))
            values_[info.output] = buffer(room.bricks * brick_samples * info.sample_bytes());
    }

    SparseDeviceTargets targets() const {
        SparseDeviceTargets targets{{counts_(), before_}, {bricks_(), before_}, {inside_(), before_}};
        for (const auto& [output, memory] : values_) {
            OutputArray array(memory());
            array.offset = before_;
            targets.values[output] = array;
        }
        return targets;
    }

    DeviceSparseCounts counts() const { return read<DeviceSparseCounts>(counts_, 1).front(); }

    void check_same(const SparseField& field) const {
        BOOST_TEST((counts() == DeviceSparseCounts{field.bricks.size(), field.inside.size(), 1}));
        BOOST_TEST((read<Index3>(bricks_, field.bricks.size()) == field.bricks));
        BOOST_TEST((read<BrickRun>(inside_, field.inside.size()) == field.inside));
        for (const auto& [output, memory] : values_)
            BOOST_TEST(std::ranges::equal(read<std::byte>(memory, field.bytes(output).size()), field.bytes(output)),
                       info_of(output).name << " differs");
        check_limits();
    }

    /// Nothing is written before and behind the arrays.
    void check_limits() const {
        const auto check = [&](const cl::Buffer& memory) {
            const auto bytes = test::read<std::uint8_t>(context(), memory, memory.getInfo<CL_MEM_SIZE>());
            const auto is_untouched = [](std::uint8_t byte) { return byte == 0xAB; };
            BOOST_TEST(std::all_of(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(before_), is_untouched));
            BOOST_TEST(std::all_of(bytes.end() - 8, bytes.end(), is_untouched));
        };
        for (const cl::Buffer& memory : {counts_, bricks_, inside_}) check(memory);
        for (const auto& [output, memory] : values_) check(memory);
    }

    const SparseCounts& room() const { return room_; }

private:
    cl::Buffer buffer(std::size_t bytes) const {
        std::vector<std::uint8_t> content(before_ + bytes + 8, 0xAB);
        return {context().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, content.size(), content.data()};
    }
    template <class Value>
    std::vector<Value> read(const cl::Buffer& memory, std::size_t count) const {
        std::vector<Value> values(count);
        if (count > 0)
            context().queue().enqueueReadBuffer(memory, CL_TRUE, before_, count * sizeof(Value), values.data());
        return values;
    }

    SparseCounts room_;
    std::size_t before_;
    cl::Buffer counts_, bricks_, inside_;
    std::map<Output, cl::Buffer> values_;
};

SparseCounts counts_of(const SparseField& field) {
    return {field.bricks.size(), field.inside.size()};
}

void run(SparsePlan& plan, const Memory& memory) {
    cl::Event end;
    plan.enqueue(nullptr, memory.targets(), {}, &end());
    end.wait();
}

void check_plan(const DistanceTransform& transform, const SparseRequest& asked, std::size_t before = 0) {
    const SparseField field = transform.compute_sparse(asked.grid, asked.band, asked.outputs);
    for (const std::size_t more : {0U, 7U}) {
        const Memory memory({field.bricks.size() + more, field.inside.size() + more}, asked.outputs, before);
        SparsePlan plan = transform.plan_sparse(asked, memory.room());
        for (int n = 0; n < 2; ++n) {
            run(plan, memory);
            memory.check_same(field);
        }
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_run_has_the_bytes_of_the_field_on_the_host) {
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const DistanceTransform transform(test_device(), mesh(), {.body = body});
        check_plan(transform, request());
        check_plan(transform, request(all_outputs()), 8);
        check_plan(transform, {grid(), {0.5 * grid().voxel(), 5 * grid().voxel()}, Output::site}, 64);
        // No sample in the band; bricks of both signs alone.
        check_plan(transform, {grid(), Band::symmetric(1e-4 * grid().voxel()), Output::triangle});
        const DistanceTransform unsigned_one(test_device(), mesh(), {.sign = SignRule::none, .body = body});
        check_plan(unsigned_one, request(Output::gradient));
        const Mesh open = open_box({0, 0, 0}, {1, 1, 1}, 0);
        const DistanceTransform of_open(test_device(), open, {.sign = SignRule::solid_angle, .body = body});
        const Grid around = grid_around(open, 70, 10);
        check_plan(of_open, {around, Band::symmetric(2 * around.voxel()), all_outputs()});
    }
}

// The grid is a plate of one brick, of a size that is computed in several slabs.
BOOST_AUTO_TEST_CASE(slabs_are_appended_in_their_order) {
    const Mesh sphere = make_shape("sphere4");
    const Grid whole = grid_around(sphere, 2000, 5);
    const Grid plate = whole.part({1000, 0, 700}, {8, whole.size[1], 600});
    const DistanceTransform transform(test_device(), sphere);
    const SparseRequest asked{plate, Band::symmetric(3 * whole.voxel()), Output::triangle};
    check_plan(transform, asked);
    BOOST_TEST(transform.plan_sparse(asked, {1000, 1000}).statistics().slabs > 1U);
}

BOOST_AUTO_TEST_CASE(a_run_without_enough_room_says_how_much_is_needed) {
    const DistanceTransform transform(test_device(), mesh());
    const SparseField field = transform.compute_sparse(grid(), band(), Output::site);
    const SparseCounts needed = counts_of(field);
    SparsePlan plan = transform.plan_sparse(request(Output::site), {});
    for (const SparseCounts& room :
         {SparseCounts{}, {needed.bricks - 1, needed.runs}, {needed.bricks, needed.runs - 1}, {needed.bricks / 3, 1}}) {
        const Memory memory(room, Output::site);
        plan.update(transform, request(Output::site), room);
        BOOST_TEST((plan.room() == room));
        run(plan, memory);
        BOOST_TEST((memory.counts() == DeviceSparseCounts{needed.bricks, needed.runs, 0}));
        memory.check_limits();
    }
    const Memory memory(needed, Output::site);
    plan.update(transform, request(Output::site), needed);
    run(plan, memory);
    memory.check_same(field);
}

BOOST_AUTO_TEST_CASE(an_update_follows_the_positions) {
    DistanceTransform transform(test_device(), mesh());
    std::vector<Vec3> positions = mesh().vertices();
    const Memory memory({4000, 4000}, Output::triangle);
    SparsePlan plan = transform.plan_sparse(request(Output::triangle), memory.room());
    for (int step = 0; step < 2; ++step) {
        for (Vec3& position : positions) position[0] += 1.7 * grid().voxel(), position[1] *= 1.1;
        transform.set_positions(positions);
        plan.update(transform);
        run(plan, memory);
        memory.check_same(transform.compute_sparse(grid(), band(), Output::triangle));
        SparseRequest moved = request(Output::triangle);
        moved.grid.first[2] += 9;
        moved.band = {2 * grid().voxel(), grid().voxel()};
        plan.update(transform, moved, memory.room());
        BOOST_TEST((plan.request().grid == moved.grid));
        run(plan, memory);
        memory.check_same(transform.compute_sparse(moved.grid, moved.band, Output::triangle));
        plan.update(transform, request(Output::triangle), memory.room());
    }
}

BOOST_AUTO_TEST_CASE(runs_wait_for_events_and_follow_one_another) {
    const DistanceTransform transform(test_device(), mesh());
    const SparseField field = transform.compute_sparse(grid(), band());
    const Memory first(counts_of(field), {}), second(counts_of(field), {});
    SparsePlan plan = transform.plan_sparse(request(), first.room());
    const cl::CommandQueue queue(context().context(), context().device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    cl::UserEvent gate(context().context());
    const std::array<cl_event, 1> wait_list{gate()};
    cl::Event end;
    plan.enqueue(queue(), first.targets(), wait_list);
    plan.enqueue(queue(), second.targets(), {}, &end());
    BOOST_TEST(end.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() != CL_COMPLETE);
    gate.setStatus(CL_COMPLETE);
    end.wait();
    first.check_same(field);
    second.check_same(field);
}

BOOST_AUTO_TEST_CASE(a_plan_outlives_its_transform) {
    std::optional<DistanceTransform> transform(std::in_place, test_device(), mesh());
    const SparseField field = transform->compute_sparse(grid(), band());
    const Memory memory(counts_of(field), {});
    SparsePlan plan = transform->plan_sparse(request(), memory.room());
    BOOST_TEST(name_of(plan.sign()) == "nonzero");
    BOOST_TEST(plan.statistics().device_bytes > field.bytes(Output::distance).size());
    transform.reset();
    SparsePlan moved = std::move(plan);
    run(moved, memory);
    memory.check_same(field);
    check_throws(ErrorCode::invalid_argument, {"SparsePlan was moved from"},
                 [&] { plan.enqueue(nullptr, memory.targets()); });
}

BOOST_AUTO_TEST_CASE(what_a_run_cannot_write_is_refused) {
    const DistanceTransform transform(test_device(), mesh());
    const SparseField field = transform.compute_sparse(grid(), band(), Output::triangle);
    const Memory memory(counts_of(field), Output::triangle);
    const Memory other(memory.room(), Output::gradient), larger({2 * memory.room().bricks, 1}, {});
    SparsePlan plan = transform.plan_sparse(request(Output::triangle), memory.room());
    const auto check = [&](ErrorCode code, const std::vector<std::string>& texts, const auto& change) {
        SparseDeviceTargets targets = memory.targets();
        change(targets);
        check_throws(code, texts, [&] { plan.enqueue(nullptr, targets); });
    };
    constexpr auto misuse = ErrorCode::invalid_argument, unsupported = ErrorCode::unsupported;
    check(misuse, {"memory of the counts", "no memory", "24 bytes"}, [](auto& to) { to.counts = {}; });
    check(misuse, {"array of bricks", "no memory"}, [](auto& to) { to.bricks = {}; });
    check(misuse, {"array of runs", "needs", "larger"}, [](auto& to) { to.inside.offset = 16; });
    check(misuse, {"array of runs", "byte 4", "multiple of 8"}, [](auto& to) { to.inside.offset = 4; });
    check(misuse, {"memory of the counts", "array of bricks", "lie on the same bytes"},
          [](auto& to) { to.counts = to.bricks; });
    check(misuse, {"array of bricks", "array of the output distance", "lie on the same bytes"},
          [](auto& to) { to.bricks.memory = to.values[Output::distance].device; });
    check(misuse, {"no target"}, [](auto& to) { to.values = {}; });
    check(misuse, {"computes the output triangle"},
          [](auto& to) { to.values = OutputTargets(to.values[Output::distance]); });
    check(misuse, {"output gradient has a target"},
          [&](auto& to) { to.values[Output::gradient] = other.targets().values[Output::gradient]; });
    check(unsupported, {"output distance has doubles"}, [&](auto& to) {
        to.values[Output::distance] = larger.targets().values[Output::distance];
        to.values[Output::distance].type = ElementType::float64;
    });
    check(unsupported, {"output distance has strides"}, [&](auto& to) {
        to.values[Output::distance] = larger.targets().values[Output::distance];
        to.values[Output::distance].strides = {8, 8, 8};
    });
    std::vector<float> host(field.distance().size());
    check(unsupported, {"memory of the host"}, [&](auto& to) { to.values[Output::distance] = OutputArray(host); });
    run(plan, memory);
    memory.check_same(field);
}

BOOST_AUTO_TEST_CASE(a_refused_update_leaves_the_plan_as_it_was) {
    const DistanceTransform transform(test_device(), mesh());
    const SparseField field = transform.compute_sparse(grid(), band());
    const Memory memory(counts_of(field), {});
    SparsePlan plan = transform.plan_sparse(request(), memory.room());
    SparseRequest endless = request();
    endless.band.outside = std::numeric_limits<double>::infinity();
    check_throws(ErrorCode::invalid_argument, {"a band with an end"},
                 [&] { plan.update(transform, endless, memory.room()); });
    check_throws(ErrorCode::invalid_argument, {"room for", "no field has so many"}, [&] {
        plan.update(transform, request(), {std::size_t{1} << 50, 1});
    });
    run(plan, memory);
    memory.check_same(field);
    CallOptions stopped;
    stopped.should_stop = [] { return true; };
    check_throws(ErrorCode::cancelled, {}, [&] { plan.update(transform, stopped); });
    check_throws(ErrorCode::invalid_argument, {"last update failed"}, [&] { plan.enqueue(nullptr, memory.targets()); });
    plan.update(transform);
    run(plan, memory);
    memory.check_same(field);
}
