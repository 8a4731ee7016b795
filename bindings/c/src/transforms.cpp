#include "handles.hpp"
#include "index_base.hpp"
#include "mesh_arrays.hpp"
#include "values.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

using namespace clsdf;
using c::Call;
using c::given;
using c::guarded;
using c::made;
using c::of;

namespace {

std::optional<std::size_t> kept_bytes_of(std::int64_t bytes, const char* name) {
    if (bytes == -1) return std::nullopt;
    return c::count_of(bytes, name);
}

TransformOptions options_of(const clsdf_transform_options* options) {
    const clsdf_transform_options from =
        c::read_struct(options, CLSDF_TRANSFORM_OPTIONS_INIT, "clsdf_transform_options");
    TransformOptions to;
    to.surface = c::surface_of(from.surface, "clsdf_transform_options.surface");
    to.sign = c::sign_rule_of(from.sign, "clsdf_transform_options.sign");
    if (from.floor != std::numeric_limits<double>::max()) to.floor = from.floor;
    to.kept_bytes = kept_bytes_of(from.kept_bytes, "clsdf_transform_options.kept_bytes");
    return to;
}

/// Hands slabs on with numbers that count from the mesh's index base, in one buffer for all slabs.
SlabSink sink_of(clsdf_slab_function sink, void* user, std::int32_t index_base) {
    return [=, shifted = c::ShiftedValues()](const Grid& part, const FieldSlab& values) mutable {
        const clsdf_grid grid = c::as_c(part);
        const std::vector<clsdf_target> targets = c::as_c(shifted(values, index_base));
        clsdf_set_last_error(nullptr);
        c::check_callback(sink(user, &grid, targets.data(), static_cast<std::int64_t>(targets.size())), "sink");
    };
}

}  // namespace

clsdf_status clsdf_transform_create(const clsdf_device* device, const clsdf_mesh* mesh,
                                    const clsdf_transform_options* options, const clsdf_call_options* call,
                                    clsdf_transform** transform) {
    return made(transform, "transform", [&] {
        const Call caller(call);
        const clsdf_mesh& self = of(mesh);
        return new clsdf_transform(DistanceTransform(of(device).device, self.mesh, options_of(options), caller),
                                   self.index_base);
    });
}

clsdf_status clsdf_transform_from_arrays(const clsdf_device* device, const clsdf_mesh_arrays* arrays,
                                         const clsdf_transform_options* options, const clsdf_call_options* call,
                                         clsdf_transform** transform) {
    return made(transform, "transform", [&] {
        const Call caller(call);
        const c::MeshArrays mesh(arrays);
        return new clsdf_transform(DistanceTransform(of(device).device, mesh.view(), options_of(options), caller),
                                   mesh.index_base());
    });
}

clsdf_status clsdf_transform_restrict(const clsdf_transform* transform, const clsdf_region* regions, std::int64_t count,
                                      clsdf_transform** restricted) {
    return clsdf_transform_restrict_with_margin(transform, regions, count, 0, restricted);
}

clsdf_status clsdf_transform_restrict_with_margin(const clsdf_transform* transform, const clsdf_region* regions,
                                                  std::int64_t count, double margin, clsdf_transform** restricted) {
    return made(restricted, "restricted", [&] {
        const clsdf_transform& self = of(transform);
        c::elements(regions, count, "regions");
        std::vector<Region> to;
        for (std::int64_t i = 0; i < count; ++i)
            to.push_back({c::box_of(&regions[i].box), regions[i].half_width, regions[i].spacing});
        return new clsdf_transform(self.transform.restrict_to(to, margin), self.index_base);
    });
}

clsdf_status clsdf_transform_part_vertices(const clsdf_transform* transform, std::uint32_t* vertices, std::int64_t room,
                                           std::int64_t* count) {
    return guarded([&] {
        std::int64_t& needed = given(count, "count");
        needed = 0;
        const clsdf_transform& self = of(transform);
        const std::vector<std::uint32_t> numbers = self.transform.part_vertices();
        needed = static_cast<std::int64_t>(numbers.size());
        if (vertices == nullptr && room == 0) return;
        if (room < needed)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("vertices has room for {}, and the part has {}; give room for them", room, needed));
        std::uint32_t* to = &given(vertices, "vertices");
        for (const std::uint32_t number : numbers) *to++ = number + static_cast<std::uint32_t>(self.index_base);
    });
}

clsdf_status clsdf_transform_part_bytes(const clsdf_transform* transform, std::uint8_t* bytes, std::int64_t room,
                                        std::int64_t* count) {
    return guarded([&] {
        std::int64_t& needed = given(count, "count");
        needed = 0;
        const std::vector<std::byte> part = of(transform).transform.part_bytes();
        needed = static_cast<std::int64_t>(part.size());
        if (bytes == nullptr && room == 0) return;
        if (room < needed)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("bytes has room for {}, and the part has {}; give room for them", room, needed));
        std::memcpy(&given(bytes, "bytes"), part.data(), part.size());
    });
}

