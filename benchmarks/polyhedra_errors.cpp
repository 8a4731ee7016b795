// The errors of Peikert & Sigg's polyhedra, measured on the device: fields of each mesh at three half widths, compared
// with the tree at random samples of the band. Prints the rows of docs/papers.md.

#include "options.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/papers.hpp>
#include <clsdf/reference.hpp>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace {

using clsdf::Field;
using clsdf::Polyhedra;
using clsdf::Scan;

/// A sample of the band, and its distance by the tree.
struct Sample {
    std::size_t at;
    double distance;
};

struct Errors {
    std::size_t wrong = 0;          ///< by more than a millionth of the mesh's longest side
    std::size_t without_value = 0;  ///< in no polyhedron of a triangle within the band
    double greatest = 0;            ///< of those with a value
};

clsdf::Mesh mesh_of(const std::string& name) {
    return std::filesystem::exists(name) ? clsdf::read_mesh(name) : clsdf::make_shape(name);
}

/// Random samples that are in the band by the default field and by the tree, or all of them.
std::vector<Sample> choose_samples(const clsdf::Mesh& mesh, const Field& field, std::size_t count, std::uint64_t seed) {
    std::vector<Sample> samples;
    for (std::size_t at = 0; at < field.distance().size(); ++at)
        if (std::abs(field.distance()[at]) < static_cast<float>(field.band.outside)) samples.push_back({at, 0});
    std::mt19937_64 random(seed);
    std::shuffle(samples.begin(), samples.end(), random);
    samples.resize(std::min(samples.size(), count));
    const clsdf::reference::Oracle oracle(mesh);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, samples.size(), 256), [&](const auto& range) {
        for (std::size_t n = range.begin(); n != range.end(); ++n) {
            const auto index = static_cast<std::int64_t>(samples[n].at);
            const auto& size = field.grid.size;
            samples[n].distance = oracle
                                      .nearest(field.grid.position(index % size[0], index / size[0] % size[1],
                                                                   index / (size[0] * size[1])))
                                      .distance;
        }
    });
    std::erase_if(samples, [&](const Sample& sample) { return sample.distance >= field.band.outside; });
    return samples;
}

Errors errors_of(const Field& field, const std::vector<Sample>& samples, double tolerance) {
    Errors errors;
    for (const Sample& sample : samples) {
        if (field.triangle()[sample.at] == clsdf::no_triangle) {
            // A distance of the half width, but for its rounding, may be beyond the band.
            errors.without_value += sample.distance < field.band.outside - tolerance;
            continue;
        }
        const double error = std::abs(std::abs(static_cast<double>(field.distance()[sample.at])) - sample.distance);
        errors.wrong += error > tolerance;
        errors.greatest = std::max(errors.greatest, error);
    }
    return errors;
}

}  // namespace

int main(int argc, char** argv) {
    Parser program("benchmark_polyhedra_errors", "Errors of Peikert & Sigg's polyhedra, as rows of a table");
    std::vector<std::string> meshes;
    std::int64_t resolution = 192;
    std::size_t sample_count = 100000;
    std::uint64_t seed = 1;
    program.add("MESH", meshes, "files, or names of shapes").required();
    program.add("--resolution", resolution, "samples on the longest side").takes("N");
    program.add("--samples", sample_count, "samples that are compared").takes("N");
    program.add("--seed", seed, "of the random choice of samples").takes("N");

    try {
        if (const auto page = program.parse(argc, argv)) {
            fmt::print("{}", *page);
            return 0;
        }
        const clsdf::Device device = clsdf::Device::automatic();
        for (const std::string& name : meshes) {
            const clsdf::Mesh mesh = mesh_of(name);
            const double extent = mesh.box().longest_side();
            for (const double share : {0.01, 0.03, 0.1}) {
                const clsdf::Band band = clsdf::Band::symmetric(share * extent);
                const clsdf::Grid grid = clsdf::Grid::around(mesh, resolution, band);
                const auto field_by = [&](Polyhedra polyhedra, Scan scan, bool close_gaps = true) {
                    return clsdf::make_transform(device, mesh,
                                                 {.polyhedra = polyhedra, .scan = scan, .close_gaps = close_gaps})
                        .compute(grid, band, clsdf::Output::triangle);
                };
                const Field bricks = field_by(Polyhedra::leaned, Scan::bricks);
                const std::vector<Sample> samples = choose_samples(mesh, bricks, sample_count, seed);
                const auto errors = [&](const Field& field) { return errors_of(field, samples, 1e-6 * extent); };
                const Errors paper = errors(field_by(Polyhedra::peikert_sigg, Scan::slices));
                const Errors open = errors(field_by(Polyhedra::peikert_sigg, Scan::slices, false));
                const Errors by_bricks = errors(bricks);
                const Errors by_slices = errors(field_by(Polyhedra::leaned, Scan::slices));
                const auto percent = [&](std::size_t part) {
                    return 100.0 * static_cast<double>(part) / static_cast<double>(samples.size());
                };
                const auto row = [&](const Errors& of_kind) {
                    return fmt::format("{:.3f} | {:.3f} | {:.2f}", percent(of_kind.without_value),
                                       percent(of_kind.wrong), of_kind.greatest / band.outside);
                };
                fmt::print("| {} | {}% | {} | {} | {} | {} | {} |\n", std::filesystem::path(name).stem().string(),
                           100 * share, samples.size(), row(open), row(paper),
                           by_bricks.wrong + by_bricks.without_value, by_slices.wrong + by_slices.without_value);
                std::fflush(stdout);
            }
        }
    } catch (const clsdf::Error& error) {
        fmt::print(stderr, "{}\n", error.what());
        return 1;
    }
    return 0;
}
