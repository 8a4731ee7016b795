#pragma once

#include "frusta/frames.hpp"
#include "topology/topology.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// Slopes of the lateral planes of a face's edges, above the face and below it (docs/method.md, 'Leaned frusta'): one
/// face at a time, with exact predicates. Kernels measure most faces (kernels/frusta/face_frames.h).
namespace clsdf::engine {

/// The slopes of one edge's planes, above the face and below it.
struct EdgeSlope {
    float above;
    float below;
};

/// By edge of a face.
struct FaceSlopes {
    std::array<float, 3> above;
    std::array<float, 3> below;
};

/// `x` >= 0 as a float that is not below it, also after the roundings that led to it.
inline float widened(double x) {
    return static_cast<float>(x * (1 + 1e-6));
}

/// Two faces whose inward directions differ by less than this angle are folded onto each other.
inline constexpr double fold_angle = CLSDF_FOLD_ANGLE;

/// `squared_apart`: the square of the distance of their unit inward directions at the edge.
inline bool folded(double squared_apart) {
    return squared_apart < fold_angle * fold_angle;
}

/// Leans two planes outward if the corner opposite the base is obtuse: lean() of kernels/frusta/face_frames.h.
void lean(const TriangleFrame& frame, FaceSlopes& slopes);

/// On which side of a face's plane another face's vertex lies that is opposite to the edge `second` of that face: 1
/// above (the edge is concave seen from above), -1 below, 0 in it. Exact for the coordinates as given.
int side_of_plane(const MeshFaces& faces, std::uint32_t first, const Corner& second);

/// A face, and the data of its edges that follow from positions.
// NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): arrays are left unset until all cores fill them
struct MeasuredFace {
    TriangleFrame frame;
    FaceSlopes slopes;
    std::array<std::uint8_t, 3> marks;  ///< EdgeMark, also those that follow from the vertices' indices
};

/// Measures faces one by one. Each face at an edge takes the angle up to the bisector with the next face on that side,
/// or the whole wedge if there is none. The views must outlive it.
class FaceMeasures {
public:
    FaceMeasures(const MeshFaces& faces, const OneRings& rings, const PairedEdges& edges);

    /// The slopes are not leaned. The face is one of the one-rings.
    MeasuredFace measure(std::uint32_t face) const;

private:
    /// The slopes at an edge where three faces or more meet; none if one of them is a box.
    struct NonManifoldEdge {
        std::uint32_t edge;  ///< packed
        std::optional<EdgeSlope> slope;
    };

    void measure_non_manifold(const OneRings& rings, std::span<const std::uint32_t> ends);
    /// At an edge of three faces or more; the whole wedge at one that the one-rings do not have.
    std::optional<EdgeSlope> non_manifold_slope(const Corner& edge) const;
    void set_unpaired(const Corner& edge, MeasuredFace& measured) const;
    void set_pair(const Corner& edge, MeasuredFace& measured) const;

    MeshFaces faces_;
    std::span<const FaceEdges> edges_;
    std::vector<NonManifoldEdge> non_manifold_;  // ascending
};

/// Faces that were measured.
class MeasuredFaces {
public:
    /// `numbers`: of the faces, ascending; empty if they are all faces of the mesh.
    MeasuredFaces(std::span<const MeasuredFace> faces, std::span<const std::uint32_t> numbers = {})
        : faces_(faces), numbers_(numbers) {}

    const MeasuredFace& operator[](std::uint32_t face) const {
        if (numbers_.empty()) return faces_[face];
        return faces_[static_cast<std::size_t>(std::lower_bound(numbers_.begin(), numbers_.end(), face) -
                                               numbers_.begin())];
    }

private:
    std::span<const MeasuredFace> faces_;
    std::span<const std::uint32_t> numbers_;
};

}  // namespace clsdf::engine
