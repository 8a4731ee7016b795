#pragma once

#include <clsdf/calls.hpp>

#include <cstddef>
#include <vector>

namespace clsdf::transform {

/// The requests of blocks [begin, end). Throws Error(invalid_argument) for arrays that cannot hold all blocks.
std::vector<Request> requests_of(const BlockSet& blocks, std::size_t begin, std::size_t end);

}  // namespace clsdf::transform
