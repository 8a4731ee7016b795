// A narrow band on a fine grid, without the rest of the grid: a file for renderers, and a level set whose band follows
// a body that moves. The bricks of a step that were bricks of the step before keep the simulation's own values.
//
// example_narrow_band [FILE.nvdb [RESOLUTION [STEPS]]]   2048 samples on the longest side take 0.7 GB of disk

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include "recorded.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace {

/// A simulation's values on the bricks of the band, here the number of steps for which a brick has been in it.
class Band {
public:
    struct Change {
        std::size_t kept = 0, entered = 0, left = 0;
    };

    /// Takes the bricks of the next step. Values of bricks that are still there stay, new bricks begin with 0.
    Change follow(const std::vector<clsdf::Index3>& bricks) {
        Change change;
        std::map<clsdf::Index3, int> next;
        for (const clsdf::Index3& brick : bricks) {
            const auto before = steps_.find(brick);
            next[brick] = before == steps_.end() ? 0 : before->second + 1;
            ++(before == steps_.end() ? change.entered : change.kept);
        }
        change.left = steps_.size() - change.kept;
        steps_ = std::move(next);
        return change;
    }

private:
    std::map<clsdf::Index3, int> steps_;
};

/// The volume inside: the samples of runs and, in bricks, a part of each sample that the surface crosses.
double volume(const clsdf::SparseField& field) {
    double samples = 0;
    for (const clsdf::BrickRun& run : field.inside)
        samples += static_cast<double>(run.count) * static_cast<double>(clsdf::brick_samples);
    for (const float d : field.distance())
        samples += std::clamp(0.5 - static_cast<double>(d) / field.grid.voxel(), 0.0, 1.0);
    const clsdf::Vec3& h = field.grid.spacing;
    return samples * h[0] * h[1] * h[2];
}

}  // namespace

int main(int argument_count, char** arguments) {
    try {
        const std::string path = argument_count > 1 ? arguments[1] : "example_narrow_band.nvdb";
        const std::int64_t resolution = argument_count > 2 ? std::atoll(arguments[2]) : 96;
        const int steps = argument_count > 3 ? std::atoi(arguments[3]) : 10;

        const clsdf::Mesh mesh = clsdf::make_shape("knot");
        const double reach = 0.75 * mesh.box().longest_side();
        clsdf::GridOptions options;
        options.resolution = resolution;
        const clsdf::Grid grid =
            clsdf::Grid::around(clsdf::Box{{-reach, -reach, -reach}, {reach, reach, reach}}, options);
        const clsdf::Band band = clsdf::Band::symmetric(3 * grid.voxel());
        clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);

        // The file: layer by layer, so neither the grid nor the band is ever whole in memory.
        clsdf::SparseFieldWriter writer(path, {grid, band, transform.sign(), "knot"});
        std::size_t bricks = 0;
        transform.compute_sparse(grid, band, {}, [&](const clsdf::SparseSlab& slab) {
            writer.append(slab);
            bricks += slab.bricks.size();
        });
        writer.finish();
        const double all = static_cast<double>(in_whole_bricks(grid).sample_count() / clsdf::brick_samples);
        std::printf("%s: %zu bricks, %.1f%% of the grid's; %.1f MB\n", path.c_str(), bricks,
                    100 * static_cast<double>(bricks) / all,
                    1e-6 * static_cast<double>(std::filesystem::file_size(path)));

        // The level set: the body turns, and its band with it.
        Band simulation;
        double first_volume = 0, largest_change = 0;
        for (int step = 0; step <= steps; ++step) {
            const double angle = 0.5 * std::numbers::pi * step / std::max(steps, 1);
            const double c = std::cos(angle), s = std::sin(angle);
            transform.set_motion({{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}, {0, 0, 0});
            const clsdf::SparseField field = transform.compute_sparse(grid, band);
            const Band::Change change = simulation.follow(field.bricks);
            if (step == 0) first_volume = volume(field);
            largest_change = std::max(largest_change, std::abs(volume(field) / first_volume - 1));
            if (step % 5 == 0) {
                record(field.distance());
                std::printf("step %d: %zu bricks kept, %zu entered the band, %zu left it\n", step, change.kept,
                            change.entered, change.left);
            }
        }
        std::printf("the volume changes by at most %.2f%%\n", 100 * largest_change);

        // A sample is looked up by its index on the lattice, in memory as in the file.
        const clsdf::SparseField read = clsdf::read_sparse_field(path).value();
        const clsdf::Index3 corner = grid.first;
        const bool is_outside = read.distance_at(corner) == static_cast<float>(band.outside);
        if (argument_count < 2) std::filesystem::remove(path);
        return is_outside && read.bricks.size() <= bricks && largest_change < 0.02 ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
