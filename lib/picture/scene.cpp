#include "picture/scene.hpp"

#include "core/refuse.hpp"
#include "core/vectors.hpp"
#include "mesh/box_index.hpp"
#include "picture/camera.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::picture {

namespace {

using Parts = std::array<double, 3>;

// The curve of sRGB (IEC 61966-2-1).
double to_light(double part) {
    return part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4);
}

double from_light(double part) {
    const double light = std::clamp(part, 0.0, 1.0);
    return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

Parts to_light(const Colour& colour) {
    return {to_light(colour[0]), to_light(colour[1]), to_light(colour[2])};
}

Vec3 in(const ViewFrame& frame, double right, double up, double back) {
    Vec3 direction{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        direction[axis] = right * frame.right[axis] + up * frame.up[axis] + back * frame.back[axis];
    return normalized(direction);
}

Vec3 vector_of(const float (&v)[3]) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

// The share of this point that a line of this width covers, if its centre is `away` pixels from here.
double cover(double away, double width) {
    return std::clamp(0.5 * width - away + 0.5, 0.0, 1.0);
}

void blend(Parts& below, const Parts& above, double opacity) {
    for (std::size_t i = 0; i < 3; ++i) below[i] += opacity * (above[i] - below[i]);
}

}  // namespace

SurfaceShading::SurfaceShading(const ViewFrame& frame, const Manner& manner, const Colour& surface, double offset,
                               double voxel)
    : frame_(frame),
      manner_(manner),
      surface_(to_light(surface)),
      offset_(offset),
      voxel_(voxel),
      key_(in(frame, -0.55, 0.7, 0.75)),
      fill_(in(frame, 0.8, 0.05, 0.6)),
      half_way_(normalized({key_[0] + frame.back[0], key_[1] + frame.back[1], key_[2] + frame.back[2]})) {}

void SurfaceShading::mark_cut(Axis axis, double position, double spacing) {
    cuts_.push_back({static_cast<int>(axis), position, spacing});
}

Parts SurfaceShading::lit(const RenderHit& hit) const {
    const Vec3 gradient = vector_of(hit.gradient);
    if (!(dot(gradient, gradient) > 0)) return surface_;
    const Vec3 normal = normalized(gradient);
    const auto open = static_cast<double>(hit.ambient);
    const double key = static_cast<double>(hit.light) * std::max(0.0, dot(normal, key_));
    const double fill = open * std::max(0.0, dot(normal, fill_));
    const double around = open * (0.75 + 0.25 * dot(normal, frame_.up));
    const double diffuse = 0.78 * key + 0.14 * fill + 0.36 * around;
    const double gloss = 0.07 * static_cast<double>(hit.light) * std::pow(std::max(0.0, dot(normal, half_way_)), 30);
    // The light around is a little cooler than the lamp.
    const Parts tint{-0.02, 0, 0.03};
    Parts parts{};
    for (std::size_t i = 0; i < 3; ++i) parts[i] = surface_[i] * (diffuse + tint[i] * around) + gloss;
    return parts;
}

Parts SurfaceShading::opened(const RenderHit& hit, double pixel) const {
    const double distance = static_cast<double>(hit.value) * voxel_;
    Parts parts = to_light(manner_.colours(distance));
    // Along the opened face alone: across it the gradient does not move the lines.
    Vec3 gradient = vector_of(hit.gradient);
    gradient[static_cast<std::size_t>((hit.kind - CLSDF_RENDER_CUT) % 3)] = 0;
    const double slope = std::max(0.3, length(gradient));
    const auto away = [&](double level) { return std::abs(distance - level) / (slope * pixel); };
    for (const double level : manner_.levels.values) {
        if (level == 0 && !manner_.zero_line) continue;
        const Pen pen = iso_line_pen(manner_, level);
        blend(parts, to_light(pen.colour), pen.opacity * cover(away(level), pen.width));
    }
    if (hit.kind < CLSDF_RENDER_BORDER)
        for (const Marked& cut : cuts_) {
            if (cut.axis == hit.kind - CLSDF_RENDER_CUT) continue;
            const double samples = std::abs(static_cast<double>(hit.position[cut.axis]) - cut.position);
            blend(parts, to_light(ink), 0.8 * cover(samples * cut.spacing / pixel, 3.0 * manner_.unit));
        }
    // The rim, half of whose line lies in the face.
    const Pen rim = iso_line_pen(manner_, 0);
    blend(parts, to_light(rim.colour), cover(away(offset_), rim.width));
    return parts;
}

Light SurfaceShading::operator()(const RenderHit& hit, double pixel) const {
    if (hit.kind == CLSDF_RENDER_NOTHING) return {};
    return {hit.kind == CLSDF_RENDER_SURFACE ? lit(hit) : opened(hit, pixel), 1};
}

std::uint32_t pixel_of(const Light& light, bool transparent) {
    const double alpha = transparent ? light.cover : 1;
    auto pixel = static_cast<std::uint32_t>(std::lround(alpha * 255));
    for (const double part : light.parts) {
        // White behind it, in proportion to the light; of a transparent pixel, the colour of what covers it.
        const double shown = transparent ? from_light(light.cover > 0 ? part / light.cover : 0) * alpha
                                         : from_light(part + 1 - light.cover);
        pixel = pixel << 8U | static_cast<std::uint32_t>(std::lround(shown * 255));
    }
    return pixel;
}

namespace {

constexpr double page = 1000;            // units on the picture's longer side
constexpr double most_levels = 14;       // iso-lines in the solid, about
constexpr double line_gap = 6;           // units between iso-lines, at least
constexpr double occlusion_reach = 0.1;  // of the solid's diagonal

double default_offset(const Field& field, bool has_sign) {
    return has_sign ? 0 : std::max({field.grid.spacing[0], field.grid.spacing[1], field.grid.spacing[2]});
}

void check_offset(const Field& field, const TracedSamples& samples, double offset) {
    const bool is_sided = samples.has_sign();
    if (!std::isfinite(offset) || (!is_sided && offset <= 0))
        refuse("render: an offset of {}; choose a finite one{}", offset,
               is_sided ? ""
                        : " above 0: the field has no sign, so its distance touches 0 without "
                          "crossing it");
    const double limit = offset < 0 ? field.band.inside : field.band.outside;
    if (offset != 0 && std::abs(offset) >= limit)
        refuse(
            "render: the band ends at distance {:.6g}, before the surface's {:.6g}; compute the "
            "field with a wider band, or choose an offset within it",
            offset < 0 ? -limit : limit, offset);
    if (!samples.has_surface(offset))
        refuse(
            "render: the grid has no surface at distance {:.6g}: the field's distances are from "
            "{:.6g} to {:.6g}; lay the grid around the mesh, or choose another offset",
            offset, samples.lower(), samples.upper());
}

void check_options(const SurfaceOptions& options) {
    const auto check = [](const char* what, int value, int least, int most) {
        if (value < least || value > most) refuse("render: {} of {}; choose {} to {}", what, value, least, most);
    };
    check("a width", options.width, 16, 10000);
    if (options.height != 0) check("a height", options.height, 16, 10000);
    check("a number of rays", options.rays, 1, 8);
    for (const double part : options.colour)
        if (!(part >= 0 && part <= 1)) refuse("render: a colour with a part of {}; choose parts from 0 to 1", part);
}

void scale_into(double (&target)[3], const Vec3& from, const Vec3& to, const Vec3& spacing) {
    for (std::size_t axis = 0; axis < 3; ++axis) target[axis] = (to[axis] - from[axis]) / spacing[axis];
}

double checked_offset(const Field& field, const TracedSamples& samples, std::optional<double> wanted) {
    const double offset = wanted.value_or(default_offset(field, samples.has_sign()));
    check_offset(field, samples, offset);
    return offset;
}

}  // namespace

Scene::Scene(const Field& field, const Device& device, std::optional<double> offset)
    : field_(field),
      samples_(field),
      offset_(checked_offset(field, samples_, offset)),
      tracer_(field, samples_, device),
      origin_(field.grid.position(0, 0, 0)) {
    find_solid();
}

void Scene::find_solid() {
    const Vec3& spacing = field_.grid.spacing;
    const auto include = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        const Vec3 point{static_cast<double>(i) * spacing[0], static_cast<double>(j) * spacing[1],
                         static_cast<double>(k) * spacing[2]};
        if (points_.empty()) solid_ = {point, point};
        add(solid_, {point, point});
        points_.push_back(point);
    };
    for (const auto& [first, last_x] : samples_.rows_below(offset_)) {
        include(first[0], first[1], first[2]);
        include(last_x, first[1], first[2]);
    }
    upright_ = upright_axis(points_, spacing);
}

