// A grid is divided among the ranks of a parallel simulation. Each rank has a layer of ghost samples, and keeps only
// what its block needs of the mesh.
//
// A part of a grid keeps the origin and spacing of the grid, and has the same bytes as the whole. So ghost samples are
// equal on both sides and need no exchange. A transform that is restricted to the block gives these bytes, too.

#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <span>
#include <vector>

namespace {

/// The samples of one rank of `ranks` along x, with a ghost layer on each side that has a neighbour.
clsdf::Grid block_of(const clsdf::Grid& domain, std::int64_t rank, std::int64_t ranks) {
    constexpr std::int64_t ghosts = 2;
    const std::int64_t samples = domain.size[0];
    const std::int64_t begin = std::max<std::int64_t>(samples * rank / ranks - ghosts, 0);
    const std::int64_t end = std::min(samples * (rank + 1) / ranks + ghosts, samples);
    return domain.part({begin, 0, 0}, {end - begin, domain.size[1], domain.size[2]});
}

/// The transform of a rank, which ends with the part that its block needs.
clsdf::DistanceTransform transform_for(const clsdf::Grid& block, const clsdf::Band& band, const clsdf::Mesh& mesh) {
    const clsdf::DistanceTransform whole(clsdf::Device::automatic(), mesh);
    const double longest = *std::max_element(block.spacing.begin(), block.spacing.end());
    return whole.restrict_to({block.box(), band.widest(), longest});
}

/// The number of samples that differ between the block and the whole.
std::size_t differences(const clsdf::Grid& grid, std::span<const float> distance, const clsdf::Field& whole) {
    const std::int64_t shift = grid.first[0] - whole.grid.first[0];
    std::size_t count = 0;
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                const float& here = distance[grid.offset(i, j, k)];
                const float& there = whole.distance()[whole.grid.offset(i + shift, j, k)];
                count += std::memcmp(&here, &there, sizeof here) != 0 ? 1 : 0;
            }
    return count;
}

}  // namespace

int main() {
    try {
        const clsdf::Mesh mesh = clsdf::make_shape("knot");
        const clsdf::Band band = clsdf::Band::symmetric(0.03 * mesh.box().longest_side());
        const clsdf::Grid domain = clsdf::Grid::around(mesh, 100, band);

        // This example is one process; in a simulation every rank makes its own transform.
        const clsdf::DistanceTransform all(clsdf::Device::automatic(), mesh);
        const clsdf::Field whole = all.compute(domain, band);
        constexpr std::int64_t ranks = 3;
        std::size_t wrong = 0;
        for (std::int64_t rank = 0; rank < ranks; ++rank) {
            const clsdf::Grid block = block_of(domain, rank, ranks);
            const clsdf::DistanceTransform transform = transform_for(block, band, mesh);

            // Memory of the simulation.
            std::vector<float> distance(block.sample_count());
            transform.compute(block, band, distance);
            record(distance);

            const std::size_t different = differences(block, distance, whole);
            std::printf("rank %lld: samples %lld to %lld of x, %zu of them different from the whole's\n",
                        static_cast<long long>(rank), static_cast<long long>(block.first[0]),
                        static_cast<long long>(block.first[0] + block.size[0] - 1), different);
            wrong += different;
        }
        std::puts(wrong == 0 ? "as it should be" : "WRONG");
        return wrong == 0 ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
