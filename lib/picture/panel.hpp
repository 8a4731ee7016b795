#pragma once

#include "picture/canvas.hpp"
#include "picture/plane.hpp"
#include "picture/round_values.hpp"

namespace clsdf::picture {

/// The settings that all slices of a field share.
struct Manner {
    Manner(const Colours& given_colours, bool given_zero_line, double given_unit)
        : colours(given_colours), zero_line(given_zero_line), unit(given_unit) {}

    Colours colours;
    Scale levels;    ///< of the iso-lines
    bool zero_line;  ///< a field without a sign has none
    double unit;     ///< pixels: the lengths and text sizes of the drawing are multiples of it
};

inline constexpr Colour ink{0.1, 0.11, 0.13};
inline constexpr Colour faint_ink{0.38, 0.4, 0.43};

Pen iso_line_pen(const Manner& manner, double level);
Pen frame_pen(const Manner& manner);
inline constexpr double text_size = 21;  // units

/// The plane in a rectangle of whole pixels: colours, iso-lines and a frame.
void draw_plane(Canvas& canvas, const Plane& plane, const Rectangle& area, const Manner& manner);

/// The axis below the rectangle, or left of it: ticks, numbers and the axis' name; `bare`: ticks alone.
void draw_axis_below(Canvas& canvas, const Plane& plane, const Rectangle& area, const Manner& manner, bool bare);
void draw_axis_left(Canvas& canvas, const Plane& plane, const Rectangle& area, const Manner& manner, bool bare);

}  // namespace clsdf::picture
