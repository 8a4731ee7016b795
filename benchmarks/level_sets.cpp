// Level sets of a narrow band, by clsdf and by OpenVDB's meshToVolume, in turns: to memory and to files, each with the
// errors of its distances, held against the reference at the same random samples of the band. Prints a table.
//
// benchmark_level_sets [MESH [RESOLUTION [VOXELS [REPETITIONS]]]]

#include "benchmarks/cost.hpp"
#include "benchmarks/memory.hpp"
#include "benchmarks/meshes.hpp"
#include "benchmarks/peers/openvdb_headers.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/openvdb.hpp>
#include <clsdf/reference.hpp>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Problem {
    clsdf::Mesh mesh;
    clsdf::Grid grid;
    double voxels;
    clsdf::Device device;

    clsdf::Band band() const { return clsdf::Band::symmetric(voxels * grid.voxel()); }
};

/// A result in memory to be judged, or a file.
struct Result {
    openvdb::FloatGrid::Ptr grid;
    std::string file;
};

struct Method {
    std::string name;
    std::function<Result()> compute;
    std::vector<clsdf::bench::Cost> costs{};
    std::optional<std::size_t> peak{};
    Result result{};
};

openvdb::FloatGrid::Ptr mesh_to_volume(const Problem& problem) {
    const clsdf::Mesh& mesh = problem.mesh;
    std::vector<openvdb::Vec3d> points(mesh.vertices().size());
    std::vector<openvdb::Vec3I> triangles(mesh.triangles().size());
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t v) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            points[v][static_cast<int>(axis)] =
                (mesh.vertices()[v][axis] - problem.grid.origin[axis]) / problem.grid.spacing[axis];
    });
    tbb::parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t t) {
        const clsdf::Triangle& triangle = mesh.triangles()[t];
        triangles[t] = {triangle[0], triangle[1], triangle[2]};
    });
    const auto transform = openvdb::math::Transform::createLinearTransform(problem.grid.voxel());
    const auto width = static_cast<float>(problem.voxels);
    return openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3d, openvdb::Vec3I>(points, triangles), *transform,
        width, width);
}

Result to_file(const Problem& problem, const std::string& path) {
    const clsdf::DistanceTransform transform(problem.device, problem.mesh);
    clsdf::SparseFieldWriter writer(path, {problem.grid, problem.band(), transform.sign(), {}});
    transform.compute_sparse(problem.grid, problem.band(), {},
                             [&](const clsdf::SparseSlab& slab) { writer.append(slab); });
    writer.finish();
    return {nullptr, path};
}

struct Sample {
    openvdb::Coord at;
    double distance;
};

/// Random samples of the band by clsdf's level set, with their distances by the reference.
std::vector<Sample> choose_samples(const Problem& problem, const openvdb::FloatGrid& grid, std::size_t count) {
    std::vector<Sample> samples;
    std::mt19937_64 random(1);
    const auto every = std::max<std::uint64_t>(1, grid.activeVoxelCount() / count);
    for (auto value = grid.cbeginValueOn(); value; ++value)
        if (random() % every == 0) samples.push_back({value.getCoord(), 0});
    const clsdf::reference::Oracle oracle(problem.mesh);
    tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t n) {
        const openvdb::Coord& at = samples[n].at;
        const clsdf::Vec3 position = problem.grid.position(at[0] - problem.grid.first[0], at[1] - problem.grid.first[1],
                                                           at[2] - problem.grid.first[2]);
        const bool is_inside = oracle.winding_number(position).value_or(0) != 0;
        samples[n].distance = oracle.nearest(position).distance * (is_inside ? -1 : 1);
    });
    return samples;
}

struct Errors {
    double greatest = 0;  ///< in voxels, of those with the right sign that are in the band
    std::size_t wrong_signs = 0;
    std::size_t missed = 0;
};

Errors errors_of(const openvdb::FloatGrid& grid, const std::vector<Sample>& samples, double voxel) {
    Errors errors;
    const auto accessor = grid.getConstAccessor();
    for (const Sample& sample : samples) {
        const auto value = static_cast<double>(accessor.getValue(sample.at));
        if (!accessor.isValueOn(sample.at))
            ++errors.missed;
        else if (std::abs(sample.distance) > 1e-6 * voxel && std::signbit(value) != std::signbit(sample.distance))
            ++errors.wrong_signs;
        else
            errors.greatest = std::max(errors.greatest, std::abs(value - sample.distance) / voxel);
    }
    return errors;
}

double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
}

