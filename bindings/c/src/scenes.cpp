#include "handles.hpp"
#include "index_base.hpp"
#include "values.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

using namespace clsdf;
using c::Call;
using c::given;
using c::guarded;
using c::made;
using c::of;

namespace {

Pose pose_from(const clsdf_pose& pose) {
    Pose to;
    for (std::size_t row = 0; row < 3; ++row) std::copy_n(pose.rotation + 3 * row, 3, to.rotation[row].begin());
    std::ranges::copy(pose.translation, to.translation.begin());
    return to;
}

Pose pose_or_none(const clsdf_pose* pose) {
    return pose == nullptr ? Pose{} : pose_from(*pose);
}

clsdf_pose as_c(const Pose& pose) {
    clsdf_pose to;
    for (std::size_t row = 0; row < 3; ++row) std::ranges::copy(pose.rotation[row], to.rotation + 3 * row);
    std::ranges::copy(pose.translation, to.translation);
    return to;
}

/// The body of a number that counts from the scene's base.
std::uint32_t body_of(const clsdf_scene& scene, std::int64_t body) {
    const std::int64_t number = body - scene.index_base, count = static_cast<std::int64_t>(scene.scene.size());
    if (number < 0 || number >= count)
        throw c::misuse("there is no body " + std::to_string(body) + ": the scene has " + std::to_string(count) +
                        ", counted from " + std::to_string(scene.index_base));
    return static_cast<std::uint32_t>(number);
}

std::int64_t number_of(const clsdf_scene& scene, std::uint32_t body) {
    return std::int64_t{body} + scene.index_base;
}

/// Pairs that count from the scene's base, as the library has them.
std::vector<PointOfBody> pairs_of(const clsdf_scene& scene, const std::uint32_t* pairs, std::int64_t count) {
    std::vector<PointOfBody> to(c::count_of(count, "count"));
    c::elements(pairs, count, "pairs");
    const auto base = static_cast<std::uint32_t>(scene.index_base);
    for (std::size_t i = 0; i < to.size(); ++i) {
        const std::uint32_t point = pairs[2 * i], body = pairs[2 * i + 1];
        if (point < base || body < base)
            throw c::misuse("pair " + std::to_string(i) + " names point " + std::to_string(point) + " and body " +
                            std::to_string(body) + "; numbers of this scene count from 1");
        to[i] = {point - base, body - base};
    }
    return to;
}

}  // namespace

clsdf_status clsdf_pose_of_matrix(const double* matrix, clsdf_pose* pose) {
    return guarded(
        [&] { given(pose, "pose") = as_c(pose_of(std::span<const double, 16>(&given(matrix, "matrix"), 16))); });
}

clsdf_status clsdf_scene_create(const clsdf_device* device, const clsdf_scene_options* options, clsdf_scene** scene) {
    return made(scene, "scene", [&] {
        const clsdf_scene_options from = c::read_struct(options, CLSDF_SCENE_OPTIONS_INIT, "clsdf_scene_options");
        SceneOptions to;
        to.surface = c::surface_of(from.surface, "clsdf_scene_options.surface");
        if (from.kept_bytes != -1) to.kept_bytes = c::count_of(from.kept_bytes, "clsdf_scene_options.kept_bytes");
        return new clsdf_scene(Scene(of(device).device, to), c::checked_index_base(from.index_base));
    });
}

clsdf_status clsdf_scene_add(clsdf_scene* scene, const clsdf_mesh* mesh, std::int32_t sign, const clsdf_pose* pose,
                             const clsdf_call_options* call, std::int64_t* body) {
    return guarded([&] {
        clsdf_scene& self = of(scene);
        const Call caller(call);
        std::int64_t& number = given(body, "body");
        number =
            number_of(self, self.scene.add(of(mesh).mesh, pose_or_none(pose), c::sign_rule_of(sign, "sign"), caller));
    });
}

clsdf_status clsdf_scene_add_instance(clsdf_scene* scene, std::int64_t of_body, const clsdf_pose* pose,
                                      std::int64_t* body) {
    return guarded([&] {
        clsdf_scene& self = of(scene);
        std::int64_t& number = given(body, "body");
        number = number_of(self, self.scene.add_instance(body_of(self, of_body), pose_or_none(pose)));
    });
}

clsdf_status clsdf_scene_set_poses(clsdf_scene* scene, const std::int64_t* bodies, const clsdf_pose* poses,
                                   std::int64_t count) {
    return guarded([&] {
        clsdf_scene& self = of(scene);
        c::elements(poses, count, "poses");
        std::vector<Pose> to(static_cast<std::size_t>(count));
        std::transform(poses, poses + count, to.begin(), pose_from);
        if (bodies == nullptr) return self.scene.set_poses(to);
        std::vector<std::uint32_t> numbers(to.size());
        std::transform(bodies, bodies + count, numbers.begin(), [&](std::int64_t body) { return body_of(self, body); });
        self.scene.set_poses(numbers, to);
    });
}

clsdf_status clsdf_scene_set_positions(clsdf_scene* scene, std::int64_t body, const clsdf_array* positions,
                                       const clsdf_call_options* call) {
    return guarded([&] {
        clsdf_scene& self = of(scene);
        const Call caller(call);
        self.scene.set_positions(body_of(self, body), c::input_of(positions, "positions"), caller);
    });
}

clsdf_status clsdf_scene_set_active(clsdf_scene* scene, std::int64_t body, std::int32_t active) {
    return guarded([&] {
        clsdf_scene& self = of(scene);
        self.scene.set_active(body_of(self, body), c::flag(active, "active"));
    });
}

