#include "peikert_sigg/peikert_sigg_polyhedra.hpp"

#include "core/parallel.hpp"
#include "peikert_sigg/gap_test.hpp"
#include "polyhedra/wedge_batch.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace clsdf::peikert_sigg {

namespace {

using namespace polyhedra;

Vector bisector_normal(const Surface& surface, const Corner& edge) {
    const Vector own = surface.frames()[edge.face].inwards[edge.vertex];
    if (!surface.has_pair(edge)) return -own;
    const Corner across = surface.across(edge);
    const Vector other = surface.frames()[across.face].inwards[across.vertex];
    return folded((own - other).squaredNorm()) ? Vector(-own) : Vector((other - own).normalized());
}

Polyhedron polyhedron_of(const Surface& surface, std::uint32_t face, double half_width) {
    Polyhedron result;
    result.triangle = surface.sources()[face];
    result.normal = surface.frames()[face].normal;
    result.half_width = half_width;
    for (std::uint32_t k = 0; k < 3; ++k) {
        result.corners[k] = to_vector(surface.position(surface.triangles()[face][k]));
        result.bisector[k] = bisector_normal(surface, {face, k});
    }
    return result;
}

/// The centroid of the test points that fail. The paper leaves open how far from the vertex they are; here they have
/// its distance along the average normal, the half width, or are twenty times as far away where they are nearly
/// perpendicular to that.
std::optional<Vector> point_in_gap(const Surface& surface, const VertexFans& fans,
                                   const std::vector<FailingLine>& lines, double half_width) {
    const std::span<const VertexFans::Face> faces = fans.faces();
    Vector normal = Vector::Zero();
    for (const VertexFans::Face& face : faces) normal += surface.frames()[face.corner.face].normal;
    normal.normalize();

    Vector sum = Vector::Zero();
    for (const FailingLine& line : lines) {
        const Vector first = bisector_normal(surface, faces[line.i].corner);
        const Vector second = bisector_normal(surface, faces[line.i + 1 < faces.size() ? line.i + 1 : 0].corner);
        sum += line.direction * first.cross(second).normalized();
    }
    if (!(sum.norm() > 0)) return std::nullopt;  // nothing failed
    constexpr double steepest = 0.05;
    const Vector direction = sum.normalized();
    return direction * (half_width / std::max(steepest, std::abs(direction.dot(normal))));
}

/// Both planes at the vertex of every face there.
void shift_planes(const VertexFans& fans, const Vector& point, std::vector<Polyhedron>& polyhedra) {
    for (const VertexFans::Face& face : fans.faces()) {
        Polyhedron& polyhedron = polyhedra[face.corner.face];
        for (const std::uint32_t edge : {face.corner.vertex, previous_of_three(face.corner.vertex)})
            polyhedron.shift[edge] = std::max(polyhedron.shift[edge], std::abs(polyhedron.bisector[edge].dot(point)));
    }
}

}  // namespace

bool Polyhedron::contains(const Vector& point) const {
    if (!(std::abs(normal.dot(point - corners[0])) <= half_width)) return false;
    for (std::size_t k = 0; k < 3; ++k)
        if (!(bisector[k].dot(point - corners[k]) <= shift[k])) return false;
    return true;
}

Polyhedra peikert_sigg_polyhedra(const Mesh& mesh, double half_width, bool close_gaps) {
    const Surface surface(mesh);
    Polyhedra result;
    result.polyhedra.resize(surface.triangles().size());
    for_each_index(result.polyhedra.size(), [&](std::size_t face) {
        result.polyhedra[face] = polyhedron_of(surface, static_cast<std::uint32_t>(face), half_width);
    });
    if (!close_gaps) return result;

    tbb::enumerable_thread_specific<VertexFans> fans_of_thread;
    std::vector<std::optional<Vector>> points(mesh.vertices().size());
    for_each_index(points.size(), [&](std::size_t vertex) {
        VertexFans& fans = fans_of_thread.local();
        if (surface.kind(vertex, fans) != VertexKind::saddle) return;
        const Fan fan = fan_at(surface, vertex, fans);
        FanSigns signs(fan);
        points[vertex] = point_in_gap(surface, fans, failing_lines(signs), half_width);
    });
    VertexFans fans;
    for (std::uint32_t vertex = 0; vertex < points.size(); ++vertex) {
        if (!points[vertex]) continue;
        result.closings.push_back({vertex, *points[vertex]});
        surface.build_fans(vertex, fans);
        shift_planes(fans, *points[vertex], result.polyhedra);
    }
    return result;
}

}  // namespace clsdf::peikert_sigg
