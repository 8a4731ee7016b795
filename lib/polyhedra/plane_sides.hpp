#pragma once

#include "polyhedra/side_of_plane.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace clsdf::polyhedra {

/// On which sides of planes points lie, as many at a time as a processor's vectors hold, in twice the precision of
/// double: that tells for nearly all points that the roundings of double leave open.
class PlaneSides {
public:
    static constexpr std::size_t capacity = 8;

    void set(std::size_t i, const OppositeVertex& vertex);

    /// side_of_plane() of each, where it is certain, else 0.
    using Sides = std::array<std::int32_t, capacity>;
    void measure(Sides& sides) const;

private:
    using Components = std::array<std::array<double, capacity>, 3>;

    std::array<Components, 4> points_{};  // what was not set is measured too, and of no use
};

}  // namespace clsdf::polyhedra
