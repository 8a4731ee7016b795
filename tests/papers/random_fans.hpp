#pragma once

#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include "papers/gap_tests.hpp"

#include <cmath>
#include <numbers>

namespace clsdf::test {

/// A closed fan whose faces all look upwards, with small whole coordinates: exact ties occur. `bend` chooses the
/// heights of the ring.
template <typename Height>
Mesh random_fan(Random& random, const Height& height) {
    for (;;) {
        const std::size_t count = 4 + random.index(6);
        std::vector<Vec3> ring(count);
        for (std::size_t i = 0; i < count; ++i) {
            const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
            ring[i] = {std::round(6 * std::cos(angle) + random.uniform(-2, 2)),
                       std::round(6 * std::sin(angle) + random.uniform(-2, 2)), 0};
            ring[i][2] = height(i, ring[i]);
        }
        bool turns = true;
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3& a = ring[i];
            const Vec3& b = ring[(i + 1) % count];
            turns = turns && a[0] * b[1] - a[1] * b[0] > 0;
        }
        if (turns) return closed_fan("fan", ring);
    }
}

inline Mesh random_saddle_fan(Random& random) {
    return random_fan(random, [&](std::size_t, const Vec3&) { return std::round(random.uniform(-4, 4)); });
}

inline papers::Fan fan_of_apex(const Mesh& mesh) {
    const papers::MeshSurface surface(mesh);
    engine::VertexFans fans;
    return papers::fan_at(surface, 0, fans);
}

}  // namespace clsdf::test
