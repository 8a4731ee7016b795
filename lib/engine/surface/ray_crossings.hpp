#pragma once

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// The crossings of the points' rays towards -x with triangles. Cells across (y, z) hold the points.
class RayCrossings {
public:
    /// Keeps the points.
    explicit RayCrossings(std::span<const Vec3> points);

    void add(const Mesh& mesh, std::span<const Triangle> triangles);

    /// By point: those that leave the surface towards -x count -1, those that enter it 1.
    std::span<const int> counts() const { return counts_; }

private:
    /// Ascends with the coordinate.
    std::size_t bin_of(double x, std::size_t k) const;
    std::size_t cell_of(const Vec3& point) const { return bin_of(point[1], 0) * side_ + bin_of(point[2], 1); }
    void add(const Mesh& mesh, const Triangle& triangle);

    std::span<const Vec3> points_;
    std::vector<int> counts_;
    std::size_t side_;
    std::array<double, 2> lower_{}, per_length_{};
    std::vector<std::uint32_t> first_;  // the place in order_ where each cell begins
    std::vector<std::uint32_t> order_;  // points, cell after cell
};

}  // namespace clsdf
