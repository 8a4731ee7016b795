#pragma once

#include "polyhedra/side_of_plane.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace clsdf::polyhedra {

/// The sides of planes on which points lie, a vector of points at a time, in twice the precision of double. This
/// decides nearly all points that double leaves open.
class PlaneSides {
public:
    static constexpr std::size_t capacity = 8;

    void set(std::size_t i, const OppositeVertex& vertex);

    /// side_of_plane() of each, where it is certain, else 0.
    using Sides = std::array<std::int32_t, capacity>;
    void measure(Sides& sides) const;

private:
    using Components = std::array<std::array<double, capacity>, 3>;

    std::array<Components, 4> points_{};  // lanes that were not set are padding
};

}  // namespace clsdf::polyhedra
