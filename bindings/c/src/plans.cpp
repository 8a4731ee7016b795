#include "handles.hpp"
#include "index_base.hpp"
#include "values.hpp"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using c::Call;
using c::given;
using c::guarded;
using c::made;
using c::of;

namespace {

std::vector<Request> requests_of(const clsdf_transform& transform, const clsdf_request* requests, std::int64_t count) {
    std::vector<Request> all = c::requests_of(requests, count);
    for (const Request& request : all) c::check_base(transform.index_base, request.targets);
    return all;
}

BlockSet blocks_of(const clsdf_transform& transform, const clsdf_block_set* blocks) {
    BlockSet result = c::block_set_of(blocks);
    c::check_base(transform.index_base, result.targets);
    return result;
}

/// A plan and the transform that updates it. Throws Error(invalid_argument) if they have different index bases.
template <typename Handle>
auto of_one_base(Handle* plan, const clsdf_transform* transform) {
    Handle& self = of(plan);
    const clsdf_transform& from = of(transform);
    if (self.index_base != from.index_base)
        throw c::misuse("the plan has index base " + std::to_string(self.index_base) + ", and the transform has " +
                        std::to_string(from.index_base) + "; update the plan with a transform of its index base");
    return std::pair<decltype(self.plan)&, const DistanceTransform&>(self.plan, from.transform);
}

SparseRequest sparse_request_of(const clsdf_transform& transform, const clsdf_sparse_request* request) {
    const clsdf_sparse_request& from = given(request, "request");
    c::check_reserved(from.reserved, "clsdf_sparse_request");
    const OutputSet outputs = c::outputs_of(from.outputs);
    c::check_base(transform.index_base, outputs);
    return {c::grid_of(&from.grid), c::band_of(&from.band), outputs};
}

SparseCounts counts_of(const clsdf_sparse_counts* room) {
    const clsdf_sparse_counts& from = given(room, "room");
    return {c::count_of(from.bricks, "clsdf_sparse_counts.bricks"), c::count_of(from.runs, "clsdf_sparse_counts.runs")};
}

SparseDeviceTargets targets_of(const clsdf_sparse_plan& plan, const clsdf_sparse_buffers* buffers) {
    const clsdf_sparse_buffers from = c::read_given(buffers, CLSDF_SPARSE_BUFFERS_INIT, "clsdf_sparse_buffers");
    const auto range = [](void* memory, std::int64_t offset, const char* name) {
        return DeviceRange{static_cast<cl_mem>(memory), c::count_of(offset, name)};
    };
    SparseDeviceTargets targets{range(from.counts, from.counts_offset, "clsdf_sparse_buffers.counts_offset"),
                                range(from.bricks, from.bricks_offset, "clsdf_sparse_buffers.bricks_offset"),
                                range(from.inside, from.inside_offset, "clsdf_sparse_buffers.inside_offset"),
                                c::targets_of(from.values, plan.plan.room().bricks * brick_samples)};
    c::check_base(plan.index_base, targets.values);
    return targets;
}

/// Enqueues with a list of events, and an event of the end if `done` is not null.
template <typename Enqueue>
void enqueue(void* const* wait_list, std::int64_t wait_count, void** done, const Enqueue& enqueue_after) {
    const std::vector<cl_event> events = c::events_of(wait_list, wait_count);
    cl_event end = nullptr;
    enqueue_after(std::span<const cl_event>(events), done != nullptr ? &end : nullptr);
    if (done != nullptr) *done = end;
}

/// As guarded(): *done is null after a failure. Until then the wait list may have it.
template <typename Body>
clsdf_status enqueued(void** done, const Body& body) {
    const clsdf_status status = guarded(body);
    if (status != CLSDF_OK && done != nullptr) *done = nullptr;
    return status;
}

}  // namespace

clsdf_status clsdf_plan_create(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                               std::uint32_t outputs, const clsdf_call_options* call, clsdf_plan** plan) {
    return made(plan, "plan", [&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        const OutputSet wanted = c::outputs_of(outputs);
        c::check_base(self.index_base, wanted);
        return new clsdf_plan(self.transform.plan(c::grid_of(grid), c::band_of(band), wanted, caller), self.index_base);
    });
}

