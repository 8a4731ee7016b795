#pragma once

#include <clsdf/calls.hpp>

#include "device/context.hpp"
#include "targets/target_overlap.hpp"

#include <cstddef>
#include <functional>
#include <vector>

namespace clsdf::transform {

/// The requests of blocks [begin, end). Throws Error(invalid_argument) for arrays that cannot hold all blocks.
std::vector<Request> requests_of(const BlockSet& blocks, std::size_t begin, std::size_t end);

/// Throws what a call for any of the requests of [begin, end) would throw for its grid and its targets, or what `check`
/// throws, with the number of the block in the message. Adds their arrays to `written`.
void check_blocks(const BlockSet& blocks, std::size_t begin, std::size_t end, const device::Context& context,
                  const std::function<void(const Request&)>& check, std::vector<scan::WrittenArray>& written);

}  // namespace clsdf::transform
