#include "calls/transform/transform_state.hpp"
#include "checks/known_segments.hpp"
#include "core/floating_point.hpp"
#include "core/large_memory.hpp"
#include "core/refuse.hpp"
#include "core/stopwatch.hpp"
#include "plan/slabs.hpp"
#include "segments/crossings.hpp"
#include "segments/device_links.hpp"
#include "segments/link_arrays.hpp"
#include "segments/links.hpp"
#include "targets/mapped_memory.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

bool DistanceTransform::State::find_links_by_kernels(const FindByKernels& find, calls::RunningCall& running) {
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    context().begin_call();
    try {
        return calls::with_remedies(&running, {forgetting()}, [&] {
            const std::optional<engine::CrossedMesh> mesh = kept_mesh->crossed_mesh();
            if (!mesh || !kept_mesh->has_own_numbers()) return false;
            test(checks::links_subject(device, programs), running);
            bool are_found = false;
            context().run_or_drain([&] { are_found = find({tools(), *mesh, sign, running.between(0, 0.5)}); });
            return are_found;
        });
    } catch (const Error& error) {
        if (!running.is_short_of_memory(error)) throw;
        return false;
    }
}

template <typename Find>
CallStatistics DistanceTransform::State::find_links(const Grid& grid, const std::array<std::int32_t, 3>& margin,
                                                    Hits hits, const CallOptions& call, const Find& find,
                                                    const FindByKernels& by_kernels) {
    grid.validate();
    Grid with_margin = grid;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        with_margin.first[axis] -= margin[axis];
        with_margin.size[axis] += 2 * margin[axis];
    }
    engine::check_grid(with_margin);
    with_margin.sample_count();
    if (hits == Hits::walls && sign == SignRule::none)
        refuse_unsupported(
            "walls of {} are asked for, and it has no sign: make the transform of a closed mesh "
            "with a sign rule, or ask for the links of its faces",
            kept_mesh->name());
    targets::wait_for(context(), call.wait_list);
    calls::RunningCall running{call};
    running.throw_if_stopped();
    if (const auto* restriction = kept_mesh->restriction()) {
        restriction->check(with_margin, Band::signs_only(), sign,
                           "the samples of the grid, and those beside it to which links lead,");
        // The part has not the whole floor.
        if (const double lowest = with_margin.position(0, 0, 0)[2]; sign == SignRule::below && lowest <= *floor)
            refuse(
                "links or edges reach down to z = {}, and a restricted transform with the sign rule "
                "below has none of its floor, at z = {}; ask above it, or the whole transform",
                lowest, *floor);
    }
    CallStatistics& statistics = running.statistics;
    const Stopwatch preparing;
    const bool is_tried = by_kernels && programs.body == KernelBody::by_group;
    if (is_tried && find_links_by_kernels(by_kernels, running)) {
        statistics.triangles = kept_mesh->face_count();
        statistics.field_seconds = preparing.seconds();
        return running.finish();
    }
    std::shared_ptr<const engine::WideTree> tree;
    const auto mesh = [&] {
        const KeepsBudget keeps_budget(*this);
        const std::scoped_lock lock(mutex);
        context().begin_call();
        return calls::with_remedies(nullptr, {forgetting()}, [&] {
            if (sign == SignRule::below) return kept_points->sign_mesh();
            auto made = kept_points->mesh();
            if (made->film) tree = kept_points->wide_tree();
            return made;
        });
    }();
    if (!engine::are_exact(*mesh)) engine::refuse_inexact(*mesh, kept_mesh->name());
    statistics.triangles = mesh->face_count();
    statistics.polyhedra_seconds = preparing.seconds();
    const Stopwatch finding;
    const DefaultFloatingPoint usual;
    find(segments::LinkInputs{{*mesh, kept_mesh->numbers()}, tree.get(), sign, running.between(is_tried ? 0.5 : 0, 1)});
    statistics.field_seconds = finding.seconds();
    return running.finish();
}

