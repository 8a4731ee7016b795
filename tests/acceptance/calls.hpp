#pragma once

#include "acceptance/case.hpp"

#include <clsdf/distance_transform.hpp>

#include <string>

namespace clsdf::acceptance {

/// Holds other calls than the one for the whole grid against its field and against the reference, in a block at each
/// end and in the middle: requests of one call, a transform that is restricted to the middle block, points at its
/// samples, and the block after the mesh has been turned. Returns what is wrong, in a sentence; nothing if all is
/// right. Leaves the transform's mesh turned.
std::string wrong_calls(DistanceTransform& transform, const Problem& problem, const Field& field);

}  // namespace clsdf::acceptance
