#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/reference.hpp>

#include <map>
#include <optional>
#include <vector>

namespace clsdf::reference {

/// A site by its geometry.
struct SiteCorners {
    std::size_t count = 0;  ///< 1: a vertex, 2: an edge, 3: a face
    std::array<Vec3, 3> positions{};
};

/// The faces at each vertex and edge of a mesh; vertices of equal coordinates are one. Constant functions may be called
/// from several threads at once.
class MeshSites {
public:
    /// The mesh must outlive this.
    explicit MeshSites(const Mesh& mesh);

    SiteCorners corners(std::uint32_t triangle, Site site) const;

    /// The lowest triangle that has the site, and the site's number there.
    std::pair<std::uint32_t, Site> lowest(std::uint32_t triangle, Site site) const;

    /// Angle-weighted, a unit vector; nothing if no face at the site has an area. If the faces' normals cancel, the
    /// normal of the lowest face with area.
    std::optional<Vec3> pseudonormal(std::uint32_t triangle, Site site) const;

    bool is_inside_out() const { return is_inside_out_; }

private:
    std::vector<std::uint32_t> faces_at(std::uint32_t triangle, Site site) const;

    const Mesh& mesh_;
    std::map<Vec3, std::vector<std::uint32_t>> faces_;  ///< at each position, ascending
    bool is_inside_out_;
};

}  // namespace clsdf::reference
