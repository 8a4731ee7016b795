#pragma once

#include "targets/result_arrays.hpp"
#include "tree/crossed_faces.hpp"
#include "tree/wide_tree.hpp"

#include <clsdf/segments.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

/// Rays, and segments between pairs of points, by the host.
namespace clsdf::segments {

/// What is searched. extent: are_exact. rule: that decides walls. A part has all faces that rays up to their limit
/// meet, and those on rows towards -x.
struct SearchedFaces {
    engine::CrossedFaces faces;
    const engine::WideTree& tree;
    const engine::CrossedExtent& extent;
    SignRule rule;

    const engine::PointMesh& mesh() const { return faces.mesh; }
};

/// The arrays that are asked for. t and triangles have `most` components.
struct RayArrays {
    std::size_t most = 1;
    targets::ResultArray t, triangles, counts, any;
};

/// Why a ray is not usable, as "its origin is not finite"; nothing if it is.
std::optional<std::string> why_unusable(const engine::PointMesh& mesh, const Vec3& origin, const Vec3& direction);
/// The same of a pair of points.
std::optional<std::string> why_unusable_pair(const engine::PointMesh& mesh, const Vec3& from, const Vec3& to);

/// The hits of rays [begin, end), on all cores. Rays that are not usable have none, and NaN for t.
void find_hits(const SearchedFaces& searched, std::span<const Vec3> origins, std::span<const Vec3> directions,
               const RayOptions& options, const RayArrays& arrays, std::size_t begin, std::size_t end);

/// Whether the segments of pairs [begin, end) meet nothing, as 1 or 0, on all cores. Pairs that are not usable have 0.
void find_visible(const SearchedFaces& searched, std::span<const Vec3> from, std::span<const Vec3> to, Hits hits,
                  const targets::ResultArray& visible, std::size_t begin, std::size_t end);

}  // namespace clsdf::segments
