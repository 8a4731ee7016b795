// The time of each stage when the ranks of an MPI program divide one domain: the mesh on all ranks, a transform, the
// field of a block with ghosts, new positions, boxes, points. Rank 0 prints a line for each stage, a name, a tab and
// the milliseconds of the slowest rank. scripts/bench-ranks makes a table of several numbers of ranks.
//
// mpirun -n 2 benchmark_ranks MESH [SAMPLES]    (a file, or the name of a shape)
#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <mpi.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr std::int64_t ghosts = 2;
constexpr std::size_t points_of_all = 1'000'000;
constexpr int repetitions = 5;

struct Ranks {
    int rank = 0, ranks = 1;
};

Ranks ranks_of(MPI_Comm comm) {
    Ranks found;
    MPI_Comm_rank(comm, &found.rank);
    MPI_Comm_size(comm, &found.ranks);
    return found;
}

Ranks ranks_of_node() {
    MPI_Comm node = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    const Ranks found = ranks_of(node);
    MPI_Comm_free(&node);
    return found;
}

void print(const char* name, double value) {
    if (ranks_of(MPI_COMM_WORLD).rank == 0) std::printf("%s\t%.1f\n", name, value);
}

double reduced(double own, MPI_Op operation) {
    double all = 0;
    MPI_Allreduce(&own, &all, 1, MPI_DOUBLE, operation, MPI_COMM_WORLD);
    return all;
}

/// The median time of the slowest rank, in milliseconds. All ranks begin together.
void measure(const char* name, int times, const std::function<void()>& work) {
    std::vector<double> milliseconds;
    for (int n = 0; n < times; ++n) {
        MPI_Barrier(MPI_COMM_WORLD);
        const double begin = MPI_Wtime();
        work();
        milliseconds.push_back(1e3 * reduced(MPI_Wtime() - begin, MPI_MAX));
    }
    std::sort(milliseconds.begin(), milliseconds.end());
    print(name, milliseconds[milliseconds.size() / 2]);
}

/// Read by rank 0, sent to all.
clsdf::Mesh read_and_send(const std::string& path) {
    std::vector<clsdf::Vec3> vertices;
    std::vector<clsdf::Triangle> triangles;
    if (ranks_of(MPI_COMM_WORLD).rank == 0) {
        const bool is_file = path.find('.') != std::string::npos;
        const clsdf::Mesh mesh = is_file ? clsdf::read_mesh(path) : clsdf::make_shape(path);
        vertices = mesh.vertices();
        triangles = mesh.triangles();
    }
    int sizes[2] = {static_cast<int>(vertices.size()), static_cast<int>(triangles.size())};
    MPI_Bcast(sizes, 2, MPI_INT, 0, MPI_COMM_WORLD);
    vertices.resize(static_cast<std::size_t>(sizes[0]));
    triangles.resize(static_cast<std::size_t>(sizes[1]));
    MPI_Bcast(vertices.data(), 3 * sizes[0], MPI_DOUBLE, 0, MPI_COMM_WORLD);
    MPI_Bcast(triangles.data(), 3 * sizes[1], MPI_UINT32_T, 0, MPI_COMM_WORLD);
    return clsdf::Mesh(std::move(vertices), std::move(triangles), path);
}

/// This rank's block of the lattice, without ghosts.
clsdf::Grid own_block(const clsdf::Grid& whole) {
    const Ranks world = ranks_of(MPI_COMM_WORLD);
    int blocks[3] = {0, 0, 0};
    MPI_Dims_create(world.ranks, 3, blocks);
    const int at[3] = {world.rank % blocks[0], world.rank / blocks[0] % blocks[1], world.rank / blocks[0] / blocks[1]};
    clsdf::Index3 first{}, size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        first[axis] = whole.size[axis] * at[axis] / blocks[axis];
        size[axis] = whole.size[axis] * (at[axis] + 1) / blocks[axis] - first[axis];
    }
    return whole.block(first, size);
}

