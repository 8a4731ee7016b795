#include "checks/known_targets.hpp"

#include "brick_order.h"
#include "device/read_back.hpp"
#include "targets/ordered_bricks.hpp"
#include "targets/stored_boxes.hpp"
#include "targets/stored_rows.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace clsdf::checks {

namespace {

/// Boxes of samples, in blocks of rows, to targets with strides; the third to another place than it was planned for.
template <typename Value>
bool stores_right(const device::Context& context, const cl::Program& program) {
    Grid block, request;
    block.size = {11, 6, 5};
    request.first = {2, 1, -1};
    request.size = {40, 4, 4};
    constexpr std::size_t components = 3;
    constexpr auto stride = static_cast<std::ptrdiff_t>(sizeof(Value));
    OutputArray target;
    target.offset = 7 * sizeof(Value);
    target.strides = {2 * stride, 90 * stride, 400 * stride};
    target.component_stride = 1800 * stride;
    const StoredBox box = *targets::stored_box(block, request, target);
    const auto place_at = [&](std::ptrdiff_t elements_on) {
        StoredBox moved = box;
        moved.to += elements_on * stride;
        return moved;
    };
    const std::array stored{box, place_at(6000), place_at(6001)};
    std::vector<Value> from(block.sample_count() * components);
    std::vector<Value> to(12000, Value{});
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = static_cast<Value>(1 + i * 7 % 251);
    std::vector<Value> expected = to;
    for (const StoredBox& of : stored)
        for (int z = 0; z < of.size[2]; ++z)
            for (int y = 0; y < of.size[1]; ++y)
                for (int x = 0; x < of.size[0]; ++x)
                    for (std::size_t c = 0; c < components; ++c) {
                        const std::size_t sample = static_cast<std::size_t>(of.from) + block.offset(x, y, z);
                        const std::int64_t place = of.to + x * of.strides[0] + y * of.strides[1] + z * of.strides[2] +
                                                   static_cast<std::int64_t>(c) * of.component_stride;
                        expected[static_cast<std::size_t>(place / stride)] = from[sample * components + c];
                    }
    const cl::Buffer samples = device::copied(context, from);
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, to.size() * sizeof(Value),
                            to.data());
    const targets::StoredElements elements{components, sizeof(Value)};
    engine::CommandChain chain(context.queue(), {});
    targets::BoxStore both(context, program, block, elements, samples, {{memory(), stored[0]}, {memory(), stored[1]}});
    both.enqueue(chain);
    targets::BoxStore moved(context, program, block, elements, samples, {{memory(), stored[0]}});
    moved.enqueue(chain, std::array{targets::TargetBox{memory(), stored[2]}});
    device::read_values(context, memory, to);
    return to == expected;
}

/// Known links, as rows with strides and as fields of two directions.
template <typename Part>
bool stores_links_right(const device::Context& context, const cl::Program& program) {
    constexpr std::size_t count = 300, width = sizeof(Part);
    Grid grid;
    grid.size = {11, 6, 9};
    grid.first = {-4, 2, 7};
    std::mt19937 random(5);
    std::vector<std::array<cl_int, 3>> samples(count);
    std::vector<cl_uchar> directions(count);
    std::vector<Part> parts(count);
    targets::ItemLayout rows{.first = 3 * width,
                             .strides = {static_cast<std::ptrdiff_t>(5 * width)},
                             .component_stride = -static_cast<std::ptrdiff_t>(width),
                             .components = 3,
                             .width = width};
    targets::ItemLayout fields{
        .first = 2000 * width,
        .strides = {static_cast<std::ptrdiff_t>(2 * width), static_cast<std::ptrdiff_t>(24 * width),
                    static_cast<std::ptrdiff_t>(150 * width)},
        .component_stride = static_cast<std::ptrdiff_t>(width),
        .components = 2,
        .width = width};
    std::vector<Part> to(4000, Part{9}), values(3 * count);
    std::vector<Part> expected = to;
    const auto place_of = [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t field) {
        return 2000 + static_cast<std::size_t>(2 * x + 24 * y + 150 * z) + field;
    };
    for (std::int64_t z = 0; z < grid.size[2]; ++z)
        for (std::int64_t y = 0; y < grid.size[1]; ++y)
            for (std::int64_t x = 0; x < grid.size[0]; ++x)
                for (std::size_t field = 0; field < 2; ++field) expected[place_of(x, y, z, field)] = -1;
    for (std::size_t n = 0; n < count; ++n) {
        // Each sample and direction once.
        const std::size_t number = n * 3 % 1187;
        directions[n] = static_cast<cl_uchar>(number % 2);
        const auto sample = static_cast<std::int64_t>(number / 2);
        const Index3 at{sample % grid.size[0], sample / grid.size[0] % grid.size[1],
                        sample / grid.size[0] / grid.size[1]};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            samples[n][axis] = static_cast<cl_int>(grid.first[axis] + at[axis]);
            values[3 * n + axis] = static_cast<Part>(random());
            expected[3 + 5 * n - axis] = values[3 * n + axis];
        }
        parts[n] = static_cast<Part>(n) / 512;
        expected[place_of(at[0], at[1], at[2], directions[n])] = parts[n];
    }
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, to.size() * width, to.data());
    rows.memory = fields.memory = memory();
    const targets::RowStore store(context, program);
    engine::CommandChain chain(context.queue(), {});
    store.enqueue_items(chain, device::copied(context, values), count, rows);
    store.enqueue_fields(
        chain,
        {count, device::copied(context, samples), device::copied(context, directions), device::copied(context, parts)},
        grid, fields);
    device::read_values(context, memory, to);
    return to == expected;
}

