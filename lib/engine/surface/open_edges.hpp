#pragma once

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace clsdf {

struct EdgeCounts;

/// An edge that the faces of a surface do not use equally often in both directions, in the direction that has more of
/// them.
struct OpenEdge {
    std::uint32_t from;
    std::uint32_t to;
    std::uint32_t count;  ///< faces in that direction minus those in the other one; above 0
};

/// The open edges of a surface as closed loops, each edge as often as it counts. They follow from the triangles alone,
/// and their order is part of the result: sums over them are rounded. No loop meets a vertex twice.
struct OpenLoops {
    std::vector<std::uint32_t> vertices;  ///< the mesh's vertices, loop after loop
    std::vector<std::size_t> begins{0};   ///< where each loop begins in `vertices`, and the end of the last
    std::optional<double> floor{};        ///< z to which walls go down from the loops, for the rule `below`

    bool empty() const { return vertices.empty(); }
    std::size_t host_bytes() const { return vertices.size() * sizeof(vertices[0]) + begins.size() * sizeof(begins[0]); }
};

/// The edges: of a surface, all different. At every vertex as many of them end as begin.
OpenLoops loops_of(std::vector<OpenEdge> edges);
OpenLoops loops_of(const EdgeCounts& edges);

/// The loops at positions of the mesh.
struct OpenBoundary {
    std::vector<Vec3> corners;  ///< the vertices of the loops, loop after loop
    std::vector<std::size_t> begins{0};
    std::optional<double> floor{};  ///< as of OpenLoops: no film closes them, but walls and a floor

    OpenBoundary() = default;
    OpenBoundary(const OpenLoops& loops, std::span<const Vec3> positions);

    bool empty() const { return corners.empty(); }
    std::size_t host_bytes() const { return corners.size() * sizeof(corners[0]) + begins.size() * sizeof(begins[0]); }
};

/// The part of the open edges in the generalised winding number at a point (kernels/common/solid_angle.h). The rest are
/// the crossings of the point's ray towards -x.
struct SolidAngle {
    int rounded;   ///< added to the crossings: the winding number rounded to an integer, a half up
    double turns;  ///< added to the crossings: the winding number
};

/// For a point as given, with exact sides of edges. unit: a power of two; positions divided by it are of moderate size.
SolidAngle angle_of(const OpenBoundary& boundary, const Vec3& point, double unit);

}  // namespace clsdf
