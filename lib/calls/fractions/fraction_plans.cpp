// Plans of fractions of cells, and those in memory of a device by kernels.
#include "calls/fractions/fraction_calls.hpp"
#include "checks/known_fractions.hpp"
#include "core/large_memory.hpp"
#include "core/lifetime.hpp"
#include "cutting/cancellation.hpp"
#include "cutting/fraction_checks.hpp"
#include "plans/fraction_plan_state.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/row_arrays.hpp"

#include <clsdf/device.hpp>
#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <memory>
#include <utility>

namespace clsdf {

namespace {

constexpr const char* memory_remedy = "for the plan; plan a part of the grid";

/// Called between stages: tells the fraction done.
std::function<void(double)> between(const CallOptions& call) {
    return [&call, cancellation = cutting::Cancellation(call.should_stop, "the search for cut cells")](double done) {
        cancellation.check();
        if (call.progress) call.progress({.fraction = done});
    };
}

void make(plans::FractionPlanState& state, const OuterSurface& surface, plans::AskedFractions asked,
          const CallOptions& call) {
    checks::ensure_tested(state.device, checks::fractions_subject(state.device, state.programs));
    state.make(surface, std::move(asked), between(call));
    if (call.progress) call.progress({.fraction = 1});
}

}  // namespace

Error calls::too_little_room(std::size_t rows, std::size_t room) {
    return {ErrorCode::invalid_argument,
            fmt::format("the surface meets {} cells, and the arrays have room for {}; give them room for as many", rows,
                        room)};
}

bool calls::are_found_by_kernels(const Device& device, const OuterSurface& surface, const Grid& grid,
                                 const FractionRows& rows) {
    return !device::context_of(device).capabilities().is_processor &&
           (targets::has_rows(cell_columns, rows) || rows.full.is_given()) && plans::are_on_device(rows) &&
           cutting::DeviceFractions::can_number(surface.mesh, grid);
}

void calls::fractions_by_kernels(const Device& device, const OuterSurface& surface, const Grid& grid,
                                 const FractionRows& rows, std::size_t& count, const FractionOptions& options,
                                 const CallOptions& call) {
    count = 0;
    cutting::check_options(options);
    device::Context& context = device::context_of(device);
    const engine::Programs programs(context, KernelBody::automatic);
    const plans::StoredRows stored(rows, grid, context);
    targets::refuse_overlap(stored.written);
    checks::ensure_tested(device, checks::fractions_subject(device, programs));
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    const engine::DeviceTools tools{context, pool, programs};
    targets::wait_for(context, call.wait_list);
    context.begin_call();
    const std::function<void(double)> tell = between(call);
    tell(0);
    context.run_or_drain([&] {
        const auto vertices = device::uploaded(context, pool, surface.mesh.vertices(), "vertices");
        cutting::DeviceFractions cuts(tools, surface.mesh, grid, options, stored.has_pieces);
        const bool needs_room = targets::has_rows(cell_columns, rows);
        if (!cuts.run_and_make_room(tools, cutting::device_vertices(*vertices, cuts.vertex_count()),
                                    needs_room ? rows.room : 0, tell))
            cutting::refuse_far_vertices(surface.mesh, grid);
        const auto found = cuts.read(tools);
        if (found.rows > rows.room && needs_room) {
            count = found.rows;
            throw too_little_room(found.rows, rows.room);
        }
        stored.enqueue(cuts, tools, engine::Launches(tools.queue(), context.kernels()));
        context.finish();
        count = found.rows;
    });
    if (call.progress) call.progress({.fraction = 1});
}

FractionPlan::FractionPlan(const Device& device, const OuterSurface& surface, const Grid& grid, std::size_t room,
                           const FractionOptions& options, const CallOptions& call) {
    with_host_memory(memory_remedy, [&] {
        device::guarded([&] {
            auto made = std::make_unique<State>(
                device, std::make_shared<device::BufferPool>(device::shared_context_of(device)));
            make(*made, surface, {grid, options, room}, call);
            state_ = std::move(made);
        });
    });
}
FractionPlan::FractionPlan(FractionPlan&&) noexcept = default;
FractionPlan& FractionPlan::operator=(FractionPlan&&) noexcept = default;
FractionPlan::~FractionPlan() = default;

FractionPlan::State& FractionPlan::state() const {
    return held_by(state_, "FractionPlan");
}

const Grid& FractionPlan::grid() const {
    return state().asked().grid;
}

const FractionOptions& FractionPlan::options() const {
    return state().asked().options;
}

std::size_t FractionPlan::room() const {
    return state().asked().room;
}

std::size_t FractionPlan::vertex_count() const {
    return state().made().cuts->vertex_count();
}

std::size_t FractionPlan::row_count() const {
    return state().made().rows;
}

const TransformStatistics& FractionPlan::statistics() const {
    return state().published;
}

void FractionPlan::enqueue(cl_command_queue queue, const FractionRows& rows, const DeviceRange& count,
                           std::span<const cl_event> wait_list, cl_event* done) {
    State& own = state();
    with_host_memory("for a run of the plan", [&] {
        device::guarded([&] { own.enqueue({queue, wait_list, done}, nullptr, rows, count); });
    });
}

void FractionPlan::enqueue(cl_command_queue queue, const InputArray& vertices, const FractionRows& rows,
                           const DeviceRange& count, std::span<const cl_event> wait_list, cl_event* done) {
    State& own = state();
    with_host_memory("for a run of the plan", [&] {
        device::guarded([&] { own.enqueue({queue, wait_list, done}, &vertices, rows, count); });
    });
}

void FractionPlan::update(const OuterSurface& surface, const CallOptions& call) {
    update(surface, Grid(grid()), room(), call);
}

void FractionPlan::update(const OuterSurface& surface, const Grid& grid, std::size_t room, const CallOptions& call) {
    State& own = state();
    with_host_memory(memory_remedy, [&] {
        device::guarded([&] { make(own, surface, {grid, own.asked().options, room}, call); });
    });
}

}  // namespace clsdf
