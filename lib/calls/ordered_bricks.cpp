#include "calls/ordered_bricks.hpp"

#include "brick_ranges.h"
#include "device/read_back.hpp"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace clsdf::calls {

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

ListedBricks::ListedBricks(device::BufferPool& pool, std::size_t room_in, std::size_t most,
                           const targets::HostArrays& wanted_in)
    : room(room_in), wanted(wanted_in) {
    const std::size_t ranges = range_count(most);
    listed = pool.lease((CLSDF_LISTED + room) * sizeof(cl_uint), "list of the bricks near the surface");
    counts = pool.lease(2 * ranges * sizeof(cl_uint), "counts of the bricks near the surface");
    starts = pool.lease((2 * ranges + 1) * sizeof(cl_uint), "sums of the bricks near the surface");
    places = pool.lease(room * sizeof(cl_uint), "places of the bricks near the surface");
    totals = pool.lease(2 * sizeof(cl_ulong), "number of the bricks near the surface");
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& array, device::BufferPool::Lease& lease) {
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

BrickOrder::BrickOrder(const engine::DeviceTools& tools, const Layout& layout, const cl::Buffer& marks,
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

void BrickOrder::enqueue(engine::CommandChain& chain, const OrderedTargets& targets) {
    constexpr std::size_t whole = sizeof(cl_ulong);
    const cl_ulong brick_room = targets.room.bricks, run_room = targets.room.runs;
    chain.then_launch(count_, {ranges_});
    sums_.each(
        [&](const device::LentKernel& kernel, const engine::WorkItems& items) { chain.then_launch(kernel, items); });
    engine::set_arguments(place_, place_targets_, brick_room, cl_ulong{targets.bricks.offset / whole},
                          targets.bricks.memory);
    chain.then_launch(place_, {memory_.room});
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& array, const device::BufferPool::Lease& values,
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

namespace {

/// A part of known bricks, and what the host makes of them.
struct KnownBricks {
    Layout layout{};  ///< its bricks alone
    std::vector<cl_uchar> marks;
    std::vector<cl_uint> listed;  ///< CLSDF_LISTED
    std::vector<Index3> firsts;   ///< in order, with `places` in the list
    std::vector<cl_uint> places;
    std::vector<BrickRun> runs;

    KnownBricks() {
        Grid part;
        part.first = {-16, 8, -64};
        part.size = {9 * brick_side, 13 * brick_side, 5 * brick_side};
        std::mt19937 random(3);
        marks.resize(part.sample_count() / brick_samples);
        for (cl_uchar& mark : marks)
            mark = std::array<cl_uchar, 4>{0, 1, CLSDF_INSIDE_BRICK, CLSDF_INSIDE_BRICK}[random() % 4];
        std::vector<cl_uint> numbers;
        for (std::size_t n = 0; n < marks.size(); ++n)
            if (marks[n] == 1) numbers.push_back(static_cast<cl_uint>(n));
        std::vector<cl_uint> shuffled = numbers;
        std::ranges::shuffle(shuffled, random);
        const auto count = static_cast<cl_uint>(numbers.size());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            layout.brick_first[axis] = static_cast<clsdf_int32>(part.first[axis] / brick_side);
            layout.bricks[axis] = static_cast<clsdf_int32>(part.size[axis] / brick_side);
        }
        listed = {count, count, count - count / 4, 0};
        listed.insert(listed.end(), shuffled.begin(), shuffled.end());
        const auto first_of = [&](std::size_t n) {
            const auto at = static_cast<std::int64_t>(n);
            return Index3{part.first[0] + at % 9 * brick_side, part.first[1] + at / 9 % 13 * brick_side,
                          part.first[2] + at / 9 / 13 * brick_side};
        };
        for (const cl_uint n : numbers) {
            firsts.push_back(first_of(n));
            places.push_back(static_cast<cl_uint>(std::ranges::find(shuffled, n) - shuffled.begin()));
        }
        for (std::size_t n = 0; n < marks.size(); ++n) {
            if (marks[n] != CLSDF_INSIDE_BRICK) continue;
            if (n % 9 != 0 && marks[n - 1] == CLSDF_INSIDE_BRICK)
                ++runs.back().count;
            else
                runs.push_back({first_of(n), 1});
        }
    }
};

template <class Value>
std::vector<Value> read(const device::Context& context, const cl::Buffer& memory, std::size_t offset,
                        std::size_t count) {
    std::vector<Value> values(count);
    device::read_values(context, memory, values, offset);
    return values;
}

/// Puts known bricks in order twice, as if they were two parts, of which the second has no room for its last brick.
std::optional<std::string> difference_of_order(const Device& device, const engine::Programs& programs) {
    device::Context& context = device::context_of(device);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    const engine::DeviceTools tools{context, pool, programs};
    const KnownBricks known;
    const std::size_t count = known.firsts.size(), runs = known.runs.size();
    const OutputSet outputs = Output::site;
    const ListedBricks memory(*pool, count, known.marks.size(), targets::arrays_for(outputs));
    std::vector<cl_uint> distances(count * brick_samples);
    std::vector<cl_uchar> sites(count * brick_samples);
    for (std::size_t i = 0; i < distances.size(); ++i) {
        distances[i] = static_cast<cl_uint>(i * 2654435761U);
        sites[i] = static_cast<cl_uchar>(i * 7 % 251);
    }
    device::write_values(context, distances, *memory.values[Output::distance]);
    device::write_values(context, sites, *memory.values[Output::site]);
    device::write_values(context, known.listed, *memory.listed);
    const cl::Buffer marks = device::copied(context, known.marks);
    // An array begins behind a few bytes, and has room for all but one of the bricks of both parts.
    const auto buffer = [&](std::size_t bytes) { return cl::Buffer(context.context(), CL_MEM_READ_WRITE, bytes + 8); };
    OrderedTargets to;
    to.room = {2 * count - 1, 2 * runs};
    to.counts = {buffer(sizeof(DeviceSparseCounts)), 8};
    to.bricks = {buffer(to.room.bricks * sizeof(Index3)), 8};
    to.inside = {buffer(to.room.runs * sizeof(BrickRun)), 8};
    to.values[Output::distance] = {buffer(to.room.bricks * brick_samples * sizeof(float)), 4};
    to.values[Output::site] = {buffer(to.room.bricks * brick_samples), 1};
    engine::CommandChain chain(context.queue(), {});
    chain.then_fill(*memory.totals, 2 * sizeof(cl_ulong));
    BrickOrder order(tools, known.layout, marks, memory);
    for (int n = 0; n < 2; ++n) order.enqueue(chain, to);
    context.finish();
    if (read<DeviceSparseCounts>(context, to.counts.memory, 8, 1).front() != DeviceSparseCounts{2 * count, 2 * runs, 0})
        return "bricks are counted wrongly";
    const auto firsts = read<Index3>(context, to.bricks.memory, 8, to.room.bricks);
    const auto found_runs = read<BrickRun>(context, to.inside.memory, 8, to.room.runs);
    const auto found_distances =
        read<cl_uint>(context, to.values[Output::distance].memory, 4, to.room.bricks * brick_samples);
    const auto found_sites = read<cl_uchar>(context, to.values[Output::site].memory, 1, to.room.bricks * brick_samples);
    for (std::size_t n = 0; n < to.room.runs; ++n)
        if (found_runs[n] != known.runs[n % runs]) return "runs of bricks are stored wrongly";
    for (std::size_t n = 0; n < to.room.bricks; ++n) {
        if (firsts[n] != known.firsts[n % count]) return "bricks are out of order";
        const std::size_t place = known.places[n % count];
        const bool is_left = place >= known.listed[CLSDF_LISTED_IN_BAND];
        for (std::size_t i = 0; i < brick_samples; ++i) {
            const std::size_t from = place * brick_samples + i, at = n * brick_samples + i;
            if (found_distances[at] != distances[from] || found_sites[at] != (is_left ? 0xFF : sites[from]))
                return "values are stored in wrong places";
        }
    }
    return std::nullopt;
}

}  // namespace

checks::TestSubject ordered_bricks_subject(const Device& device, const engine::Programs& programs) {
    checks::TestSubject subject;
    subject.name = "ordered bricks";
    subject.build = [&programs](const device::BuildWatch& watch) {
        return std::vector{programs.order.get(watch), programs.scan.get(watch)};
    };
    subject.difference = [&device, &programs](const device::BuildWatch&) {
        return difference_of_order(device, programs);
    };
    return subject;
}

}  // namespace clsdf::calls
