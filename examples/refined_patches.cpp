// Patches of three levels of refinement: the start of a level set, or the walls of an adaptive mesh (AMR). The
// transform says which patches the surface may cross: these are refined. Then one call computes the patches of all
// levels, ghost samples included.

#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <set>
#include <vector>

namespace {

using clsdf::Output;

constexpr std::int64_t side = 16, ghosts = 2, ratio = 2;

/// A patch of samples at the centres of cells, with its memory in the simulation.
struct Patch {
    clsdf::Index3 place{};  ///< in patches of its level
    clsdf::Grid grid;       ///< with its ghost samples
    std::vector<float> distance, gradient;
};

struct Level {
    clsdf::Grid lattice;
    std::vector<Patch> patches;
};

Level make_level(const clsdf::Grid& lattice, const std::set<clsdf::Index3>& places) {
    Level level{lattice, {}};
    for (const clsdf::Index3& place : places) {
        Patch& patch = level.patches.emplace_back();
        patch.place = place;
        patch.grid =
            lattice.block({place[0] * side, place[1] * side, place[2] * side}, {side, side, side}).grown(ghosts);
        patch.distance.resize(patch.grid.sample_count());
        patch.gradient.resize(3 * patch.grid.sample_count());
    }
    return level;
}

/// Computes the patches of all levels in one call. Each level has its own lattice and band.
void compute(const clsdf::DistanceTransform& transform, std::vector<Level>& levels) {
    std::vector<clsdf::Request> requests;
    for (Level& level : levels) {
        const clsdf::Band band = clsdf::Band::symmetric(4 * level.lattice.voxel());
        for (Patch& patch : level.patches)
            requests.push_back(
                {patch.grid, band, {{Output::distance, patch.distance}, {Output::gradient, patch.gradient}}});
    }
    transform.compute(requests);
}

/// The patches of the next level that lie within the given ones and that the surface may cross.
std::set<clsdf::Index3> next_places(const clsdf::DistanceTransform& transform, const clsdf::Grid& next,
                                    const std::set<clsdf::Index3>& places) {
    std::vector<clsdf::Index3> candidates;
    std::vector<clsdf::Box> boxes;
    for (const clsdf::Index3& place : places)
        for (std::int64_t n = 0; n < ratio * ratio * ratio; ++n) {
            const clsdf::Index3 finer{ratio * place[0] + n % ratio, ratio * place[1] + n / ratio % ratio,
                                      ratio * place[2] + n / (ratio * ratio)};
            candidates.push_back(finer);
            boxes.push_back(next.block({finer[0] * side, finer[1] * side, finer[2] * side}, {side, side, side}).box());
        }
    std::vector<clsdf::BoxPlace> answers(boxes.size());
    transform.classify(boxes, std::sqrt(0.75) * next.voxel(), answers);  // half the diagonal of a cell
    std::set<clsdf::Index3> near_surface;
    for (std::size_t n = 0; n < boxes.size(); ++n)
        if (answers[n] == clsdf::BoxPlace::within) near_surface.insert(candidates[n]);
    return near_surface;
}

/// The number of samples of the lattice that two patches share and that have different values in them.
std::size_t differences(const std::vector<Patch>& patches) {
    std::size_t count = 0;
    for (const Patch& patch : patches)
        for (const Patch& other : patches) {
            clsdf::Index3 begin{}, end{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                begin[axis] = std::max(patch.grid.first[axis], other.grid.first[axis]);
                end[axis] = std::min(patch.grid.first[axis], other.grid.first[axis]) + side + 2 * ghosts;
            }
            const auto value = [&](const Patch& of, std::int64_t i, std::int64_t j, std::int64_t k) {
                const clsdf::Index3& first = of.grid.first;
                return of.distance[of.grid.offset(i - first[0], j - first[1], k - first[2])];
            };
            for (std::int64_t k = begin[2]; k < end[2]; ++k)
                for (std::int64_t j = begin[1]; j < end[1]; ++j)
                    for (std::int64_t i = begin[0]; i < end[0]; ++i)
                        if (value(patch, i, j, k) != value(other, i, j, k)) ++count;
        }
    return count;
}

}  // namespace

int main() {
    try {
        const clsdf::Mesh mesh = clsdf::make_shape("knot");
        const clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);

        // The coarsest level covers the mesh.
        clsdf::Grid lattice = clsdf::Grid::around(mesh, 48, clsdf::Band::full()).cell_centred();
        std::set<clsdf::Index3> places;
        for (std::int64_t z = 0; z * side < lattice.size[2]; ++z)
            for (std::int64_t y = 0; y * side < lattice.size[1]; ++y)
                for (std::int64_t x = 0; x * side < lattice.size[0]; ++x) places.insert({x, y, z});

        std::vector<Level> levels;
        for (int number = 0; number < 3; ++number) {
            if (number > 0) {
                lattice = lattice.refined_cells(ratio);
                places = next_places(transform, lattice, places);
            }
            levels.push_back(make_level(lattice, places));
        }
        compute(transform, levels);
        for (const Level& level : levels)
            for (const Patch& patch : level.patches) {
                record(patch.distance);
                record(patch.gradient);
            }

        std::size_t different = 0;
        for (std::size_t number = 0; number < levels.size(); ++number) {
            const std::vector<Patch>& patches = levels[number].patches;
            const std::size_t of_level = differences(patches);
            std::printf(
                "level %zu: %zu patches of %lld^3 samples, ghost samples included; %zu of their shared samples "
                "differ\n",
                number, patches.size(), static_cast<long long>(side + 2 * ghosts), of_level);
            different += of_level;
        }
        return different == 0 ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
