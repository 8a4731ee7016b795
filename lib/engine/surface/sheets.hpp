#pragma once

#include <clsdf/mesh.hpp>

#include "surface/parts.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// By face: whether it is of a free sheet. A free sheet is a part with an edge of one face; edges count without the
/// sheets that were found before.
std::vector<bool> free_sheets(const OrientedParts& parts, std::size_t face_count);

/// The faces that can be left out of an open surface for the sign (docs/sign.md, 'Sheets beside bodies').
struct Sheets {
    std::vector<std::uint32_t> left_out;  ///< ascending; empty if the surface has no sign without them, either
    std::vector<std::uint32_t> walls;     ///< those of them that are inner walls
    std::vector<std::uint32_t> turned;    ///< faces that look the wrong way without them
    std::size_t enclosing = 0;            ///< faces of a set of sheets that encloses something
    std::uint32_t first_enclosing = 0;
};
Sheets find_sheets(const Mesh& mesh, std::span<const Triangle> triangles);

}  // namespace clsdf
