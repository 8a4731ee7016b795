// One mesh on all ranks of a parallel program (MPI): rank 0 reads it and sends it. Ranks that hold another mesh are
// found out, each rank takes its share of the machine, one rank of a node compiles while the others wait, and an error
// on one rank ends all of them with a message. Then the same field by one prepared mesh that the ranks of a node share,
// and by parts that rank 0 prepares and sends, so that no other rank needs the mesh. docs/parallel.md explains all of
// it.
//
// mpirun -n 4 example_mesh_on_ranks [MESH [FAULT]]
//
// Without a file, the mesh is a knot. FAULT is for tests: what the last rank does, `throw`, `kill` or `other` (mesh).

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <mpi.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

struct Ranks {
    int rank = 0, ranks = 1;
};

Ranks ranks_of(MPI_Comm comm) {
    Ranks found;
    MPI_Comm_rank(comm, &found.rank);
    MPI_Comm_size(comm, &found.ranks);
    return found;
}

/// The processes of this machine.
Ranks ranks_of_node() {
    MPI_Comm node = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    const Ranks found = ranks_of(node);
    MPI_Comm_free(&node);
    return found;
}

/// All ranks have this error at once. Its text is empty on ranks that did not fail themselves.
struct FailureOnAll : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Does the work on every rank of the communicator, and waits for all of them. If it throws on one, this throws on all.
/// The work must not communicate: a rank that has failed does not answer.
template <typename Work>
void on_all(MPI_Comm comm, const Work& work) {
    int failed = 0;
    std::string message;
    try {
        work();
    } catch (const std::exception& error) {
        failed = 1;
        message = error.what();
    }
    MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, comm);
    if (failed != 0) throw FailureOnAll(message);
}

/// The file's mesh, read by rank 0 alone.
clsdf::Mesh read_and_send(MPI_Comm comm, const std::string& path) {
    std::optional<clsdf::Mesh> read;
    on_all(comm, [&] {
        if (ranks_of(comm).rank == 0) read = path == "knot" ? clsdf::make_shape(path) : clsdf::read_mesh(path);
    });
    std::vector<clsdf::Vec3> vertices;
    std::vector<clsdf::Triangle> triangles;
    if (read) vertices = read->vertices(), triangles = read->triangles();
    std::uint64_t sizes[2] = {vertices.size(), triangles.size()};
    MPI_Bcast(sizes, 2, MPI_UINT64_T, 0, comm);
    vertices.resize(sizes[0]);
    triangles.resize(sizes[1]);
    // A count of MPI is an int: triples, not numbers.
    MPI_Datatype vertex = MPI_DATATYPE_NULL, triangle = MPI_DATATYPE_NULL;
    MPI_Type_contiguous(3, MPI_DOUBLE, &vertex);
    MPI_Type_contiguous(3, MPI_UINT32_T, &triangle);
    MPI_Type_commit(&vertex);
    MPI_Type_commit(&triangle);
    MPI_Bcast(vertices.data(), static_cast<int>(sizes[0]), vertex, 0, comm);
    MPI_Bcast(triangles.data(), static_cast<int>(sizes[1]), triangle, 0, comm);
    MPI_Type_free(&vertex);
    MPI_Type_free(&triangle);
    return clsdf::Mesh(std::move(vertices), std::move(triangles), path);
}

/// Throws on all ranks if two of them have different meshes. One reduction: the largest of x and of -x - 1.
void check_is_the_same(MPI_Comm comm, const clsdf::Mesh& mesh) {
    std::uint64_t hashes[2] = {mesh.hash(), ~mesh.hash()};
    MPI_Allreduce(MPI_IN_PLACE, hashes, 2, MPI_UINT64_T, MPI_MAX, comm);
    if (hashes[0] != ~hashes[1])
        throw FailureOnAll(ranks_of(comm).rank == 0 ? mesh.name() + ": the ranks have different meshes" : "");
}