clsdf_status clsdf_scene_size(const clsdf_scene* scene, std::int64_t* count) {
    return guarded([&] { given(count, "count") = static_cast<std::int64_t>(of(scene).scene.size()); });
}

clsdf_status clsdf_scene_active(const clsdf_scene* scene, std::int64_t body, std::int32_t* active) {
    return guarded([&] {
        const clsdf_scene& self = of(scene);
        given(active, "active") = self.scene.is_active(body_of(self, body)) ? 1 : 0;
    });
}

clsdf_status clsdf_scene_pose(const clsdf_scene* scene, std::int64_t body, clsdf_pose* pose) {
    return guarded([&] {
        const clsdf_scene& self = of(scene);
        given(pose, "pose") = as_c(self.scene.pose(body_of(self, body)));
    });
}

clsdf_status clsdf_scene_sign(const clsdf_scene* scene, std::int64_t body, std::int32_t* rule) {
    return guarded([&] {
        const clsdf_scene& self = of(scene);
        given(rule, "rule") = static_cast<std::int32_t>(self.scene.sign(body_of(self, body)));
    });
}

clsdf_status clsdf_scene_has_sign(const clsdf_scene* scene, std::int32_t* has_sign) {
    return guarded([&] { given(has_sign, "has_sign") = of(scene).scene.has_sign() ? 1 : 0; });
}

clsdf_status clsdf_scene_box(const clsdf_scene* scene, clsdf_box* box) {
    return guarded([&] { given(box, "box") = c::as_c(of(scene).scene.box()); });
}

clsdf_status clsdf_scene_memory(const clsdf_scene* scene, clsdf_kept_memory* memory) {
    return guarded([&] { c::write_given(c::as_c(of(scene).scene.memory()), memory, "clsdf_kept_memory"); });
}

clsdf_status clsdf_scene_compute(const clsdf_scene* scene, const clsdf_grid* grid, const clsdf_band* band,
                                 const clsdf_target* targets, std::int64_t target_count, const clsdf_call_options* call,
                                 clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_scene& self = of(scene);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const Grid of_field = c::grid_of(grid);
        const OutputTargets to = c::targets_of(clsdf_targets{targets, target_count}, of_field);
        c::check_base(self.index_base, to);
        c::set(self.scene.compute(of_field, c::band_of(band), to, caller), statistics);
        c::set_base(self.index_base, to, of_field.size);
    });
}

clsdf_status clsdf_scene_compute_field(const clsdf_scene* scene, const clsdf_grid* grid, const clsdf_band* band,
                                       std::uint32_t outputs, const clsdf_call_options* call,
                                       clsdf_statistics* statistics, clsdf_field** field) {
    return made(field, "field", [&] {
        const clsdf_scene& self = of(scene);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        TransformStatistics measured;
        auto result = std::make_unique<clsdf_field>(
            self.scene.compute(c::grid_of(grid), c::band_of(band), c::outputs_of(outputs), caller, &measured),
            self.index_base);
        c::set_base(self.index_base, result->field.triangle());
        c::set_base(self.index_base, result->field.body());
        c::set(measured, statistics);
        return result.release();
    });
}

clsdf_status clsdf_scene_query(const clsdf_scene* scene, const clsdf_array* points, double half_width,
                               const clsdf_target* targets, std::int64_t target_count, std::uint8_t* own,
                               const clsdf_call_options* call, clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_scene& self = of(scene);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const InputArray from = c::input_of(points, "points");
        SceneTargets to{c::targets_of(clsdf_targets{targets, target_count}, from.count)};
        if (own != nullptr) to.is_own = {own, from.count};
        c::check_base(self.index_base, to.outputs);
        c::set(self.scene.query(from, half_width, to, caller), statistics);
        c::set_base(self.index_base, to.outputs, from.count);
    });
}

clsdf_status clsdf_scene_query_pairs(const clsdf_scene* scene, const clsdf_array* points, const std::uint32_t* pairs,
                                     std::int64_t count, double half_width, const clsdf_target* targets,
                                     std::int64_t target_count, const clsdf_call_options* call,
                                     clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_scene& self = of(scene);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        const InputArray from = c::input_of(points, "points");
        const std::vector<PointOfBody> all = pairs_of(self, pairs, count);
        const OutputTargets to = c::targets_of(clsdf_targets{targets, target_count}, all.size());
        c::check_base(self.index_base, to);
        c::set(self.scene.query_pairs(from, all, half_width, to, caller), statistics);
        c::set_base(self.index_base, to, all.size());
    });
}

clsdf_status clsdf_scene_contains(const clsdf_scene* scene, const clsdf_array* points, std::uint8_t* inside,
                                  const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const InputArray from = c::input_of(points, "points");
        of(scene).scene.contains(
            from, {c::elements(inside, static_cast<std::int64_t>(from.count), "inside"), from.count}, caller);
    });
}

clsdf_status clsdf_scene_winding(const clsdf_scene* scene, const clsdf_array* points, double* results,
                                 const clsdf_call_options* call) {
    return guarded([&] {
        const Call caller(call);
        const InputArray from = c::input_of(points, "points");
        of(scene).scene.winding(
            from, {c::elements(results, static_cast<std::int64_t>(from.count), "results"), from.count}, caller);
    });
}

clsdf_status clsdf_scene_classify(const clsdf_scene* scene, const clsdf_box* boxes, std::int64_t count,
                                  double half_width, std::uint8_t* places) {
    return guarded(
        [&] { of(scene).scene.classify(c::boxes_of(boxes, count), half_width, c::places_of(places, count)); });
}
