#pragma once

#include "device/buffer_pool.hpp"
#include "papers/pieces.hpp"
#include "plan/field_method.hpp"

#include <clsdf/papers.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::papers {

/// The initial value of least distances and of nearest triangles.
inline constexpr cl_uint no_key = 0xFFFFFFFF;

inline std::size_t samples_of_slice(const Layout& layout) {
    return static_cast<std::size_t>(layout.size[0]) * static_cast<std::size_t>(layout.size[1]);
}

/// A buffer with the values.
device::BufferPool::Lease upload(const engine::KeptMesh& kept_mesh, const void* values, std::size_t bytes,
                                 const char* purpose);

/// The records of all faces, in the order of the mesh's topology.
UninitializedVector<Polyhedron> face_records(engine::KeptMesh& kept_mesh, const engine::LatticeView& lattice);

/// Throws Error(unsupported) that names the scan for any other output.
void check_distance_and_triangle(OutputSet outputs, const char* scan);

/// The slices of a piece, and its cost, as the host keeps them.
struct PieceSlices {
    std::int32_t begin = 0;
    std::int32_t end = 0;
    PieceCost cost;
};

/// A mesh's records and the convex pieces of its polyhedra, on the device.
struct PreparedPieces final : engine::PreparedMesh {
    device::BufferPool::Lease pieces;
    device::BufferPool::Lease planes;
    std::vector<PieceSlices> slices;  ///< of each piece

    std::size_t device_bytes() const override { return PreparedMesh::device_bytes() + pieces.bytes() + planes.bytes(); }
};

/// Slices that are computed together, because there is memory for their keys and active pieces.
struct SliceChunk {
    std::int32_t begin;  ///< slices [begin, end) of the lattice
    std::int32_t end;
    std::size_t active_begin;  ///< (piece, slice) in the order of slices: [active_begin, active_end)
    std::size_t active_end;
};

/// Entries [begin, end) of a chunk's active list, counted from its first.
struct SliceLaunch {
    std::size_t chunk;
    std::int32_t pass;
    std::size_t begin;
    std::size_t end;
    double fraction_before;  ///< of the work
};

struct SliceSchedule {
    std::vector<SliceChunk> chunks;
    std::vector<SliceLaunch> launches;  ///< of each chunk at least one a pass
    std::size_t most_slices = 0;        ///< of a chunk
    std::size_t most_active = 0;
};

struct SliceLimits {
    std::size_t slices_at_once;  ///< at least 1
    std::size_t active_at_once;  ///< a single slice may exceed it
    double cost_per_launch;      ///< in distances of a sample; a single piece may exceed it
    std::int32_t passes;
};

/// The cost of a piece in a slice; the unit is the distance of one sample.
double cost_of(const PieceCost& piece);

/// Divides slices [first, first + count) of the lattice.
SliceSchedule schedule_slices(std::span<const PieceSlices> pieces, std::int32_t first, std::int32_t count,
                              const SliceLimits& limits);

/// The options that the kernels of the scan are compiled with.
struct SliceVariant {
    engine::BrickVariant brick;  ///< the same options as there
    bool key_64 = false;         ///< distance and triangle in one 64-bit number
};

/// A group of `group` work-items takes `batch` intersections of a piece and a slice.
struct SliceShape {
    std::size_t group;
    std::size_t batch;
};
SliceShape slice_shape(KernelBody body);

/// The sum of counters, one for each slice. Blocks.
std::size_t sum_of(const device::Context& context, const device::BufferPool::Lease& counters, std::size_t count);

/// The program of the scan's three kernels.
device::ProgramSource slices_source(const engine::ProgramSources& programs, const SliceVariant& variant);
cl::Program slices_program(device::Context& context, const engine::ProgramSources& programs,
                           const SliceVariant& variant, const device::BuildWatch& watch = {});

/// Launches slices_finish, whose arguments are set, for so many slices.
void enqueue_finish(engine::CommandChain& chain, const device::LentKernel& kernel, const Layout& layout,
                    std::size_t slices);

/// Whether distance and triangle are one 64-bit number; without triangles the distances alone are the key, and 32 bits
/// are enough. Throws Error(unsupported) if the device has no 64-bit atomics and `asked` needs them.
bool takes_64_bits(const device::Context& context, const Layout& layout, bool with_triangle, SliceMinimum asked);

/// The scan by slices of PreparedPieces. Throws what takes_64_bits() does.
std::unique_ptr<engine::FieldScan> make_slice_scan(const engine::ScanInputs& inputs, SliceMinimum minimum);

/// The distance at every sample to every triangle, on the device: exact, and a time that grows with their product. It
/// gives the distance and the triangle.
std::shared_ptr<const FieldMethod> make_brute_force();

/// Null for leaned polyhedra by bricks, which are the core's own. Throws what resolve_scan() throws.
std::shared_ptr<const FieldMethod> method_of(const PapersOptions& options);

/// The program of the distances; slices_finish makes the outputs of them.
device::ProgramSource brute_force_source(const engine::ProgramSources& programs, const engine::BrickVariant& variant);

}  // namespace clsdf::papers
