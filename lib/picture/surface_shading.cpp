#include "picture/surface_shading.hpp"

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

double dot(const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vec3 unit(const Vec3& v) {
    const double length = std::sqrt(dot(v, v));
    return {v[0] / length, v[1] / length, v[2] / length};
}

Vec3 in(const ViewFrame& frame, double right, double up, double back) {
    Vec3 direction{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        direction[axis] = right * frame.right[axis] + up * frame.up[axis] + back * frame.back[axis];
    return unit(direction);
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
      half_way_(unit({key_[0] + frame.back[0], key_[1] + frame.back[1], key_[2] + frame.back[2]})) {}

void SurfaceShading::mark_cut(Axis axis, double position, double spacing) {
    cuts_.push_back({static_cast<int>(axis), position, spacing});
}

Parts SurfaceShading::lit(const RenderHit& hit) const {
    const Vec3 gradient = vector_of(hit.gradient);
    if (!(dot(gradient, gradient) > 0)) return surface_;
    const Vec3 normal = unit(gradient);
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
    const double slope = std::max(0.3, std::sqrt(dot(gradient, gradient)));
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

}  // namespace clsdf::picture
