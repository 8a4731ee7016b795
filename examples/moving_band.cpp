// A level set whose band follows a body that moves. The bricks near the surface, with their distances, are in arrays of
// the program, which grow when a step needs more room. Bricks have fixed places on the lattice, so a step finds what
// the step before had in the same brick: here the volume that the body has swept.
//
// example_moving_band [RESOLUTION]

#include <clsdf/clsdf.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <utility>
#include <vector>

namespace {

using clsdf::Index3;

/// A narrow band in arrays that are used again.
struct NarrowBand {
    std::vector<Index3> bricks;
    std::vector<clsdf::BrickRun> inside;
    std::vector<float> phi;  ///< 512 for each brick
    clsdf::SparseCounts counts;

    void compute(const clsdf::DistanceTransform& transform, const clsdf::Grid& grid, const clsdf::Band& band) {
        for (;;) {
            try {
                transform.compute_sparse(grid, band, {bricks, inside, phi}, counts);
                return;
            } catch (const clsdf::Error&) {
                if (counts.bricks <= bricks.size() && counts.runs <= inside.size()) throw;
                // A tenth more than this step needs, for those that follow.
                bricks.resize(counts.bricks + counts.bricks / 10);
                inside.resize(counts.runs + counts.runs / 10);
                phi.resize(bricks.size() * clsdf::brick_samples);
            }
        }
    }

    /// The field as the library looks samples up in it.
    clsdf::SparseSlab slab(const clsdf::Grid& grid) const {
        clsdf::SparseSlab slab{clsdf::in_whole_bricks(grid),
                               std::span(bricks).first(counts.bricks),
                               {},
                               std::span(inside).first(counts.runs)};
        slab.values.set(clsdf::Output::distance, std::span(phi).first(counts.bricks * clsdf::brick_samples));
        return slab;
    }
};

/// The samples that are inside now and were outside before. All lie near the surface of now: a step is shorter than the
/// band is wide.
std::size_t newly_inside(const clsdf::SparseSlab& now, const clsdf::SparseSlab& before, const clsdf::Band& band) {
    std::size_t count = 0;
    for (std::size_t n = 0; n < now.bricks.size(); ++n)
        for (std::size_t s = 0; s < clsdf::brick_samples; ++s) {
            if (!(now.values.distance()[n * clsdf::brick_samples + s] < 0)) continue;
            const auto at = static_cast<std::int64_t>(s);
            const Index3& first = now.bricks[n];
            const Index3 sample{first[0] + at % 8, first[1] + at / 8 % 8, first[2] + at / 64};
            if (!(before.distance_at(sample, band) < 0)) ++count;
        }
    return count;
}

}  // namespace

int main(int argument_count, char** arguments) {
    try {
        const std::int64_t resolution = argument_count > 1 ? std::atoll(arguments[1]) : 128;
        const clsdf::Mesh mesh = clsdf::make_shape("sphere5");  // of the radius 1
        const double side = 3, h = side / static_cast<double>(resolution);
        const clsdf::Grid grid{{-side / 2, -side / 2, -side / 2}, {h, h, h}, {resolution, resolution, resolution}};
        const clsdf::Band band = clsdf::Band::symmetric(3 * h);
        clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);

        NarrowBand now, before;
        std::size_t swept = 0;
        constexpr int steps = 6;
        now.compute(transform, grid, band);
        for (int step = 1; step <= steps; ++step) {
            std::swap(now, before);
            transform.set_motion({{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {1.7 * h * step, 0, 0});
            now.compute(transform, grid, band);
            const std::size_t count = newly_inside(now.slab(grid), before.slab(grid), band);
            std::printf("step %d: %zu bricks, room for %zu; %zu samples are inside that were not\n", step,
                        now.counts.bricks, now.bricks.size(), count);
            swept += count;
        }
        // Each step sweeps its length times the body's cross-section.
        const double expected = std::acos(-1.0) * 1.7 * h * steps, volume = static_cast<double>(swept) * h * h * h;
        std::printf("swept volume %.4f, expected %.4f\n", volume, expected);
        return std::abs(volume - expected) < 0.02 * expected ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
