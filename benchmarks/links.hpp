#pragma once

#include "benchmarks/rays.hpp"

namespace clsdf::bench {

/// Links of D3Q19 by walls: of the mesh on a grid of `resolution` samples on its longest side, 5% more around it. The
/// first call of a transform, the call again, the number of links alone, and the links of the faces as given.
std::vector<RayCost> measure_links(const Mesh& mesh, const Device& device, const MeasureOptions& options,
                                   std::int64_t resolution);

/// The same, first and again, of a ball, and of a cube whose faces lie on planes of the lattice: ties at every sample
/// of them. The ball has about as many links; the limit of the cube is three times its time.
std::vector<RayCost> measure_links_of_ties(const Device& device, const MeasureOptions& options,
                                           std::int64_t resolution);

}  // namespace clsdf::bench
