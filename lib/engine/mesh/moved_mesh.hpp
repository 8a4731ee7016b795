#pragma once

#include <clsdf/mesh.hpp>

#include "mesh/mesh_arrays.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace clsdf::engine {

/// A mesh of arrays that are known to be right, and their box.
Mesh mesh_of(MeshArrays arrays, const Box& box, std::string name);
/// The same mesh with another box.
Mesh with_box(Mesh mesh, const Box& box);

/// The mesh at new positions, which have this box and are finite if a triangle uses them. Shares the triangles.
Mesh moved(const Mesh& mesh, std::vector<Vec3> positions, const Box& box);
/// The same as mesh.set_positions(), with its errors, without a look at the triangles. used: the vertices in use.
Mesh moved(const Mesh& mesh, std::vector<Vec3> positions, std::span<const std::uint32_t> used);

}  // namespace clsdf::engine
