#pragma once

#include "acceptance/case.hpp"

#include <clsdf/distance_transform.hpp>

#include <cstddef>
#include <string>

namespace clsdf::acceptance {

struct CallChecks {
    std::size_t samples = 0;  ///< of a block, and points of the batch, that the reference judges; 0: all of a block
    bool has_points = true;   ///< the batch
};

/// Holds other calls than the one for the whole grid against its field and against the reference: requests of one call,
/// of a block at each end of the grid and one around a sample of the band; a transform that is restricted to this
/// block; points at its samples; a batch of points anywhere, many and few at once; and a block at a vertex after the
/// mesh has been turned. A block without a sample in the band is wrong: it proves nothing. Returns what is wrong, in a
/// sentence; nothing if all is right. Leaves the transform's mesh turned.
std::string wrong_calls(DistanceTransform& transform, const Problem& problem, const Field& field,
                        const CallChecks& checks);

}  // namespace clsdf::acceptance
