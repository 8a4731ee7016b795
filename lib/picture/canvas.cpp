#include "picture/canvas.hpp"

#include "core/files.hpp"
#include "core/refuse.hpp"
#include "picture/text.hpp"

#include <clsdf/error.hpp>

#include <cairo-pdf.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <new>
#include <span>

namespace clsdf::picture {

namespace {

constexpr Colour rgb(unsigned hexadecimal) {
    const auto part = [&](unsigned shift) { return static_cast<double>(hexadecimal >> shift & 0xFFU) / 255; };
    return {part(16), part(8), part(0)};
}

// Evenly spaced, from the surface outwards.
constexpr std::array blues{rgb(0xE4EFF7), rgb(0xABD0E6), rgb(0x6AAED6), rgb(0x3A87BF), rgb(0x1C62A5)};
constexpr std::array oranges{rgb(0xFFF0DC), rgb(0xFDD3A2), rgb(0xFBAE66), rgb(0xF0843A), rgb(0xD35A1B)};
constexpr std::array one_sided{rgb(0xFEFBD9), rgb(0xD5EEB7), rgb(0x8DD2B9), rgb(0x43ABBE), rgb(0x2776AE)};
constexpr Colour pale_blue = rgb(0xD3DCE6);
constexpr Colour pale_orange = rgb(0xF1E9DF);
constexpr Colour pale_green = rgb(0xE3E8EA);
constexpr Colour grey = rgb(0xB0B0B0);

// Stronger near the surface than in proportion, so that a shallow inside has colours beside a deep outside.
constexpr double bend = 0.7;

Colour between(std::span<const Colour> colours, double part) {
    const double place = std::clamp(part, 0.0, 1.0) * static_cast<double>(colours.size() - 1);
    const auto first = std::min(static_cast<std::size_t>(place), colours.size() - 2);
    const double weight = place - static_cast<double>(first);
    Colour mixed{};
    for (std::size_t i = 0; i < 3; ++i) mixed[i] = colours[first][i] * (1 - weight) + colours[first + 1][i] * weight;
    return mixed;
}

}  // namespace

Colours::Colours(double lower, double upper, const Band& band, bool has_sign)
    : reach_(std::max(-lower, upper)),
      inside_(has_sign ? static_cast<double>(static_cast<float>(band.inside))
                       : std::numeric_limits<double>::infinity()),
      outside_(static_cast<double>(static_cast<float>(band.outside))),
      has_sign_(has_sign) {}

Colour Colours::operator()(double distance) const {
    if (std::isnan(distance)) return grey;
    if (distance >= outside_) return beyond_outside();
    if (distance < 0 && distance <= -inside_) return beyond_inside();
    const double strength = std::pow(std::abs(distance) / reach_, bend);
    if (!has_sign_) return between(one_sided, strength);
    return distance < 0 ? between(blues, strength) : between(oranges, strength);
}

Colour Colours::beyond_outside() const {
    return has_sign_ ? pale_orange : pale_green;
}

Colour Colours::beyond_inside() const {
    return pale_blue;
}

namespace {

constexpr double capital_height = 0.73;  // of the font's size

void check(cairo_status_t status) {
    if (status != CAIRO_STATUS_SUCCESS)
        throw Error(status == CAIRO_STATUS_NO_MEMORY ? ErrorCode::out_of_memory : ErrorCode::unsupported,
                    fmt::format("the picture cannot be drawn: {}", cairo_status_to_string(status)));
}

void set_colour(cairo_t* context, const Colour& colour, double opacity = 1) {
    cairo_set_source_rgba(context, colour[0], colour[1], colour[2], opacity);
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
    try {
        static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
        return CAIRO_STATUS_SUCCESS;
    } catch (const std::bad_alloc&) {  // must not pass through C
        return CAIRO_STATUS_NO_MEMORY;
    }
}

double part_of(Place place) {
    return place == Place::start ? 0 : place == Place::middle ? 0.5 : 1;
}

/// The largest extent of cairo's images. cairo 1.16 never frees a recording without bounds that it puts into a PDF.
constexpr cairo_rectangle_t largest_sheet{-32767, -32767, 65534, 65534};

}  // namespace

void Canvas::Release::operator()(cairo_surface_t* surface) const {
    cairo_surface_destroy(surface);
}

void Canvas::Release::operator()(cairo_t* context) const {
    cairo_destroy(context);
}

Canvas::Surface Canvas::image_of(const Raster& raster, cairo_format_t format) {
    Surface image(cairo_image_surface_create(format, raster.width, raster.height));
    check(cairo_surface_status(image.get()));
    const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(image.get()));
    unsigned char* bytes = cairo_image_surface_get_data(image.get());
    const auto width = static_cast<std::size_t>(raster.width);
    for (std::size_t row = 0; row < static_cast<std::size_t>(raster.height); ++row)
        std::memcpy(bytes + row * stride, raster.pixels.data() + row * width, width * sizeof(std::uint32_t));
    cairo_surface_mark_dirty(image.get());
    return image;
}

std::string Canvas::png_of(const Raster& raster) {
    const Surface image = image_of(raster, CAIRO_FORMAT_ARGB32);
    std::string bytes;
    check(cairo_surface_write_to_png_stream(image.get(), append, &bytes));
    return bytes;
}

Canvas::Canvas()
    : recording_(cairo_recording_surface_create(CAIRO_CONTENT_COLOR_ALPHA, &largest_sheet)),
      context_(cairo_create(recording_.get())) {
    check(cairo_status(context_.get()));
    cairo_set_line_join(context_.get(), CAIRO_LINE_JOIN_ROUND);
    // The same letters in the same places whatever the desktop's settings are.
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(context_.get(), options);
    cairo_font_options_destroy(options);
}

