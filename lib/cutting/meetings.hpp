#pragma once

#include <clsdf/mesh.hpp>

#include "cutting/cancellation.hpp"
#include "cutting/cut_points.hpp"
#include "cutting/plane_patches.hpp"
#include "mesh/box_index.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::cutting {

/// The axis along which a face is seen, and whether its normal points along it (1) or against it (-1).
struct View {
    std::uint8_t axis = 0;
    std::int8_t direction = 0;  ///< 0: the face has no area
};

/// That of the largest component of each face's normal.
std::vector<View> views_of(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

/// The boxes of the faces that have an area.
class FaceBoxes {
public:
    /// margin: by which the boxes are widened.
    FaceBoxes(std::span<const Vec3> vertices, std::span<const Triangle> triangles, std::span<const View> views,
              double margin = 0);

    /// Calls f(face) for the faces whose boxes overlap the given one, in no particular order, until it returns true.
    /// Returns whether it did.
    template <typename Function>
    bool any(const Box& box, const Function& f) const {
        return index_->any(box, [&](std::size_t i) { return f(faces_[i]); });
    }
    /// Groups of pairs of faces whose boxes overlap.
    std::size_t pair_groups() const { return index_->leaf_count(); }
    /// Calls f(a, b) for the pairs of a group, a < b, in no particular order.
    template <typename Function>
    void for_each_pair(std::size_t group, const Function& f) const {
        index_->for_each_pair(group, [&](std::size_t a, std::size_t b) { f(faces_[a], faces_[b]); });
    }

private:
    std::vector<std::uint32_t> faces_;  // ascending
    std::optional<BoxIndex> index_;
};

/// A straight line in a face along which it is cut, or a point (both ends are the same).
struct FaceSegment {
    std::uint32_t from, to;  ///< points
    Cutter cutter;
};

/// The faces that meet others elsewhere than at edges and vertices that they share, and where.
class Meetings {
public:
    /// Numbers the points. Of faces in one plane the outlines of patches cut each other.
    Meetings(CutPoints& points, std::span<const View> views, const FaceBoxes& boxes, const PlanePatches& patches,
             const Cancellation& cancellation);
    /// The same of these pairs of faces alone, the lower one first, which have an area.
    Meetings(CutPoints& points, std::span<const View> views, std::span<const std::array<std::uint32_t, 2>> pairs,
             const Cancellation& cancellation);

    /// Of a face; none if it meets no other.
    std::span<const FaceSegment> of(std::uint32_t face) const {
        return std::span(segments_).subspan(begins_[face], begins_[face + 1] - begins_[face]);
    }

private:
    /// for_each_pair(group, f) calls f(first, second).
    template <typename ForEachPair>
    void find(CutPoints& points, std::span<const View> views, const PlanePatches* patches, std::size_t groups,
              std::size_t grain, const ForEachPair& for_each_pair, const Cancellation& cancellation);

    std::vector<FaceSegment> segments_;  // face after face
    std::vector<std::size_t> begins_;
};

}  // namespace clsdf::cutting
