#include "targets/ordered_bricks.hpp"

#include "brick_order.h"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"

#include <algorithm>

namespace clsdf::targets {

namespace {

// On a GPU so many work-items store a brick's values together.
constexpr std::size_t pieces_of_gpu = 64;
// Of a launch, which stores 128 MiB of distances.
constexpr std::size_t most_stored_bricks = std::size_t{1} << 16;

std::size_t brick_count(const Layout& layout) {
    std::size_t count = 1;
    for (const clsdf_int32 bricks : layout.bricks) count *= static_cast<std::size_t>(bricks);
    return count;
}

std::size_t range_count(std::size_t bricks) {
    return (bricks + CLSDF_RANGE_BRICKS - 1) / CLSDF_RANGE_BRICKS;
}

}  // namespace

ListedBricks::ListedBricks(device::BufferPool& pool, std::size_t room_in, std::size_t most, const HostArrays& wanted_in)
    : room(room_in), wanted(wanted_in) {
    const std::size_t ranges = range_count(most);
    listed = pool.lease((CLSDF_STORED + room) * sizeof(cl_uint), "list of the bricks near the surface");
    counts = pool.lease(2 * ranges * sizeof(cl_uint), "counts of the bricks near the surface");
    starts = pool.lease((2 * ranges + 1) * sizeof(cl_uint), "sums of the bricks near the surface");
    places = pool.lease(room * sizeof(cl_uint), "places of the bricks near the surface");
    totals = pool.lease(2 * sizeof(cl_ulong), "number of the bricks near the surface");
    for_each_output(
        [&](const OutputInfo& row, const HostArray& array, device::BufferPool::Lease& lease) {
            if (!array.is_wanted) return;
            lease = pool.lease(room * brick_samples * row.sample_bytes(), "values of the bricks near the surface");
        },
        wanted, values);
}

std::size_t ListedBricks::bytes() const {
    std::size_t sum = listed.bytes() + counts.bytes() + starts.bytes() + places.bytes() + totals.bytes();
    for_each_output([&](const OutputInfo&, const device::BufferPool::Lease& lease) { sum += lease.bytes(); }, values);
    return sum;
}

BrickStore::BrickStore(const engine::DeviceTools& tools, const Layout& layout, const cl::Buffer& marks,
                       const ListedBricks& memory)
    : memory_(memory),
      ranges_(range_count(brick_count(layout))),
      sums_(tools, *memory.counts, *memory.starts, 2 * ranges_, "bricks near the surface"),
      pieces_(tools.context.capabilities().is_processor ? 1 : pieces_of_gpu) {
    const cl::Program program = tools.programs.order;
    const auto bricks = static_cast<cl_uint>(brick_count(layout)), ranges = static_cast<cl_uint>(ranges_);
    count_ = tools.kernel(program, "count_marks");
    place_ = tools.kernel(program, "place_bricks");
    store_ = tools.kernel(program, "store_bricks");
    store_bytes_ = tools.kernel(program, "store_brick_bytes");
    runs_ = tools.kernel(program, "store_runs");
    add_ = tools.kernel(program, "add_counts");
    engine::set_arguments(count_, 0, layout, bricks, ranges, marks, *memory.counts);
    place_targets_ =
        engine::set_arguments(place_, 0, layout, marks, *memory.starts, *memory.listed, *memory.totals, *memory.places);
    for (device::LentKernel* kernel : {&store_, &store_bytes_})
        engine::set_arguments(*kernel, 0, *memory.listed, *memory.places);
    runs_targets_ = engine::set_arguments(runs_, 0, layout, bricks, ranges, marks, *memory.starts, *memory.totals);
    add_targets_ = engine::set_arguments(add_, 0, ranges, *memory.starts, *memory.totals);
}

void BrickStore::enqueue(engine::CommandChain& chain, const OrderedTargets& targets) {
    constexpr std::size_t whole = sizeof(cl_ulong);
    const cl_ulong brick_room = targets.room.bricks, run_room = targets.room.runs;
    chain.then_launch(count_, {ranges_});
    sums_.each(
        [&](const device::LentKernel& kernel, const engine::WorkItems& items) { chain.then_launch(kernel, items); });
    engine::set_arguments(place_, place_targets_, brick_room, cl_ulong{targets.bricks.offset / whole},
                          targets.bricks.memory);
    chain.then_launch(place_, {memory_.room});
    for_each_output(
        [&](const OutputInfo& row, const HostArray& array, const device::BufferPool::Lease& values,
            const OrderedTargets::Place& place) {
            if (!array.is_wanted || targets.room.bricks == 0) return;
            const auto words = static_cast<cl_uint>(brick_samples * row.sample_bytes() / sizeof(cl_uint));
            const cl_int in_band = row.output == Output::distance ? 0 : 1;
            device::LentKernel& kernel = place.offset % sizeof(cl_uint) == 0 ? store_ : store_bytes_;
            for (std::size_t first = 0; first < memory_.room; first += most_stored_bricks) {
                const std::size_t bricks = std::min(most_stored_bricks, memory_.room - first);
                engine::set_arguments(kernel, 2, *values, words, in_band, static_cast<cl_uint>(first),
                                      cl_ulong{place.offset}, place.memory);
                engine::divided({pieces_, bricks, 1}, {engine::most_groups, 1},
                                [&](std::size_t y, std::size_t, const cl::NDRange& items) {
                                    kernel.setArg(5, static_cast<cl_uint>(first + y));
                                    chain.then_launch(kernel, cl::NullRange, items, cl::NDRange(pieces_, 1, 1));
                                });
            }
        },
        memory_.wanted, memory_.values, targets.values);
    engine::set_arguments(runs_, runs_targets_, run_room, cl_ulong{targets.inside.offset / whole},
                          targets.inside.memory);
    chain.then_launch(runs_, {ranges_});
    engine::set_arguments(add_, add_targets_, brick_room, run_room, cl_ulong{targets.counts.offset / whole},
                          targets.counts.memory);
    chain.then_launch(add_, {1, 1});
}

}  // namespace clsdf::targets
