#pragma once

#include "core/kernel_language.hpp"

#include <clsdf/fractions.hpp>
#include <clsdf/mesh.hpp>

#include "cut_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

// OpenCL C gets no warnings for C++.
#ifdef __GNUC__
#pragma GCC system_header
#endif

/// kernels/cutting/cell_rows.h and what it includes, compiled by the host.
namespace clsdf::cutting {

using namespace kernel_language;
using std::floor, std::fma, std::rint;

#define __private
#include "cell_rows.h"
#undef __private

/// The lowest and the highest cell along an axis in which corners of a triangle lie.
inline std::pair<double, double> cells_of_corners(const std::array<CutPoint, 3>& corners, std::size_t axis) {
    const auto along = static_cast<int>(axis);
    return std::minmax({cell_of(corners[0], along), cell_of(corners[1], along), cell_of(corners[2], along)});
}

inline CellFraction as_fraction(const FractionRow& row) {
    static_assert(sizeof(CellFraction) == sizeof(FractionRow) &&
                  offsetof(CellFraction, area) == offsetof(FractionRow, area) &&
                  offsetof(CellFraction, face_centroids) == offsetof(FractionRow, face_centroids));
    return std::bit_cast<CellFraction>(row);
}

}  // namespace clsdf::cutting
