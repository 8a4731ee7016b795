#include "benchmarks/calls.hpp"

#include "benchmarks/call_judge.hpp"
#include "benchmarks/cost.hpp"
#include "benchmarks/points.hpp"

#include "device/opencl.hpp"

#include <clsdf/reference.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <span>

namespace clsdf::bench {

namespace {

constexpr double band_voxels = 3;

double seconds_of(const std::function<void()>& calls) {
    const CostWatch watch;
    calls();
    return watch.cost().wall;
}

struct Job {
    const Mesh& mesh;
    const Device& device;
    const MeasureOptions& options;
    bool is_quick;

    std::int64_t scaled(std::int64_t resolution) const { return is_quick ? resolution / 8 : resolution; }

    Grid grid(std::int64_t resolution) const {
        const double side = mesh.box().longest_side();
        const auto samples = static_cast<double>(scaled(resolution));
        return Grid::around(mesh, scaled(resolution),
                            Band::symmetric(band_voxels * side / (samples - 1 - 2 * band_voxels)));
    }
    static Band band(const Grid& grid) { return Band::symmetric(band_voxels * grid.voxel()); }
    DistanceTransform transform() const { return {device, mesh}; }

    /// Both kinds of calls take turns; each pair gives one ratio's parts.
    template <typename Calls, typename Base>
    void measure(CallCost& cost, const Calls& calls, const Base& base) const {
        std::vector<double> seconds, base_seconds;
        for (std::size_t n = 0; n < options.repetitions + 1; ++n) {
            if (options.progress) options.progress(cost.name);
            const double of_base = base();
            const double of_calls = calls();
            if (n == 0) continue;  // warms up
            base_seconds.push_back(of_base);
            seconds.push_back(of_calls);
        }
        cost.seconds = spread_of(seconds);
        cost.base_seconds = spread_of(base_seconds);
        cost.ratio = cost.seconds.median / cost.base_seconds.median;
    }
};

CallCost measure_again(const Job& job, CallJudge& judge) {
    CallCost cost{"again", "the same grid and band on a kept transform / its first call"};
    cost.limit = 0.75;
    const Grid grid = job.grid(256);
    Field field = job.transform().compute(grid, Job::band(grid));
    std::unique_ptr<DistanceTransform> transform;
    const auto compute = [&] { transform->compute(grid, Job::band(grid), field.distance()); };
    job.measure(
        cost, [&] { return seconds_of(compute); },
        [&] {
            transform = std::make_unique<DistanceTransform>(job.device, job.mesh);
            return seconds_of(compute);
        });
    judge.look_at(field, job.options.samples_judged, cost);
    return cost;
}

/// The cost of more outputs, in a band of 10% on 256 samples a side: from the mesh's arrays, or on a kept transform.
CallCost measure_outputs(const Job& job, CallJudge& judge, bool is_kept) {
    const char* const what =
        "distance, offset to the closest point and gradient / the distance; a band of 10% on 256 samples on the "
        "longest side";
    CallCost cost{is_kept ? "outputs_again" : "outputs",
                  std::string(what) + (is_kept ? ", on a kept transform" : ", from the mesh's arrays")};
    if (!is_kept) cost.limit = 1.5;
    const Band wide = Band::symmetric(0.1 * job.mesh.box().longest_side());
    const Grid grid = Grid::around(job.mesh, job.scaled(256), wide);
    const DistanceTransform kept = job.transform();
    FieldWithOutputs outputs{kept.compute(grid, wide), {}, {}};
    Field alone = outputs.field;
    outputs.offset.resize(3 * grid.sample_count());
    outputs.gradient.resize(3 * grid.sample_count());
    const auto compute = [&](const OutputTargets& targets) {
        return seconds_of([&] {
            if (is_kept)
                kept.compute(grid, wide, targets);
            else
                job.transform().compute(grid, wide, targets);
        });
    };
    job.measure(
        cost, [&] { return compute(outputs.targets()); }, [&] { return compute(alone.distance()); });
    judge.look_at(outputs, job.options.samples_judged, cost);
    return cost;
}

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

CallCost measure_one_sample(const Job& job, CallJudge& judge) {
    CallCost cost{"one_sample",
                  "a grid of one sample, half of 64 in the band / a band of 10% on 256 samples on the "
                  "longest side, from the mesh's arrays"};
    cost.limit = 1.0 / 50;
    const Grid grid = job.grid(256);
    const DistanceTransform transform = job.transform();
    // Other samples each time, because the plans of earlier calls are kept.
    const Field field = transform.compute(grid, Job::band(grid));
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
                    seconds_of([&] { transform.compute(one, Job::band(grid), std::span(&distance, 1)); }));
            }
            return spread_of(seconds).median;
        },
        [&] { return seconds_of([&] { job.transform().compute(around, wide, whole.distance()); }); });
    for (const Index3& sample : samples)
        judge.look_at(transform.compute(grid.part(sample, {1, 1, 1}), Job::band(grid)), 1, cost);
    return cost;
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
        for (std::size_t n = 0; n < grids.size(); ++n) result.push_back({grids[n], Job::band(grids[n]), distances[n]});
        return result;
    }
};

