#pragma once

#include "polyhedra/vector.hpp"

#include <array>
#include <cstddef>

namespace clsdf::polyhedra {

/// A vector of numbers, as wide as the processor's vectors.
constexpr std::size_t lanes = 8;

using Lanes = std::array<double, lanes>;

struct LaneVectors {
    Lanes x;
    Lanes y;
    Lanes z;

    /// For vectors of any kind.
    template <typename V>
    void set(std::size_t i, const V& v) {
        x[i] = v[0];
        y[i] = v[1];
        z[i] = v[2];
    }
    Vector get(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

inline double dot_of_lane(const LaneVectors& a, const LaneVectors& b, std::size_t i) {
    return dot(a.x[i], a.y[i], a.z[i], b.x[i], b.y[i], b.z[i]);
}

}  // namespace clsdf::polyhedra
