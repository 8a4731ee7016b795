#pragma once

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// For each vertex the index of the first one with equal coordinates, its own where there is none before it; -0.0
/// equals 0.0. At most 2^32 - 1 vertices.
std::vector<std::uint32_t> first_equal_vertices(std::span<const Vec3> vertices);

}  // namespace clsdf
