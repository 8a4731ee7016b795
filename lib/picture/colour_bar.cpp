#include "picture/colour_bar.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::picture {
namespace {

constexpr double cap_height = 26;  // units
constexpr double cap_gap = 7;
constexpr double label_gap = 10;

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
    canvas.write(label, {area.right() + label_gap * manner.unit, area.top + area.height / 2},
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
        canvas.write(levels.labels[i], {colours.right() + label_gap * unit, y}, own);
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
    canvas.write(bar.caption + levels.remark,
                 {colours.right() + label_gap * unit + longest + 0.7 * text_size * unit, area.top + area.height / 2},
                 caption);
}

}  // namespace clsdf::picture