/// Those of the points of all ranks that are in the cells of the block.
std::vector<clsdf::Vec3> own_points(const clsdf::Grid& whole, const clsdf::Grid& own) {
    const clsdf::Box box = whole.box();
    std::mt19937_64 random(1);
    std::vector<clsdf::Vec3> points;
    for (std::size_t n = 0; n < points_of_all; ++n) {
        clsdf::Vec3 point{};
        bool is_own = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double part = std::uniform_real_distribution<double>()(random);
            point.at(axis) = box.lower.at(axis) + part * (box.upper.at(axis) - box.lower.at(axis));
            const auto sample = static_cast<std::int64_t>(part * static_cast<double>(whole.size[axis]));
            is_own = is_own && sample >= own.first[axis] && sample < own.first[axis] + own.size[axis];
        }
        if (is_own) points.push_back(point);
    }
    return points;
}

/// Boxes of 8 x 8 x 8 cells that cover the block.
std::vector<clsdf::Box> own_boxes(const clsdf::Grid& whole, const clsdf::Grid& own) {
    constexpr std::int64_t side = 8;
    std::vector<clsdf::Box> boxes;
    for (std::int64_t z = 0; z < own.size[2]; z += side)
        for (std::int64_t y = 0; y < own.size[1]; y += side)
            for (std::int64_t x = 0; x < own.size[0]; x += side)
                boxes.push_back(
                    whole.block({own.first[0] + x, own.first[1] + y, own.first[2] + z}, {side + 1, side + 1, side + 1})
                        .box());
    return boxes;
}

void run(const std::string& path, std::int64_t samples) {
    const Ranks node = ranks_of_node();
    std::optional<clsdf::Mesh> mesh;
    measure("read the mesh on one rank and send it", 1, [&] { mesh.emplace(read_and_send(path)); });
    const auto device =
        clsdf::Device::of_rank(static_cast<std::size_t>(node.rank), static_cast<std::size_t>(node.ranks));
    std::optional<tbb::global_control> loops;
    if (device.info().kind == clsdf::DeviceKind::processor)
        loops.emplace(tbb::global_control::max_allowed_parallelism, std::max(1U, device.info().compute_units));

    const clsdf::Grid whole = clsdf::Grid::around(*mesh, samples, clsdf::Band::full());
    const clsdf::Band band = clsdf::Band::symmetric(3 * whole.voxel());
    const clsdf::Grid own = own_block(whole), part = own.grown(ghosts);
    std::optional<clsdf::DistanceTransform> transform;
    measure("new transform", 1, [&] { transform.emplace(device, *mesh); });
    std::vector<float> field(part.sample_count());
    measure("first field of the block and its ghosts", 1, [&] { transform->compute(part, band, field); });
    measure("the field again", repetitions, [&] { transform->compute(part, band, field); });
    measure("new positions of all vertices, and the field", repetitions, [&] {
        transform->set_positions(mesh->vertices());
        transform->compute(part, band, field);
    });
    const std::vector<clsdf::Box> boxes = own_boxes(whole, own);
    std::vector<clsdf::BoxPlace> places(boxes.size());
    measure("classify the boxes of the block", repetitions, [&] { transform->classify(boxes, 0, places); });
    const std::vector<clsdf::Vec3> points = own_points(whole, own);
    std::vector<float> distances(points.size());
    clsdf::OutputTargets targets;
    targets[clsdf::Output::distance] = distances;
    const double within = 0.1 * mesh->box().longest_side();
    measure("first query of the points in the block", 1, [&] { transform->query(points, within, targets); });
    measure("the query again", repetitions, [&] { transform->query(points, within, targets); });

    constexpr double mega = 1e-6;
    print("samples with ghosts, millions", mega * reduced(static_cast<double>(field.size()), MPI_SUM));
    print("kept by a rank beside the mesh, MB",
          mega *
              reduced(static_cast<double>(transform->memory().host_bytes + transform->memory().device_bytes), MPI_MAX));
    const auto negative = [](const std::vector<float>& values) {
        return static_cast<double>(std::count_if(values.begin(), values.end(), [](float value) { return value < 0; }));
    };
    print("points inside, to compare", reduced(negative(distances), MPI_SUM));
}

}  // namespace

int main(int argument_count, char** arguments) {
    MPI_Init(&argument_count, &arguments);
    try {
        if (argument_count < 2) throw std::runtime_error("usage: benchmark_ranks MESH [SAMPLES]");
        run(arguments[1], argument_count > 2 ? std::atoll(arguments[2]) : 256);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "rank %d: %s\n", ranks_of(MPI_COMM_WORLD).rank, error.what());
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    MPI_Finalize();
    return 0;
}
