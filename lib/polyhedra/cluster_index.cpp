#include "polyhedra/cluster_index.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::polyhedra {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Box nothing{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

void add(Box& box, const Box& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::min(box.lower[axis], other.lower[axis]);
        box.upper[axis] = std::max(box.upper[axis], other.upper[axis]);
    }
}

bool overlap(const Box& a, const Box& b) {
    bool result = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
        result &= a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis];
    return result;
}

/// Around the foot of the altitude on the longest edge: the ball that the kernels put around a face.
Box box_of(const std::array<Vec3, 3>& corners) {
    std::array<Vector, 3> at{to_vector(corners[0]), to_vector(corners[1]), to_vector(corners[2])};
    std::size_t base = 0;
    double squared = -1;
    for (std::size_t k = 0; k < 3; ++k) {
        const double length = (at[(k + 1) % 3] - at[k]).squaredNorm();
        if (length > squared) {
            squared = length;
            base = k;
        }
    }
    const Vector edge = at[(base + 1) % 3] - at[base];
    const double length = edge.cwiseAbs().sum();
    // Squares of very long and very short edges leave a double's range.
    const bool has_square = squared > 1e-280 && squared < 1e280;
    const double along = has_square ? std::clamp((at[(base + 2) % 3] - at[base]).dot(edge) / squared, 0.0, 1.0) : 0;
    // An altitude on the longest edge is at most sqrt(3) / 2 of it.
    const double extent =
        has_square ? std::sqrt(squared) * std::max({along, 1 - along, 0.8661}) * (1 + 1e-6) : 2 * length;
    const Vector foot = at[base] + along * edge;
    Box box = nothing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = foot[static_cast<int>(axis)];
        const double rounding = 1e-15 * std::abs(x);
        box.lower[axis] = x - extent - rounding;
        box.upper[axis] = x + extent + rounding;
        for (const Vec3& corner : corners) {
            box.lower[axis] = std::min(box.lower[axis], corner[axis]);
            box.upper[axis] = std::max(box.upper[axis], corner[axis]);
        }
    }
    return box;
}

/// The kernels' boxes are of floats from a cluster's first face.
void widen(Box& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double rounding = 4e-5 * (box.upper[axis] - box.lower[axis]);
        box.lower[axis] -= rounding;
        box.upper[axis] += rounding;
    }
}

/// Ranges of neighbours that are wanted, made one if they touch.
void append(std::vector<RecordRange>& ranges, std::size_t begin, std::size_t end) {
    if (!ranges.empty() && ranges.back().end == begin)
        ranges.back().end = end;
    else
        ranges.push_back({begin, end});
}

}  // namespace

ClusterIndex::ClusterIndex(const MeshTopology& topology, const Frusta& frusta)
    : face_count_(topology.order.size()),
      site_count_(frusta.sites.size()),
      clusters_(chunk_count(face_count_, cluster), nothing),
      blocks_(chunk_count(clusters_.size(), block), nothing),
      sites_(chunk_count(site_count_, record_group), nothing) {
    const auto position = [&](std::uint32_t vertex) { return frusta.positions[vertex]; };
    for_each_chunk(face_count_, cluster, [&](std::size_t number, std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face < end; ++face) {
            const auto& [a, b, c] = topology.faces.triangles[face];
            add(clusters_[number], box_of({position(a), position(b), position(c)}));
        }
        widen(clusters_[number]);
    });
    for (std::size_t number = 0; number < clusters_.size(); ++number) add(blocks_[number / block], clusters_[number]);
    for (std::size_t site = 0; site < site_count_; ++site) {
        const Vec3 at = position(frusta.sites[site].vertex);
        add(sites_[site / record_group], box_of({at, at, at}));
    }
    for (Box& box : sites_) widen(box);
}

NearRecords ClusterIndex::near(const Box& box) const {
    NearRecords found;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        if (!overlap(blocks_[b], box)) continue;
        for (std::size_t c = b * block; c < std::min((b + 1) * block, clusters_.size()); ++c)
            if (overlap(clusters_[c], box)) append(found.faces, c * cluster, std::min((c + 1) * cluster, face_count_));
    }
    for (std::size_t s = 0; s < sites_.size(); ++s)
        if (overlap(sites_[s], box))
            append(found.sites, s * record_group, std::min((s + 1) * record_group, site_count_));
    for (const RecordRange& range : found.faces) found.face_count += range.end - range.begin;
    for (const RecordRange& range : found.sites) found.site_count += range.end - range.begin;
    return found;
}

}  // namespace clsdf::polyhedra
