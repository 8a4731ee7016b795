#include "plans/link_plan_state.hpp"

#include "segments/result_arrays.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/stored_links.hpp"
#include "targets/target_overlap.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

namespace clsdf::plans {

PlannedLinks planned(const device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                     segments::DeviceLinks&& links) {
    auto totals = device::uploaded(
        context, pool, std::array{DeviceLinkCount{links.count, 1}, DeviceLinkCount{links.count, 0}}, "links of a plan");
    return {std::move(links), std::move(totals)};
}

PlannedLinks uploaded(const device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                      const Links& links, std::size_t room) {
    segments::DeviceLinks on_device;
    on_device.count = links.size();
    PlannedLinks planned = plans::planned(context, pool, std::move(on_device));
    const auto upload = [&](const auto& values) { return device::uploaded(context, pool, values, "links of a plan"); };
    std::vector<std::uint8_t> sides(links.inside.sample_count());
    for (std::size_t n = 0; n < sides.size(); ++n) sides[n] = links.inside.is_inside(n) ? 1 : 0;
    planned.inside = upload(sides);
    if (links.size() == 0 || links.size() > room) return planned;
    std::vector<float> floats(links.size());
    std::ranges::transform(links.q, floats.begin(), as_float_part);
    planned.samples = upload(links.samples);
    planned.directions = upload(links.directions);
    planned.q = upload(links.q);
    planned.q_floats = upload(floats);
    planned.triangles = upload(links.triangles);
    planned.counts = upload(links.counts);
    planned.flags = upload(links.flags);
    return planned;
}

void LinkPlanState::enqueue(const RunOptions& options, const LinkTargets& given, const DeviceRange& count) {
    using enum ElementType;
    if (given.room > asked().room)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the arrays have room for {} links, and the plan has room for {}; give that, or make "
                                "the plan with more",
                                given.room, asked().room));
    const device::Context& context = this->context();
    const Grid& grid = asked().grid;
    const Index3 rows{static_cast<std::int64_t>(given.room), 1, 1},
        samples{static_cast<std::int64_t>(grid.sample_count()), 1, 1};
    const PlannedLinks& made = made_;
    const bool has_rows = std::ranges::any_of(
        std::array{&given.samples, &given.directions, &given.q, &given.triangles, &given.counts, &given.flags},
        [](const OutputArray* array) { return array->is_given(); });
    // With too little room rows and fields stay as they are.
    const bool is_complete = made.count <= (has_rows ? given.room : asked().room);
    struct Stored {
        segments::ResultArray array;
        const device::BufferPool::Lease& values;
        std::size_t count;
    };
    std::vector<Stored> stored;
    std::vector<targets::WrittenArray> written;
    const auto array_of = [&](const OutputArray& array, const char* name, const Index3& size, std::size_t components,
                              std::initializer_list<ElementType> types, bool are_fields = false) {
        segments::ResultArray checked =
            segments::ResultArray::on_device(array, name, size, components, types, context, are_fields);
        if (checked.is_given() && size[0] * size[1] * size[2] > 0) written.push_back(checked.written());
        return checked;
    };
    const auto add_rows = [&](const segments::ResultArray& array, const PlannedLinks::Lease& values) {
        if (array.is_given() && is_complete) stored.push_back({array, values, made.count});
    };
    add_rows(array_of(given.samples, "the array of samples", rows, 3, {int32}), made.samples);
    add_rows(array_of(given.directions, "the array of directions", rows, 1, {uint8}), made.directions);
    const segments::ResultArray q = array_of(given.q, "the array of q", rows, 1, {float64, float32});
    add_rows(q, q.type() == float32 ? made.q_floats : made.q);
    add_rows(array_of(given.triangles, "the array of triangles", rows, 1, {uint32, int32}), made.triangles);
    add_rows(array_of(given.counts, "the array of counts", rows, 1, {uint32, int32}), made.counts);
    add_rows(array_of(given.flags, "the array of flags", rows, 1, {uint8}), made.flags);
    const segments::ResultArray inside = array_of(given.inside, "the array of inside", samples, 1, {uint8});
    if (inside.is_given()) stored.push_back({inside, made.inside, grid.sample_count()});
    const segments::ResultArray dense =
        array_of(given.dense, "the dense array of q", grid.size, asked().directions.size(), {float64, float32}, true);
    cl::Buffer of_count;
    if (count.memory != nullptr) {
        of_count = targets::checked_range(context, count, sizeof(DeviceLinkCount), sizeof(std::uint64_t),
                                          "the memory of the count");
        const targets::BufferPlace begin = targets::place_of(count.memory, count.offset);
        written.push_back({.memory = begin.memory(),
                           .first = begin.byte,
                           .width = sizeof(DeviceLinkCount),
                           .name = "the memory of the count"});
    }
    targets::refuse_overlap(written);
    const targets::LinkStore store(context, programs_.store);
    run(options, [&](engine::CommandChain& chain) {
        for (const Stored& one : stored) store.enqueue_items(chain, *one.values, one.count, one.array.place());
        if (dense.is_given() && is_complete)
            store.enqueue_fields(
                chain,
                {made.count, *made.samples, *made.directions, dense.type() == float32 ? *made.q_floats : *made.q}, grid,
                dense.place());
        if (of_count() == nullptr) return;
        const std::size_t from = is_complete ? 0 : sizeof(DeviceLinkCount);
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueCopyBuffer(*made.totals, of_count, from, count.offset, sizeof(DeviceLinkCount), wait, event);
        });
    });
}

}  // namespace clsdf::plans
