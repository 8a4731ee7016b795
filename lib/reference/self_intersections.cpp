#include <clsdf/reference.hpp>

#include <CGAL/Bbox_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <array>

namespace clsdf::reference {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using FaceBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;

/// The triangles of a mesh without equal vertices.
class Faces {
public:
    explicit Faces(const Mesh& mesh) : triangles_(mesh.triangles()) {
        points_.reserve(mesh.vertices().size());
        for (const Vec3& v : mesh.vertices()) points_.emplace_back(v[0], v[1], v[2]);
    }

    bool has_area(std::uint32_t face) const {
        const auto& [a, b, c] = triangles_[face];
        return !CGAL::collinear(points_[a], points_[b], points_[c]);
    }

    CGAL::Bbox_3 box(std::uint32_t face) const { return triangle(face).bbox(); }

    /// Whether two triangles with area meet in more than the vertices they share and the edges between these.
    bool intersect(std::uint32_t one, std::uint32_t other) const {
        Triangle first = triangles_[one];
        Triangle second = triangles_[other];
        // The vertices they share first.
        std::size_t shared = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto found = std::find(second.begin() + shared, second.end(), first[i]);
            if (found == second.end()) continue;
            std::swap(second[shared], *found);
            std::swap(first[shared], first[i]);
            ++shared;
        }
        switch (shared) {
            case 0:
                return CGAL::do_intersect(triangle(one), triangle(other));
            case 1:
                // The intersection begins at the shared vertex and ends at the edge opposite to it.
                return CGAL::do_intersect(opposite(first), triangle(other)) ||
                       CGAL::do_intersect(opposite(second), triangle(one));
            case 2: {
                const Point& a = points_[first[0]];
                const Point& b = points_[first[1]];
                const Point& c = points_[first[2]];
                const Point& d = points_[second[2]];
                return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
            }
            default:
                return true;
        }
    }

private:
    Kernel::Triangle_3 triangle(std::uint32_t face) const {
        const auto& [a, b, c] = triangles_[face];
        return {points_[a], points_[b], points_[c]};
    }
    Kernel::Segment_3 opposite(const Triangle& triangle) const { return {points_[triangle[1]], points_[triangle[2]]}; }

    const std::vector<Triangle>& triangles_;
    std::vector<Point> points_;
};

}  // namespace

std::vector<TrianglePair> find_self_intersections(const Mesh& mesh) {
    const Mesh welded = weld(mesh);
    const Faces faces(welded);
    std::vector<TrianglePair> pairs;
    std::vector<FaceBox> boxes;
    for (std::uint32_t i = 0; i < welded.triangles().size(); ++i) {
        const auto& [a, b, c] = welded.triangles()[i];
        if (a == b || b == c || c == a) continue;
        if (faces.has_area(i))
            boxes.emplace_back(faces.box(i), i);
        else
            pairs.emplace_back(i, i);
    }
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const FaceBox& one, const FaceBox& other) {
        if (faces.intersect(one.info(), other.info())) pairs.emplace_back(std::minmax({one.info(), other.info()}));
    });
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

}  // namespace clsdf::reference
