#include "calls/transform/transform_state.hpp"
#include "core/large_memory.hpp"
#include "core/stopwatch.hpp"
#include "mesh/input_arrays.hpp"
#include "segments/rays.hpp"
#include "targets/mapped_memory.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

// Between them a call can be cancelled.
constexpr std::size_t rays_at_once = std::size_t{1} << 16;

/// The two arrays of a call, an item of each for each ray or pair.
struct Pairs {
    const char* what;  ///< "ray" or "pair"
    const char* first_name;
    const char* second_name;
    const InputArray& first;
    const InputArray& second;

    void check() const {
        check_array(first, ArrayKind::positions, first_name, ErrorCode::invalid_argument);
        check_array(second, ArrayKind::positions, second_name, ErrorCode::invalid_argument);
        if (first.count != second.count)
            throw Error(ErrorCode::invalid_argument, fmt::format("there are {} {} and {} {}; give as many", first.count,
                                                                 first_name, second.count, second_name));
    }

    void add_to(targets::MappedMemory& memory) const {
        memory.add_triples(first, first_name);
        memory.add_triples(second, second_name);
    }

    /// Throws Error(invalid_argument) if one of the results lies on another one or on what is read.
    void refuse_overlap(std::span<const targets::ResultArray> results) const {
        std::vector<targets::WrittenArray> written;
        for (const targets::ResultArray& result : results)
            if (result.is_given()) written.push_back(result.written());
        for (const auto& [name, array] : {std::pair(first_name, &first), std::pair(second_name, &second)}) {
            const Steps steps = steps_of(*array);
            const targets::BufferPlace begin =
                array->device != nullptr
                    ? device::guarded([&] { return targets::place_of(array->device, array->offset); })
                    : targets::BufferPlace{{}, reinterpret_cast<std::uintptr_t>(first_of(*array))};
            written.push_back({.memory = begin.memory(),
                               .first = begin.byte,
                               .width = bytes_of(array->type),
                               .size = {static_cast<std::int64_t>(array->count), 1, 1},
                               .strides = {steps.triple, 0, 0},
                               .components = 3,
                               .component_stride = steps.number,
                               .name = name});
            targets::refuse_overlap(written);
            written.pop_back();
        }
    }
};

std::string text_of(const Vec3& p) {
    return fmt::format("({}, {}, {})", p[0], p[1], p[2]);
}

/// Throws unless each of these segments lies in a region of a restricted transform. end_of(i): its end, and how far off
/// that may be; NaN if it is not usable.
void check_in_regions(const engine::Restriction& restriction, std::optional<double> floor, const char* what,
                      std::span<const Vec3> from, const auto& end_of) {
    for (std::size_t i = 0; i < from.size(); ++i) {
        const std::pair<Vec3, double> found = end_of(i);
        const Vec3& end = found.first;
        if (!is_finite(from[i]) || std::ranges::any_of(end, [](double x) { return std::isnan(x); })) continue;
        Box box{from[i], from[i]};
        add(box, widened({end, end}, found.second));
        const auto text = [&] {
            return fmt::format("{} {} goes from {} to {}", what, i, text_of(from[i]), text_of(end));
        };
        if (!is_finite(end) || !restriction.holds(box, 0, 0, 0)) restriction.refuse(text(), box);
        if (floor && box.lower[2] <= *floor)
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("{}, and a restricted transform with the sign rule below has not the whole floor, at "
                            "z = {}; ask above it, or the whole transform",
                            text(), *floor));
    }
}

/// Finds the rays or pairs that are not usable, and what to say of them.
std::string warning_of(const Pairs& pairs, std::span<const Vec3> first, std::span<const Vec3> second, const auto& why,
                       bool are_refused, std::size_t& count) {
    std::size_t lowest = 0;
    count = 0;
    for (std::size_t i = 0; i < first.size(); ++i)
        if (why(first[i], second[i]) && count++ == 0) lowest = i;
    if (count == 0) return {};
    const std::string described =
        fmt::format("{} {}, counted from 0, {} {}: {}", pairs.what, lowest, text_of(first[lowest]),
                    text_of(second[lowest]), *why(first[lowest], second[lowest]));
    if (are_refused) throw Error(ErrorCode::invalid_argument, described + "; leave it out");
    return fmt::format("{} of {} {}s {}; the first, {}", count, first.size(), pairs.what,
                       pairs.what == std::string("ray") ? "have no hits and t = NaN" : "count as not visible",
                       described);
}

}  // namespace