void print(const Method& method, const std::vector<Sample>& samples, double voxel) {
    std::vector<double> wall, processor;
    for (const clsdf::bench::Cost& cost : method.costs) {
        wall.push_back(cost.wall);
        processor.push_back(cost.processor);
    }
    const std::string file = method.result.file.empty()
                                 ? "-"
                                 : fmt::format("{:.0f}", 1e-6 * static_cast<double>(fs::file_size(method.result.file)));
    std::string errors = "| - | - | - |";
    if (method.result.grid) {
        const Errors found = errors_of(*method.result.grid, samples, voxel);
        errors = fmt::format("| {:.2g} | {} | {} |", found.greatest, found.wrong_signs, found.missed);
    }
    fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} | {} | {} {}\n", method.name, std::ranges::min(wall), median(wall),
               median(processor), method.peak ? fmt::format("{:.0f}", 1e-6 * static_cast<double>(*method.peak)) : "-",
               file, errors);
}

int run(const std::string& mesh_name, std::int64_t resolution, double voxels, std::size_t repetitions) {
    openvdb::initialize();
    clsdf::Mesh mesh = clsdf::bench::load_mesh(mesh_name, ".", 1);
    clsdf::GridOptions options;
    options.resolution = resolution;
    options.margin = clsdf::Length::in_voxels(voxels);
    const clsdf::Grid grid = clsdf::Grid::around(mesh.box(), options);
    const Problem problem{std::move(mesh), grid, voxels, clsdf::Device::automatic()};
    const fs::path folder = fs::current_path() / "level-sets";
    fs::create_directory(folder);
    const auto file = [&](const char* name) { return (folder / name).string(); };

    std::vector<Method> methods;
    methods.push_back({"clsdf to a FloatGrid", [&] {
                           const clsdf::DistanceTransform transform(problem.device, problem.mesh);
                           clsdf::LevelSetBuilder builder({problem.grid, problem.band(), transform.sign(), {}});
                           transform.compute_sparse(problem.grid, problem.band(), {},
                                                    [&](const clsdf::SparseSlab& slab) { builder.append(slab); });
                           return Result{builder.finish().distance, {}};
                       }});
    methods.push_back({"OpenVDB's meshToVolume", [&] { return Result{mesh_to_volume(problem), {}}; }});
    methods.push_back({"clsdf to bricks in memory", [&] {
                           const clsdf::DistanceTransform transform(problem.device, problem.mesh);
                           const clsdf::SparseField field = transform.compute_sparse(problem.grid, problem.band());
                           return Result{};
                       }});
    methods.push_back({"clsdf to .nvdb", [&] { return to_file(problem, file("clsdf.nvdb")); }});
    methods.push_back({"clsdf to .vdb", [&] { return to_file(problem, file("clsdf.vdb")); }});
    methods.push_back({"meshToVolume to .vdb", [&] {
                           openvdb::io::File archive(file("openvdb.vdb"));
                           archive.write({mesh_to_volume(problem)});
                           return Result{nullptr, file("openvdb.vdb")};
                       }});

    // A small grid of the same kind compiles the kernels.
    clsdf::Grid small = problem.grid;
    for (std::int64_t& size : small.size) size = std::min<std::int64_t>(size, 32);
    clsdf::DistanceTransform(problem.device, problem.mesh).compute_sparse(small, problem.band());
    for (std::size_t repetition = 0; repetition < repetitions; ++repetition)
        for (Method& method : methods) {
            method.result = {};
            const clsdf::bench::PeakMemory memory;
            const clsdf::bench::CostWatch watch;
            Result result = method.compute();
            method.costs.push_back(watch.cost());
            if (repetition == 0) method.peak = memory.growth();
            if (repetition + 1 == repetitions || !result.file.empty()) method.result = std::move(result);
        }

    const std::vector<Sample> samples = choose_samples(problem, *methods[0].result.grid, 20000);
    fmt::print(
        "{}: {} triangles; {} x {} x {} samples, a band of {} voxels; {} ({}), OpenVDB {}; errors at {} samples\n\n",
        clsdf::bench::short_name(mesh_name), problem.mesh.triangles().size(), grid.size[0], grid.size[1], grid.size[2],
        voxels, problem.device.name(), problem.device.platform(), openvdb::getLibraryVersionString(), samples.size());
    fmt::print(
        "| method | least, s | median | user + system | memory, MB | file, MB | max error, voxel | wrong signs | "
        "missed |\n|-|-|-|-|-|-|-|-|-|\n");
    for (const Method& method : methods) print(method, samples, problem.grid.voxel());
    fs::remove_all(folder);
    const Errors ours = errors_of(*methods[0].result.grid, samples, problem.grid.voxel());
    return ours.greatest < 1e-5 && ours.wrong_signs + ours.missed == 0 ? 0 : 1;
}

}  // namespace

int main(int argument_count, char** arguments) {
    try {
        const std::string mesh = argument_count > 1 ? arguments[1] : "sphere4";
        const std::int64_t resolution = argument_count > 2 ? std::atoll(arguments[2]) : 256;
        const double voxels = argument_count > 3 ? std::atof(arguments[3]) : 3;
        const int repetitions = argument_count > 4 ? std::atoi(arguments[4]) : 3;
        return run(mesh, resolution, voxels, static_cast<std::size_t>(std::max(1, repetitions)));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
