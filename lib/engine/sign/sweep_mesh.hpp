#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "frusta/cluster_index.hpp"
#include "frusta/device_faces.hpp"
#include "frusta/homed_mesh.hpp"
#include "launch/device_tools.hpp"
#include "mesh/vertices.hpp"
#include "sign/film.hpp"
#include "surface/open_edges.hpp"
#include "surface/sign_surface.hpp"
#include "topology/topology.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>

namespace clsdf::engine {

/// A mesh on the device as the sweep for the sign sees it from one lattice: the same for all parts of a grid.
struct SweepMesh {
    device::BufferPool::Lease own_triangles;
    device::BufferPool::Lease vertices;  ///< SweepVertex, x counted from sample first_x
    std::size_t triangle_count = 0;
    int bits_y = 0;  ///< of a snapped vertex, below a sample
    int bits_z = 0;
    std::int32_t first_x = 0;  ///< a multiple of CLSDF_BRICK; not 0 only if the mesh is far from sample (0, 0, 0)

    /// Whose triangles are swept; null: own_triangles.
    std::shared_ptr<const NamedFaces> faces{};
    /// The open edges of the whole surface; null if there are none that count.
    std::shared_ptr<const LatticeBoundary> boundary{};

    const cl::Buffer& triangles() const;
    /// Bytes on the device that are its own.
    std::size_t device_bytes() const { return vertices.bytes() + own_triangles.bytes(); }
};

/// The triangles that rows of a part of the lattice can cross, if they are few.
struct SweepSelection {
    cl::Buffer triangles;  ///< their numbers; null: all of them
    std::size_t count = 0;
};

/// Selects from a mesh that make_sweep_mesh() made.
SweepSelection select_triangles(const device::Context& context, const NearRecords& near);

/// The mesh with the surface that decides its sign. Throws Error(unsupported) if it reaches farther from the grid's
/// origin than the sweep's integers. view: of the grid's lattice. `faces`: null if the host makes the vertices.
/// boundary: null unless open edges count. Mesh and topology come to the host if it makes triangles or vertices.
SweepMesh make_sweep_mesh(const DeviceSetUp& set_up, const Grid& grid, const LatticeView& view, HomedMesh& mesh,
                          const SignSurface& surface, const OpenBoundary* boundary, const DeviceFaces* faces);

/// Whether all of a mesh with this box lies near enough for the sweep's integers, and a part of it can be swept by
/// itself.
bool is_within_sweep(const Box& box, const Grid& grid, const LatticeView& view);

/// The faces that rows of a part of the lattice can cross, without the others, and all open edges. The sign has the
/// same bits.
SweepMesh near_sweep_mesh(const DeviceTools& tools, const Grid& grid, const LatticeView& view,
                          const PlacedVertices& mesh, const SignSurface& surface, const OpenBoundary* boundary,
                          const MeshTopology& topology, const std::vector<RecordRange>& faces);
/// The same by kernels, of a mesh that decides the sign and has no open edges that count. `near`: whole clusters.
SweepMesh near_sweep_mesh(const DeviceSetUp& set_up, const Grid& grid, const LatticeView& view, const Box& box,
                          const DeviceFaces& faces, const NearRecords& near);

}  // namespace clsdf::engine
