// The whole call, from arrays in memory to the finished field in memory, beside CGAL's AABB tree on the band's samples,
// and the error of the very field that was timed. Program built and buffers allocated; polyhedra and lists computed
// anew.

#include <clsdf/clsdf.hpp>
#include <clsdf/reference.hpp>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace {

double seconds_of(const auto& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

struct Spread {
    double least, median, most;
};

Spread spread_of(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return {values.front(), values[values.size() / 2], values.back()};
}

/// Unsigned distances of every `stride`-th band sample by the tree, all cores; scaled to all of them.
double tree_seconds(const clsdf::Mesh& mesh, const clsdf::Field& field, std::size_t stride, std::size_t& band_samples) {
    std::vector<std::size_t> band;
    for (std::size_t i = 0; i < field.distance.size(); ++i)
        if (std::abs(static_cast<double>(field.distance[i])) <
            static_cast<double>(static_cast<float>(field.band.outside)))
            band.push_back(i);
    band_samples = band.size();
    double sum = 0;
    const double build =
        seconds_of([&] { sum += clsdf::reference::Oracle(mesh).nearest(mesh.vertices()[0]).distance; });
    const clsdf::reference::Oracle oracle(mesh);
    const std::size_t count = band.size() / stride;
    const double queries = seconds_of([&] {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 256), [&](const auto& range) {
            for (std::size_t n = range.begin(); n != range.end(); ++n) {
                const auto index = static_cast<std::int64_t>(band[n * stride]);
                const auto& size = field.grid.size;
                oracle.nearest(
                    field.grid.position(index % size[0], index / size[0] % size[1], index / (size[0] * size[1])));
            }
        });
    });
    return build + queries * static_cast<double>(stride);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Times the whole call of clsdf beside CGAL's AABB tree, with the error in the same row.");
    std::string path;
    std::int64_t resolution = 256;
    std::string band_text = "10%";
    int repetitions = 9;
    std::size_t tree_stride = 20;
    bool cubic = false;
    app.add_option("mesh", path, "Mesh file")->required();
    app.add_option("--resolution", resolution, "Samples on the longest side");
    app.add_option("--band", band_text, "Half width, as in clsdf compute");
    app.add_option("--repetitions", repetitions, "Timed calls, after one to warm up")->check(CLI::PositiveNumber);
    app.add_option("--tree-stride", tree_stride, "Query the tree with every so many band samples; 0: not at all");
    app.add_flag("--cubic", cubic, "Every axis gets as many samples as the longest one");
    CLI11_PARSE(app, argc, argv);
    try {
        const clsdf::Mesh mesh = clsdf::read_mesh(path);
        const double extent = mesh.box().longest_side();
        const clsdf::Length length = clsdf::Length::parse(band_text);
        clsdf::GridOptions options;
        options.resolution = resolution;
        options.cubic = cubic;
        options.margin = length.is_infinite() ? clsdf::Length::of_extent(0.05) : length;
        const clsdf::Grid grid = clsdf::Grid::around(mesh.box(), options);
        const double half_width = length.resolve(grid.voxel(), extent);
        const clsdf::Band band = clsdf::Band::symmetric(half_width);

        const clsdf::Device device = clsdf::Device::best();
        clsdf::DistanceTransform transform(device, mesh);
        clsdf::Field field = transform(grid, band);
        std::vector<double> wall, polyhedra, lists, samples;
        for (int i = 0; i < repetitions; ++i) {
            wall.push_back(seconds_of([&] { transform.compute(grid, band, {field.distance, {}}); }));
            polyhedra.push_back(transform.statistics().polyhedra_seconds);
            lists.push_back(transform.statistics().lists_seconds);
            samples.push_back(transform.statistics().field_seconds);
        }
        const clsdf::reference::CheckReport check = clsdf::reference::check(mesh, field);
        const Spread s = spread_of(wall);
        fmt::print("{}: {} triangles, {} x {} x {} samples, half width {:.2f} voxels, on {}\n", path,
                   mesh.triangles().size(), grid.size[0], grid.size[1], grid.size[2], half_width / grid.voxel(),
                   device.name());
        fmt::print(
            "  clsdf       {:8.1f} ms  (median {:.1f}, most {:.1f}; of the medians: polyhedra {:.1f}, lists and sign "
            "{:.1f}, field {:.1f})\n",
            1e3 * s.least, 1e3 * s.median, 1e3 * s.most, 1e3 * spread_of(polyhedra).median,
            1e3 * spread_of(lists).median, 1e3 * spread_of(samples).median);
        fmt::print(
            "  its error   {:8.2g} voxel, {:.2f} ulp; wrong signs {}, missed {}, leaked {}, of {} samples checked\n",
            check.max_error_voxels, check.max_error_ulp, check.wrong_signs, check.missed, check.leaked, check.samples);
        if (tree_stride > 0) {
            std::size_t band_samples = 0;
            const double tree = tree_seconds(mesh, field, tree_stride, band_samples);
            fmt::print(
                "  AABB tree   {:8.0f} ms for the distances of the {} band samples, every {}th queried: {:.0f} times "
                "as long\n",
                1e3 * tree, band_samples, tree_stride, tree / s.median);
        }
        return check.passed() ? 0 : 1;
    } catch (const clsdf::Error& error) {
        fmt::print(stderr, "{}\n", error.what());
        return 2;
    }
}
