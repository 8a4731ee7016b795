#include <clsdf/error.hpp>
#include <clsdf/reference.hpp>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace clsdf::reference {

std::vector<TrianglePair> find_self_intersections(const Mesh& mesh) {
    namespace processing = CGAL::Polygon_mesh_processing;
    using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
    using Surface = CGAL::Surface_mesh<Point>;

    const Mesh welded = weld(mesh);
    std::vector<Point> points;
    for (const Vec3& v : welded.vertices()) points.emplace_back(v[0], v[1], v[2]);
    std::vector<std::vector<std::size_t>> polygons;
    std::vector<std::uint32_t> sources;
    for (std::uint32_t i = 0; i < welded.triangles().size(); ++i) {
        const auto& [a, b, c] = welded.triangles()[i];
        if (a == b || b == c || c == a) continue;
        polygons.push_back({a, b, c});
        sources.push_back(i);
    }
    if (!processing::is_polygon_soup_a_polygon_mesh(polygons))
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: self-intersections can be looked for only where the faces are oriented alike and "
                                "no edge has three; repair the mesh first",
                                mesh.name()));
    Surface surface;
    processing::polygon_soup_to_polygon_mesh(points, polygons, surface);

    std::vector<std::pair<Surface::Face_index, Surface::Face_index>> found;
    processing::self_intersections(surface, std::back_inserter(found));
    std::vector<TrianglePair> pairs;
    for (const auto& [one, other] : found) {
        const auto [first, second] = std::minmax(sources[one], sources[other]);
        pairs.emplace_back(first, second);
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

}  // namespace clsdf::reference