/// The bytes of the part of this rank's region, for DistanceTransform::from_part(). Rank 0 alone needs the transform.
std::vector<std::byte> part_of_rank(MPI_Comm comm, const clsdf::DistanceTransform* whole, const clsdf::Region& region) {
    constexpr std::size_t piece = std::size_t{1} << 30;  // a count of MPI is an int
    constexpr int bytes_of_region = sizeof(clsdf::Region);
    const Ranks own = ranks_of(comm);
    std::vector<clsdf::Region> regions(static_cast<std::size_t>(own.rank == 0 ? own.ranks : 0));
    MPI_Gather(&region, bytes_of_region, MPI_BYTE, regions.data(), bytes_of_region, MPI_BYTE, 0, comm);
    std::vector<std::byte> bytes;
    std::string message;
    // One part after the other is in memory, that of rank 0 last. After an error the others get none.
    for (int rank = own.ranks - 1; own.rank == 0 && rank >= 0; --rank) {
        try {
            bytes.clear();
            if (message.empty()) bytes = whole->restrict_to(regions[static_cast<std::size_t>(rank)]).part_bytes();
        } catch (const std::exception& error) {
            message = error.what();
        }
        if (rank == 0) break;
        std::uint64_t size = bytes.size();
        MPI_Send(&size, 1, MPI_UINT64_T, rank, 0, comm);
        for (std::size_t at = 0; at < size; at += piece)
            MPI_Send(bytes.data() + at, static_cast<int>(std::min(piece, size - at)), MPI_BYTE, rank, 0, comm);
    }
    if (own.rank > 0) {
        std::uint64_t size = 0;
        MPI_Recv(&size, 1, MPI_UINT64_T, 0, 0, comm, MPI_STATUS_IGNORE);
        bytes.resize(size);
        for (std::size_t at = 0; at < size; at += piece)
            MPI_Recv(bytes.data() + at, static_cast<int>(std::min(piece, size - at)), MPI_BYTE, 0, 0, comm,
                     MPI_STATUS_IGNORE);
    }
    on_all(comm, [&] {
        if (!message.empty()) throw std::runtime_error(message);
    });
    return bytes;
}

/// Memory that the ranks of this machine share: as many bytes as the first of them asks for, from a multiple of 64 on.
class NodeMemory {
public:
    explicit NodeMemory(std::size_t bytes) {
        constexpr std::size_t line = 64;
        MPI_Comm node = MPI_COMM_NULL;
        MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
        const auto own = static_cast<MPI_Aint>(ranks_of(node).rank == 0 ? bytes + line : 0);
        void* begin = nullptr;
        MPI_Win_allocate_shared(own, 1, MPI_INFO_NULL, node, &begin, &window_);
        MPI_Comm_free(&node);
        MPI_Aint size = 0;
        int unit = 0;
        MPI_Win_shared_query(window_, 0, &size, &unit, &begin);  // of the first rank
        const std::size_t past = reinterpret_cast<std::uintptr_t>(begin) % line;
        bytes_ = {static_cast<std::byte*>(begin) + (line - past) % line, static_cast<std::size_t>(size) - line};
    }
    ~NodeMemory() { MPI_Win_free(&window_); }
    NodeMemory(const NodeMemory&) = delete;
    NodeMemory& operator=(const NodeMemory&) = delete;

    std::span<std::byte> bytes() const { return bytes_; }
    /// On all ranks: what one has written before, the others read afterwards.
    void fence() const { MPI_Win_fence(0, window_); }

private:
    MPI_Win window_ = MPI_WIN_NULL;
    std::span<std::byte> bytes_;
};

/// Calls use(transform) on all ranks, with one prepared mesh for those of a node: that of `whole`, which the first rank
/// of each has, and which ends here. Returns its bytes. If a rank fails, all of them throw, for the end of the memory
/// needs them all.
template <class Use>
std::size_t with_shared_mesh(const clsdf::Device& device, std::optional<clsdf::DistanceTransform>& whole,
                             const Use& use) {
    std::size_t prepared = 0;
    on_all(MPI_COMM_WORLD, [&] {
        if (whole) prepared = whole->prepared_bytes();
    });
    const NodeMemory memory(prepared);
    on_all(MPI_COMM_WORLD, [&] {
        if (whole) whole->share(memory.bytes());
    });
    memory.fence();
    whole.reset();
    std::optional<clsdf::DistanceTransform> mine;  // ends before the memory
    on_all(MPI_COMM_WORLD, [&] { mine = clsdf::DistanceTransform::from_shared(device, memory.bytes()); });
    on_all(MPI_COMM_WORLD, [&] { use(*mine); });
    return memory.bytes().size();
}

/// For tests.
void fail(const std::string& fault, clsdf::Mesh& mesh) {
    if (fault == "throw") throw clsdf::Error(clsdf::ErrorCode::out_of_memory, "a failure of one rank");
    if (fault == "kill") std::raise(SIGKILL);
    if (fault == "other") {
        std::vector<clsdf::Vec3> vertices = mesh.vertices();
        vertices.back()[2] = std::nextafter(vertices.back()[2], 1e9);
        mesh.set_positions(std::move(vertices));
    }
}

