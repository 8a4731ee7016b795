// The outer surface of the bodies of a scene.
#include "calls/scenes/scene_state.hpp"
#include "calls/transform/transform_access.hpp"
#include "calls/transform/transform_state.hpp"
#include "core/call_mutex.hpp"
#include "core/floating_point.hpp"
#include "core/refuse.hpp"
#include "mesh/vertices.hpp"

#include <clsdf/outer.hpp>

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

/// The outer surface of a body alone: closed, and its faces look outwards.
OuterSurface outer_of_body(const Mesh& mesh, SignRule sign, std::uint32_t body, const CallOptions& call) {
    CallOptions of_body{.should_stop = call.should_stop};
    if (call.log)
        of_body.log = [&](const std::string& message) { call.log(fmt::format("body {}: {}", body, message)); };
    try {
        return outer(mesh, sign, of_body);
    } catch (const Error& error) {
        throw Error(error.code(), fmt::format("body {}: {}", body, error.what()));
    }
}

}  // namespace

SceneSurface Scene::State::outer(const CallOptions& call) const {
    const DefaultFloatingPoint as_kernels;
    require_bodies();
    std::map<const Shape*, OuterSurface> surfaces;  // of bodies alone; instances share one
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> numbers, faces;  // of each triangle
    for (std::uint32_t number = 0; number < bodies.size(); ++number) {
        const Body& body = bodies[number];
        if (!body.is_active) continue;
        auto found = surfaces.find(body.shape);
        if (found == surfaces.end()) {
            auto& of_shape = detail::TransformAccess::state(body.shape->transform);
            std::vector<std::uint32_t> given;  // the faces of an outer surface
            const Mesh mesh = [&] {
                const std::scoped_lock lock(of_shape.mutex);
                given.assign(of_shape.kept_mesh->numbers().begin(), of_shape.kept_mesh->numbers().end());
                return of_shape.kept_mesh->mesh();
            }();
            const SignRule rule = is_union() ? SignRule::nonzero : body.shape->asked;
            found = surfaces.emplace(body.shape, outer_of_body(mesh, rule, number, call)).first;
            if (!given.empty())
                for (std::uint32_t& face : found->second.faces) face = given[face];
        }
        const OuterSurface& own = found->second;
        constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max();
        if (vertices.size() > most - own.mesh.vertices().size())
            refuse_unsupported(
                "the surfaces of bodies 0 to {} have more than 2^32 vertices together; switch some "
                "bodies off, and take the outer surface of the others",
                number);
        const auto first = static_cast<std::uint32_t>(vertices.size());
        const std::vector<Vec3> moved =
            engine::Vertices::moved(own.mesh.vertices(), body.frame.rotation, body.frame.translation);
        vertices.insert(vertices.end(), moved.begin(), moved.end());
        for (const Triangle& triangle : own.mesh.triangles())
            triangles.push_back({triangle[0] + first, triangle[1] + first, triangle[2] + first});
        numbers.insert(numbers.end(), own.faces.size(), number);
        faces.insert(faces.end(), own.faces.begin(), own.faces.end());
    }
    surfaces.clear();
    SceneSurface result{
        clsdf::outer(Mesh(std::move(vertices), std::move(triangles), "bodies"), SignRule::nonzero, call), {}};
    result.bodies.reserve(result.surface.faces.size());
    for (std::uint32_t& face : result.surface.faces) {
        result.bodies.push_back(numbers[face]);
        face = faces[face];
    }
    return result;
}

SceneSurface Scene::outer(const CallOptions& call) const {
    return with_host_memory("for the outer surface", [&] { return state().outer(call); });
}

}  // namespace clsdf