clsdf_status clsdf_plan_create_requests(const clsdf_transform* transform, const clsdf_request* requests,
                                        std::int64_t count, const clsdf_call_options* call, clsdf_plan** plan) {
    return made(plan, "plan", [&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        return new clsdf_plan(self.transform.plan(requests_of(self, requests, count), caller), self.index_base);
    });
}

clsdf_status clsdf_plan_create_blocks(const clsdf_transform* transform, const clsdf_block_set* blocks,
                                      const clsdf_call_options* call, clsdf_plan** plan) {
    return made(plan, "plan", [&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        return new clsdf_plan(self.transform.plan(blocks_of(self, blocks), caller), self.index_base);
    });
}

clsdf_status clsdf_plan_bytes_requests(const clsdf_transform* transform, const clsdf_request* requests,
                                       std::int64_t count, const clsdf_call_options* call, std::int64_t* bytes) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        given(bytes, "bytes") =
            static_cast<std::int64_t>(self.transform.plan_bytes(requests_of(self, requests, count), caller));
    });
}

clsdf_status clsdf_plan_bytes_blocks(const clsdf_transform* transform, const clsdf_block_set* blocks,
                                     const clsdf_call_options* call, std::int64_t* bytes) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        given(bytes, "bytes") = static_cast<std::int64_t>(self.transform.plan_bytes(blocks_of(self, blocks), caller));
    });
}

clsdf_status clsdf_plan_enqueue(clsdf_plan* plan, void* queue, void* const* wait_list, std::int64_t wait_count,
                                void** done) {
    return enqueued(done, [&] {
        Plan& self = of(plan).plan;
        enqueue(wait_list, wait_count, done, [&](std::span<const cl_event> events, cl_event* end) {
            self.enqueue(static_cast<cl_command_queue>(queue), events, end);
        });
    });
}

clsdf_status clsdf_plan_enqueue_to(clsdf_plan* plan, void* queue, const clsdf_targets* targets, std::int64_t count,
                                   void* const* wait_list, std::int64_t wait_count, void** done) {
    return enqueued(done, [&] {
        clsdf_plan& self = of(plan);
        c::elements(targets, count, "targets");
        const std::span<const Request> requests = self.plan.requests();
        std::vector<OutputTargets> all(static_cast<std::size_t>(count));
        // The library refuses another number of them.
        for (std::size_t i = 0; i < all.size() && all.size() == requests.size(); ++i)
            all[i] = c::for_request(i, all.size(), [&] {
                OutputTargets to = c::targets_of(targets[i], requests[i].grid);
                c::check_base(self.index_base, to);
                return to;
            });
        enqueue(wait_list, wait_count, done, [&](std::span<const cl_event> events, cl_event* end) {
            self.plan.enqueue(static_cast<cl_command_queue>(queue), all, events, end);
        });
    });
}

clsdf_status clsdf_plan_update(clsdf_plan* plan, const clsdf_transform* transform, const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, caller);
    });
}

clsdf_status clsdf_plan_update_grids(clsdf_plan* plan, const clsdf_transform* transform, const clsdf_grid* grids,
                                     std::int64_t count, const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        c::elements(grids, count, "grids");
        std::vector<Grid> all;
        std::transform(grids, grids + count, std::back_inserter(all),
                       [](const clsdf_grid& grid) { return c::grid_of(&grid); });
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, all, caller);
    });
}

clsdf_status clsdf_plan_update_requests(clsdf_plan* plan, const clsdf_transform* transform,
                                        const clsdf_request* requests, std::int64_t count,
                                        const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, requests_of(*transform, requests, count), caller);
    });
}

clsdf_status clsdf_plan_update_blocks(clsdf_plan* plan, const clsdf_transform* transform, const clsdf_block_set* blocks,
                                      const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, blocks_of(*transform, blocks), caller);
    });
}

clsdf_status clsdf_plan_sign(const clsdf_plan* plan, std::int32_t* rule) {
    return guarded([&] { given(rule, "rule") = static_cast<std::int32_t>(of(plan).plan.sign()); });
}

clsdf_status clsdf_plan_statistics(const clsdf_plan* plan, clsdf_statistics* statistics) {
    return guarded([&] { c::write_given(c::as_c(of(plan).plan.statistics()), statistics, "clsdf_statistics"); });
}

clsdf_status clsdf_plan_request_count(const clsdf_plan* plan, std::int64_t* count) {
    return guarded([&] { given(count, "count") = static_cast<std::int64_t>(of(plan).plan.requests().size()); });
}

