#pragma once

#include "benchmarks/measure.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace clsdf::bench {

/// The cost of cut cells, and what their sums are off by.
struct FractionCost {
    std::string name;
    std::string what;
    std::size_t cells = 0;          ///< that the surface meets
    std::optional<double> limit{};  ///< of the seconds: the project's bar
    Spread seconds{};               ///< by the clock on the wall
    Spread processor_seconds{};     ///< user and system time of all threads
    double volume_error = 0;        ///< of the volumes' sum, as a part of the outer surface's volume
    double area_error = 0;          ///< the same of the areas
};

/// The outer surface alone; cells on so many along the longest side, with the outer surface and without it.
std::vector<FractionCost> measure_fractions(const Mesh& mesh, const MeasureOptions& options,
                                            const std::vector<std::int64_t>& resolutions);

}  // namespace clsdf::bench
