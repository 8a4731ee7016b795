#pragma once

#include <clsdf/grid.hpp>

#include <array>

namespace clsdf::picture {

/// Red, green and blue, 0 ... 1, sRGB.
using Colour = std::array<double, 3>;

/// A colour for every distance. Signed: blue inside and orange outside, stronger with the distance, equally on both
/// sides. Readers with any colour vision can tell them apart; in grey copies iso-lines help. Unsigned: from yellow over
/// green to blue. Beyond the band: flat and paler. NaN is grey.
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