Camera Scene::camera(const SurfaceOptions& options) const {
    check_options(options);
    // The surface lies up to a sample beyond those that are inside.
    const Vec3& spacing = field_.grid.spacing;
    View view = options.view;
    if (!view.up) view.up = upright_;
    return {view, points_, std::max({spacing[0], spacing[1], spacing[2]}), options.width, options.height};
}

double Scene::position_of(const Cut& cut) const {
    const auto axis = static_cast<std::size_t>(cut.axis);
    if (!cut.position) return 0.5 * (solid_.lower[axis] + solid_.upper[axis]);
    const double position = *cut.position - origin_[axis];
    const double length = static_cast<double>(field_.grid.size[axis] - 1) * field_.grid.spacing[axis];
    if (!(position > 0 && position < length))
        refuse("render: a cut at {} = {:.6g}, and the grid reaches from {:.6g} to {:.6g}", name_of(cut.axis),
               *cut.position, origin_[axis], origin_[axis] + length);
    return position;
}

// Wide differences make smooth shades. They must not reach samples beyond the band or, without a sign, beyond the mesh.
bool Scene::has_room_for_gradients() const {
    const double reach = 3 * std::max({field_.grid.spacing[0], field_.grid.spacing[1], field_.grid.spacing[2]});
    const double inner = samples_.has_sign() ? -field_.band.inside : 0;
    return offset_ - reach >= inner && offset_ + reach <= field_.band.outside;
}

