#pragma once

#include "polyhedra/slopes.hpp"
#include "polyhedra/triangle_frame.hpp"

namespace clsdf::polyhedra {

/// The device's record of a polyhedron. `triangle`: index in the caller's order.
Polyhedron pack(const TriangleFrame& frame, const FaceSlopes& slopes, std::uint32_t triangle,
                const LatticeView& lattice);

}  // namespace clsdf::polyhedra
