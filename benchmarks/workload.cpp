#include "benchmarks/workload.hpp"

#include "benchmarks/meshes.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace clsdf::bench {

namespace {

constexpr std::int64_t brick_side = 8;

/// The offsets of a brick's samples that have their distance, ordered so that each is next to the one before.
void append_brick(const Field& field, const Index3& brick, std::vector<std::uint32_t>& samples) {
    const auto limit = static_cast<float>(field.band.outside);
    Index3 first{}, last{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        first[axis] = brick[axis] * brick_side;
        last[axis] = std::min(first[axis] + brick_side, field.grid.size[axis]) - 1;
    }
    bool back_y = false, back_x = false;
    for (std::int64_t k = first[2]; k <= last[2]; ++k, back_y = !back_y)
        for (std::int64_t m = first[1]; m <= last[1]; ++m, back_x = !back_x)
            for (std::int64_t n = first[0]; n <= last[0]; ++n) {
                const std::int64_t j = back_y ? first[1] + last[1] - m : m;
                const std::int64_t i = back_x ? first[0] + last[0] - n : n;
                const std::size_t offset = field.grid.offset(i, j, k);
                if (std::abs(field.distance()[offset]) < limit) samples.push_back(static_cast<std::uint32_t>(offset));
            }
}

SampleList list_of(const Field& field) {
    const auto bricks = [&](std::size_t axis) { return (field.grid.size[axis] + brick_side - 1) / brick_side; };
    const auto layers = static_cast<std::size_t>(bricks(2));
    std::vector<SampleList> parts(layers);
    tbb::parallel_for(std::size_t{0}, layers, [&](std::size_t layer) {
        SampleList& part = parts[layer];
        for (std::int64_t y = 0; y < bricks(1); ++y)
            for (std::int64_t x = 0; x < bricks(0); ++x) {
                const std::size_t begin = part.samples.size();
                append_brick(field, {x, y, static_cast<std::int64_t>(layer)}, part.samples);
                if (part.samples.size() > begin) part.starts.push_back(begin);
            }
    });
    SampleList list;
    for (const SampleList& part : parts) {
        for (const std::size_t start : part.starts) list.starts.push_back(list.samples.size() + start);
        list.samples.insert(list.samples.end(), part.samples.begin(), part.samples.end());
    }
    list.starts.push_back(list.samples.size());
    return list;
}

}  // namespace

std::size_t SampleList::count(std::size_t stride) const {
    std::size_t sum = 0;
    for (std::size_t brick = 0; brick < bricks(); brick += stride) sum += starts[brick + 1] - starts[brick];
    return sum;
}

double mean_area_voxels(const Workload& workload) {
    const double voxel = workload.grid.voxel();
    return mean_triangle_area(workload.mesh) / (voxel * voxel);
}

const std::vector<Layout>& standard_layouts() {
    static const std::vector<Layout> layouts{{"W1", 256, Length::of_extent(0.1)},
                                             {"W2", 512, Length::in_voxels(3)},
                                             {"W3", 256, Length::infinite()},
                                             {"W4", 128, Length::infinite()}};
    return layouts;
}

Length margin_of(const Length& half_width) {
    return half_width.is_infinite() ? Length::of_extent(0.05) : half_width;
}

Workload make_workload(const Layout& layout, const std::string& mesh_name, const Mesh& mesh, const Device& device) {
    GridOptions options;
    options.resolution = layout.resolution;
    options.cubic = true;
    options.margin = margin_of(layout.half_width);
    Workload workload{layout.name, mesh_name, mesh, Grid::around(mesh.box(), options), {}, {}, {}, 0};
    const Grid& grid = workload.grid;
    if (grid.sample_count() > std::numeric_limits<std::uint32_t>::max())
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: a benchmark's grid has at most 2^32 samples, and {} x {} x {} are more",
                                layout.name, grid.size[0], grid.size[1], grid.size[2]));
    workload.band = Band::symmetric(layout.half_width.resolve(grid.voxel(), mesh.box().longest_side()));
    const Field field = DistanceTransform(device, mesh).compute(grid, workload.band);
    workload.sign = field.sign;
    workload.list = list_of(field);
    for (const std::uint32_t sample : workload.list.samples)
        workload.largest_distance =
            std::max(workload.largest_distance, static_cast<double>(std::abs(field.distance()[sample])));
    return workload;
}

}  // namespace clsdf::bench
