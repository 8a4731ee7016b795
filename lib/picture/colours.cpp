#include "picture/colours.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

}  // namespace clsdf::picture
