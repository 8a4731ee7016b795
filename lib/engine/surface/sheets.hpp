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

/// The faces that can be left out of an open surface for the sign (docs/sign.md, 'Walls within a body' and 'Sheets
/// beside bodies').
struct Sheets {
    std::vector<std::uint32_t> left_out;  ///< ascending; empty if the surface has no sign without them, either
    std::vector<std::uint32_t> walls;     ///< those of them that are inner walls
    std::vector<std::uint32_t> open;      ///< those of them that can be reached, of bodies whose walls are left out
    std::vector<std::uint32_t> turned;    ///< faces that look the wrong way without them
    std::size_t enclosing = 0;            ///< faces of a set of sheets that encloses something
    std::uint32_t first_enclosing = 0;
};
Sheets find_sheets(const Mesh& mesh, std::span<const Triangle> triangles);

/// Whether faces enclose something as sheets that could be left out may not.
bool enclose_something(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const std::uint32_t> faces);

}  // namespace clsdf
