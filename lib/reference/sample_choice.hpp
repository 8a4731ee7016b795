#pragma once

#include "true_samples.hpp"

#include <clsdf/field.hpp>

namespace clsdf::reference {

/// Samples of a field for a check: half drawn uniformly, half near the band's limits, edges and vertices. The same for
/// the same seed on every platform.
std::vector<Index3> choose_samples(const TrueSamples& truth, const Field& field, std::size_t count, std::uint64_t seed);

}  // namespace clsdf::reference