clsdf_status clsdf_transform_from_part(const clsdf_device* device, const std::uint8_t* bytes, std::int64_t count,
                                       std::int32_t index_base, std::int64_t kept_bytes, clsdf_transform** transform) {
    return made(transform, "transform", [&] {
        c::elements(bytes, count, "bytes");
        return new clsdf_transform(
            DistanceTransform::from_part(of(device).device,
                                         std::as_bytes(std::span(bytes, static_cast<std::size_t>(count))),
                                         kept_bytes_of(kept_bytes, "kept_bytes")),
            c::checked_index_base(index_base));
    });
}

clsdf_status clsdf_transform_prepared_bytes(const clsdf_transform* transform, std::int64_t* bytes) {
    return guarded([&] {
        std::int64_t& size = given(bytes, "bytes");
        size = 0;
        size = static_cast<std::int64_t>(of(transform).transform.prepared_bytes());
    });
}

clsdf_status clsdf_transform_share(const clsdf_transform* transform, void* memory, std::int64_t bytes) {
    return guarded([&] {
        auto* const first = static_cast<std::byte*>(memory);
        c::elements(first, bytes, "memory");
        of(transform).transform.share({first, static_cast<std::size_t>(bytes)});
    });
}

clsdf_status clsdf_transform_from_shared(const clsdf_device* device, const void* memory, std::int64_t bytes,
                                         std::int32_t index_base, std::int64_t kept_bytes,
                                         clsdf_transform** transform) {
    return made(transform, "transform", [&] {
        const auto* const first = static_cast<const std::byte*>(memory);
        c::elements(first, bytes, "memory");
        return new clsdf_transform(
            DistanceTransform::from_shared(of(device).device, {first, static_cast<std::size_t>(bytes)},
                                           kept_bytes_of(kept_bytes, "kept_bytes")),
            c::checked_index_base(index_base));
    });
}

clsdf_status clsdf_transform_set_positions(clsdf_transform* transform, const clsdf_array* positions,
                                           const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        of(transform).transform.set_positions(c::input_of(positions, "positions"), caller);
    });
}

clsdf_status clsdf_transform_set_motion(clsdf_transform* transform, const double* rotation, const double* translation) {
    return guarded([&] {
        const double *r = &given(rotation, "rotation"), *t = &given(translation, "translation");
        of(transform).transform.set_motion({{{r[0], r[1], r[2]}, {r[3], r[4], r[5]}, {r[6], r[7], r[8]}}},
                                           {t[0], t[1], t[2]});
    });
}

clsdf_status clsdf_compute(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                           const clsdf_target* targets, std::int64_t target_count, const clsdf_call_options* call,
                           clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const Grid of_field = c::grid_of(grid);
        const OutputTargets to = c::targets_of(clsdf_targets{targets, target_count}, of_field);
        c::check_base(self.index_base, to);
        c::set(self.transform.compute(of_field, c::band_of(band), to, caller), statistics);
        c::set_base(self.index_base, to, of_field.size);
    });
}

clsdf_status clsdf_compute_requests(const clsdf_transform* transform, const clsdf_request* requests, std::int64_t count,
                                    const clsdf_call_options* call, clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const std::vector<Request> all = c::requests_of(requests, count);
        for (const Request& request : all) c::check_base(self.index_base, request.targets);
        c::set(self.transform.compute(all, caller), statistics);
        for (const Request& request : all) c::set_base(self.index_base, request.targets, request.grid.size);
    });
}

clsdf_status clsdf_compute_blocks(const clsdf_transform* transform, const clsdf_block_set* blocks,
                                  const clsdf_call_options* call, clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const BlockSet set_of = c::block_set_of(blocks);
        c::check_base(self.index_base, set_of.targets);
        c::set(self.transform.compute(set_of, caller), statistics);
        c::set_base(self.index_base, set_of);
    });
}

clsdf_status clsdf_compute_slabs(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                                 std::uint32_t outputs, clsdf_slab_function sink, void* user,
                                 const clsdf_slab_options* options, const clsdf_call_options* call,
                                 clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const clsdf_slab_options from = c::read_struct(options, CLSDF_SLAB_OPTIONS_INIT, "clsdf_slab_options");
        c::check_reserved(from.reserved, "clsdf_slab_options");
        SlabOptions to;
        to.sink_has_own_thread = c::flag(from.own_thread, "clsdf_slab_options.own_thread");
        if (sink == nullptr) throw c::misuse("sink is null; give a function");
        c::set(self.transform.compute(c::grid_of(grid), c::band_of(band), c::outputs_of(outputs),
                                      sink_of(sink, user, self.index_base), to, caller),
               statistics);
    });
}

clsdf_status clsdf_compute_field(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                                 std::uint32_t outputs, const clsdf_call_options* call, clsdf_statistics* statistics,
                                 clsdf_field** field) {
    return made(field, "field", [&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        TransformStatistics measured;
        auto result = std::make_unique<clsdf_field>(
            self.transform.compute(c::grid_of(grid), c::band_of(band), c::outputs_of(outputs), caller, &measured),
            self.index_base);
        c::set_base(self.index_base, result->field.triangle());
        c::set_base(self.index_base, result->field.body());
        c::set(measured, statistics);
        return result.release();
    });
}

