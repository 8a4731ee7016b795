#include "surface/sign_surface.hpp"

#include <clsdf/error.hpp>

#include "mesh/box_index.hpp"

#include <fmt/format.h>

#include <utility>

namespace clsdf {

std::vector<DoubledFace> doubled_faces(std::span<const Triangle> triangles) {
    /// The vertices in ascending order.
    struct Named {
        Triangle vertices;
        std::uint32_t face;
        bool is_forward;  ///< the face runs through them in that order

        bool operator<(const Named& other) const {
            return vertices != other.vertices ? vertices < other.vertices : face < other.face;
        }
    };
    std::vector<Named> named;
    named.reserve(triangles.size());
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        const auto& [a, b, c] = triangles[face];
        if (a == b || b == c || c == a) continue;
        const bool is_forward = (a > b) != ((b > c) != (c > a));
        named.push_back({triangles[face], face, is_forward});
        std::ranges::sort(named.back().vertices);
    }
    std::sort(named.begin(), named.end());
    std::vector<DoubledFace> doubled;
    for (std::size_t first = 0, i = 1; i < named.size(); ++i) {
        if (named[i].vertices != named[first].vertices)
            first = i;
        else
            doubled.push_back({named[i].face, named[first].face, named[i].is_forward != named[first].is_forward});
    }
    return doubled;
}

void check_joined(const engine::Vertices& vertices, const Mesh& mesh, const SignSurface& surface,
                  std::span<const Vec3> moved) {
    if (surface.vertices.empty()) return;
    Box all = empty_box;
    for (const Triangle& triangle : mesh.triangles())
        for (const std::uint32_t index : triangle) add(all, {moved[index], moved[index]});
    double half_side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        half_side = std::max(half_side, 0.5 * all.upper[axis] - 0.5 * all.lower[axis]);
    const double most = 2 * joined_extent * half_side;
    std::vector<Box> boxes(moved.size(), empty_box);  // of clusters, by the vertex that counts
    for (std::uint32_t vertex = 0; vertex < moved.size(); ++vertex) {
        const std::uint32_t least = surface.vertex(vertex);
        if (least == vertex) continue;
        Box& box = boxes[least];
        for (const std::uint32_t one : {least, vertex}) add(box, {moved[one], moved[one]});
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!(box.upper[axis] - box.lower[axis] > most))
                continue;  // also if one is not finite, which is told later
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("vertices {} and {} of {} differed by rounding and are joined for the sign, and "
                            "they move apart, to ({}, {}, {}) and ({}, {}, {}), or others that are joined with "
                            "them do; move them together, to within {} on each axis, use the sign rule none, or "
                            "make a new transform",
                            vertices.callers_number(least), vertices.callers_number(vertex), mesh.name(),
                            moved[least][0], moved[least][1], moved[least][2], moved[vertex][0], moved[vertex][1],
                            moved[vertex][2], most));
        }
    }
}

}  // namespace clsdf
