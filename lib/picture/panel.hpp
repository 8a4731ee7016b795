#pragma once

#include "picture/canvas.hpp"
#include "picture/plane.hpp"
#include "picture/text.hpp"

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

struct ColourBar {
    double lower = 0;  ///< the least and the greatest distance
    double upper = 0;
    bool beyond_inside = false;  ///< there are samples beyond the band
    bool beyond_outside = false;
    std::string caption;
};

inline constexpr double colour_bar_width = 30;  // units

/// The colours of all distances from top to bottom, with the iso-lines' values beside them, and the flat tones at the
/// ends.
void draw_colour_bar(Canvas& canvas, const ColourBar& bar, const Rectangle& area, const Manner& manner);

}  // namespace clsdf::picture
