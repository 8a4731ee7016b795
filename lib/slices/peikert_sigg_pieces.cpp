#include "slices/peikert_sigg_pieces.hpp"

#include "core/parallel.hpp"
#include "peikert_sigg/peikert_sigg_polyhedra.hpp"
#include "polyhedra/records.hpp"
#include "polyhedra/triangle_frame.hpp"

namespace clsdf::slices {

namespace {

using polyhedra::LatticeView;
using polyhedra::to_vector;
using polyhedra::Vector;

/// normal . (point - through) <= limit, lengths in units, in samples from a polyhedron's origin.
PiecePlane plane_of(const Vector& normal, const Vector& through, double limit, const LatticeView& lattice) {
    const Vector steps = normal.cwiseProduct(to_vector(lattice.spacing_in_units));
    return {{steps.x(), steps.y(), steps.z()}, limit + normal.dot(through)};
}

}  // namespace

PeikertSiggPieces peikert_sigg_pieces(const Mesh& mesh, const LatticeView& lattice, double half_width, bool close_gaps,
                                      const Layout& grid) {
    const peikert_sigg::Polyhedra paper =
        peikert_sigg::peikert_sigg_polyhedra(mesh, half_width * lattice.unit, close_gaps);
    PeikertSiggPieces result;
    result.closed_gaps = paper.closings.size();
    result.polyhedra.resize(paper.polyhedra.size());
    for_each_index(paper.polyhedra.size(), [&](std::size_t i) {
        const std::uint32_t index = paper.polyhedra[i].triangle;
        const auto& [a, b, c] = mesh.triangles()[index];
        const std::array<Vec3, 3> corners{mesh.vertices()[a], mesh.vertices()[b], mesh.vertices()[c]};
        result.polyhedra[i] = polyhedra::pack(polyhedra::triangle_frame(corners, lattice), polyhedra::FaceSlopes{},
                                              index, mesh.vertices(), mesh.triangles()[index], lattice);
    });
    result.pieces = collect_pieces(paper.polyhedra.size(), grid, [&](std::size_t i, PieceCollector& collector) {
        const peikert_sigg::Polyhedron& polyhedron = paper.polyhedra[i];
        const Polyhedron& record = result.polyhedra[i];
        const std::array<std::int32_t, 3> origin{record.origin_x, record.origin_y, record.origin_z};
        const auto in_units = [&](const Vector& position) {
            return to_vector(lattice.from_sample({position.x(), position.y(), position.z()}, origin));
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

}  // namespace clsdf::slices