/// Boxes, by a call each or in one call, beside levels that are computed whole, all with a transform that is new.
CallCost measure_boxes(const Job& job, CallJudge& judge, CallCost cost, Patches& patches, std::vector<Field>& levels,
                       bool in_one_call) {
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
        Field field({.grid = patches.grids[n], .band = Job::band(patches.grids[n]), .mesh_name = {}});
        std::ranges::copy(patches.distances[n], field.distance().begin());
        judge.look_at(field, std::max<std::size_t>(1, job.options.samples_judged / patches.grids.size()), cost);
    }
    return cost;
}

CallCost measure_patches(const Job& job, CallJudge& judge, bool in_one_call) {
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
        levels.push_back(job.transform().compute(grid, Job::band(grid)));
        patches.take(patches_of(levels.back(), 2));
    }
    patches.shuffle_and_keep(512, job.options.seed);
    return measure_boxes(job, judge, cost, patches, levels, in_one_call);
}

CallCost measure_band_boxes(const Job& job, CallJudge& judge) {
    CallCost cost{"band_boxes",
                  "all boxes of 16^3 samples of 512 a side that meet the band, 4096 at most, in one call / "
                  "the grid whole"};
    cost.limit = 1.5;
    const Grid grid = job.grid(512);
    std::vector<Field> level;
    level.push_back(job.transform().compute(grid, Job::band(grid)));
    Patches patches;
    patches.take(patches_of(level.front(), 0));
    patches.shuffle_and_keep(4096, job.options.seed);
    return measure_boxes(job, judge, cost, patches, level, true);
}

std::vector<Vec3> twisted(const Mesh& mesh) {
    std::vector<Vec3> positions = mesh.vertices();
    const double per_length = 0.2 / mesh.box().longest_side();
    for (Vec3& p : positions) {
        const double turn = per_length * p[0];
        p = {p[0], std::cos(turn) * p[1] - std::sin(turn) * p[2], std::sin(turn) * p[1] + std::cos(turn) * p[2]};
    }
    return positions;
}

CallCost measure_moved(const Job& job, const char* name, std::int64_t resolution) {
    CallCost cost{name, fmt::format("vertices move, and a field of {0} samples on the longest side / a transform is "
                                    "made, and its first field",
                                    resolution)};
    cost.limit = 0.5;
    const Mesh moved(twisted(job.mesh), job.mesh.triangles(), job.mesh.name());
    const Grid grid = job.grid(resolution);
    const Band band = Job::band(grid);
    Field field = job.transform().compute(grid, band);
    DistanceTransform transform = job.transform();
    job.measure(
        cost,
        [&] {
            transform.set_positions(job.mesh.vertices());
            transform.compute(grid, band, field.distance());
            return seconds_of([&] {
                transform.set_positions(moved.vertices());
                transform.compute(grid, band, field.distance());
            });
        },
        [&] {
            return seconds_of([&] { DistanceTransform(job.device, moved).compute(grid, band, field.distance()); });
        });
    CallJudge(moved, job.options.seed).look_at(transform.compute(grid, band), job.options.samples_judged, cost);
    return cost;
}