namespace {

/// "for the links of 3 x 4 x 5 samples, whose sides alone take 8 bytes; ask for those of a part of the grid"
std::string lacking(const char* what, const Grid& grid, const char* whose, double bytes) {
    return fmt::format("{} of {} x {} x {} samples, {} take {:.0f} bytes; ask for those of a part of the grid", what,
                       grid.size[0], grid.size[1], grid.size[2], whose, bytes);
}

double samples_of(const Grid& grid) {
    return static_cast<double>(grid.size[0]) * static_cast<double>(grid.size[1]) * static_cast<double>(grid.size[2]);
}

/// A bit for each sample.
std::string lacking_for_links(const char* what, const Grid& grid) {
    return lacking(what, grid, "whose sides alone", std::ceil(samples_of(grid) / 8));
}

std::string lacking_for_crossings(const Grid& grid, bool with_counts) {
    double edges = 0;
    for (const std::int64_t size : grid.size)
        edges += samples_of(grid) / static_cast<double>(size) * static_cast<double>(size - 1);
    const double each = sizeof(double) + sizeof(std::uint32_t) * (with_counts ? 2 : 1);
    return lacking("for the crossings", grid, "which", edges * each + std::ceil(samples_of(grid) / 8));
}

segments::LinkChoice choice_of(const LinkOptions& options) {
    if (options.with_between && options.hits == Hits::faces)
        refuse(
            "links with a body between their ends are asked for, and hits are faces, whose links are all there "
            "are; leave out with_between, or ask for walls");
    return {.hits = options.hits, .with_between = options.with_between};
}

/// Room for any number of links.
constexpr auto all_rows = std::numeric_limits<std::size_t>::max();

/// Whether all arrays that are given are memory of the device.
bool are_on_device(const LinkTargets& targets) {
    std::vector<const OutputArray*> arrays{&targets.inside, &targets.dense};
    for (const LinkColumn& column : link_columns) arrays.push_back(&(targets.*column.target));
    std::erase_if(arrays, [](const OutputArray* array) { return !array->is_given(); });
    return !arrays.empty() && std::ranges::all_of(arrays, [](const auto* array) { return array->device != nullptr; });
}

/// A function of State::find_links() that finds links by kernels; empty if they are of another kind than kernels find.
using FindByKernels = std::function<bool(const segments::DeviceLinkInputs&)>;
FindByKernels for_kernels(const segments::LinkChoice& choice, FindByKernels find) {
    const bool are_usual = choice.hits == Hits::walls && !choice.with_between && !choice.with_gaps;
    return are_usual ? std::move(find) : FindByKernels();
}

}  // namespace

DistanceTransform::State::FoundLinks DistanceTransform::State::find_planned_links(const plans::AskedLinks& asked,
                                                                                  const CallOptions& call) {
    segments::check_directions(asked.directions);
    const segments::LinkChoice choice = choice_of(asked.options);
    FoundLinks found;
    found.statistics = find_links(
                           asked.grid, segments::margin_of(asked.directions), asked.options.hits, call,
                           [&](const auto& inputs) {
                               found.on_host = segments::find_links(inputs, asked.grid, asked.directions, choice);
                           },
                           for_kernels(choice,
                                       [&](const auto& inputs) {
                                           found.on_device = segments::links_on_device(inputs, asked.grid,
                                                                                       asked.directions, asked.room);
                                           return found.on_device.has_value();
                                       }))
                           .published();
    return found;
}

TransformStatistics DistanceTransform::State::store(const plans::AskedLinks& asked, FoundLinks found,
                                                    const LinkTargets& targets, const CallOptions& call) {
    plans::LinkPlanState made(device, pool, programs);
    plan(made, asked, std::move(found), call);
    device::guarded([&] {
        cl::Event done;
        made.enqueue({.done = &done()}, targets, {});
        context().wait(done, context().kernels().launched().count());
    });
    made.give_back();
    return made.published;
}

