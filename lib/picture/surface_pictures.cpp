#include "core/lifetime.hpp"
#include "core/parallel.hpp"
#include "picture/canvas.hpp"
#include "picture/panel.hpp"
#include "picture/scene.hpp"
#include "picture/text.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>

namespace clsdf::picture {
namespace {

// In units, a thousandth of the picture's longer side.
constexpr double margin = 24;  // around a picture with a colour bar
constexpr double bar_height = 560;
constexpr double bar_gap = 24;  // between picture and colour bar

void report(const SurfaceOptions& options, int rows, int all) {
    if (options.progress) options.progress(static_cast<double>(rows) / static_cast<double>(all));
}

Hit::Kind kind_of(int kind) {
    if (kind == CLSDF_RENDER_NOTHING) return Hit::Kind::nothing;
    if (kind == CLSDF_RENDER_SURFACE) return Hit::Kind::surface;
    return kind < CLSDF_RENDER_BORDER ? Hit::Kind::cut : Hit::Kind::border;
}

}  // namespace

SurfacePictures::SurfacePictures(const Field& field, const Device& device, std::optional<double> offset)
    : scene_(std::make_unique<const Scene>(field, device, offset)) {}
SurfacePictures::SurfacePictures(SurfacePictures&&) noexcept = default;
SurfacePictures& SurfacePictures::operator=(SurfacePictures&&) noexcept = default;
SurfacePictures::~SurfacePictures() = default;

double SurfacePictures::offset() const {
    return held_by(scene_, "SurfacePictures").offset();
}

Axis SurfacePictures::upright() const {
    return held_by(scene_, "SurfacePictures").upright();
}

Hits SurfacePictures::hits(const SurfaceOptions& options) const {
    const Scene& scene = held_by(scene_, "SurfacePictures");
    const Camera camera = scene.camera(options);
    const Manner manner = scene.manner(camera);
    const RenderView view = scene.view(options, camera, scene.shading(options, camera, manner), 1);
    const double voxel = scene.field().grid.voxel();
    Hits hits{camera.width(), camera.height(), {}};
    scene.tracer().trace(view, options.should_stop, [&](int first_row, std::span<const RenderHit> found) {
        for (const RenderHit& hit : found) {
            Hit& pixel = hits.pixels.emplace_back();
            pixel.kind = kind_of(hit.kind);
            if (pixel.kind == Hit::Kind::nothing) continue;
            pixel.position = scene.position_of(hit);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                pixel.position[axis] += scene.origin()[axis];
                pixel.gradient[axis] = static_cast<double>(hit.gradient[axis]);
            }
            pixel.distance = static_cast<double>(hit.value) * voxel;
        }
        report(options, first_row + static_cast<int>(found.size() / static_cast<std::size_t>(view.columns)), view.rows);
    });
    return hits;
}

namespace {

// A pixel's light is the mean of its rays'.
class PixelSums {
public:
    PixelSums(int width, int height, int rays)
        : rays_(rays), width_(static_cast<std::size_t>(width)), lights_(width_ * static_cast<std::size_t>(height)) {}

    template <class LightOf>
    void add(int first_row, std::span<const RenderHit> hits, const LightOf& light_of) {
        const auto rays = static_cast<std::size_t>(rays_);
        const std::size_t columns = width_ * rays;
        const std::size_t rows = hits.size() / columns;
        const double share = 1.0 / static_cast<double>(rays * rays);
        for_each_index(
            width_,
            [&](std::size_t x) {
                for (std::size_t row = 0; row < rows; ++row) {
                    Light& sum = lights_[(static_cast<std::size_t>(first_row) + row) / rays * width_ + x];
                    for (std::size_t column = x * rays; column < (x + 1) * rays; ++column) {
                        const Light light = light_of(hits[row * columns + column]);
                        for (std::size_t i = 0; i < 3; ++i) sum.parts[i] += share * light.parts[i];
                        sum.cover += share * light.cover;
                    }
                }
            },
            1);
    }

