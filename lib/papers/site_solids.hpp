#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace clsdf::papers {

/// The polyhedron of a face, an edge or a vertex: a prism or a pyramid. Lengths in voxels, from an integer origin.
struct SiteSolid {
    static constexpr std::size_t most_corners = 14;
    enum class Shape : std::uint8_t { none, prism, pyramid };
    enum class Site : std::uint8_t { face, edge, vertex };

    Shape shape = Shape::none;
    Site site = Site::face;
    std::uint8_t sides =
        0;           ///< corners of a prism: one end's, then the other's; of a pyramid: the tip, then the base's
    float sign = 1;  ///< of edges and vertices
    std::array<std::int32_t, 3> origin{};
    std::array<float, 3> point{};                ///< of the site
    std::array<std::array<float, 3>, 2> axes{};  ///< of a face its normal; of an edge two unit vectors across it
    std::array<std::array<float, 3>, most_corners> corners{};

    std::size_t corner_count() const { return shape == Shape::prism ? 2U * sides : 1U + sides; }
};

/// The polyhedra of the faces, edges and vertices of a closed manifold mesh, relative to the grid's first sample; some
/// sites have none.
std::vector<SiteSolid> site_solids(const Mesh& mesh, const Grid& grid, double half_width);

}  // namespace clsdf::papers
