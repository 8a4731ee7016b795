#pragma once

#include <clsdf/grid.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace clsdf {

/// The samples that two blocks of a lattice share; nothing if there are none.
inline std::optional<Grid> common_part(const Grid& one, const Grid& other) {
    Grid common = one;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        common.first[axis] = std::max(one.first[axis], other.first[axis]);
        common.size[axis] =
            std::min(one.first[axis] + one.size[axis], other.first[axis] + other.size[axis]) - common.first[axis];
        if (common.size[axis] <= 0) return std::nullopt;
    }
    return common;
}

}  // namespace clsdf
