#pragma once

#include <clsdf/grid.hpp>

#include <array>

namespace clsdf::picture {

/// Red, green and blue, 0 ... 1, sRGB.
using Colour = std::array<double, 3>;

/// A colour for every distance. Signed: blues inside and oranges outside, which readers with any colour vision and grey
/// copies by the iso-lines can tell apart; the farther from the surface the stronger, equally on both sides. Unsigned:
/// from yellow over green to blue. Beyond the band: flat and paler. What is not a number is grey.
class Colours {
public:
    /// `lower` <= 0 <= `upper` are the least and the greatest distance that occur.
    Colours(double lower, double upper, const Band& band, bool has_sign);

    Colour operator()(double distance) const;

    /// The flat tones.
    Colour beyond_outside() const;
    Colour beyond_inside() const;

private:
    double reach_;
    double inside_;
    double outside_;
    bool has_sign_;
};

}  // namespace clsdf::picture
