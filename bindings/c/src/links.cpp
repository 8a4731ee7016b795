#include "handles.hpp"
#include "index_base.hpp"
#include "values.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <vector>

using namespace clsdf;
using c::Call;
using c::given;
using c::guarded;
using c::of;

namespace {

std::span<const LinkDirection> directions_of(const std::int32_t* directions, std::int64_t count) {
    static_assert(sizeof(LinkDirection) == 3 * sizeof(std::int32_t));
    c::elements(directions, count, "directions");
    return {reinterpret_cast<const LinkDirection*>(directions), static_cast<std::size_t>(count)};
}

LinkOptions options_of(const clsdf_link_options* options) {
    if (options == nullptr) return {};
    return {c::enumerator(options->hits, Hits::faces, "clsdf_link_options.hits"),
            c::flag(options->with_between, "clsdf_link_options.with_between")};
}

template <typename Value>
OutputArray array_of(Value* first) {
    return first == nullptr ? OutputArray() : OutputArray(first);
}

LinkTargets targets_of(const clsdf_link_arrays& arrays) {
    if (arrays.q != nullptr && arrays.q_floats != nullptr)
        throw c::misuse("clsdf_link_arrays has q and q_floats; give one of them");
    LinkTargets targets;
    targets.room = c::count_of(arrays.room, "clsdf_link_arrays.room");
    targets.samples = array_of(reinterpret_cast<std::array<std::int32_t, 3>*>(arrays.samples));
    targets.directions = array_of(arrays.directions);
    targets.q = arrays.q != nullptr ? array_of(arrays.q) : array_of(arrays.q_floats);
    targets.triangles = array_of(arrays.triangles);
    targets.counts = array_of(arrays.counts);
    targets.flags = array_of(arrays.flags);
    targets.inside = array_of(arrays.inside);
    return targets;
}

void set(const TransformStatistics& from, clsdf_statistics* to) {
    if (to != nullptr) c::write_struct(c::as_c(from), to, "clsdf_statistics");
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
            set(self.transform.links(c::grid_of(grid), directions_of(directions, direction_count), targets_of(to),
                                     found, options_of(options), caller),
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

clsdf_status clsdf_count_links(const clsdf_transform* transform, const clsdf_grid* grid, const std::int32_t* directions,
                               std::int64_t direction_count, const clsdf_link_options* options,
                               const clsdf_call_options* call, std::int64_t* count) {
    return guarded([&] {
        const Call caller(call);
        given(count, "count") = static_cast<std::int64_t>(of(transform).transform.count_links(
            c::grid_of(grid), directions_of(directions, direction_count), options_of(options), caller));
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
        TransformStatistics measured;
        const Crossings found =
            self.transform.crossings(c::grid_of(grid), {.with_counts = with_counts}, caller, &measured);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const EdgeCrossings& edges = found.axes[axis];
            if (to.coordinates[axis] != nullptr) std::ranges::copy(edges.coordinates, to.coordinates[axis]);
            if (to.counts[axis] != nullptr) std::ranges::copy(edges.counts, to.counts[axis]);
            if (to.triangles[axis] == nullptr) continue;
            std::ranges::copy(edges.triangles, to.triangles[axis]);
            c::set_base(self.index_base, std::span(to.triangles[axis], edges.triangles.size()));
        }
        const Index3& size = found.inside.size;
        if (to.inside != nullptr)
            for (std::size_t n = 0; n < static_cast<std::size_t>(size[0] * size[1] * size[2]); ++n)
                to.inside[n] = found.inside.bits[n / 8] >> n % 8 & 1U;
        set(measured, statistics);
    });
}
