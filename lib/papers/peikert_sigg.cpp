#include "papers/pieces.hpp"

#include "core/parallel.hpp"
#include "frusta/frames.hpp"
#include "frusta/slopes.hpp"
#include "papers/gap_tests.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace clsdf::papers {

namespace {

using namespace engine;

Vector bisector_normal(const MeshSurface& surface, const Corner& edge) {
    const Vector own = surface.frames()[edge.face].inwards[edge.vertex];
    if (!surface.has_pair(edge)) return -own;
    const Corner across = surface.across(edge);
    const Vector other = surface.frames()[across.face].inwards[across.vertex];
    return folded((own - other).squaredNorm()) ? Vector(-own) : Vector((other - own).normalized());
}

BisectorPolyhedron polyhedron_of(const MeshSurface& surface, std::uint32_t face, double half_width) {
    BisectorPolyhedron result;
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
/// its distance along the average normal, the half width, or are twenty times as far away if they are nearly
/// perpendicular to that.
std::optional<Vector> point_in_gap(const MeshSurface& surface, const VertexFans& fans,
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
void shift_planes(const VertexFans& fans, const Vector& point, std::vector<BisectorPolyhedron>& polyhedra) {
    for (const VertexFans::Face& face : fans.faces()) {
        BisectorPolyhedron& polyhedron = polyhedra[face.corner.face];
        for (const std::uint32_t edge : {face.corner.vertex, previous_of_three(face.corner.vertex)})
            polyhedron.shift[edge] = std::max(polyhedron.shift[edge], std::abs(polyhedron.bisector[edge].dot(point)));
    }
}

/// normal . (point - through) <= limit, lengths in units, in samples from a polyhedron's origin.
PiecePlane plane_of(const Vector& normal, const Vector& through, double limit, const LatticeView& lattice) {
    const Vector steps = normal.cwiseProduct(to_vector(lattice.spacing_in_units));
    return {{steps.x(), steps.y(), steps.z()}, limit + normal.dot(through)};
}

}  // namespace

bool BisectorPolyhedron::contains(const Vector& point) const {
    if (!(std::abs(normal.dot(point - corners[0])) <= half_width)) return false;
    for (std::size_t k = 0; k < 3; ++k)
        if (!(bisector[k].dot(point - corners[k]) <= shift[k])) return false;
    return true;
}

BisectorPolyhedra peikert_sigg_polyhedra(const Mesh& mesh, double half_width, bool close_gaps) {
    const MeshSurface surface(mesh);
    BisectorPolyhedra result;
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

PeikertSiggPieces peikert_sigg_pieces(const Mesh& mesh, const LatticeView& lattice, double half_width, bool close_gaps,
                                      const Layout& grid) {
    const BisectorPolyhedra paper = peikert_sigg_polyhedra(mesh, half_width * lattice.unit, close_gaps);
    PeikertSiggPieces result;
    result.closed_gaps = paper.closings.size();
    result.polyhedra.resize(paper.polyhedra.size());
    for_each_index(paper.polyhedra.size(), [&](std::size_t i) {
        const std::uint32_t index = paper.polyhedra[i].triangle;
        const auto& [a, b, c] = mesh.triangles()[index];
        const std::array<Vec3, 3> corners{mesh.vertices()[a], mesh.vertices()[b], mesh.vertices()[c]};
        result.polyhedra[i] = engine::pack(engine::triangle_frame(corners, lattice), engine::FaceSlopes{}, index,
                                           mesh.vertices(), mesh.triangles()[index], lattice);
    });
    result.pieces = collect_pieces(paper.polyhedra.size(), grid, [&](std::size_t i, PieceCollector& collector) {
        const BisectorPolyhedron& polyhedron = paper.polyhedra[i];
        const Polyhedron& record = result.polyhedra[i];
        const std::array<std::int32_t, 3> origin{record.origin_x, record.origin_y, record.origin_z};
        const auto in_units = [&](const Vector& position) {
            return from_sample(lattice, {position.x(), position.y(), position.z()}, origin);
        };
        const Vector corner = in_units(polyhedron.corners[0]);
        std::array<PiecePlane, 5> planes{plane_of(polyhedron.normal, corner, half_width, lattice),
                                         plane_of(-polyhedron.normal, corner, half_width, lattice)};
        for (std::size_t k = 0; k < 3; ++k)
            planes[2 + k] = plane_of(polyhedron.bisector[k], in_units(polyhedron.corners[k]),
                                     polyhedron.shift[k] / lattice.unit, lattice);
        collector.add(origin, static_cast<std::uint32_t>(i), planes);
    });
    return result;
}

}  // namespace clsdf::papers