void run(const std::string& path, const std::string& fault) {
    const Ranks world = ranks_of(MPI_COMM_WORLD), node = ranks_of_node();
    clsdf::Mesh mesh = read_and_send(MPI_COMM_WORLD, path);
    on_all(MPI_COMM_WORLD, [&] {
        if (world.rank == world.ranks - 1) fail(fault, mesh);
    });
    check_is_the_same(MPI_COMM_WORLD, mesh);

    // The share of this rank: of the device, and of the library's loops on the host.
    std::optional<clsdf::Device> device;
    on_all(MPI_COMM_WORLD, [&] {
        device = clsdf::Device::of_rank(static_cast<std::size_t>(node.rank), static_cast<std::size_t>(node.ranks));
    });
    const clsdf::DeviceInfo info = device->info();
    std::optional<tbb::global_control> loops;
    if (info.kind == clsdf::DeviceKind::processor)
        loops.emplace(tbb::global_control::max_allowed_parallelism, std::max(1U, info.compute_units));
    std::printf("rank %d is %d of %d on its node, with %u compute units of a %s\n", world.rank, node.rank, node.ranks,
                info.compute_units, clsdf::name_of(info.kind));

    // Every rank computes slices of its own.
    const clsdf::Grid whole = clsdf::Grid::around(mesh, 64, clsdf::Band::full());
    const std::int64_t begin = whole.size[2] * world.rank / world.ranks;
    const std::int64_t end = whole.size[2] * (world.rank + 1) / world.ranks;
    const clsdf::Grid part =
        whole.part({0, 0, begin}, {whole.size[0], whole.size[1], std::max<std::int64_t>(1, end - begin)});
    const clsdf::Band band = clsdf::Band::symmetric(3 * whole.voxel());
    std::optional<clsdf::DistanceTransform> transform;
    std::vector<float> distance(part.sample_count());

    // One rank of a node compiles. The others then find the programs in the driver's cache.
    on_all(MPI_COMM_WORLD, [&] {
        transform.emplace(*device, mesh);
        if (node.rank == 0) transform->compile(part, band);
    });
    on_all(MPI_COMM_WORLD, [&] { transform->compute(part, band, distance); });

    // One prepared mesh for all ranks of a node. Its first rank alone makes a transform of the mesh.
    if (node.rank != 0) transform.reset();
    std::vector<float> again(part.sample_count());
    const std::size_t shared = with_shared_mesh(
        *device, transform, [&](const clsdf::DistanceTransform& mine) { mine.compute(part, band, again); });
    on_all(MPI_COMM_WORLD, [&] {
        if (again != distance) throw std::runtime_error("the field of shared memory is not that of the mesh");
    });
    std::printf("rank %d: a prepared mesh of %zu bytes in memory of the node\n", world.rank, shared);

    // The same by a part of the mesh. A program whose ranks take parts makes a transform of the mesh on rank 0 alone.
    on_all(MPI_COMM_WORLD, [&] {
        if (world.rank == 0) transform.emplace(*device, mesh);
    });
    const clsdf::Region region{part.box(), band.outside, whole.voxel()};
    const std::vector<std::byte> bytes = part_of_rank(MPI_COMM_WORLD, transform ? &*transform : nullptr, region);
    transform.reset();
    on_all(MPI_COMM_WORLD, [&] {
        clsdf::DistanceTransform::from_part(*device, bytes).compute(part, band, again);
        if (again != distance) throw std::runtime_error("the field of the part is not that of the mesh");
    });
    std::printf("rank %d: a part of %zu bytes\n", world.rank, bytes.size());

    std::uint64_t inside = 0;
    if (end > begin)
        for (const float value : distance) inside += value < 0 ? 1 : 0;
    MPI_Allreduce(MPI_IN_PLACE, &inside, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    if (world.rank == 0)
        std::printf("mesh %016llx, %llu samples inside\n", static_cast<unsigned long long>(mesh.hash()),
                    static_cast<unsigned long long>(inside));
}

}  // namespace

int main(int argument_count, char** arguments) {
    MPI_Init(&argument_count, &arguments);
    int status = 0;
    try {
        run(argument_count > 1 ? arguments[1] : "knot", argument_count > 2 ? arguments[2] : "");
    } catch (const FailureOnAll& failure) {
        if (failure.what()[0] != 0)
            std::fprintf(stderr, "rank %d: %s\n", ranks_of(MPI_COMM_WORLD).rank, failure.what());
        status = 1;
    } catch (const std::exception& error) {
        // The others do not know of it: end them.
        std::fprintf(stderr, "rank %d: %s\n", ranks_of(MPI_COMM_WORLD).rank, error.what());
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    MPI_Finalize();
    return status;
}
