#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>

#include "core/outputs.hpp"
#include "device/buffer_pool.hpp"
#include "frusta/frames.hpp"
#include "launch/device_tools.hpp"
#include "layout.h"
#include "outputs.h"
#include "surface/sign_surface.hpp"
#include "topology/topology.hpp"

#include <cstdint>
#include <memory>
#include <span>

namespace clsdf::engine {

/// The buffers of a computation's outputs; null for outputs that are not asked for.
struct OutputBuffers : PerOutput<cl::Buffer> {
    std::uint32_t in_double = 0;  ///< bits of outputs (bit_of): the elements are doubles
    cl::Buffer listed{};          ///< the stored bricks of a sparse field (CLSDF_STORED); null: a dense field
};

/// Whether an output tells sites by their names.
inline bool names_sites(OutputSet outputs) {
    return (outputs.bits() & CLSDF_OUTPUTS_BY_NAME) != 0;
}

/// Whether an output takes pseudonormals.
inline bool takes_normals(OutputSet outputs) {
    return (outputs.bits() & CLSDF_OUTPUTS_BY_NORMAL) != 0;
}

/// The data of a mesh's sites on the device (finish/sites.hpp).
struct DeviceSites {
    std::shared_ptr<const device::BufferPool::Lease> names;    ///< null unless an output names sites
    std::shared_ptr<const device::BufferPool::Lease> normals;  ///< null unless pseudonormals are needed
    std::size_t renumbered = 0;  ///< of a part of a mesh: its triangles; behind `names` are their numbers in the whole
    std::size_t pieces = 0;      ///< triangles that are pieces of faces; behind `names` are these
    std::size_t turned = 0;      ///< triangles whose directions follow the normals; 0: all look to the front
};

/// numbers: of the triangles of a part of a mesh in the whole; empty for a whole mesh. pieces: of faces, that the
/// triangles are; empty if they are none, else the numbers do not count.
device::BufferPool::Lease site_names(const DeviceTools& tools, const MeshTopology& topology,
                                     std::span<const std::uint32_t> numbers, std::span<const FacePiece> pieces);
/// The pseudonormals and, if some faces are turned around for the sign, 1 or -1 for each triangle.
device::BufferPool::Lease site_normals(const DeviceTools& tools, const Mesh& mesh, const SignSurface& surface,
                                       const MeshTopology& topology);

/// The arguments with which brick kernels finish the samples of a grid (kernels/finish/finish.h).
class Finishing {
public:
    /// is_inside_out: the mesh is, and the field has a sign.
    Finishing(const Grid& grid, const Band& band, const Layout& layout, std::shared_ptr<const DeviceSites> sites,
              bool is_inside_out);

    /// For points, in units of a lattice.
    Finishing(const LatticeView& lattice, std::shared_ptr<const DeviceSites> sites, bool is_inside_out);

    /// The struct for kernels. wanted, in_double: bits of outputs (bit_of).
    Finish finish(std::uint32_t wanted, std::uint32_t in_double) const;

    /// The arguments of the macro FINISHING_PARAMETERS. Returns the number of the next one.
    cl_uint set_arguments(cl::Kernel& kernel, cl_uint first, const OutputBuffers& outputs) const;

    /// The distances in double beyond the band.
    double inside_fill() const { return finish_.inside_fill; }
    double outside_fill() const { return finish_.outside_fill; }

private:
    Finish finish_{};
    std::shared_ptr<const DeviceSites> sites_;
};

}  // namespace clsdf::engine
