#pragma once

#include <clsdf/fractions.hpp>

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "launch/launches.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/radix_sort.hpp"
#include "topology/device_topology.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace clsdf {

struct CutGrid;

}  // namespace clsdf

namespace clsdf::cutting {

/// The programs of cut cells and of their way to the caller's arrays. Throw Error(device_failure) with the build log.
std::vector<cl::Program> fraction_programs(const engine::DeviceTools& tools, const device::BuildWatch& watch = {});

/// What a run has found, as it is on the device: kernels/cutting/cut_grid.h. The first two are a DeviceFractionCount.
struct FoundCells {
    std::uint64_t rows = 0, is_complete = 0;
    std::uint64_t items = 0, records = 0;
    std::uint32_t item_limit = 0, record_limit = 0, row_limit = 0, far_vertex = 0;
};

/// How numbers of rows are written. The values are those of kernels/cutting/cut_grid.h.
enum class StoredNumbers : std::int32_t { words = 0, doubles = 1, floats = 2 };

/// Where rows go in a buffer of the caller's: a member of each, or which cells are full. Strides are bytes.
struct StoredCells {
    cl_mem memory = nullptr;
    std::size_t first = 0;  ///< byte of the first item
    std::ptrdiff_t stride = 0;
    std::ptrdiff_t component_stride = 0;
    int components = 1;
    std::size_t member = 0;  ///< its byte in a CellFraction
    StoredNumbers numbers = StoredNumbers::doubles;
};

/// The cells of a grid that a surface meets, found by kernels (kernels/cutting/cut_cells.cl): the rows of Slab, with
/// the same bytes. The stages follow one another; each needs its memory. All enqueue and do not wait, but for read()
/// and the constructor. Of tools there may be others of the same device and body each time. For one thread at a time.
class DeviceFractions {
public:
    using Lease = device::BufferPool::Lease;

    /// Of layers of triangles, and of triangles in cells.
    static constexpr std::size_t most_numbers = std::numeric_limits<cl_uint>::max() - 4096;
    /// Whether 32 bits number what the surface leaves in the grid.
    static bool can_number(const Mesh& mesh, const Grid& grid);

    /// Uploads the triangles. Throws Error(out_of_memory or device_failure).
    DeviceFractions(const engine::DeviceTools& tools, const Mesh& mesh, const Grid& grid,
                    const FractionOptions& options, bool with_pieces);
    DeviceFractions(DeviceFractions&&) noexcept;
    DeviceFractions& operator=(DeviceFractions&&) noexcept;
    ~DeviceFractions();

    /// The layers of faces. vertices: as many as the mesh has, in units of the mesh.
    void enqueue_layers(const engine::DeviceTools& tools, const engine::Launches& launches,
                        const engine::DeviceTriples& vertices);
    void make_item_room(const engine::DeviceTools& tools, std::size_t items);
    void enqueue_record_counts(const engine::DeviceTools& tools, const engine::Launches& launches);
    void make_record_room(const engine::DeviceTools& tools, std::size_t records);
    void enqueue_records(const engine::DeviceTools& tools, const engine::Launches& launches);
    /// Without room for rows they are counted alone.
    void make_row_room(const engine::DeviceTools& tools, std::size_t rows);
    /// asked: the most rows of a complete result.
    void enqueue_rows(const engine::DeviceTools& tools, const engine::Launches& launches, std::size_t asked);

    /// All stages for the present room, which there must be.
    void enqueue_all(const engine::DeviceTools& tools, const engine::Launches& launches,
                     const engine::DeviceTriples& vertices, std::size_t asked);
    /// The stages one after another, with the room that they turn out to need; waits for each. most: makes room for no
    /// more rows. between: called between stages with the fraction done; may throw. False: a vertex is too far away.
    bool run_and_make_room(const engine::DeviceTools& tools, const engine::DeviceTriples& vertices, std::size_t most,
                           const std::function<void(double)>& between);

    /// What the stages so far have found; waits.
    FoundCells read(const engine::DeviceTools& tools) const;
    const cl::Buffer& counts() const { return *counts_; }
    const cl::Buffer& rows() const { return *rows_; }

    void enqueue_store(const engine::DeviceTools& tools, const engine::Launches& launches, const StoredCells& to) const;
    void enqueue_store_full(const engine::DeviceTools& tools, const engine::Launches& launches,
                            const StoredCells& to) const;

    std::size_t item_room() const { return item_room_; }
    std::size_t record_room() const { return record_room_; }
    std::size_t row_room() const { return row_room_; }
    std::size_t vertex_count() const { return vertices_; }
    std::size_t device_bytes() const;

private:
    std::unique_ptr<CutGrid> grid_;
    std::size_t faces_, vertices_;
    bool with_pieces_;
    std::size_t item_room_ = 0, record_room_ = 0, row_room_ = 0;
    Lease triangles_, next_of_edge_, counts_;
    Lease positions_, layers_, layer_starts_;  ///< positions: in cells of the lattice
    Lease item_records_, record_starts_;
    Lease keys_, key_copies_, words_, order_, sorted_words_, heads_, ways_, row_starts_, way_sums_;
    Lease row_firsts_, rows_;
    std::optional<engine::SumLaunches> layer_sums_, record_sums_, head_sums_, sums_of_ways_;
    std::optional<engine::SortMemory> sort_;
};

/// Vertices of a mesh in memory of the device.
engine::DeviceTriples device_vertices(const cl::Buffer& packed, std::size_t count);
/// The same of an array that has been checked. Throws cl::Error.
engine::DeviceTriples given_vertices(const InputArray& vertices);

}  // namespace clsdf::cutting
