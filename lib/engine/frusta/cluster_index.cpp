#include "frusta/cluster_index.hpp"

#include "core/parallel.hpp"
#include "mesh/box_index.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clsdf::engine {

namespace {

/// Around the foot of the altitude on the longest edge: the ball that the kernels put around a face. The kernel
/// cluster_boxes has the same.
Box box_of(const std::array<Vec3, 3>& corners) {
    std::array<Vector, 3> at{to_vector(corners[0]), to_vector(corners[1]), to_vector(corners[2])};
    std::size_t base = 0;
    double squared = -1;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector side = at[(k + 1) % 3] - at[k];
        const double length = dot(side, side);
        if (length > squared) {
            squared = length;
            base = k;
        }
    }
    const Vector edge = at[(base + 1) % 3] - at[base];
    const double length = std::abs(edge.x()) + std::abs(edge.y()) + std::abs(edge.z());
    // Squares of very long and very short edges leave a double's range.
    const bool has_square = squared > 1e-280 && squared < 1e280;
    const double along = has_square ? std::clamp(dot(at[(base + 2) % 3] - at[base], edge) / squared, 0.0, 1.0) : 0;
    // An altitude on the longest edge is at most sqrt(3) / 2 of it.
    const double extent =
        has_square ? std::sqrt(squared) * std::max({along, 1 - along, 0.8661}) * (1 + 1e-6) : 2 * length;
    const Vector foot = at[base] + along * edge;
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = foot[static_cast<int>(axis)];
        const double rounding = 1e-15 * std::abs(x);
        box.lower[axis] = x - extent - rounding;
        box.upper[axis] = x + extent + rounding;
    }
    for (const Vec3& corner : corners) add(box, {corner, corner});
    return box;
}

/// Kernels compute the box in float, relative to the cluster's first face. This covers their rounding.
void widen(Box& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double rounding = 4e-5 * (box.upper[axis] - box.lower[axis]);
        box.lower[axis] -= rounding;
        box.upper[axis] += rounding;
    }
}

/// Appends a range, or extends the last one if that ends at `begin`.
void append(std::vector<RecordRange>& ranges, std::size_t begin, std::size_t end) {
    if (!ranges.empty() && ranges.back().end == begin)
        ranges.back().end = end;
    else
        ranges.push_back({begin, end});
}

}  // namespace

std::vector<Box> cluster_boxes(std::span<const Triangle> triangles, std::span<const Vec3> positions) {
    std::vector<Box> boxes(chunk_count(triangles.size(), ClusterIndex::cluster), empty_box);
    for_each_chunk(triangles.size(), ClusterIndex::cluster,
                   [&](std::size_t number, std::size_t begin, std::size_t end) {
                       for (const auto& [a, b, c] : triangles.subspan(begin, end - begin))
                           add(boxes[number], box_of({positions[a], positions[b], positions[c]}));
                   });
    return boxes;
}

ClusterIndex::ClusterIndex(std::size_t face_count, std::vector<Box> clusters, const Frusta& of_sites)
    : face_count_(face_count),
      site_count_(of_sites.sites.size()),
      clusters_(std::move(clusters)),
      superclusters_(chunk_count(clusters_.size(), supercluster), empty_box),
      sites_(chunk_count(site_count_, record_group), empty_box) {
    for (std::size_t number = 0; number < clusters_.size(); ++number) {
        widen(clusters_[number]);
        add(superclusters_[number / supercluster], clusters_[number]);
    }
    for (std::size_t site = 0; site < site_count_; ++site) {
        const Vec3 at = of_sites.positions[of_sites.sites[site].vertex];
        add(sites_[site / record_group], box_of({at, at, at}));
    }
    for (Box& box : sites_) widen(box);
}

NearRecords ClusterIndex::near(std::span<const Box> boxes) const {
    const BoxIndex given(boxes);
    const auto is_near = [&](const Box& box) { return given.any(box); };
    NearRecords found;
    for (std::size_t b = 0; b < superclusters_.size(); ++b) {
        if (!is_near(superclusters_[b])) continue;
        for (std::size_t c = b * supercluster; c < std::min((b + 1) * supercluster, clusters_.size()); ++c)
            if (is_near(clusters_[c])) append(found.faces, c * cluster, std::min((c + 1) * cluster, face_count_));
    }
    for (std::size_t s = 0; s < sites_.size(); ++s)
        if (is_near(sites_[s])) append(found.sites, s * record_group, std::min((s + 1) * record_group, site_count_));
    for (const RecordRange& range : found.faces) found.face_count += range.end - range.begin;
    for (const RecordRange& range : found.sites) found.site_count += range.end - range.begin;
    return found;
}

}  // namespace clsdf::engine
