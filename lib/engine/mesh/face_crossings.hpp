#pragma once

#include <clsdf/mesh.hpp>

#include <span>

namespace clsdf {

/// Whether the insides of two faces have a line or an area in common; faces that only touch do not cross. Exact for the
/// doubles as given. Both have an area, and they have at most two vertices in common.
bool faces_cross(std::span<const Vec3> vertices, const Triangle& first, const Triangle& second);

}  // namespace clsdf
