#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::scenes {

/// Divides boxes into groups, so that no two of a group have a point in common: each box comes to the first group that
/// it may be in. The numbers of a group ascend.
std::vector<std::vector<std::uint32_t>> separate_groups(std::span<const Box> boxes);

}  // namespace clsdf::scenes
