#include "picture/panel.hpp"

#include "core/parallel.hpp"
#include "picture/plane.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::picture {

namespace {

constexpr int samples_a_side = 2;  // of a pixel, so that the edges of the flat tones are smooth

// From samples of the plane to pixels of the canvas.
struct Frame {
    const Plane& plane;
    const Rectangle& area;

    Point operator()(const PlanePoint& point) const {
        return {area.left + point[0] / static_cast<double>(plane.size[0] - 1) * area.width,
                area.bottom() - point[1] / static_cast<double>(plane.size[1] - 1) * area.height};
    }
    double column(double pixel) const { return pixel / area.width * static_cast<double>(plane.size[0] - 1); }
    double row(double pixel) const { return (1 - pixel / area.height) * static_cast<double>(plane.size[1] - 1); }
};

std::uint32_t colour_of_pixel(const Frame& frame, const Colours& colours, int x, int y) {
    Colour sum{};
    for (int i = 0; i < samples_a_side; ++i)
        for (int j = 0; j < samples_a_side; ++j) {
            const double column = frame.column(x + (i + 0.5) / samples_a_side);
            const double row = frame.row(y + (j + 0.5) / samples_a_side);
            const Colour colour = colours(frame.plane.at(column, row));
            for (std::size_t k = 0; k < 3; ++k) sum[k] += colour[k];
        }
    std::uint32_t pixel = 0;
    for (const double part : sum)
        pixel = pixel << 8U | static_cast<std::uint32_t>(std::lround(part / (samples_a_side * samples_a_side) * 255));
    return pixel;
}

Raster colours_of(const Frame& frame, const Colours& colours) {
    Raster raster{static_cast<int>(frame.area.width), static_cast<int>(frame.area.height), {}};
    raster.pixels.resize(static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height));
    for_each_index(
        static_cast<std::size_t>(raster.height),
        [&](std::size_t y) {
            for (int x = 0; x < raster.width; ++x)
                raster.pixels[y * static_cast<std::size_t>(raster.width) + static_cast<std::size_t>(x)] =
                    colour_of_pixel(frame, colours, x, static_cast<int>(y));
        },
        1);
    return raster;
}

void draw_iso_lines(Canvas& canvas, const Frame& frame, const Manner& manner, double level) {
    const Pen pen = iso_line_pen(manner, level);
    std::vector<Point> line;
    for (const Polyline& polyline : iso_lines(frame.plane, level)) {
        line.clear();
        for (const PlanePoint& point : polyline) line.push_back(frame(point));
        canvas.draw(line, pen);
    }
}

// Ticks are as close as their labels allow, with a minimum distance.
template <class LabelLength>
Scale ticks_along(double lower, double upper, double pixels, double unit, const LabelLength& label_length) {
    Scale scale;
    for (int count = std::max(4, static_cast<int>(pixels / (60 * unit))); count >= 1; --count) {
        scale = scale_between(lower, upper, count);
        if (scale.values.size() < 2) return scale;
        double longest = 0;
        for (const std::string& label : scale.labels) longest = std::max(longest, label_length(label));
        const double apart = (scale.values[1] - scale.values[0]) / (upper - lower) * pixels;
        if (longest + text_size * unit <= apart) break;
    }
    return scale;
}

constexpr double tick_length = 8;
constexpr double label_gap = 7;

}  // namespace

Pen iso_line_pen(const Manner& manner, double level) {
    if (level == 0) return {4.2 * manner.unit, ink, 1, {}};
    return {1.5 * manner.unit, ink, 0.62, {}};
}

Pen frame_pen(const Manner& manner) {
    return {1.5 * manner.unit, ink, 1, {}};
}

void draw_plane(Canvas& canvas, const Plane& plane, const Rectangle& area, const Manner& manner) {
    const Frame frame{plane, area};
    canvas.place(colours_of(frame, manner.colours), static_cast<int>(area.left), static_cast<int>(area.top));
    {
        const Canvas::Clip clip(canvas, area);
        for (const double level : manner.levels.values)
            if (level != 0) draw_iso_lines(canvas, frame, manner, level);
        if (manner.zero_line) draw_iso_lines(canvas, frame, manner, 0);
    }
    canvas.draw(area, frame_pen(manner));
}

void draw_axis_below(Canvas& canvas, const Plane& plane, const Rectangle& area, const Manner& manner, bool bare) {
    const double unit = manner.unit;
    const TextStyle style{text_size * unit, Place::middle, Place::start, false, false, ink};
    const Scale ticks = ticks_along(plane.lower[0], plane.upper[0], area.width, unit,
                                    [&](const std::string& label) { return canvas.width_of(label, style); });
    const double numbers = area.bottom() + (tick_length + label_gap) * unit;
    for (std::size_t i = 0; i < ticks.values.size(); ++i) {
        const double x =
            area.left + (ticks.values[i] - plane.lower[0]) / (plane.upper[0] - plane.lower[0]) * area.width;
        const Point tick[] = {{x, area.bottom()}, {x, area.bottom() + tick_length * unit}};
        canvas.draw(tick, frame_pen(manner));
        if (!bare) canvas.write(ticks.labels[i], {x, numbers}, style);
    }
    if (!bare)
        canvas.write(name_of(plane.axes[0]) + ticks.remark,
                     {area.left + area.width / 2, numbers + 1.55 * text_size * unit}, style);
}

