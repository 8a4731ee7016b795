#pragma once

#include "coarse.h"
#include "frusta/frusta.hpp"
#include "topology/topology.hpp"

#include <array>
#include <vector>

namespace clsdf::engine {

/// A fixed sample of the surface's points, in a lattice's units, that distances are bounded with.
using SurfacePoints = std::vector<SurfacePoint>;

/// The triangles of the sample, of any lattice.
using SurfaceSample = std::vector<std::array<Vec3, 3>>;
SurfaceSample surface_sample(const MeshTopology& topology, const Frusta& frusta);
/// Their vertices, as MeshTopology numbers them.
std::vector<Triangle> sample_triangles(const MeshTopology& topology);

SurfacePoints surface_points(const SurfaceSample& sample, const LatticeView& lattice);

}  // namespace clsdf::engine
