#include "core/parallel.hpp"
#include "surface/local_frame.hpp"
#include "surface/topology.hpp"

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

bool encloses_negative_volume(const Mesh& mesh, const SignSurface& surface) {
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
    const Volume volume = surface.is_mesh() ? sum_of([&](std::size_t t) -> const Triangle& { return given[t]; })
                                            : sum_of([&](std::size_t t) { return surface.triangle(given[t], t); });
    return is_negative_volume(volume.sum, volume.magnitude, given.size());
}

}  // namespace clsdf
