#include "surface/ray_crossings.hpp"

#include "core/parallel.hpp"
#include "surface/parts.hpp"
#include "surface/ray_side.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

namespace clsdf {

RayCrossings::RayCrossings(std::span<const Vec3> points) : points_(points), counts_(points.size()) {
    side_ = std::clamp<std::size_t>(static_cast<std::size_t>(std::sqrt(static_cast<double>(points.size()))), 1, 128);
    for (std::size_t k = 0; k < 2; ++k) {
        double lower = std::numeric_limits<double>::infinity(), upper = -lower;
        for (const Vec3& point : points) {
            lower = std::min(lower, point[k + 1] / 2);
            upper = std::max(upper, point[k + 1] / 2);
        }
        lower_[k] = lower;
        const double per_length = upper > lower ? static_cast<double>(side_) / (upper - lower) : 0;
        per_length_[k] = std::isfinite(per_length) ? per_length : 0;
    }
    first_.assign(side_ * side_ + 1, 0);
    for (const Vec3& point : points) ++first_[cell_of(point) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    order_.resize(points.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < points.size(); ++i) order_[next[cell_of(points[i])]++] = i;
}

void RayCrossings::add(const Mesh& mesh, std::span<const Triangle> triangles) {
    for_each_range(
        triangles.size(),
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t t = begin; t != end; ++t) add(mesh, triangles[t]);
        },
        4096);
}

std::size_t RayCrossings::bin_of(double x, std::size_t k) const {
    const double bin = (x / 2 - lower_[k]) * per_length_[k];
    return bin > 0 ? std::min(static_cast<std::size_t>(std::min(bin, 1e9)), side_ - 1) : 0;
}

void RayCrossings::add(const Mesh& mesh, const Triangle& triangle) {
    if (has_repeated_vertex(triangle)) return;
    const Vec3 &a = mesh.vertices()[triangle[0]], &b = mesh.vertices()[triangle[1]], &c = mesh.vertices()[triangle[2]];
    const double low_x = std::min({a[0], b[0], c[0]}), low_y = std::min({a[1], b[1], c[1]}),
                 high_y = std::max({a[1], b[1], c[1]}), low_z = std::min({a[2], b[2], c[2]}),
                 high_z = std::max({a[2], b[2], c[2]});
    const std::size_t last_y = bin_of(high_y, 0), first_z = bin_of(low_z, 1), last_z = bin_of(high_z, 1);
    for (std::size_t y = bin_of(low_y, 0); y <= last_y; ++y)
        for (std::size_t n = first_[y * side_ + first_z]; n < first_[y * side_ + last_z + 1]; ++n) {
            const std::uint32_t i = order_[n];
            const Vec3& p = points_[i];
            if (p[1] < low_y || p[1] > high_y || p[2] < low_z || p[2] > high_z || p[0] < low_x) continue;
            const int side = side_of_edges(a, b, c, p);
            if (side == 0 || orientation(a, b, c, p) != side) continue;  // the crossing has a greater x
            std::atomic_ref(counts_[i]).fetch_sub(side, std::memory_order_relaxed);
        }
}

}  // namespace clsdf