void draw_axis_left(Canvas& canvas, const Plane& plane, const Rectangle& area, const Manner& manner, bool bare) {
    const double unit = manner.unit;
    const TextStyle style{text_size * unit, Place::end, Place::middle, false, false, ink};
    const Scale ticks = ticks_along(plane.lower[1], plane.upper[1], area.height, unit,
                                    [&](const std::string&) { return text_size * unit; });
    const double numbers = area.left - (tick_length + label_gap) * unit;
    double longest = 0;
    for (std::size_t i = 0; i < ticks.values.size(); ++i) {
        const double y =
            area.bottom() - (ticks.values[i] - plane.lower[1]) / (plane.upper[1] - plane.lower[1]) * area.height;
        const Point tick[] = {{area.left, y}, {area.left - tick_length * unit, y}};
        canvas.draw(tick, frame_pen(manner));
        if (bare) continue;
        canvas.write(ticks.labels[i], {numbers, y}, style);
        longest = std::max(longest, canvas.width_of(ticks.labels[i], style));
    }
    if (bare) return;
    TextStyle name_style = style;
    name_style.horizontal = Place::middle;
    name_style.vertical = Place::end;
    // A single letter is drawn upright, a longer text along the axis.
    name_style.upwards = !ticks.remark.empty();
    if (!name_style.upwards) {
        name_style.horizontal = Place::end;
        name_style.vertical = Place::middle;
    }
    canvas.write(name_of(plane.axes[1]) + ticks.remark,
                 {numbers - longest - 0.55 * text_size * unit, area.top + area.height / 2}, name_style);
}

namespace {

constexpr double cap_height = 26;  // units
constexpr double cap_gap = 7;
constexpr double bar_label_gap = 10;

// The bar is drawn as a plane with one column of values, so it has the colours of the slices.
Plane plane_of(const ColourBar& bar) {
    Plane plane;
    plane.size = {2, 2};
    plane.lower = {0, bar.lower};
    plane.upper = {1, bar.upper};
    plane.values = {bar.lower, bar.lower, bar.upper, bar.upper};
    return plane;
}

// The numbers of the levels without overlaps: all, every second or every fifth from zero.
std::int64_t label_stride(const Scale& levels, double pixels_per_value, double text_height) {
    if (levels.values.size() < 2) return 1;
    const double apart = (levels.values[1] - levels.values[0]) * pixels_per_value;
    for (const std::int64_t stride : {1, 2, 5, 10, 20})
        if (static_cast<double>(stride) * apart >= 1.25 * text_height) return stride;
    return 50;
}

void draw_cap(Canvas& canvas, const Rectangle& area, const Colour& colour, const std::string& label,
              const Manner& manner) {
    canvas.fill(area, colour);
    canvas.draw(area, frame_pen(manner));
    canvas.write(label, {area.right() + bar_label_gap * manner.unit, area.top + area.height / 2},
                 {text_size * manner.unit, Place::start, Place::middle, false, false, ink});
}

}  // namespace

void draw_colour_bar(Canvas& canvas, const ColourBar& bar, const Rectangle& area, const Manner& manner) {
    const double unit = manner.unit;
    Rectangle colours = area;
    const double cap = std::round((cap_height + cap_gap) * unit);
    if (bar.beyond_outside) colours.top += cap;
    colours.height -= cap * (int{bar.beyond_outside} + int{bar.beyond_inside});
    draw_plane(canvas, plane_of(bar), colours, manner);

    const TextStyle style{text_size * unit, Place::start, Place::middle, false, false, ink};
    const Scale& levels = manner.levels;
    const double pixels_per_value = colours.height / (bar.upper - bar.lower);
    const std::int64_t stride = label_stride(levels, pixels_per_value, style.size);
    const auto zero = std::find(levels.values.begin(), levels.values.end(), 0.0) - levels.values.begin();
    double longest = 0;
    for (std::size_t i = 0; i < levels.values.size(); ++i) {
        if ((static_cast<std::int64_t>(i) - zero) % stride != 0) continue;
        const double y = colours.bottom() - (levels.values[i] - bar.lower) * pixels_per_value;
        TextStyle own = style;
        own.bold = levels.values[i] == 0 && manner.zero_line;
        canvas.write(levels.labels[i], {colours.right() + bar_label_gap * unit, y}, own);
        longest = std::max(longest, canvas.width_of(levels.labels[i], own));
    }

    const double height = cap_height * unit;
    if (bar.beyond_outside)
        draw_cap(canvas, {area.left, area.top, area.width, height}, manner.colours.beyond_outside(), "beyond", manner);
    if (bar.beyond_inside)
        draw_cap(canvas, {area.left, area.bottom() - height, area.width, height}, manner.colours.beyond_inside(),
                 "beyond", manner);
    if (bar.beyond_inside || bar.beyond_outside) longest = std::max(longest, canvas.width_of("beyond", style));
    TextStyle caption = style;
    caption.horizontal = Place::middle;
    caption.vertical = Place::start;
    caption.upwards = true;
    canvas.write(
        bar.caption + levels.remark,
        {colours.right() + bar_label_gap * unit + longest + 0.7 * text_size * unit, area.top + area.height / 2},
        caption);
}

}  // namespace clsdf::picture
