#include "benchmarks/call_job.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <span>

namespace clsdf::bench {

namespace {

/// Samples of a field, half of them in its band.
std::vector<Index3> chosen_samples(const Field& field, std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<std::size_t> any(0, field.distance().size() - 1);
    std::vector<Index3> chosen;
    while (chosen.size() < count) {
        const std::size_t offset = any(random);
        const bool in_band = std::abs(static_cast<double>(field.distance()[offset])) < 0.999 * field.band.outside;
        if (in_band != (chosen.size() < count / 2)) continue;
        const auto nx = static_cast<std::size_t>(field.grid.size[0]), ny = static_cast<std::size_t>(field.grid.size[1]);
        chosen.push_back({static_cast<std::int64_t>(offset % nx), static_cast<std::int64_t>(offset / nx % ny),
                          static_cast<std::int64_t>(offset / (nx * ny))});
    }
    return chosen;
}

/// Boxes of 16 x 16 x 16 samples that hold a sample of the band, with so many ghost samples a side.
std::vector<Grid> patches_of(const Field& level, std::int64_t ghosts) {
    constexpr std::int64_t side = 16;
    const Grid& grid = level.grid;
    std::vector<Grid> patches;
    for (std::int64_t z = 0; z + side <= grid.size[2]; z += side)
        for (std::int64_t y = 0; y + side <= grid.size[1]; y += side)
            for (std::int64_t x = 0; x + side <= grid.size[0]; x += side) {
                bool meets_band = false;
                for (std::int64_t n = 0; n < side * side * side && !meets_band; ++n) {
                    const std::int64_t i = x + n % side, j = y + n / side % side, k = z + n / (side * side);
                    const auto offset = static_cast<std::size_t>((k * grid.size[1] + j) * grid.size[0] + i);
                    meets_band = std::abs(static_cast<double>(level.distance()[offset])) < 0.999 * level.band.outside;
                }
                if (!meets_band) continue;
                patches.push_back(grid.part({x, y, z}, {side, side, side}).grown(ghosts));
            }
    return patches;
}

/// Boxes and memory for each of them.
struct Patches {
    std::vector<Grid> grids;
    std::vector<FieldArray<float>> distances;

    void take(std::vector<Grid> more) {
        for (const Grid& grid : more) {
            grids.push_back(grid);
            distances.emplace_back().resize(grid.sample_count());
        }
    }
    void shuffle_and_keep(std::size_t count, std::uint64_t seed) {
        std::shuffle(grids.begin(), grids.end(), std::mt19937_64(seed));
        grids.resize(std::min(grids.size(), count));
        distances.resize(grids.size());
    }
    std::vector<Request> requests() {
        std::vector<Request> result;
        for (std::size_t n = 0; n < grids.size(); ++n)
            result.push_back({grids[n], CallJob::band(grids[n]), distances[n]});
        return result;
    }
};

/// Boxes, by a call each or in one call, beside levels that are computed whole, all with a transform that is new.
CallCost measure_boxes(const CallJob& job, CallJudge& judge, CallCost cost, Patches& patches,
                       std::vector<Field>& levels, bool in_one_call) {
    std::unique_ptr<DistanceTransform> transform;
    const auto renew = [&] { transform = std::make_unique<DistanceTransform>(job.device, job.mesh); };
    job.measure(
        cost,
        [&] {
            renew();
            const std::vector<Request> requests = patches.requests();
            return seconds_of([&] {
                if (in_one_call) {
                    transform->compute(requests);
                    return;
                }
                for (const Request& request : requests) transform->compute(request.grid, request.band, request.targets);
            });
        },
        [&] {
            renew();
            return seconds_of([&] {
                for (Field& level : levels) transform->compute(level.grid, level.band, level.distance());
            });
        });
    for (std::size_t n = 0; n < patches.grids.size(); ++n) {
        Field field({.grid = patches.grids[n], .band = CallJob::band(patches.grids[n]), .mesh_name = {}});
        std::ranges::copy(patches.distances[n], field.distance().begin());
        judge.look_at(field, std::max<std::size_t>(1, job.options.samples_judged / patches.grids.size()), cost);
    }
    return cost;
}

/// The eight halves of each box.
std::vector<Box> divided(const std::vector<Box>& boxes) {
    std::vector<Box> result;
    for (const Box& box : boxes)
        for (std::size_t n = 0; n < 8; ++n) {
            Box part = box;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double middle = std::midpoint(box.lower[axis], box.upper[axis]);
                ((n >> axis) % 2 == 0 ? part.upper : part.lower)[axis] = middle;
            }
            result.push_back(part);
        }
    return result;
}

}  // namespace

