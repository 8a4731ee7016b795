#include "mesh/face_distances.hpp"

#include "core/vectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace clsdf {

namespace {

/// Of the origin and a segment.
double squared_distance(const Vec3& a, const Vec3& b) {
    const Vec3 along = difference(b, a);
    const double squared = dot(along, along);
    const double share = squared > 0 ? std::clamp(-dot(a, along) / squared, 0.0, 1.0) : 0;
    const Vec3 nearest{a[0] + share * along[0], a[1] + share * along[1], a[2] + share * along[2]};
    return dot(nearest, nearest);
}

/// Of the origin and a triangle.
double squared_distance(const std::array<Vec3, 3>& corners) {
    const auto& [a, b, c] = corners;
    const Vec3 normal = cross(difference(b, a), difference(c, a));
    const bool is_above =
        dot(cross(a, b), normal) >= 0 && dot(cross(b, c), normal) >= 0 && dot(cross(c, a), normal) >= 0;
    if (const double squared = dot(normal, normal); is_above && squared > 0) {
        const double height = dot(a, normal);
        return height * height / squared;
    }
    return std::min({squared_distance(a, b), squared_distance(b, c), squared_distance(c, a)});
}

std::vector<Box> boxes_of(const Mesh& mesh, std::span<const Triangle> faces) {
    std::vector<Box> boxes(faces.size(), empty_box);
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (const std::uint32_t vertex : faces[i]) add(boxes[i], {mesh.vertices()[vertex], mesh.vertices()[vertex]});
    return boxes;
}

}  // namespace

FaceDistances::FaceDistances(const Mesh& mesh, std::span<const Triangle> faces)
    : mesh_(mesh), faces_(faces.begin(), faces.end()), boxes_(boxes_of(mesh, faces)) {}

double FaceDistances::at(const Vec3& point, double most) const {
    double squared = 1;
    boxes_.any(widened({point, point}, most), [&](std::size_t i) {
        std::array<Vec3, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis)
                corners[k][axis] = (mesh_.vertices()[faces_[i][k]][axis] - point[axis]) / most;
        squared = std::min(squared, squared_distance(corners));
        return false;
    });
    return std::sqrt(squared);
}

}  // namespace clsdf
