#pragma once

#include <clsdf/grid.hpp>

#include <algorithm>

namespace clsdf {

/// The order of bricks and runs of sparse fields: by z, then y, then x.
inline bool is_before(const Index3& a, const Index3& b) {
    return std::lexicographical_compare(a.rbegin(), a.rend(), b.rbegin(), b.rend());
}

}  // namespace clsdf
