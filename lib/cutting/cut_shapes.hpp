#pragma once

#include "core/kernel_language.hpp"

#include <clsdf/fractions.hpp>
#include <clsdf/mesh.hpp>

#include "cut_grid.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

// OpenCL C gets no warnings for C++.
#ifdef __GNUC__
#pragma GCC system_header
#endif

/// kernels/cutting/cell_rows.h and what it includes, compiled by the host.
namespace clsdf::cutting {

using namespace kernel_language;
using std::floor;

#define __private
#include "cell_rows.h"
#undef __private

inline CutPoint cut_point(const Vec3& p) {
    return {{p[0], p[1], p[2]}};
}

inline CellFraction as_fraction(const FractionRow& row) {
    static_assert(sizeof(CellFraction) == sizeof(FractionRow) &&
                  offsetof(CellFraction, area) == offsetof(FractionRow, area) &&
                  offsetof(CellFraction, face_centroids) == offsetof(FractionRow, face_centroids));
    return std::bit_cast<CellFraction>(row);
}

}  // namespace clsdf::cutting
