#pragma once

#include "mesh_sites.hpp"
#include "true_samples.hpp"

#include <cstddef>

namespace clsdf::reference {

/// What the outputs of a sample follow from.
struct OutputSources {
    const TrueSamples& truths;
    const MeshSites& sites;
    const TrueSample& truth;
    const Index3& index;
};

/// Stores the outputs of a sample of the band beside the distance, computed plainly.
void store_outputs(const OutputSources& sources, Field& field, std::size_t offset);

}  // namespace clsdf::reference
