#include "plans/link_plan_state.hpp"

#include "core/refuse.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/row_arrays.hpp"
#include "targets/stored_rows.hpp"
#include "targets/target_overlap.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
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
    planned.q_floats = upload(floats);
    for (std::size_t n = 0; n < link_columns.size(); ++n) {
        const ColumnValues values = link_columns[n].values(links);
        planned.*segments::device_columns[n] = upload(std::span(values.first, values.count * values.stride));
    }
    return planned;
}

void LinkPlanState::enqueue(const RunOptions& options, const LinkTargets& given, const DeviceRange& count) {
    using enum ElementType;
    if (given.room > asked().room)
        refuse(
            "the arrays have room for {} links, and the plan has room for {}; give that, or make "
            "the plan with more",
            given.room, asked().room);
    const device::Context& context = this->context();
    const Grid& grid = asked().grid;
    const PlannedLinks& made = made_;
    // With too little room rows and fields stay as they are.
    const bool is_complete = made.count <= (targets::has_rows(link_columns, given) ? given.room : asked().room);
    const auto array_of = [&](const OutputArray& array, const char* name, const Index3& size, std::size_t components,
                              const ElementTypes& types, bool are_fields = false) {
        return targets::ResultArray::on_device(array, name, size, components, types, context, are_fields);
    };
    const targets::RowArrays<LinkColumn> rows(
        link_columns, given,
        [&](const OutputArray& array, const char* name, const Index3& size, std::size_t components,
            const ElementTypes& types) { return array_of(array, name, size, components, types); });
    const targets::ResultArray inside = array_of(given.inside, "the array of inside",
                                                 {static_cast<std::int64_t>(grid.sample_count()), 1, 1}, 1, {uint8});
    const targets::ResultArray dense =
        array_of(given.dense, "the dense array of q", grid.size, asked().directions.size(), {float64, float32}, true);
    std::vector<targets::WrittenArray> written;
    rows.add_to(written);
    for (const targets::ResultArray* array : {&inside, &dense})
        if (array->is_given()) written.push_back(array->written());
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
    const targets::RowStore store(context, programs_.store);
    run(options, [&](engine::CommandChain& chain) {
        if (is_complete)
            rows.for_each_given([&](std::size_t n, const targets::ResultArray& array) {
                const PlannedLinks::Lease& values =
                    array.type() == float32 ? made.q_floats : made.*segments::device_columns[n];
                store.enqueue_items(chain, *values, made.count, array.layout());
            });
        if (inside.is_given()) store.enqueue_items(chain, *made.inside, grid.sample_count(), inside.layout());
        if (dense.is_given() && is_complete)
            store.enqueue_fields(
                chain,
                {made.count, *made.samples, *made.directions, dense.type() == float32 ? *made.q_floats : *made.q}, grid,
                dense.layout());
        if (of_count() == nullptr) return;
        const std::size_t from = is_complete ? 0 : sizeof(DeviceLinkCount);
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueCopyBuffer(*made.totals, of_count, from, count.offset, sizeof(DeviceLinkCount), wait, event);
        });
    });
}

}  // namespace clsdf::plans