    Raster raster(bool transparent) const {
        Raster raster{static_cast<int>(width_), static_cast<int>(lights_.size() / width_), {}};
        raster.pixels.reserve(lights_.size());
        for (const Light& light : lights_) raster.pixels.push_back(pixel_of(light, transparent));
        return raster;
    }

private:
    int rays_;
    std::size_t width_;
    std::vector<Light> lights_;
};

// "cut at x = 0.3 and z = 0.1; iso-lines every 0.01".
std::string description(const Scene& scene, const SurfaceOptions& options, const Manner& manner) {
    std::string text = scene.offset() == 0 ? "" : fmt::format("surface at distance {}", number(scene.offset(), 4));
    const auto continue_with = [&](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
    std::string cuts;
    for (const Cut& cut : options.cuts) {
        const double position = scene.position_of(cut) + scene.origin()[static_cast<std::size_t>(cut.axis)];
        const bool zero = std::abs(position) < 1e-9 * scene.field().grid.voxel();
        cuts += fmt::format("{}{} = {}", cuts.empty() ? "cut at " : ", ", name_of(cut.axis),
                            number(zero ? 0 : position, 4));
    }
    if (!cuts.empty()) continue_with(cuts);
    const std::vector<double>& values = manner.levels.values;
    if (values.size() > 1) continue_with(fmt::format("iso-lines every {}", number(values[1] - values[0], 4)));
    return text;
}

// The mesh's name above, a colour bar of the distances inside beside the picture.
void draw_legend(Canvas& canvas, const Scene& scene, const SurfaceOptions& options, const Manner& manner,
                 const Raster& raster) {
    const double unit = manner.unit;
    const TextStyle small{0.86 * unit * text_size, Place::start, Place::end, false, false, faint_ink};
    canvas.write(description(scene, options, manner), {0, -20 * unit}, small);
    const std::string name = std::filesystem::path(scene.field().mesh_name).filename().string();
    canvas.write(name.empty() ? "Distance field" : printable(name, 48), {0, -57 * unit},
                 {1.4 * unit * text_size, Place::start, Place::end, true, false, ink});
    const double lower = std::min(scene.samples().lower(), scene.offset());
    if (!(lower < scene.offset())) return;  // nothing lies inside to have a colour
    const bool has_sign = scene.samples().has_sign();
    const ColourBar bar{lower, scene.offset(), has_sign && lower <= -scene.field().band.inside, false,
                        has_sign ? "signed distance (mesh units)" : "distance (mesh units)"};
    const double height = std::round(std::min(bar_height * unit, static_cast<double>(raster.height)));
    draw_colour_bar(canvas, bar,
                    {std::round(raster.width + bar_gap * unit), std::round(0.5 * (raster.height - height)),
                     std::round(colour_bar_width * unit), height},
                    manner);
}

}  // namespace

void SurfacePictures::write(const SurfaceOptions& options, const std::string& path) const {
    const Scene& scene = held_by(scene_, "SurfacePictures");
    check_path(path);
    const Camera camera = scene.camera(options);
    const Manner manner = scene.manner(camera);
    const SurfaceShading shading = scene.shading(options, camera, manner);
    const RenderView view = scene.view(options, camera, shading, options.rays);
    PixelSums sums(camera.width(), camera.height(), options.rays);
    std::atomic<bool> is_opened = false;
    scene.tracer().trace(view, options.should_stop, [&](int first_row, std::span<const RenderHit> hits) {
        sums.add(first_row, hits, [&](const RenderHit& hit) {
            if (hit.kind >= CLSDF_RENDER_CUT) is_opened.store(true, std::memory_order_relaxed);
            return shading(hit, hit.kind == CLSDF_RENDER_NOTHING ? 1 : camera.pixel_at(scene.position_of(hit)));
        });
        report(options, first_row + static_cast<int>(hits.size() / static_cast<std::size_t>(view.columns)), view.rows);
    });
    const Raster raster = sums.raster(options.transparent);
    if (!is_opened || options.transparent || options.bare) {
        write_file(path, Canvas::png_of(raster));
        return;
    }
    Canvas canvas;
    canvas.place(raster, 0, 0);
    draw_legend(canvas, scene, options, manner, raster);
    write_file(path, canvas.png(margin * manner.unit));
}

void SurfacePictures::check_path(const std::string& path) {
    ending_of(path, {".png"});
    check_writable(path);
}

}  // namespace clsdf::picture
