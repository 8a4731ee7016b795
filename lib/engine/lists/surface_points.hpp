#pragma once

#include "coarse.h"
#include "frusta/frusta.hpp"
#include "frusta/topology.hpp"

#include <array>
#include <vector>

namespace clsdf::scan {

/// A fixed sample of the surface's points, in a lattice's units, that distances are bounded with.
using SurfacePoints = std::vector<SurfacePoint>;

/// The triangles of the sample, of any lattice.
using SurfaceSample = std::vector<std::array<Vec3, 3>>;
SurfaceSample surface_sample(const polyhedra::MeshTopology& topology, const polyhedra::Frusta& frusta);

SurfacePoints surface_points(const SurfaceSample& sample, const polyhedra::LatticeView& lattice);

}  // namespace clsdf::scan
