#include "benchmarks/fractions.hpp"

#include "benchmarks/cost.hpp"

#include <clsdf/fractions.hpp>
#include <clsdf/outer.hpp>

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <utility>

namespace clsdf::bench {

namespace {

void measure(FractionCost& cost, const MeasureOptions& options, const auto& call) {
    std::vector<double> seconds, processor;
    for (std::size_t n = 0; n < options.repetitions + 1; ++n) {
        if (options.progress) options.progress(cost.name);
        const CostWatch watch;
        call();
        const Cost of_call = watch.cost();
        if (n == 0) continue;  // warms up
        seconds.push_back(of_call.wall);
        processor.push_back(of_call.processor);
    }
    cost.seconds = spread_of(seconds);
    cost.processor_seconds = spread_of(processor);
}

void judge(FractionCost& cost, const Fractions& found, const OuterSurface& surface) {
    double volume = 0, area = 0;
    for (const std::uint8_t byte : found.full) volume += std::popcount(byte);
    for (const CellFraction& cell : found.cells) {
        volume += cell.volume;
        area += cell.area;
    }
    const Vec3& spacing = found.grid.spacing;
    cost.cells = found.cells.size();
    cost.volume_error = std::abs(volume * spacing[0] * spacing[1] * spacing[2] / surface.volume - 1);
    cost.area_error = std::abs(area / surface.area - 1);
}

}  // namespace

std::vector<FractionCost> measure_fractions(const Mesh& mesh, const MeasureOptions& options,
                                            const std::vector<std::int64_t>& resolutions) {
    OuterSurface surface = outer(mesh);
    std::vector<FractionCost> costs{{"outer", "the outer surface alone"}};
    measure(costs.back(), options, [&] { surface = outer(mesh); });
    for (const std::int64_t cells : resolutions) {
        const Grid grid = Grid::around(mesh.box(), {.resolution = cells + 1});
        Fractions found;
        FractionCost whole{fmt::format("{}", cells),
                           fmt::format("the outer surface and {} cells along the longest side", cells)};
        measure(whole, options, [&] { found = fractions(mesh, grid); });
        judge(whole, found, surface);
        FractionCost again{fmt::format("{}, again", cells), "cells of an outer surface that is there"};
        measure(again, options, [&] { found = fractions(surface, grid); });
        judge(again, found, surface);
        costs.push_back(std::move(whole));
        costs.push_back(std::move(again));
    }
    return costs;
}

}  // namespace clsdf::bench
