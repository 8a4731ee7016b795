#include "handles.hpp"
#include "index_base.hpp"
#include "values.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <span>
#include <string>
#include <vector>

using namespace clsdf;
using c::Call;
using c::given;
using c::guarded;
using c::of;

namespace {

template <typename Value>
OutputArray array_of(Value* first) {
    return first == nullptr ? OutputArray() : OutputArray(first);
}

LinkTargets targets_of(const clsdf_link_arrays& arrays) {
    if (arrays.q != nullptr && arrays.q_floats != nullptr)
        throw c::misuse("clsdf_link_arrays has q and q_floats; give one of them");
    if (arrays.dense != nullptr && arrays.dense_floats != nullptr)
        throw c::misuse("clsdf_link_arrays has dense and dense_floats; give one of them");
    LinkTargets targets;
    targets.room = c::count_of(arrays.room, "clsdf_link_arrays.room");
    targets.samples = array_of(reinterpret_cast<std::array<std::int32_t, 3>*>(arrays.samples));
    targets.directions = array_of(arrays.directions);
    targets.q = arrays.q != nullptr ? array_of(arrays.q) : array_of(arrays.q_floats);
    targets.triangles = array_of(arrays.triangles);
    targets.counts = array_of(arrays.counts);
    targets.flags = array_of(arrays.flags);
    targets.inside = array_of(arrays.inside);
    targets.dense = arrays.dense != nullptr ? array_of(arrays.dense) : array_of(arrays.dense_floats);
    return targets;
}

void set_bytes(const SampleSides& sides, std::uint8_t* bytes) {
    for (std::size_t n = 0; n < sides.sample_count(); ++n) bytes[n] = sides.is_inside(n) ? 1 : 0;
}

/// Throws if two of the arrays have a byte in common.
void refuse_overlap(const clsdf_crossing_arrays& arrays, const Grid& grid) {
    struct Range {
        std::uintptr_t begin, end;
        const char* name;
    };
    std::vector<Range> ranges;
    const auto add = [&](const auto* first, std::size_t count, const char* name) {
        const auto begin = reinterpret_cast<std::uintptr_t>(first);
        if (first != nullptr && count > 0) ranges.push_back({begin, begin + count * sizeof(*first), name});
    };
    constexpr std::array coordinates{"coordinates[0]", "coordinates[1]", "coordinates[2]"};
    constexpr std::array triangles{"triangles[0]", "triangles[1]", "triangles[2]"};
    constexpr std::array counts{"counts[0]", "counts[1]", "counts[2]"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Grid edges = grid;
        --edges.size[axis];
        const std::size_t count = edges.sample_count();
        add(arrays.coordinates[axis], count, coordinates[axis]);
        add(arrays.triangles[axis], count, triangles[axis]);
        add(arrays.counts[axis], count, counts[axis]);
    }
    add(arrays.inside, grid.sample_count(), "inside");
    std::ranges::stable_sort(ranges, {}, &Range::begin);
    const auto found = std::ranges::adjacent_find(
        ranges, [](const Range& before, const Range& range) { return range.begin < before.end; });
    if (found != ranges.end())
        throw c::misuse(std::string("clsdf_crossing_arrays.") + found->name + " and " + std::next(found)->name +
                        " lie on the same bytes; give each memory of its own");
}

/// Hands slabs on with triangles and directions that count from the mesh's index base.
LinkSink sink_of(clsdf_link_function sink, void* user, std::int32_t index_base) {
    return [=, own = Links(), inside = std::vector<std::uint8_t>()](const Grid& part, const Links& links) mutable {
        own = links;
        c::set_base(index_base, own.triangles);
        if (index_base != 0)
            for (std::uint8_t& direction : own.directions) ++direction;
        inside.resize(part.sample_count());
        set_bytes(links.inside, inside.data());
        const auto count = static_cast<std::int64_t>(own.size());
        const clsdf_link_arrays arrays{.room = count,
                                       .samples = own.samples.empty() ? nullptr : own.samples.front().data(),
                                       .directions = own.directions.data(),
                                       .q = own.q.data(),
                                       .q_floats = nullptr,
                                       .triangles = own.triangles.data(),
                                       .counts = own.counts.data(),
                                       .flags = reinterpret_cast<std::uint8_t*>(own.flags.data()),
                                       .inside = inside.data(),
                                       .dense = nullptr,
                                       .dense_floats = nullptr};
        const clsdf_grid grid = c::as_c(part);
        clsdf_set_last_error(nullptr);
        c::check_callback(sink(user, &grid, &arrays, count), "sink");
    };
}

}  // namespace