DistanceTransform::State::SegmentInputs DistanceTransform::State::segment_inputs(Hits hits) {
    if (hits == Hits::walls && sign == SignRule::none)
        throw Error(ErrorCode::unsupported,
                    fmt::format("{} has no sign, and walls are where inside and outside meet; ask for faces",
                                kept_mesh->name()));
    const KeepsBudget keeps_budget(*this);
    const std::scoped_lock lock(mutex);
    context().begin_call();
    SegmentInputs inputs;
    calls::with_remedies(nullptr, {forgetting()}, [&] {
        if (hits == Hits::walls && sign == SignRule::below) {
            inputs.mesh = kept_points->sign_mesh();
            const auto closed = kept_points->closed_faces();
            inputs.tree = {closed, &closed->tree};
            inputs.extent = {closed, &closed->extent};
            return;
        }
        inputs.mesh = kept_points->mesh();
        inputs.tree = kept_points->wide_tree();
        inputs.extent = kept_points->crossed_extent();
    });
    if (!inputs.extent->are_exact) engine::refuse_inexact(*inputs.mesh, kept_mesh->name());
    return inputs;
}

template <typename Warn, typename Find>
CallStatistics DistanceTransform::State::look_up_pairs(std::size_t count, const CallOptions& call, Hits hits,
                                                       const Warn& warn, const Find& find) {
    calls::RunningCall running{call};
    CallStatistics& statistics = running.statistics;
    statistics.triangles = kept_mesh->face_count();
    running.throw_if_stopped();
    const Stopwatch watch;
    const SegmentInputs inputs = segment_inputs(hits);
    statistics.polyhedra_seconds = watch.seconds();
    const std::string warning = warn(*inputs.mesh, statistics.unusable_points);
    const Stopwatch search_watch;
    segments::SearchedFaces searched{{*inputs.mesh}, *inputs.tree, *inputs.extent, sign};
    searched.faces.numbers = kept_mesh->numbers();
    const auto between = running.between(0, 1);
    for (std::size_t begin = 0; begin < count; begin += rays_at_once) {
        if (between) between(static_cast<double>(begin) / static_cast<double>(count));
        find(searched, begin, std::min(begin + rays_at_once, count));
    }
    statistics.field_seconds = search_watch.seconds();
    if (call.log && !warning.empty()) call.log(warning);
    return running.finish();
}