RenderView Scene::view(const SurfaceOptions& options, const Camera& camera, const SurfaceShading& shading,
                       int rays) const {
    const Vec3& spacing = field_.grid.spacing;
    const double voxel = field_.grid.voxel();
    RenderView seen = tracer_.view();
    const double middle = 0.5 / rays;
    const Camera::Ray first = camera.ray(middle, middle);
    const Camera::Ray right = camera.ray(middle + 1.0 / rays, middle);
    const Camera::Ray down = camera.ray(middle, middle + 1.0 / rays);
    scale_into(seen.origin, {}, first.origin, spacing);
    scale_into(seen.origin_right, first.origin, right.origin, spacing);
    scale_into(seen.origin_down, first.origin, down.origin, spacing);
    scale_into(seen.direction, {}, first.direction, spacing);
    scale_into(seen.direction_right, first.direction, right.direction, spacing);
    scale_into(seen.direction_down, first.direction, down.direction, spacing);
    for (const Cut& cut : options.cuts) {
        const auto axis = static_cast<std::size_t>(cut.axis);
        if (seen.cut_side[axis] != 0)
            refuse("render: two cuts across {}; at most one across each axis", name_of(cut.axis));
        seen.cut[axis] = position_of(cut) / spacing[axis];
        seen.cut_side[axis] = camera.frame().back[axis] < -1e-9 ? -1 : 1;
    }
    double diagonal = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        seen.light[axis] = static_cast<float>(shading.key()[axis]);
        diagonal = std::hypot(diagonal, solid_.upper[axis] - solid_.lower[axis]);
    }
    seen.light_spread = static_cast<float>(SurfaceShading::key_spread);
    seen.level = static_cast<float>(offset_ / voxel);
    seen.highest = static_cast<float>(0.999 * std::min(samples_.upper(), field_.band.outside) / voxel);
    seen.reach = static_cast<float>(
        std::max(2.0, std::min(occlusion_reach * diagonal / voxel,
                               static_cast<double>(seen.highest) - static_cast<double>(seen.level))));
    seen.gradient_step = has_room_for_gradients() ? 1.0F : 0.3F;
    seen.columns = camera.width() * rays;
    seen.rows = camera.height() * rays;
    seen.per_side = rays;
    return seen;
}

Manner Scene::manner(const Camera& camera) const {
    const double unit = std::max(camera.width(), camera.height()) / page;
    Manner manner(
        Colours(std::min(0.0, samples_.lower()), std::max(0.0, samples_.upper()), field_.band, samples_.has_sign()),
        samples_.has_sign(), unit);
    const double lower = std::min(samples_.lower(), offset_);
    const double range = offset_ - lower;
    const Vec3 middle{0.5 * (solid_.lower[0] + solid_.upper[0]), 0.5 * (solid_.lower[1] + solid_.upper[1]),
                      0.5 * (solid_.lower[2] + solid_.upper[2])};
    const double least = std::max(range / most_levels, line_gap * unit * camera.pixel_at(middle));
    manner.levels = scale_with_step(lower + 1e-6 * range, offset_, round_step(least));
    return manner;
}

SurfaceShading Scene::shading(const SurfaceOptions& options, const Camera& camera, const Manner& manner) const {
    SurfaceShading shading(camera.frame(), manner, options.colour, offset_, field_.grid.voxel());
    for (const Cut& cut : options.cuts) {
        const double spacing = field_.grid.spacing[static_cast<std::size_t>(cut.axis)];
        shading.mark_cut(cut.axis, position_of(cut) / spacing, spacing);
    }
    return shading;
}

Vec3 Scene::position_of(const RenderHit& hit) const {
    Vec3 position{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        position[axis] = static_cast<double>(hit.position[axis]) * field_.grid.spacing[axis];
    return position;
}

}  // namespace clsdf::picture
