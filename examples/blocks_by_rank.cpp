// Blocks of an adaptive mesh, dealt out to the ranks of a parallel simulation (MPI). Each rank keeps only the part of
// the surface that its blocks need, and its share of the node's cores. It computes its own blocks, ghost samples
// included, and no rank asks another. The bytes of a block do not depend on the rank or on their number: the sum of all
// blocks' hashes is the same for 1, 2 and 7 ranks.
//
// mpirun -n 2 example_blocks_by_rank [RESOLUTION]

#include <clsdf/clsdf.hpp>

#include <mpi.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace {

constexpr std::int64_t side = 16, ghosts = 2;

/// This rank's share of its machine. The library's own loops on the host are oneTBB's: a program that links oneTBB
/// limits them with tbb::global_control.
clsdf::Device device_of_rank() {
    MPI_Comm node = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    int rank = 0, ranks = 1;
    MPI_Comm_rank(node, &rank);
    MPI_Comm_size(node, &ranks);
    MPI_Comm_free(&node);
    return clsdf::Device::of_rank(static_cast<std::size_t>(rank), static_cast<std::size_t>(ranks));
}

/// All blocks of the domain that hold samples near the surface, in the same order on every rank.
std::vector<clsdf::Grid> blocks_near(const clsdf::DistanceTransform& transform, const clsdf::Grid& domain,
                                     const clsdf::Band& band) {
    std::vector<clsdf::Grid> blocks;
    std::vector<clsdf::Box> boxes;
    for (std::int64_t z = 0; z < domain.size[2]; z += side)
        for (std::int64_t y = 0; y < domain.size[1]; y += side)
            for (std::int64_t x = 0; x < domain.size[0]; x += side) {
                blocks.push_back(domain.block({x, y, z}, {side, side, side}).grown(ghosts));
                boxes.push_back(blocks.back().box());
            }
    std::vector<clsdf::BoxPlace> places(boxes.size());
    transform.classify(boxes, band.outside, places);
    std::vector<clsdf::Grid> near_surface;
    for (std::size_t n = 0; n < blocks.size(); ++n)
        if (places[n] == clsdf::BoxPlace::within) near_surface.push_back(blocks[n]);
    return near_surface;
}

/// FNV-1a of a block's place and bytes.
std::uint64_t hash_of(const clsdf::Grid& block, std::span<const float> distance) {
    std::uint64_t hash = 0xcbf29ce484222325U;
    const auto add = [&](std::span<const std::byte> bytes) {
        for (const std::byte byte : bytes) hash = (hash ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3U;
    };
    add(std::as_bytes(std::span(block.first)));
    add(std::as_bytes(distance));
    return hash;
}

}  // namespace

int main(int argument_count, char** arguments) {
    MPI_Init(&argument_count, &arguments);
    int rank = 0, ranks = 1, status = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    try {
        const std::int64_t resolution = argument_count > 1 ? std::atoll(arguments[1]) : 96;
        const clsdf::Mesh mesh = clsdf::make_shape("knot");
        const clsdf::Grid domain = clsdf::Grid::around(mesh, resolution, clsdf::Band::full());
        const clsdf::Band band = clsdf::Band::symmetric(3 * domain.voxel());
        std::optional<clsdf::DistanceTransform> whole(std::in_place, device_of_rank(), mesh);

        // Consecutive blocks are near each other: each rank takes a sub-range of them.
        const std::vector<clsdf::Grid> all = blocks_near(*whole, domain, band);
        const std::size_t begin = all.size() * static_cast<std::size_t>(rank) / static_cast<std::size_t>(ranks);
        const std::size_t end = all.size() * static_cast<std::size_t>(rank + 1) / static_cast<std::size_t>(ranks);
        const std::span<const clsdf::Grid> own = std::span(all).subspan(begin, end - begin);

        std::vector<std::vector<float>> distances(own.size());
        if (!own.empty()) {
            // The part of the mesh that the rank's blocks need. The rest ends with the whole transform.
            std::vector<clsdf::Region> regions;
            for (const clsdf::Grid& block : own) regions.push_back({block.box(), band.widest(), domain.voxel()});
            const clsdf::DistanceTransform part = whole->restrict_to(regions);
            whole.reset();
            std::vector<clsdf::Request> requests;
            for (std::size_t n = 0; n < own.size(); ++n) {
                distances[n].resize(own[n].sample_count());
                requests.push_back({own[n], band, distances[n]});
            }
            part.compute(requests);
        }

        std::uint64_t sum = 0, total = 0;
        for (std::size_t n = 0; n < own.size(); ++n) sum += hash_of(own[n], distances[n]);
        MPI_Reduce(&sum, &total, 1, MPI_UINT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
        if (rank == 0)
            std::printf("%zu blocks of all ranks: hash %016llx\n", all.size(), static_cast<unsigned long long>(total));
        status = all.empty() ? 1 : 0;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "rank %d: %s\n", rank, error.what());
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    MPI_Finalize();
    return status;
}