clsdf_status clsdf_stencil(const char* name, const char* code, std::int32_t* directions, std::int64_t* count) {
    return guarded([&] {
        given(directions, "directions");
        given(count, "count");
        const std::vector<LinkDirection> found = stencil(&given(name, "name"), &given(code, "code"));
        std::memcpy(directions, found.data(), found.size() * sizeof(LinkDirection));
        *count = static_cast<std::int64_t>(found.size());
    });
}

clsdf_status clsdf_links(const clsdf_transform* transform, const clsdf_grid* grid, const std::int32_t* directions,
                         std::int64_t direction_count, const clsdf_link_options* options,
                         const clsdf_link_arrays* arrays, const clsdf_call_options* call, clsdf_statistics* statistics,
                         std::int64_t* count) {
    if (count != nullptr) *count = 0;
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        given(count, "count");
        const Call caller(call);
        const clsdf_link_arrays& to = given(arrays, "arrays");
        std::size_t found = 0;
        try {
            c::set(self.transform.links(c::grid_of(grid), c::directions_of(directions, direction_count), targets_of(to),
                                        found, c::link_options_of(options), caller),
                   statistics);
        } catch (const Error&) {
            *count = static_cast<std::int64_t>(found);
            throw;
        }
        *count = static_cast<std::int64_t>(found);
        if (self.index_base == 0) return;
        if (to.triangles != nullptr) c::set_base(self.index_base, std::span(to.triangles, found));
        if (to.directions != nullptr)
            for (std::uint8_t& direction : std::span(to.directions, found)) ++direction;
    });
}

clsdf_status clsdf_link_slabs(const clsdf_transform* transform, const clsdf_grid* grid, const std::int32_t* directions,
                              std::int64_t direction_count, const clsdf_link_options* options, clsdf_link_function sink,
                              void* user, const clsdf_call_options* call, clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        if (sink == nullptr) throw c::misuse("sink is null; give a function");
        c::set(self.transform.links(c::grid_of(grid), c::directions_of(directions, direction_count),
                                    sink_of(sink, user, self.index_base), c::link_options_of(options), caller),
               statistics);
    });
}

clsdf_status clsdf_count_links(const clsdf_transform* transform, const clsdf_grid* grid, const std::int32_t* directions,
                               std::int64_t direction_count, const clsdf_link_options* options,
                               const clsdf_call_options* call, std::int64_t* count) {
    return guarded([&] {
        const Call caller(call);
        given(count, "count") = static_cast<std::int64_t>(of(transform).transform.count_links(
            c::grid_of(grid), c::directions_of(directions, direction_count), c::link_options_of(options), caller));
    });
}

clsdf_status clsdf_crossings(const clsdf_transform* transform, const clsdf_grid* grid,
                             const clsdf_crossing_arrays* arrays, const clsdf_call_options* call,
                             clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const clsdf_crossing_arrays& to = given(arrays, "arrays");
        const bool with_counts = std::ranges::any_of(to.counts, [](const auto* own) { return own != nullptr; });
        const Grid of_caller = c::grid_of(grid);
        of_caller.validate();
        refuse_overlap(to, of_caller);
        TransformStatistics measured;
        const Crossings found = self.transform.crossings(of_caller, {.with_counts = with_counts}, caller, &measured);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const EdgeCrossings& edges = found.axes[axis];
            if (to.coordinates[axis] != nullptr) std::ranges::copy(edges.coordinates, to.coordinates[axis]);
            if (to.counts[axis] != nullptr) std::ranges::copy(edges.counts, to.counts[axis]);
            if (to.triangles[axis] == nullptr) continue;
            std::ranges::copy(edges.triangles, to.triangles[axis]);
            c::set_base(self.index_base, std::span(to.triangles[axis], edges.triangles.size()));
        }
        if (to.inside != nullptr) set_bytes(found.inside, to.inside);
        c::set(measured, statistics);
    });
}
