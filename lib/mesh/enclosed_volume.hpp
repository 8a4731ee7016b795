#pragma once

#include <clsdf/mesh.hpp>

namespace clsdf {

/// Whether a closed mesh encloses a volume that is negative by more than its rounding error: its faces look inwards.
bool encloses_negative_volume(const Mesh& mesh);

}  // namespace clsdf
