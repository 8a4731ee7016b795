#pragma once

#include "picture/panel.hpp"

namespace clsdf::picture {

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
