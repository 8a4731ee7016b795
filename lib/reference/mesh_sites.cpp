#include "mesh_sites.hpp"

#include <clsdf/topology.hpp>

#include "surface/topology.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace clsdf::reference {

namespace {

using Wide = long double;
using WideVector = Eigen::Matrix<Wide, 3, 1>;

/// A sum of unit vectors that is shorter than this has no direction.
constexpr Wide cancelled = 1e-6L;

WideVector difference(const Vec3& to, const Vec3& from) {
    return {Wide(to[0]) - Wide(from[0]), Wide(to[1]) - Wide(from[1]), Wide(to[2]) - Wide(from[2])};
}

std::size_t number_of(Site site) {
    return static_cast<std::size_t>(site);
}

/// -0 and 0 are one position.
Vec3 key_of(const Vec3& position) {
    return {position[0] + 0.0, position[1] + 0.0, position[2] + 0.0};
}

std::array<Vec3, 3> positions_of(const Mesh& mesh, std::uint32_t triangle) {
    std::array<Vec3, 3> positions;
    for (std::size_t k = 0; k < 3; ++k) positions[k] = key_of(mesh.vertices()[mesh.triangles()[triangle][k]]);
    return positions;
}

/// The site of a face that has the same geometry; nothing if it has none.
std::optional<Site> same_site(const std::array<Vec3, 3>& face, const SiteCorners& corners) {
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &from = face[k], &to = face[(k + 1) % 3];
        if (corners.count == 1 && from == corners.positions[0]) return static_cast<Site>(k);
        const bool is_along = from == corners.positions[0] && to == corners.positions[1];
        const bool is_against = from == corners.positions[1] && to == corners.positions[0];
        if (corners.count == 2 && (is_along || is_against)) return static_cast<Site>(3 + k);
    }
    return std::nullopt;
}

SiteCorners corners_of(const Mesh& mesh, std::uint32_t triangle, Site site) {
    const std::array<Vec3, 3> face = positions_of(mesh, triangle);
    const std::size_t number = number_of(site);
    if (number < 3) return {1, {face[number]}};
    if (number < 6) return {2, {face[number - 3], face[(number - 2) % 3]}};
    return {3, face};
}

}  // namespace

MeshSites::FacesAt MeshSites::find_faces(const Mesh& mesh) {
    FacesAt all;
    for (std::uint32_t triangle = 0; triangle < mesh.triangles().size(); ++triangle)
        for (const Vec3& position : positions_of(mesh, triangle)) {
            std::vector<std::uint32_t>& faces = all[position];
            if (faces.empty() || faces.back() != triangle) faces.push_back(triangle);
        }
    return all;
}

MeshSites::MeshSites(const Mesh& mesh, const SignSurface& surface)
    : mesh_(mesh),
      surface_(surface),
      faces_(find_faces(mesh)),
      is_inside_out_(!surface.open_loops.floor &&
                     describe_mesh(mesh, surface.open_loops.empty() ? SignRule::automatic : SignRule::solid_angle)
                         .topology.inside_out) {
    if (surface.is_mesh()) return;
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles)
        for (std::uint32_t& index : triangle) index = surface.vertex(index);
    joined_.emplace(mesh.vertices(), std::move(triangles));
    joined_faces_ = find_faces(*joined_);
}

SiteCorners MeshSites::corners(std::uint32_t triangle, Site site) const {
    return corners_of(mesh_, triangle, site);
}

std::vector<std::uint32_t> MeshSites::faces_at(const Mesh& mesh, const FacesAt& all, std::uint32_t triangle,
                                               Site site) {
    if (site == Site::face) return {triangle};
    const SiteCorners of_site = corners_of(mesh, triangle, site);
    std::vector<std::uint32_t> faces;
    for (const std::uint32_t face : all.at(of_site.positions[0]))
        if (same_site(positions_of(mesh, face), of_site)) faces.push_back(face);
    return faces;
}

std::pair<std::uint32_t, Site> MeshSites::lowest(std::uint32_t triangle, Site site) const {
    if (site == Site::face) return {triangle, site};
    const std::uint32_t first = faces_at(mesh_, faces_, triangle, site).front();
    return {first, *same_site(positions_of(mesh_, first), corners(triangle, site))};
}

template <typename Count>
std::optional<Vec3> MeshSites::pseudonormal(const Mesh& mesh, const FacesAt& all, std::uint32_t triangle, Site site,
                                            const Count& count) {
    WideVector sum = WideVector::Zero();
    std::optional<WideVector> first;
    Wide weights = 0;
    const SiteCorners of_site = corners_of(mesh, triangle, site);
    for (const std::uint32_t face : faces_at(mesh, all, triangle, site)) {
        const std::array<Vec3, 3> positions = positions_of(mesh, face);
        const WideVector normal =
            count(face) *
            difference(positions[1], positions[0]).cross(difference(positions[2], positions[0])).stableNormalized();
        if (!(normal.norm() > 0.5L)) continue;
        Wide weight = 1;
        if (of_site.count == 1) {
            const std::size_t k = number_of(*same_site(positions, of_site));
            const WideVector one = difference(positions[(k + 1) % 3], positions[k]),
                             other = difference(positions[(k + 2) % 3], positions[k]);
            weight = std::atan2(one.cross(other).norm(), one.dot(other));
        }
        if (!first) first = normal;
        sum += weight * normal;
        weights += weight;
    }
    if (!first) return std::nullopt;
    const WideVector unit = sum.norm() > cancelled * weights ? WideVector(sum / sum.norm()) : *first;
    return Vec3{static_cast<double>(unit[0]), static_cast<double>(unit[1]), static_cast<double>(unit[2])};
}

std::optional<Vec3> MeshSites::pseudonormal(std::uint32_t triangle, Site site) const {
    const auto direction = [&](std::uint32_t face) { return Wide(surface_.direction(face)); };
    if (site == Site::face) return pseudonormal(mesh_, faces_, triangle, site, direction);
    if (joined_)
        if (const auto normal = pseudonormal(*joined_, joined_faces_, triangle, site,
                                             [&](std::uint32_t face) { return Wide(surface_.count(face)); }))
            return normal;
    return pseudonormal(mesh_, faces_, triangle, site, [](std::uint32_t) { return Wide(1); });
}

}  // namespace clsdf::reference
