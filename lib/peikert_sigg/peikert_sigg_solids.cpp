#include <clsdf/bounding_solids.hpp>

#include "peikert_sigg/peikert_sigg_polyhedra.hpp"
#include "polyhedra/solid_mesh.hpp"

#include <algorithm>

namespace clsdf {

namespace {

using namespace peikert_sigg;
using polyhedra::ConvexPolyhedron;
using polyhedra::HalfSpace;
using polyhedra::Vector;

/// From the triangle's first corner.
ConvexPolyhedron solid_of(const peikert_sigg::Polyhedron& polyhedron) {
    constexpr double reach = 8;
    std::vector<HalfSpace> half_spaces{{polyhedron.normal, polyhedron.half_width},
                                       {-polyhedron.normal, polyhedron.half_width}};
    Box box;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector corner = polyhedron.corners[k] - polyhedron.corners[0];
        half_spaces.push_back({polyhedron.bisector[k], polyhedron.bisector[k].dot(corner) + polyhedron.shift[k]});
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double place = corner[static_cast<Eigen::Index>(axis)];
            box.lower[axis] = std::min(box.lower[axis], place);
            box.upper[axis] = std::max(box.upper[axis], place);
        }
    }
    for (double& lower : box.lower) lower -= reach * polyhedron.half_width;
    for (double& upper : box.upper) upper += reach * polyhedron.half_width;
    return clip(box, half_spaces);
}

}  // namespace

std::vector<BoundingSolid> peikert_sigg_solids(const Mesh& mesh, std::span<const std::uint32_t> selected,
                                               double half_width, bool close_gaps) {
    polyhedra::check_solids_asked_for(mesh, selected, half_width);
    const peikert_sigg::Polyhedra all = peikert_sigg_polyhedra(mesh, half_width, close_gaps);
    std::vector<BoundingSolid> result;
    for (const std::uint32_t triangle : selected) {
        const auto found = std::lower_bound(all.polyhedra.begin(), all.polyhedra.end(), triangle,
                                            [](const peikert_sigg::Polyhedron& polyhedron, std::uint32_t index) {
                                                return polyhedron.triangle < index;
                                            });
        if (found == all.polyhedra.end() || found->triangle != triangle) continue;  // with repeated vertices
        const ConvexPolyhedron solid = solid_of(*found);
        if (!solid.is_empty())
            result.push_back({triangle, SolidPart::both_sides, solid_mesh(solid, found->corners[0])});
    }
    return result;
}

}  // namespace clsdf
