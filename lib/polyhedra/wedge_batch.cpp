#include "polyhedra/wedge_batch.hpp"

#include "core/several_targets.hpp"
#include "polyhedra/slopes.hpp"

#include <cmath>

namespace clsdf::polyhedra {

CLSDF_SEVERAL_TARGETS void WedgeBatch::measure(Results& results) const {
    const auto& [first_x, first_y, first_z] = first_;
    const auto& [second_x, second_y, second_z] = second_;
    for (std::size_t i = 0; i < capacity; ++i) {
        const double sine = second_x[i] * normal_[0][i] + second_y[i] * normal_[1][i] + second_z[i] * normal_[2][i];
        const double x = first_x[i] - second_x[i];
        const double y = first_y[i] - second_y[i];
        const double z = first_z[i] - second_z[i];
        const double squared_apart = x * x + y * y + z * z;
        const double u = first_x[i] + second_x[i];
        const double v = first_y[i] + second_y[i];
        const double w = first_z[i] + second_z[i];
        // Folded pairs must not divide by zero: programs may trap that.
        const double divisor = squared_apart > 0 ? squared_apart : 1;
        results.slope[i] = widened(std::sqrt(u * u + v * v + w * w) / std::sqrt(divisor));
        results.folded[i] = folded(squared_apart) ? 1 : 0;
        const double turn = folded(squared_apart) ? 2 : turn_[i];
        results.side[i] = (sine > turn ? 1 : 0) - (sine < -turn ? 1 : 0);
    }
}

}  // namespace clsdf::polyhedra
