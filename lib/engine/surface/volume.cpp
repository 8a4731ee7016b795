#include "core/parallel.hpp"
#include "surface/local_frame.hpp"
#include "surface/topology.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <limits>

namespace clsdf {

namespace {

/// Six times a volume, and the sum of the magnitudes of its terms.
struct Volume {
    double sum = 0;
    double magnitude = 0;

    friend Volume operator+(const Volume& a, const Volume& b) { return {a.sum + b.sum, a.magnitude + b.magnitude}; }
};

/// Sums faces [begin, end), divided by halves down to leaves of 64: an order that GPUs sum in, too
/// (kernels/topology/mesh_volume.h).
template <class TriangleOf>
Volume volume_of(const LocalFrame& frame, const TriangleOf& triangle_of, std::size_t begin, std::size_t end) {
    if (end - begin > volume_leaf) {
        const std::size_t middle = begin + (end - begin) / 2;
        return volume_of(frame, triangle_of, begin, middle) + volume_of(frame, triangle_of, middle, end);
    }
    Volume volume;
    for (std::size_t t = begin; t != end; ++t) frame.add_volume(triangle_of(t), volume.sum, volume.magnitude);
    return volume;
}

}  // namespace

bool is_negative_volume(double sum, double magnitude, std::size_t faces) {
    const double rounding = static_cast<double>(faces + 16) * std::numeric_limits<double>::epsilon();
    return sum < -rounding * magnitude;
}

namespace {

Volume volume_of(const Mesh& mesh, const SignSurface& surface) {
    const LocalFrame frame(mesh);
    constexpr std::size_t grain = 4096;  // ranges are divided by halves, too
    const auto sum_of = [&](const auto& triangle_of) {
        return reduce_ranges(
            mesh.triangles().size(), grain, Volume{},
            [&](std::size_t begin, std::size_t end, const Volume& before) {
                return before + volume_of(frame, triangle_of, begin, end);
            },
            std::plus<>());
    };
    const std::vector<Triangle>& given = mesh.triangles();
    return surface.is_mesh() ? sum_of([&](std::size_t t) -> const Triangle& { return given[t]; })
                             : sum_of([&](std::size_t t) { return surface.triangle(given[t], t); });
}

}  // namespace

bool encloses_negative_volume(const Mesh& mesh, const SignSurface& surface) {
    const Volume volume = volume_of(mesh, surface);
    return is_negative_volume(volume.sum, volume.magnitude, mesh.triangles().size());
}

std::optional<bool> encloses_negative_volume(const Mesh& mesh, const SignSurface& surface, double margin) {
    const LocalFrame frame(mesh);
    const double most = margin * frame.scale();
    // A closed surface sweeps at most its area, at any time of a straight motion, times the way. A moved edge is at
    // most two ways longer.
    double area = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        const std::array<Vec3, 3> at{frame.local(triangle[0]), frame.local(triangle[1]), frame.local(triangle[2])};
        const auto side = [&](std::size_t k) {
            return std::hypot(at[k][0] - at[0][0], at[k][1] - at[0][1], at[k][2] - at[0][2]);
        };
        area += length_of(frame.normal(triangle)) / 2 + most * (side(1) + side(2)) + 2 * most * most;
    }
    const Volume volume = volume_of(mesh, surface);
    const double change = 6 * most * area + 1e-6 * volume.magnitude;  // and rounding
    if (std::abs(volume.sum) > change) return volume.sum < 0;
    return std::nullopt;
}

}  // namespace clsdf
