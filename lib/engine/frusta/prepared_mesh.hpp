#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <clsdf/tuning.hpp>

#include "device/buffer_pool.hpp"
#include "frusta/cluster_index.hpp"
#include "frusta/records.hpp"
#include "launch/device_tools.hpp"
#include "layout.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace clsdf::engine {

/// The limit of coordinates in a lattice's units: squares of distances stay far inside a float's range.
inline constexpr double farthest = 1e14;

/// Polyhedra on the device, as a lattice sees them: those of the whole mesh, or of what is near a box. Another method
/// may add to them.
struct PreparedMesh {
    device::BufferPool::Lease polyhedra;  ///< Polyhedron: faces in Morton order, in whole groups (the last face is
                                          ///< repeated), then point sites
    std::size_t record_count = 0;
    std::size_t triangle_count = 0;    ///< of the mesh
    std::size_t polyhedron_count = 0;  ///< of the whole mesh
    std::size_t saddle_vertices = 0;
    std::size_t point_sites = 0;
    std::size_t boxes = 0;
    bool from_kept_frusta = false;           ///< made by another kernel than those of the first call
    std::vector<MethodCount> method_counts;  ///< see TransformStatistics

    PreparedMesh() = default;
    PreparedMesh(PreparedMesh&&) = default;
    PreparedMesh& operator=(PreparedMesh&&) = default;
    virtual ~PreparedMesh() = default;

    virtual std::size_t device_bytes() const { return polyhedra.bytes(); }
};

/// The records of a lattice that a grid needs, if they are few: their groups (record_group), ascending.
struct RecordSelection {
    cl::Buffer groups;  ///< null: all records matter
    std::size_t group_count = 0;
};

/// Selects the records of `near` from those of `kept`, which contain them.
RecordSelection select_records(const device::Context& context, const NearRecords& kept, const NearRecords& near);

/// Sets the numbers that belong to the whole mesh.
void set_counts(std::size_t faces, const FoundFrusta& frusta, PreparedMesh& prepared);

/// The records of ranges of faces, each of which begins with a group (record_group), and of point sites, by
/// the host: for any lattice.
PreparedMesh records_by_host(const DeviceTools& tools, const MeshTopology& topology, const Frusta& frusta,
                             const LatticeView& lattice, std::span<const RecordRange> of_faces,
                             std::span<const RecordRange> of_sites);

/// box: of the mesh. Throws Error(invalid_argument) if squares of distances would leave a float's range.
void check_distance(const Box& box, const std::string& mesh_name, const LatticeView& lattice);

}  // namespace clsdf::engine