void Canvas::draw(std::span<const Point> line, const Pen& pen) {
    if (line.size() < 2) return;
    cairo_t* context = context_.get();
    for (const Point& point : line) cairo_line_to(context, point[0], point[1]);
    if (line.front() == line.back()) cairo_close_path(context);
    cairo_set_line_width(context, pen.width);
    cairo_set_dash(context, pen.dashes.data(), static_cast<int>(pen.dashes.size()), 0);
    set_colour(context, pen.colour, pen.opacity);
    cairo_stroke(context);
}

void Canvas::draw(const Rectangle& outline, const Pen& pen) {
    const Point corners[] = {{outline.left, outline.top},
                             {outline.right(), outline.top},
                             {outline.right(), outline.bottom()},
                             {outline.left, outline.bottom()},
                             {outline.left, outline.top}};
    draw(corners, pen);
}

void Canvas::fill(const Rectangle& area, const Colour& colour) {
    cairo_rectangle(context_.get(), area.left, area.top, area.width, area.height);
    set_colour(context_.get(), colour);
    cairo_fill(context_.get());
}

void Canvas::place(const Raster& raster, int left, int top) {
    const Surface image = image_of(raster, CAIRO_FORMAT_RGB24);

    cairo_t* context = context_.get();
    cairo_set_source_surface(context, image.get(), left, top);
    cairo_pattern_set_filter(cairo_get_source(context), CAIRO_FILTER_NEAREST);
    cairo_rectangle(context, left, top, raster.width, raster.height);
    cairo_fill(context);
}

std::string Canvas::choose_font(const std::string& text, const TextStyle& style) const {
    cairo_t* context = context_.get();
    cairo_select_font_face(context, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context, style.size);
    // If no font is installed, cairo uses letters of its own, which lack a minus sign.
    const bool poor = cairo_scaled_font_get_type(cairo_get_scaled_font(context)) == CAIRO_FONT_TYPE_USER;
    return poor ? in_ascii(text) : text;
}

double Canvas::width_of(const std::string& text, const TextStyle& style) const {
    const std::string shown = choose_font(text, style);
    cairo_text_extents_t extents;
    cairo_text_extents(context_.get(), shown.c_str(), &extents);
    check(cairo_status(context_.get()));
    return extents.x_advance;
}

void Canvas::write(const std::string& text, const Point& at, const TextStyle& style) {
    const double width = width_of(text, style);
    const std::string shown = choose_font(text, style);
    cairo_t* context = context_.get();
    cairo_save(context);
    cairo_translate(context, at[0], at[1]);
    if (style.upwards) cairo_rotate(context, -std::acos(-1.0) / 2);
    cairo_move_to(context, -width * part_of(style.horizontal),
                  capital_height * style.size * (1 - part_of(style.vertical)));
    set_colour(context, style.colour);
    cairo_show_text(context, shown.c_str());
    cairo_new_path(context);  // text leaves a point behind, from which the next line would start
    cairo_restore(context);
}

Canvas::Clip::Clip(Canvas& canvas, const Rectangle& area) : canvas_(canvas) {
    cairo_t* context = canvas_.context_.get();
    cairo_save(context);
    cairo_rectangle(context, area.left, area.top, area.width, area.height);
    cairo_clip(context);
}

Canvas::Clip::~Clip() {
    cairo_restore(canvas_.context_.get());
}

Rectangle Canvas::sheet(double margin) const {
    check(cairo_status(context_.get()));
    Rectangle ink;
    cairo_recording_surface_ink_extents(recording_.get(), &ink.left, &ink.top, &ink.width, &ink.height);
    const double left = std::floor(ink.left - margin);
    const double top = std::floor(ink.top - margin);
    return {left, top, std::ceil(ink.right() + margin) - left, std::ceil(ink.bottom() + margin) - top};
}

void Canvas::replay(cairo_surface_t* target, const Rectangle& sheet, double scale) const {
    const Context context(cairo_create(target));
    set_colour(context.get(), {1, 1, 1});
    cairo_paint(context.get());
    cairo_scale(context.get(), scale, scale);
    cairo_set_source_surface(context.get(), recording_.get(), -sheet.left, -sheet.top);
    cairo_paint(context.get());
    check(cairo_status(context.get()));
}

std::string Canvas::png(double margin) const {
    const Rectangle area = sheet(margin);
    const Surface image(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(area.width), static_cast<int>(area.height)));
    replay(image.get(), area, 1);
    std::string bytes;
    check(cairo_surface_write_to_png_stream(image.get(), append, &bytes));
    return bytes;
}

std::string Canvas::pdf(double margin, double points_per_pixel) const {
    const Rectangle area = sheet(margin);
    std::string bytes;
    const Surface document(cairo_pdf_surface_create_for_stream(append, &bytes, area.width * points_per_pixel,
                                                               area.height * points_per_pixel));
    replay(document.get(), area, points_per_pixel);
    cairo_surface_finish(document.get());
    check(cairo_surface_status(document.get()));
    return bytes;
}

std::string ending_of(const std::string& path, std::initializer_list<std::string_view> endings) {
    const std::string ending = clsdf::ending_of(path);
    if (std::find(endings.begin(), endings.end(), ending) == endings.end())
        refuse_unsupported("{}: no picture format ends in \"{}\"; choose {}", path, ending, fmt::join(endings, " or "));
    return ending;
}

void check_writable(const std::string& path) {
    clsdf::check_writable(path);
}

void write_file(const std::string& path, const std::string& bytes) {
    AtomicFile file(path);
    file.write(bytes);
    file.commit();
}

}  // namespace clsdf::picture