TransformStatistics DistanceTransform::rays(const InputArray& origins, const InputArray& directions,
                                            const RayOptions& options, const RayTargets& targets,
                                            const CallOptions& call) const {
    return with_host_memory("for the rays; give fewer at once", [&] {
        State& state = this->state();
        const Pairs pairs{"ray", "origins", "directions", origins, directions};
        pairs.check();
        if (!(options.limit >= 0))
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("rays have the limit {}, which must be 0 or more; infinity is no limit", options.limit));
        const std::size_t count = origins.count;
        segments::RayArrays arrays;
        arrays.most = targets.most;
        const bool has_rows = targets.t.is_given() || targets.triangles.is_given();
        if (targets.most == 0 && has_rows)
            throw Error(ErrorCode::invalid_argument, "0 hits of each ray are asked for; ask for one or more");
        if (count > 0 && !has_rows && !targets.counts.is_given() && !targets.any.is_given())
            throw Error(ErrorCode::invalid_argument, "rays have no array for results; give one");
        if (!has_rows) arrays.most = 0;
        using enum ElementType;
        const Index3 row{static_cast<std::int64_t>(count), 1, 1};
        targets::MappedMemory memory(state.context());
        pairs.add_to(memory);
        arrays.t = {targets.t, "the array t", row, targets.most, {float64, float32}, memory};
        arrays.triangles = {targets.triangles, "the array triangles", row, targets.most, {uint32, int32}, memory};
        arrays.counts = {targets.counts, "the array counts", row, 1, {uint32, int32}, memory};
        arrays.any = {targets.any, "the array any", row, 1, {uint8}, memory};
        if (count == 0) {
            calls::RunningCall{call}.report({.fraction = 1});
            return CallStatistics().published();
        }
        pairs.refuse_overlap(std::array{arrays.t, arrays.triangles, arrays.counts, arrays.any});
        memory.map(call.wait_list);
        for (targets::ResultArray* array : {&arrays.t, &arrays.triangles, &arrays.counts, &arrays.any})
            array->set_mapped(memory);
        const PositionArray from(memory.mapped(origins)), along(memory.mapped(directions));
        if (const auto* restriction = state.kept_mesh->restriction()) {
            if (options.hits == Hits::walls && state.sign == SignRule::solid_angle)
                throw Error(
                    ErrorCode::unsupported,
                    fmt::format("walls of {} are asked for along rays, its open edges count for its sign, and the "
                                "transform is restricted; ask the whole transform, or for faces",
                                state.kept_mesh->name()));
            if (!std::isfinite(options.limit))
                throw Error(ErrorCode::invalid_argument,
                            "the rays have no limit, and the transform is restricted to regions; give a limit up to "
                            "which each ray lies in a region, or ask the whole transform");
            check_in_regions(*restriction, state.floor_of(options.hits), "ray", from.get(), [&](std::size_t i) {
                const Vec3 &origin = from.get()[i], &direction = along.get()[i];
                Vec3 end{};
                double greatest = 0;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const double along_axis = is_finite(direction) ? direction[axis] : std::nan("");
                    end[axis] = std::fma(options.limit, along_axis, origin[axis]);
                    greatest = std::max({greatest, std::abs(origin[axis]), std::abs(end[axis])});
                }
                return std::pair(end, 0x1p-50 * greatest);
            });
        }
        const CallStatistics statistics = state.look_up_pairs(
            count, call, options.hits,
            [&](const engine::PointMesh& mesh, std::size_t& unusable) {
                return warning_of(
                    pairs, from.get(), along.get(),
                    [&](const Vec3& a, const Vec3& b) { return segments::why_unusable(mesh, a, b); },
                    call.refuse_unusable_points, unusable);
            },
            [&](const segments::SearchedFaces& searched, std::size_t begin, std::size_t end) {
                segments::find_hits(searched, from.get(), along.get(), options, arrays, begin, end);
            });
        memory.unmap();
        return statistics.published();
    });
}

TransformStatistics DistanceTransform::visible(const InputArray& from, const InputArray& to, const OutputArray& visible,
                                               Hits hits, const CallOptions& call) const {
    return with_host_memory("for the pairs; give fewer at once", [&] {
        State& state = this->state();
        const Pairs pairs{"pair", "first points", "second points", from, to};
        pairs.check();
        targets::MappedMemory memory(state.context());
        pairs.add_to(memory);
        targets::ResultArray result(visible, "the array of what is visible",
                                    {static_cast<std::int64_t>(from.count), 1, 1}, 1, {ElementType::uint8}, memory);
        if (!result.is_given() && from.count > 0)
            throw Error(ErrorCode::invalid_argument, "pairs have no array for results; give one");
        if (from.count == 0) {
            calls::RunningCall{call}.report({.fraction = 1});
            return CallStatistics().published();
        }
        pairs.refuse_overlap(std::span(&result, 1));
        memory.map(call.wait_list);
        result.set_mapped(memory);
        const PositionArray first(memory.mapped(from)), second(memory.mapped(to));
        if (const auto* restriction = state.kept_mesh->restriction())
            check_in_regions(*restriction, state.floor_of(hits), "pair", first.get(), [&](std::size_t i) {
                const Vec3& end = second.get()[i];
                return std::pair(is_finite(end) ? end : Vec3{std::nan(""), 0, 0}, 0.0);
            });
        const CallStatistics statistics = state.look_up_pairs(
            from.count, call, hits,
            [&](const engine::PointMesh& mesh, std::size_t& unusable) {
                return warning_of(
                    pairs, first.get(), second.get(),
                    [&](const Vec3& a, const Vec3& b) { return segments::why_unusable_pair(mesh, a, b); },
                    call.refuse_unusable_points, unusable);
            },
            [&](const segments::SearchedFaces& searched, std::size_t begin, std::size_t end) {
                segments::find_visible(searched, first.get(), second.get(), hits, result, begin, end);
            });
        memory.unmap();
        return statistics.published();
    });
}

}  // namespace clsdf
