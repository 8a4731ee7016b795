#pragma once

#include "polyhedra/triangle_frame.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <span>

namespace clsdf::polyhedra {

/// triangle_frame() of every triangle, to the same bits, as many at a time as a processor's vectors hold. Triangles
/// with needles' or degenerate shapes are left to triangle_frame().
void triangle_frames(std::span<const Vec3> positions, std::span<const Triangle> triangles, const LatticeView& lattice,
                     std::span<TriangleFrame> frames);

}  // namespace clsdf::polyhedra
