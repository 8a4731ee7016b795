#include "polyhedra/pair_batch.hpp"

#include "core/several_targets.hpp"

#include <cmath>

namespace clsdf::polyhedra {

CLSDF_SEVERAL_TARGETS void PairBatch::measure(Results& results) const {
    const auto& [first, second, normal] = inputs_;
    for (std::size_t i = 0; i < capacity; ++i) {
        results.sine[i] = second[0][i] * normal[0][i] + second[1][i] * normal[1][i] + second[2][i] * normal[2][i];
        const double x = first[0][i] - second[0][i];
        const double y = first[1][i] - second[1][i];
        const double z = first[2][i] - second[2][i];
        const double squared = x * x + y * y + z * z;
        // Folded pairs, and lanes beyond the size, must not divide by zero: programs may trap that.
        const double divisor = squared > 0 ? squared : 1;
        const double u = first[0][i] + second[0][i];
        const double v = first[1][i] + second[1][i];
        const double w = first[2][i] + second[2][i];
        results.squared_apart[i] = squared;
        results.slope[i] = std::sqrt(u * u + v * v + w * w) / std::sqrt(divisor);
    }
}

}  // namespace clsdf::polyhedra