CallCost measure_moved_points(const Job& job) {
    CallCost cost{"moved_points", "vertices move, and a query of a million points / the same query without a move"};
    const Mesh moved(twisted(job.mesh), job.mesh.triangles(), job.mesh.name());
    const std::vector<Vec3> points = points_around(moved, job.is_quick ? 20'000 : 1'000'000, job.options.seed);
    std::vector<float> distance(points.size());
    const auto query = [&](const DistanceTransform& transform) {
        transform.query(points, std::numeric_limits<double>::infinity(), distance);
    };
    DistanceTransform transform = job.transform();
    const DistanceTransform kept(job.device, moved);
    // The first queries prepare the mesh: the tree, then the sides of faces.
    query(kept);
    query(kept);
    job.measure(
        cost,
        [&] {
            transform.set_positions(job.mesh.vertices());
            query(transform);
            return seconds_of([&] {
                transform.set_positions(moved.vertices());
                query(transform);
            });
        },
        [&] { return seconds_of([&] { query(kept); }); });
    // The results of the last call, after a move.
    CallJudge(moved, job.options.seed)
        .look_at(points, distance, moved.box().longest_side() / 256, job.options.samples_judged, cost);
    return cost;
}

/// Queries of one point, as a robot or a loop in Python asks them.
CallCost measure_one_point(const Job& job, CallJudge& judge, bool has_all_outputs) {
    CallCost cost{has_all_outputs ? "one_point_all_outputs" : "one_point",
                  fmt::format("a query of one point {}, a million of them (its ratio is the microseconds of one) / a "
                              "second",
                              has_all_outputs ? "with all outputs" : "for its distance")};
    cost.limit = has_all_outputs ? 40 : 20;
    const std::vector<Vec3> points = points_around(job.mesh, job.is_quick ? 1'000 : 20'000, job.options.seed);
    Field field;
    for (const OutputInfo& info : output_table()) field.resize(info.output, 1);
    std::vector<float> distance(points.size());
    const DistanceTransform transform = job.transform();
    const auto query = [&](std::size_t i) {
        OutputTargets targets = std::span(distance).subspan(i, 1);
        if (has_all_outputs) {
            targets = field.targets();
            targets[Output::distance] = std::span(distance).subspan(i, 1);
        }
        transform.query(std::span(points).subspan(i, 1), std::numeric_limits<double>::infinity(), targets);
    };
    query(0);  // builds the tree
    job.measure(
        cost,
        [&] {
            return 1e6 / static_cast<double>(points.size()) * seconds_of([&] {
                       for (std::size_t i = 0; i < points.size(); ++i) query(i);
                   });
        },
        [] { return 1.0; });
    judge.look_at(points, distance, job.mesh.box().longest_side() / 256, job.options.samples_judged, cost);
    return cost;
}

/// A mesh in memory of the device, and a field's distances there.
class DeviceArrays {
public:
    DeviceArrays(const Device& device, const Mesh& mesh, std::size_t samples)
        : context_(device.context(), true),
          queue_(device.queue(), true),
          vertices_(mesh.vertices().size()),
          faces_(mesh.triangles().size()),
          positions_(copied(mesh.vertices())),
          triangles_(copied(mesh.triangles())),
          distance_(context_, CL_MEM_READ_WRITE, samples * sizeof(float)) {}

    InputArray positions() const { return {positions_(), ElementType::float64, vertices_}; }
    MeshView mesh() const { return {positions(), InputArray(triangles_(), ElementType::uint32, faces_)}; }
    OutputArray distance() const { return OutputArray(distance_()); }
    void run(Plan& plan) const {
        cl_event done = nullptr;
        plan.enqueue(queue_(), distance_(), {}, &done);
        cl::Event(done).wait();
    }
    void read(Field& field) const {
        queue_.enqueueReadBuffer(distance_, CL_TRUE, 0, field.distance().size() * sizeof(float),
                                 field.distance().data());
    }
    void wait() const { queue_.finish(); }

private:
    template <typename Item>
    cl::Buffer copied(const std::vector<Item>& items) const {
        const cl::Buffer buffer(context_, CL_MEM_READ_WRITE, items.size() * sizeof(Item));
        queue_.enqueueWriteBuffer(buffer, CL_TRUE, 0, items.size() * sizeof(Item), items.data());
        return buffer;
    }

    cl::Context context_;
    cl::CommandQueue queue_;
    std::size_t vertices_, faces_;
    cl::Buffer positions_, triangles_, distance_;
};

CallCost measure_device_first(const Job& job, CallJudge& judge) {
    CallCost cost{
        "device_first",
        "a transform is made of a mesh in memory of the device, and its first field goes there; a band of 10% "
        "on 256 samples on the longest side / the same from and to memory of the host"};
    const Band wide = Band::symmetric(0.1 * job.mesh.box().longest_side());
    const Grid grid = Grid::around(job.mesh, job.scaled(256), wide);
    Field field = job.transform().compute(grid, wide);
    const DeviceArrays arrays(job.device, job.mesh, field.distance().size());
    job.measure(
        cost,
        [&] {
            return seconds_of([&] {
                DistanceTransform(job.device, arrays.mesh()).compute(grid, wide, arrays.distance());
                arrays.wait();
            });
        },
        [&] { return seconds_of([&] { job.transform().compute(grid, wide, field.distance()); }); });
    arrays.read(field);
    judge.look_at(field, job.options.samples_judged, cost);
    return cost;
}

/// A moved step into memory of the device; the positions come from there, too, or from the host.
CallCost measure_step(const Job& job, bool from_device) {
    CallCost cost{
        from_device ? "device_step" : "plan_update",
        fmt::format("vertices{} and a plan move, and a run of the plan, a field of 256 samples on the longest "
                    "side in device memory / vertices of the host move, and the field in host memory",
                    from_device ? " in device memory" : "")};
    const Mesh moved(twisted(job.mesh), job.mesh.triangles(), job.mesh.name());
    const Grid grid = job.grid(256);
    const Band band = Job::band(grid);
    Field field = job.transform().compute(grid, band);
    const DeviceArrays before(job.device, job.mesh, 1), after(job.device, moved, field.distance().size());
    DistanceTransform transform = from_device ? DistanceTransform(job.device, before.mesh()) : job.transform();
    DistanceTransform on_host = job.transform();
    Plan plan = transform.plan(grid, band);
    const auto run = [&](const Mesh& mesh, const DeviceArrays& arrays) {
        if (from_device)
            transform.set_positions(arrays.positions());
        else
            transform.set_positions(mesh.vertices());
        plan.update(transform);
        after.run(plan);
    };
    const auto compute = [&](const Mesh& mesh) {
        on_host.set_positions(mesh.vertices());
        on_host.compute(grid, band, field.distance());
    };
    job.measure(
        cost,
        [&] {
            run(job.mesh, before);
            return seconds_of([&] { run(moved, after); });
        },
        [&] {
            compute(job.mesh);
            return seconds_of([&] { compute(moved); });
        });
    after.read(field);
    CallJudge(moved, job.options.seed).look_at(field, job.options.samples_judged, cost);
    return cost;
}

CallCost measure_small_meshes(const Job& job) {
    CallCost cost{"small_meshes", "1000 transforms of 512 triangles, 32 samples a side each / one field of 256 a side"};
    const Mesh small = make_shape("sphere3");
    const Band band = Band::symmetric(0.2);
    const Grid grid = Grid::around(small, 32, band);
    const Grid large = job.grid(256);
    Field field = DistanceTransform(job.device, small).compute(grid, band);
    Field whole = job.transform().compute(large, Job::band(large));
    job.measure(
        cost,
        [&] {
            return seconds_of([&] {
                for (int n = 0; n < (job.is_quick ? 100 : 1000); ++n)
                    DistanceTransform(job.device, small).compute(grid, band, field.distance());
            });
        },
        [&] { return seconds_of([&] { job.transform().compute(large, Job::band(large), whole.distance()); }); });
    CallJudge(small, job.options.seed).look_at(field, job.options.samples_judged, cost);
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

CallCost measure_classify(const Job& job, CallJudge& judge) {
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

}  // namespace

std::vector<CallCost> measure_calls(const Mesh& mesh, const Device& device, const MeasureOptions& options,
                                    bool is_quick) {
    const Job job{mesh, device, options, is_quick};
    CallJudge judge(mesh, options.seed);
    return {measure_again(job, judge),
            measure_outputs(job, judge, false),
            measure_outputs(job, judge, true),
            measure_one_sample(job, judge),
            measure_one_point(job, judge, false),
            measure_one_point(job, judge, true),
            measure_patches(job, judge, false),
            measure_patches(job, judge, true),
            measure_band_boxes(job, judge),
            measure_moved(job, "moved", 256),
            measure_moved(job, "moved_128", 128),
            measure_moved_points(job),
            measure_step(job, false),
            measure_device_first(job, judge),
            measure_step(job, true),
            measure_classify(job, judge),
            measure_small_meshes(job)};
}

}  // namespace clsdf::bench