Links DistanceTransform::links(const Grid& grid, std::span<const LinkDirection> directions, const LinkOptions& options,
                               const CallOptions& call, TransformStatistics* statistics) const {
    return with_host_memory(lacking_for_links("for the links", grid).c_str(), [&] {
        segments::check_directions(directions);
        const segments::LinkChoice choice = choice_of(options);
        Links links;
        const CallStatistics made = state().find_links(
            grid, segments::margin_of(directions), options.hits, call,
            [&](const auto& inputs) { links = segments::find_links(inputs, grid, directions, choice); },
            for_kernels(choice, [&](const auto& inputs) {
                auto found = segments::links_by_kernels(inputs, grid, directions);
                if (found) links = std::move(*found);
                return found.has_value();
            }));
        if (statistics != nullptr) *statistics = made.published();
        return links;
    });
}

TransformStatistics DistanceTransform::links(const Grid& grid, std::span<const LinkDirection> directions,
                                             const LinkTargets& targets, std::size_t& count, const LinkOptions& options,
                                             const CallOptions& call) const {
    count = 0;
    return with_host_memory(lacking_for_links("for the links", grid).c_str(), [&] {
        grid.validate();
        segments::check_directions(directions);
        targets::MappedMemory memory(state().context());
        segments::LinkArrays arrays(targets, grid, directions.size(), memory);
        State& own = state();
        const plans::AskedLinks asked{grid, {directions.begin(), directions.end()}, options, all_rows};
        State::FoundLinks found = are_on_device(targets) ? own.find_planned_links(asked, call) : State::FoundLinks();
        if (!are_on_device(targets)) found.on_host = links(grid, directions, options, call, &found.statistics);
        count = found.on_device ? found.on_device->count : found.on_host.size();
        arrays.require_room(count);
        try {
            if (found.on_device) return own.store(asked, std::move(found), targets, call);
            memory.map({});
            arrays.store(found.on_host, memory);
            memory.unmap();
        } catch (...) {
            count = 0;
            throw;
        }
        return found.statistics;
    });
}

TransformStatistics DistanceTransform::links(const Grid& grid, std::span<const LinkDirection> directions,
                                             const LinkSink& sink, const LinkOptions& options,
                                             const CallOptions& call) const {
    return with_host_memory("for the slabs; ask for those of a part of the grid", [&] {
        segments::check_directions(directions);
        if (!sink) refuse("links in slabs need a sink, and it is empty");
        const segments::LinkChoice choice = choice_of(options);
        const std::vector<Grid> slabs = slabs_of(grid);
        CallStatistics made =
            state().find_links(grid, segments::margin_of(directions), options.hits, call, [&](const auto& inputs) {
                segments::LinkInputs own = inputs;
                for (std::size_t n = 0; n < slabs.size(); ++n) {
                    if (inputs.between)
                        own.between = [&](double fraction) {
                            inputs.between((static_cast<double>(n) + fraction) / static_cast<double>(slabs.size()));
                        };
                    sink(slabs[n], segments::find_links(own, slabs[n], directions, choice));
                }
            });
        made.slabs = slabs.size();
        return made.published();
    });
}

std::size_t DistanceTransform::count_links(const Grid& grid, std::span<const LinkDirection> directions,
                                           const LinkOptions& options, const CallOptions& call) const {
    return with_host_memory(lacking_for_links("to count the links", grid).c_str(), [&] {
        segments::check_directions(directions);
        const segments::LinkChoice choice = choice_of(options);
        std::size_t count = 0;
        state().find_links(
            grid, segments::margin_of(directions), options.hits, call,
            [&](const auto& inputs) { count = segments::count_links(inputs, grid, directions, choice); },
            for_kernels(choice, [&](const auto& inputs) {
                const auto found = segments::count_links_by_kernels(inputs, grid, directions);
                if (found) count = *found;
                return found.has_value();
            }));
        return count;
    });
}

Crossings DistanceTransform::crossings(const Grid& grid, const CrossingOptions& options, const CallOptions& call,
                                       TransformStatistics* statistics) const {
    return with_host_memory(lacking_for_crossings(grid, options.with_counts).c_str(), [&] {
        Crossings crossings;
        const CallStatistics made = state().find_links(grid, {1, 1, 1}, Hits::walls, call, [&](const auto& inputs) {
            crossings = segments::find_crossings(inputs, grid, options.with_counts);
        });
        if (statistics != nullptr) *statistics = made.published();
        return crossings;
    });
}

}  // namespace clsdf