clsdf_status clsdf_plan_request(const clsdf_plan* plan, std::int64_t index, clsdf_grid* grid, clsdf_band* band,
                                clsdf_target* targets, std::int64_t size, std::int64_t* target_count) {
    return guarded([&] {
        const std::span<const Request> requests = of(plan).plan.requests();
        c::elements(targets, size, "targets");
        if (c::count_of(index, "index") >= requests.size())
            throw c::misuse("there is no request " + std::to_string(index) + "; the plan has " +
                            std::to_string(requests.size()));
        const Request& request = requests[static_cast<std::size_t>(index)];
        if (grid != nullptr) *grid = c::as_c(request.grid);
        if (band != nullptr) *band = c::as_c(request.band);
        const std::span<const OutputTarget> all = request.targets.all();
        for (std::size_t i = 0; i < all.size() && i < static_cast<std::size_t>(size); ++i) targets[i] = c::as_c(all[i]);
        if (target_count != nullptr) *target_count = static_cast<std::int64_t>(all.size());
    });
}

clsdf_status clsdf_sparse_plan_create(const clsdf_transform* transform, const clsdf_sparse_request* request,
                                      const clsdf_sparse_counts* room, const clsdf_call_options* call,
                                      clsdf_sparse_plan** plan) {
    return made(plan, "plan", [&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        return new clsdf_sparse_plan(
            self.transform.plan_sparse(sparse_request_of(self, request), counts_of(room), caller), self.index_base);
    });
}

clsdf_status clsdf_sparse_plan_enqueue(clsdf_sparse_plan* plan, void* queue, const clsdf_sparse_buffers* buffers,
                                       void* const* wait_list, std::int64_t wait_count, void** done) {
    return enqueued(done, [&] {
        clsdf_sparse_plan& self = of(plan);
        const SparseDeviceTargets targets = targets_of(self, buffers);
        enqueue(wait_list, wait_count, done, [&](std::span<const cl_event> events, cl_event* end) {
            self.plan.enqueue(static_cast<cl_command_queue>(queue), targets, events, end);
        });
    });
}

clsdf_status clsdf_sparse_plan_update(clsdf_sparse_plan* plan, const clsdf_transform* transform,
                                      const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, caller);
    });
}

clsdf_status clsdf_sparse_plan_update_request(clsdf_sparse_plan* plan, const clsdf_transform* transform,
                                              const clsdf_sparse_request* request, const clsdf_sparse_counts* room,
                                              const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, sparse_request_of(*transform, request), counts_of(room), caller);
    });
}

clsdf_status clsdf_sparse_plan_request(const clsdf_sparse_plan* plan, clsdf_sparse_request* request,
                                       clsdf_sparse_counts* room) {
    return guarded([&] {
        const SparsePlan& self = of(plan).plan;
        if (request != nullptr)
            *request = {c::as_c(self.request().grid), c::as_c(self.request().band), self.request().outputs.bits(), 0};
        if (room != nullptr)
            *room = {static_cast<std::int64_t>(self.room().bricks), static_cast<std::int64_t>(self.room().runs)};
    });
}

clsdf_status clsdf_sparse_plan_sign(const clsdf_sparse_plan* plan, std::int32_t* rule) {
    return guarded([&] { given(rule, "rule") = static_cast<std::int32_t>(of(plan).plan.sign()); });
}

clsdf_status clsdf_sparse_plan_statistics(const clsdf_sparse_plan* plan, clsdf_statistics* statistics) {
    return guarded([&] { c::write_given(c::as_c(of(plan).plan.statistics()), statistics, "clsdf_statistics"); });
}

clsdf_status clsdf_link_plan_create(const clsdf_transform* transform, const clsdf_grid* grid,
                                    const std::int32_t* directions, std::int64_t direction_count, std::int64_t room,
                                    const clsdf_link_options* options, const clsdf_call_options* call,
                                    clsdf_link_plan** plan) {
    return made(plan, "plan", [&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        return new clsdf_link_plan(
            self.transform.plan_links(c::grid_of(grid), c::directions_of(directions, direction_count),
                                      c::count_of(room, "room"), c::link_options_of(options), caller),
            self.index_base);
    });
}

