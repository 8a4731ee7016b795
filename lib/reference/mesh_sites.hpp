#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/reference.hpp>

#include "surface/sign_surface.hpp"

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
    /// Both must outlive this. surface: that decides the sign, and with it the pseudonormals.
    MeshSites(const Mesh& mesh, const SignSurface& surface);

    SiteCorners corners(std::uint32_t triangle, Site site) const;

    /// The lowest triangle that has the site, and the site's number there.
    std::pair<std::uint32_t, Site> lowest(std::uint32_t triangle, Site site) const;

    /// Angle-weighted, a unit vector; nothing if no face at the site has an area. If the faces' normals cancel, the
    /// normal of the lowest face with area.
    std::optional<Vec3> pseudonormal(std::uint32_t triangle, Site site) const;

    bool is_inside_out() const { return is_inside_out_; }

private:
    using FacesAt = std::map<Vec3, std::vector<std::uint32_t>>;  ///< at each position, ascending
    static FacesAt find_faces(const Mesh& mesh);
    static std::vector<std::uint32_t> faces_at(const Mesh& mesh, const FacesAt& faces, std::uint32_t triangle,
                                               Site site);
    template <typename Count>
    static std::optional<Vec3> pseudonormal(const Mesh& mesh, const FacesAt& faces, std::uint32_t triangle, Site site,
                                            const Count& count);

    const Mesh& mesh_;
    const SignSurface& surface_;
    FacesAt faces_;
    std::optional<Mesh> joined_;  ///< with the positions that decide the sign, if they are others
    FacesAt joined_faces_;
    bool is_inside_out_;
};

}  // namespace clsdf::reference