/// Bytes with a stride, as flags are.
bool stores_bytes_right(const device::Context& context, const cl::Program& program) {
    std::vector<cl_uchar> values(200), to(401, 9), expected = to;
    for (std::size_t n = 0; n < values.size(); ++n)
        expected[2 * n + 1] = values[n] = static_cast<cl_uchar>(n * 7 % 251);
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, to.size(), to.data());
    engine::CommandChain chain(context.queue(), {});
    targets::RowStore(context, program)
        .enqueue_items(chain, device::copied(context, values), values.size(),
                       {.memory = memory(), .first = 1, .strides = {2}, .component_stride = 1, .width = 1});
    device::read_values(context, memory, to);
    return to == expected;
}

/// A part of known bricks, and what the host makes of them.
struct KnownBricks {
    Layout layout{};  ///< its bricks alone
    std::vector<cl_uchar> marks;
    std::vector<cl_uint> listed;  ///< CLSDF_STORED
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

/// A DeviceSparseCounts.
using KnownCounts = std::array<cl_ulong, 3>;

/// Puts known bricks in order twice, as if they were two parts, of which the second has no room for its last brick.
std::optional<std::string> difference_of_order(const Device& device, const engine::Programs& programs) {
    device::Context& context = device::context_of(device);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    const engine::DeviceTools tools{context, pool, programs};
    const KnownBricks known;
    const std::size_t count = known.firsts.size(), runs = known.runs.size();
    const OutputSet outputs = Output::site;
    const targets::ListedBricks memory(*pool, count, known.marks.size(), targets::arrays_for(outputs));
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
    targets::OrderedTargets to;
    to.room = {2 * count - 1, 2 * runs};
    to.counts = {buffer(sizeof(KnownCounts)), 8};
    to.bricks = {buffer(to.room.bricks * sizeof(Index3)), 8};
    to.inside = {buffer(to.room.runs * sizeof(BrickRun)), 8};
    to.values[Output::distance] = {buffer(to.room.bricks * brick_samples * sizeof(float)), 4};
    to.values[Output::site] = {buffer(to.room.bricks * brick_samples), 1};
    engine::CommandChain chain(context.queue(), {});
    chain.then_fill(*memory.totals, 2 * sizeof(cl_ulong));
    targets::BrickStore store(tools, known.layout, marks, memory);
    for (int n = 0; n < 2; ++n) store.enqueue(chain, to);
    context.finish();
    if (read<KnownCounts>(context, to.counts.memory, 8, 1).front() != KnownCounts{2 * count, 2 * runs, 0})
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
        const bool is_left = place >= known.listed[CLSDF_STORED_IN_BAND];
        for (std::size_t i = 0; i < brick_samples; ++i) {
            const std::size_t from = place * brick_samples + i, at = n * brick_samples + i;
            if (found_distances[at] != distances[from] || found_sites[at] != (is_left ? 0xFF : sites[from]))
                return "values are stored in wrong places";
        }
    }
    return std::nullopt;
}

}  // namespace

TestSubject stored_boxes_subject(const Device& device, const engine::Programs& programs) {
    TestSubject subject;
    subject.name = "stored boxes";
    subject.build = [&programs](const device::BuildWatch& watch) { return std::vector{programs.store.get(watch)}; };
    subject.difference = [&device, &programs](const device::BuildWatch&) -> std::optional<std::string> {
        const device::Context& context = device::context_of(device);
        if (stores_right<std::uint8_t>(context, programs.store) &&
            stores_right<std::uint32_t>(context, programs.store) &&
            stores_right<std::uint64_t>(context, programs.store))
            return std::nullopt;
        return "elements are stored in wrong places";
    };
    return subject;
}

TestSubject stored_links_subject(const Device& device, const engine::Programs& programs) {
    TestSubject subject;
    subject.name = "stored links";
    subject.build = [&programs](const device::BuildWatch& watch) { return std::vector{programs.store.get(watch)}; };
    subject.difference = [&device, &programs](const device::BuildWatch&) -> std::optional<std::string> {
        const device::Context& context = device::context_of(device);
        if (stores_links_right<float>(context, programs.store) && stores_links_right<double>(context, programs.store) &&
            stores_bytes_right(context, programs.store))
            return std::nullopt;
        return "links are stored in wrong places";
    };
    return subject;
}

TestSubject ordered_bricks_subject(const Device& device, const engine::Programs& programs) {
    TestSubject subject;
    subject.name = "ordered bricks";
    subject.build = [&programs](const device::BuildWatch& watch) {
        return std::vector{programs.order.get(watch), programs.scan.get(watch)};
    };
    subject.difference = [&device, &programs](const device::BuildWatch&) {
        return difference_of_order(device, programs);
    };
    return subject;
}

}  // namespace clsdf::checks