CallCost measure_one_sample(const CallJob& job, CallJudge& judge) {
    CallCost cost{"one_sample",
                  "a grid of one sample, half of 64 in the band / a band of 10% on 256 samples on the "
                  "longest side, from the mesh's arrays"};
    cost.limit = 1.0 / 50;
    const Grid grid = job.grid(256);
    const DistanceTransform transform = job.transform();
    // Other samples each time, because the plans of earlier calls are kept.
    const Field field = transform.compute(grid, CallJob::band(grid));
    std::uint64_t seed = job.options.seed;
    std::vector<Index3> samples;
    const Band wide = Band::symmetric(0.1 * job.mesh.box().longest_side());
    const Grid around = Grid::around(job.mesh, job.scaled(256), wide);
    Field whole = transform.compute(around, wide);
    job.measure(
        cost,
        [&] {
            std::vector<double> seconds;
            samples = chosen_samples(field, 64, ++seed);
            for (const Index3& sample : samples) {
                float distance = 0;
                const Grid one = grid.part(sample, {1, 1, 1});
                seconds.push_back(
                    seconds_of([&] { transform.compute(one, CallJob::band(grid), std::span(&distance, 1)); }));
            }
            return spread_of(seconds).median;
        },
        [&] { return seconds_of([&] { job.transform().compute(around, wide, whole.distance()); }); });
    for (const Index3& sample : samples)
        judge.look_at(transform.compute(grid.part(sample, {1, 1, 1}), CallJob::band(grid)), 1, cost);
    return cost;
}

CallCost measure_patches(const CallJob& job, CallJudge& judge, bool in_one_call) {
    CallCost cost =
        in_one_call
            ? CallCost{"patches_at_once",
                       "512 boxes of 20^3 on levels of 128, 256 and 512, in one call / the levels whole"}
            : CallCost{"patches", "512 boxes of 20^3 on levels of 128, 256 and 512, a call each / the levels whole"};
    cost.limit = in_one_call ? 3 : 10;
    std::vector<Field> levels;
    Patches patches;
    for (const std::int64_t resolution : {128, 256, 512}) {
        const Grid grid = job.grid(resolution);
        levels.push_back(job.transform().compute(grid, CallJob::band(grid)));
        patches.take(patches_of(levels.back(), 2));
    }
    patches.shuffle_and_keep(512, job.options.seed);
    return measure_boxes(job, judge, cost, patches, levels, in_one_call);
}

CallCost measure_band_boxes(const CallJob& job, CallJudge& judge) {
    CallCost cost{"band_boxes",
                  "all boxes of 16^3 samples of 512 a side that meet the band, 4096 at most, in one call / "
                  "the grid whole"};
    cost.limit = 1.5;
    const Grid grid = job.grid(512);
    std::vector<Field> level;
    level.push_back(job.transform().compute(grid, CallJob::band(grid)));
    Patches patches;
    patches.take(patches_of(level.front(), 0));
    patches.shuffle_and_keep(4096, job.options.seed);
    return measure_boxes(job, judge, cost, patches, level, true);
}

CallCost measure_classify(const CallJob& job, CallJudge& judge) {
    CallCost cost{"classify",
                  "cells of an octree that is refined near the surface, a call for each level, a million of them / a "
                  "second"};
    cost.limit = 1;
    const std::size_t least = job.is_quick ? 10'000 : 1'000'000;
    const DistanceTransform transform = job.transform();
    const Grid around = job.grid(512);
    const double half_width = around.voxel();
    std::vector<Box> cells;
    std::vector<BoxPlace> places;
    std::size_t count = 0;
    job.measure(
        cost,
        [&] {
            double seconds = 0;
            std::vector<Box> near{around.box()};
            for (count = 0; count < least;) {
                cells = divided(near);
                places.resize(cells.size());
                seconds += seconds_of([&] { transform.classify(cells, half_width, places); });
                count += cells.size();
                near.clear();
                for (std::size_t n = 0; n < cells.size(); ++n)
                    if (places[n] == BoxPlace::within) near.push_back(cells[n]);
            }
            return seconds * 1e6 / static_cast<double>(count);
        },
        [] { return 1.0; });
    judge.look_at(cells, places, half_width, job.options.samples_judged, cost);
    return cost;
}

}  // namespace clsdf::bench
