#pragma once

#include "mesh/segment_crossings.hpp"

#include <array>
#include <cstddef>

namespace clsdf::segments {

/// Segments and the faces that they cross, as many as are computed together.
struct LinkPlaces {
    static constexpr std::size_t most = 8;
    struct Numbers {
        alignas(64) std::array<double, most> of{};
    };

    /// Of number n.
    void set(std::size_t n, const crossing::Corners& face, const Vec3& from, const Vec3& to) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t i = 0; i < 3; ++i) corners[i][axis].of[n] = face[i][axis];
            ends[0][axis].of[n] = from[axis];
            ends[1][axis].of[n] = to[axis];
        }
    }
    /// Sets crossing::place_of() of each of them, by vectors.
    void compute();

    std::array<std::array<Numbers, 3>, 3> corners{};
    std::array<std::array<Numbers, 3>, 2> ends{};
    Numbers places{};
};

}  // namespace clsdf::segments