clsdf_status clsdf_slabs_of(const clsdf_grid* grid, clsdf_grid* slabs, std::int64_t size, std::int64_t* count) {
    return guarded([&] {
        c::elements(slabs, size, "slabs");
        const Grid of_field = c::grid_of(grid);
        of_field.validate();
        const std::vector<Grid> found = DistanceTransform::slabs_of(of_field);
        for (std::size_t i = 0; i < found.size() && i < static_cast<std::size_t>(size); ++i)
            slabs[i] = c::as_c(found[i]);
        if (count != nullptr) *count = static_cast<std::int64_t>(found.size());
    });
}

clsdf_status clsdf_query(const clsdf_transform* transform, const clsdf_array* points, double half_width,
                         const clsdf_target* targets, std::int64_t target_count, const clsdf_call_options* call,
                         clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const InputArray from = c::input_of(points, "points");
        const OutputTargets to = c::targets_of(clsdf_targets{targets, target_count}, from.count);
        c::check_base(self.index_base, to);
        c::set(self.transform.query(from, half_width, to, caller), statistics);
        c::set_base(self.index_base, to, from.count);
    });
}

clsdf_status clsdf_classify(const clsdf_transform* transform, const clsdf_box* boxes, std::int64_t count,
                            double half_width, std::uint8_t* places) {
    return guarded(
        [&] { of(transform).transform.classify(c::boxes_of(boxes, count), half_width, c::places_of(places, count)); });
}

clsdf_status clsdf_winding(const clsdf_transform* transform, const clsdf_array* points, const clsdf_array* results,
                           const clsdf_call_options* call) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        const Call caller(call);
        const InputArray from = c::input_of(points, "points");
        self.transform.winding(from, c::output_of(results, "results", from.count), caller);
    });
}

clsdf_status clsdf_rays(const clsdf_transform* transform, const clsdf_array* origins, const clsdf_array* directions,
                        const clsdf_ray_request* request, const clsdf_call_options* call,
                        clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const InputArray from = c::input_of(origins, "origins"), along = c::input_of(directions, "directions");
        const clsdf_ray_request asked = c::read_given(request, CLSDF_RAY_REQUEST_INIT, "clsdf_ray_request");
        c::check_reserved(asked.reserved, "clsdf_ray_request");
        const RayTargets to = c::ray_targets_of(asked, from.count);
        if (to.triangles.device != nullptr) c::check_base(self.index_base, OutputSet(Output::triangle));
        const RayOptions options{c::hits_of(asked.hits, "clsdf_ray_request.hits"), asked.limit};
        c::set(self.transform.rays(from, along, options, to, caller), statistics);
        c::set_base(self.index_base, to.triangles, from.count, to.most);
    });
}

clsdf_status clsdf_visible(const clsdf_transform* transform, const clsdf_array* from, const clsdf_array* to,
                           std::int32_t hits, const clsdf_array* visible, const clsdf_call_options* call,
                           clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const InputArray first = c::input_of(from, "from"), second = c::input_of(to, "to");
        c::set(self.transform.visible(first, second, c::output_of(visible, "visible", first.count),
                                      c::hits_of(hits, "hits"), caller),
               statistics);
    });
}

clsdf_status clsdf_transform_box(const clsdf_transform* transform, clsdf_box* box) {
    return guarded([&] { given(box, "box") = c::as_c(of(transform).transform.box()); });
}

clsdf_status clsdf_transform_topology(const clsdf_transform* transform, clsdf_topology* topology) {
    return guarded([&] { c::write_given(c::as_c(of(transform).transform.topology()), topology, "clsdf_topology"); });
}

clsdf_status clsdf_transform_sign(const clsdf_transform* transform, std::int32_t* rule) {
    return guarded([&] { given(rule, "rule") = static_cast<std::int32_t>(of(transform).transform.sign()); });
}

clsdf_status clsdf_transform_index_base(const clsdf_transform* transform, std::int32_t* index_base) {
    return guarded([&] { given(index_base, "index_base") = of(transform).index_base; });
}

clsdf_status clsdf_transform_device(const clsdf_transform* transform, clsdf_device** device) {
    return made(device, "device", [&] { return new clsdf_device(of(transform).transform.device()); });
}

clsdf_status clsdf_transform_memory(const clsdf_transform* transform, clsdf_kept_memory* memory) {
    return guarded([&] { c::write_given(c::as_c(of(transform).transform.memory()), memory, "clsdf_kept_memory"); });
}

clsdf_status clsdf_transform_compile(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                                     std::uint32_t outputs, const clsdf_call_options* call,
                                     clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        c::set(self.transform.compile(c::grid_of(grid), c::band_of(band), c::outputs_of(outputs), caller), statistics);
    });
}
