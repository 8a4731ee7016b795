#include "scenes/union_search.hpp"

#include "core/outputs.hpp"
#include "points/faces_by_distance.hpp"
#include "targets/host_arrays.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace clsdf::scenes {

namespace {

/// The closest point of a face, in the body's coordinates.
Vec3 closest_on(const SearchedBody& body, const Vec3& in_units, std::uint32_t face) {
    double distance = 0;
    Vec3 closest{};
    targets::HostArrays arrays;
    arrays[Output::distance] = {true, true, reinterpret_cast<std::byte*>(&distance), false};
    arrays[Output::closest] = {true, true, reinterpret_cast<std::byte*>(closest.data()), false};
    points::finish_on_host(*body.shape->finishing, in_units, face, CLSDF_POINT_INSIDE,
                           std::numeric_limits<double>::infinity(), arrays);
    return closest;
}

}  // namespace

UnionSearch::Nearest UnionSearch::nearest(const Vec3& p, double least, double most) const {
    Nearest found;
    found.distance = most;
    if (const MeetingLines::Nearest line = lines_.nearest(p, most); line.line != nullptr)
        found = {line.line->body, line.line->face, true, line.closest, line.distance};
    const SearchedScene& scene = test_.scene();
    // A face counts before a line at the same distance, whatever was rounded.
    const auto bound = [&] { return found.is_cut ? found.distance * (1 + 1e-15) : found.distance; };
    scene.tree.visit_near(p, bound(), [&](std::uint32_t body) {
        search_body(body, p, least, bound(), found);
        return bound();
    });
    return found;
}

void UnionSearch::search_body(std::uint32_t number, const Vec3& p, double least, double most, Nearest& found) const {
    const SearchedBody& body = test_.scene().bodies[number];
    const Vec3 in_body = body.frame->to_body(p);
    if (!is_usable(body, in_body)) return;
    const engine::PointMesh& mesh = mesh_of(body);
    const Vec3 in_units = mesh.in_units(in_body);
    const double unit = mesh.lattice.unit, limit = most / unit;
    points::FacesByDistance faces(body.shape->inputs, in_units, limit * limit * (1 + 1e-15),
                                  2 * rounding_of(body, p) / unit);
    for (points::FacesByDistance::Face face = faces.next(); face.face != CLSDF_NO_FACE; face = faces.next()) {
        const double distance = std::sqrt(face.squared) * unit;
        if (distance < least) continue;
        if (distance > most || (distance == found.distance && !found.is_cut && number > found.body)) return;
        const Vec3 closest = body.frame->to_scene(closest_on(body, in_units, face.face));
        if (!test_.is_on_union(closest, number, PlacedFace(body, face.face))) continue;
        found = {number, face.face, false, closest, distance};
        return;
    }
}

}  // namespace clsdf::scenes
