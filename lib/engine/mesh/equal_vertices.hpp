#pragma once

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// For each vertex the index of the first vertex with equal coordinates, which may be its own; -0.0 equals 0.0. At most
/// 2^32 - 1 vertices.
std::vector<std::uint32_t> first_equal_vertices(std::span<const Vec3> vertices);

/// The mesh with only those vertices that stand for themselves. first: for each vertex the one that stands for it.
Mesh merged(const Mesh& mesh, const std::vector<std::uint32_t>& first);

}  // namespace clsdf
