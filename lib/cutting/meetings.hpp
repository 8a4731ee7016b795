#pragma once

#include <clsdf/mesh.hpp>

#include "cutting/cancellation.hpp"
#include "cutting/cut_points.hpp"

#include <cstddef>
#include <cstdint>
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

/// A straight line in a face along which it is cut, or a point (both ends are the same).
struct FaceSegment {
    std::uint32_t from, to;  ///< points
    Cutter cutter;
};

/// The faces that meet others elsewhere than at edges and vertices that they share, and where.
class Meetings {
public:
    /// Numbers the points.
    Meetings(CutPoints& points, std::span<const View> views, const Cancellation& cancellation);

    /// Of a face; none if it meets no other.
    std::span<const FaceSegment> of(std::uint32_t face) const {
        return std::span(segments_).subspan(begins_[face], begins_[face + 1] - begins_[face]);
    }
    std::size_t pairs() const { return pairs_; }

private:
    std::vector<FaceSegment> segments_;  // face after face
    std::vector<std::size_t> begins_;
    std::size_t pairs_ = 0;
};

}  // namespace clsdf::cutting