clsdf_status clsdf_link_plan_enqueue(clsdf_link_plan* plan, void* queue, const clsdf_link_buffers* buffers,
                                     void* const* wait_list, std::int64_t wait_count, void** done) {
    return enqueued(done, [&] {
        clsdf_link_plan& self = of(plan);
        const clsdf_link_buffers from = c::read_given(buffers, CLSDF_LINK_BUFFERS_INIT, "clsdf_link_buffers");
        const LinkTargets targets = c::link_targets_of(from, self.plan.grid().sample_count());
        if (targets.triangles.is_given()) c::check_base(self.index_base, OutputSet(Output::triangle));
        const DeviceRange count{static_cast<cl_mem>(from.count),
                                c::count_of(from.count_offset, "clsdf_link_buffers.count_offset")};
        enqueue(wait_list, wait_count, done, [&](std::span<const cl_event> events, cl_event* end) {
            self.plan.enqueue(static_cast<cl_command_queue>(queue), targets, count, events, end);
        });
    });
}

clsdf_status clsdf_link_plan_update(clsdf_link_plan* plan, const clsdf_transform* transform,
                                    const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, caller);
    });
}

clsdf_status clsdf_link_plan_update_grid(clsdf_link_plan* plan, const clsdf_transform* transform,
                                         const clsdf_grid* grid, std::int64_t room, const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, c::grid_of(grid), c::count_of(room, "room"), caller);
    });
}

clsdf_status clsdf_link_plan_grid(const clsdf_link_plan* plan, clsdf_grid* grid, std::int64_t* room) {
    return guarded([&] {
        const LinkPlan& self = of(plan).plan;
        if (grid != nullptr) *grid = c::as_c(self.grid());
        if (room != nullptr) *room = static_cast<std::int64_t>(self.room());
    });
}

clsdf_status clsdf_link_plan_sign(const clsdf_link_plan* plan, std::int32_t* rule) {
    return guarded([&] { given(rule, "rule") = static_cast<std::int32_t>(of(plan).plan.sign()); });
}

clsdf_status clsdf_link_plan_statistics(const clsdf_link_plan* plan, clsdf_statistics* statistics) {
    return guarded([&] { c::write_given(c::as_c(of(plan).plan.statistics()), statistics, "clsdf_statistics"); });
}

clsdf_status clsdf_point_plan_create(const clsdf_transform* transform, std::int64_t count, double half_width,
                                     std::uint32_t outputs, const clsdf_call_options* call, clsdf_point_plan** plan) {
    return made(plan, "plan", [&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        const OutputSet wanted = c::outputs_of(outputs);
        c::check_base(self.index_base, wanted);
        return new clsdf_point_plan(self.transform.plan_points(c::count_of(count, "count"), half_width, wanted, caller),
                                    self.index_base);
    });
}

clsdf_status clsdf_point_plan_enqueue(clsdf_point_plan* plan, void* queue, const clsdf_array* points,
                                      const clsdf_target* targets, std::int64_t target_count, const clsdf_array* status,
                                      void* const* wait_list, std::int64_t wait_count, void** done) {
    return enqueued(done, [&] {
        clsdf_point_plan& self = of(plan);
        const InputArray from = c::input_of(points, "points");
        const OutputTargets to = c::targets_of(clsdf_targets{targets, target_count}, from.count);
        const OutputArray status_to = status != nullptr ? c::output_of(status, "status", from.count) : OutputArray();
        enqueue(wait_list, wait_count, done, [&](std::span<const cl_event> events, cl_event* end) {
            self.plan.enqueue(static_cast<cl_command_queue>(queue), from, to, events, end, status_to);
        });
    });
}

clsdf_status clsdf_point_plan_update(clsdf_point_plan* plan, const clsdf_transform* transform,
                                     const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const auto& [self, from] = of_one_base(plan, transform);
        self.update(from, caller);
    });
}

clsdf_status clsdf_point_plan_count(const clsdf_point_plan* plan, std::int64_t* count) {
    return guarded([&] { given(count, "count") = static_cast<std::int64_t>(of(plan).plan.count()); });
}

clsdf_status clsdf_point_plan_sign(const clsdf_point_plan* plan, std::int32_t* rule) {
    return guarded([&] { given(rule, "rule") = static_cast<std::int32_t>(of(plan).plan.sign()); });
}

clsdf_status clsdf_point_plan_statistics(const clsdf_point_plan* plan, clsdf_statistics* statistics) {
    return guarded([&] { c::write_given(c::as_c(of(plan).plan.statistics()), statistics, "clsdf_statistics"); });
}
