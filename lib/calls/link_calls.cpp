#include "calls/transform_state.hpp"
#include "core/floating_point.hpp"
#include "core/large_memory.hpp"
#include "core/stopwatch.hpp"
#include "plan/slabs.hpp"
#include "segments/crossings.hpp"
#include "segments/links.hpp"
#include "segments/result_arrays.hpp"
#include "targets/mapped_memory.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace clsdf {

template <typename Find>
CallStatistics DistanceTransform::State::find_links(const Grid& grid, const std::array<std::int32_t, 3>& margin,
                                                    Hits hits, const CallOptions& call, const Find& find) {
    grid.validate();
    Grid with_margin = grid;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        with_margin.first[axis] -= margin[axis];
        with_margin.size[axis] += 2 * margin[axis];
    }
    engine::check_grid(with_margin);
    with_margin.sample_count();
    if (hits == Hits::walls && sign == SignRule::none)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("walls of {} are asked for, and it has no sign: make the transform of a closed mesh "
                                "with a sign rule, or ask for the links of its faces",
                                kept_mesh->name()));
    targets::wait_for(context(), call.wait_list);
    calls::RunningCall running{call};
    running.throw_if_stopped();
    std::span<const std::uint32_t> numbers;
    if (const auto* restriction = kept_mesh->restriction()) {
        restriction->check(with_margin, Band::signs_only(), sign);
        numbers = restriction->numbers;
        // The part has not the whole floor.
        if (const double lowest = with_margin.position(0, 0, 0)[2]; sign == SignRule::below && lowest <= *floor)
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("links or edges reach down to z = {}, and a restricted transform with the sign rule "
                            "below has none of its floor, at z = {}; ask above it, or the whole transform",
                            lowest, *floor));
    }
    CallStatistics& statistics = running.statistics;
    const Stopwatch preparing;
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
    statistics.triangles = mesh->face_count();
    statistics.polyhedra_seconds = preparing.seconds();
    const Stopwatch finding;
    const DefaultFloatingPoint usual;
    find(segments::LinkInputs{*mesh, tree.get(), numbers, kept_mesh->name(), sign, running.between(0, 1)});
    statistics.field_seconds = finding.seconds();
    return running.finish();
}

namespace {

segments::LinkChoice choice_of(const LinkOptions& options) {
    return {.hits = options.hits, .with_between = options.with_between && options.hits == Hits::walls};
}

/// The caller's arrays, checked.
class LinkArrays {
public:
    LinkArrays(const LinkTargets& given, const Grid& grid)
        : room_(given.room),
          samples_(given.samples, "the array of samples", room_, 3, {ElementType::int32}),
          directions_(given.directions, "the array of directions", room_, 1, {ElementType::uint8}),
          q_(given.q, "the array of q", room_, 1, {ElementType::float64, ElementType::float32}),
          triangles_(given.triangles, "the array of triangles", room_, 1, {ElementType::uint32, ElementType::int32}),
          counts_(given.counts, "the array of counts", room_, 1, {ElementType::uint32, ElementType::int32}),
          flags_(given.flags, "the array of flags", room_, 1, {ElementType::uint8}),
          inside_(given.inside, "the array of inside", given.inside.is_given() ? grid.sample_count() : 0, 1,
                  {ElementType::uint8}) {
        std::vector<targets::WrittenArray> written;
        for (const segments::ResultArray* array : {&samples_, &directions_, &q_, &triangles_, &counts_, &flags_})
            if (array->is_given() && room_ > 0) written.push_back(array->written());
        if (inside_.is_given()) written.push_back(inside_.written());
        targets::refuse_overlap(written);
    }

    void store(const Links& links) const {
        if (links.size() > room_)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("there are {} links, and the arrays have room for {}; give them room for as many",
                                    links.size(), room_));
        for (std::size_t n = 0; n < links.size(); ++n) {
            for (std::size_t axis = 0; samples_.is_given() && axis < 3; ++axis)
                samples_.set(n, axis, links.samples[n][axis]);
            if (directions_.is_given()) directions_.set(n, 0, links.directions[n]);
            if (q_.is_given()) store_part(n, links.q[n]);
            if (triangles_.is_given()) triangles_.set(n, 0, links.triangles[n]);
            if (counts_.is_given()) counts_.set(n, 0, links.counts[n]);
            if (flags_.is_given()) flags_.set(n, 0, links.flags[n]);
        }
        if (!inside_.is_given()) return;
        const std::vector<std::uint8_t>& bits = links.inside.bits;
        const Index3& size = links.inside.size;
        for (std::size_t n = 0; n < static_cast<std::size_t>(size[0] * size[1] * size[2]); ++n)
            inside_.set(n, 0, static_cast<std::uint8_t>(bits[n / 8] >> n % 8 & 1U));
    }

private:
    /// Neither 0 nor 1 by rounding to a float.
    void store_part(std::size_t n, double q) const {
        if (q_.type() == ElementType::float64) return q_.set(n, 0, q);
        auto single = static_cast<float>(q);
        if (q > 0 && single == 0) single = std::numeric_limits<float>::denorm_min();
        if (q < 1 && single == 1) single = std::nextafter(1.0F, 0.0F);
        q_.set(n, 0, single);
    }

    std::size_t room_;
    segments::ResultArray samples_, directions_, q_, triangles_, counts_, flags_, inside_;
};

}  // namespace

Links DistanceTransform::links(const Grid& grid, std::span<const LinkDirection> directions, const LinkOptions& options,
                               const CallOptions& call, TransformStatistics* statistics) const {
    return with_host_memory("for the links; ask for those of a part of the grid", [&] {
        segments::check_directions(directions);
        Links links;
        const CallStatistics made = state().find_links(
            grid, segments::margin_of(directions), options.hits, call,
            [&](const auto& inputs) { links = segments::find_links(inputs, grid, directions, choice_of(options)); });
        if (statistics != nullptr) *statistics = made.published();
        return links;
    });
}

TransformStatistics DistanceTransform::links(const Grid& grid, std::span<const LinkDirection> directions,
                                             const LinkTargets& targets, std::size_t& count, const LinkOptions& options,
                                             const CallOptions& call) const {
    count = 0;
    grid.validate();
    const LinkArrays arrays(targets, grid);
    TransformStatistics statistics;
    const Links found = links(grid, directions, options, call, &statistics);
    count = found.size();
    arrays.store(found);
    return statistics;
}

std::size_t DistanceTransform::count_links(const Grid& grid, std::span<const LinkDirection> directions,
                                           const LinkOptions& options, const CallOptions& call) const {
    return with_host_memory("to count links; count those of a part of the grid", [&] {
        segments::check_directions(directions);
        std::size_t count = 0;
        state().find_links(grid, segments::margin_of(directions), options.hits, call, [&](const auto& inputs) {
            count = segments::count_links(inputs, grid, directions, choice_of(options));
        });
        return count;
    });
}

Crossings DistanceTransform::crossings(const Grid& grid, const CrossingOptions& options, const CallOptions& call,
                                       TransformStatistics* statistics) const {
    return with_host_memory("for the crossings; ask for those of a part of the grid", [&] {
        Crossings crossings;
        const CallStatistics made = state().find_links(grid, {1, 1, 1}, Hits::walls, call, [&](const auto& inputs) {
            crossings = segments::find_crossings(inputs, grid, options.with_counts);
        });
        if (statistics != nullptr) *statistics = made.published();
        return crossings;
    });
}

}  // namespace clsdf
