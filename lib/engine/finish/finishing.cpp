#include "finish/finishing.hpp"

#include "core/parallel.hpp"
#include "device/buffer_pool.hpp"
#include "finish/sites.hpp"

#include <cmath>
#include <cstring>

namespace clsdf::engine {

device::BufferPool::Lease site_names(const DeviceTools& tools, const MeshTopology& topology,
                                     std::span<const std::uint32_t> numbers, std::span<const FacePiece> pieces) {
    const std::size_t count = topology.order.size();
    const std::size_t behind = pieces.empty() ? numbers.size_bytes() : pieces.size_bytes();
    const std::size_t rows = count + chunk_count(behind, sizeof(TriangleSites));
    device::HostFilling filling(tools.context, tools.pool, rows * sizeof(TriangleSites), "names of the sites");
    const std::span names(static_cast<TriangleSites*>(filling.memory()), count);
    // Triangles that fill up groups of records get no names.
    if (!topology.joined.empty()) std::memset(names.data(), 0, names.size_bytes());
    name_sites(topology, names);
    if (!pieces.empty()) {
        std::memcpy(names.data() + count, pieces.data(), pieces.size_bytes());
    } else if (!numbers.empty()) {
        for (TriangleSites& triangle : names)
            for (clsdf_uint32& lowest : triangle.triangle) lowest = numbers[lowest];
        std::memcpy(names.data() + count, numbers.data(), numbers.size_bytes());
    }
    return filling.finish();
}

device::BufferPool::Lease site_normals(const DeviceTools& tools, const Mesh& mesh, const SignSurface& surface,
                                       const MeshTopology& topology) {
    const std::size_t count = 18 * topology.order.size(), turned = surface.faces.size();
    device::HostFilling filling(tools.context, tools.pool, (count + turned) * sizeof(float),
                                "pseudonormals of the sites");
    auto* const normals = static_cast<float*>(filling.memory());
    make_pseudonormals(mesh, surface, topology, {normals, count});
    for (std::size_t face = 0; face < turned; ++face)
        normals[count + face] = static_cast<float>(surface.direction(face));
    return filling.finish();
}

Finishing::Finishing(const Grid& grid, const Band& band, const Layout& layout, std::shared_ptr<const DeviceSites> sites,
                     bool is_inside_out)
    : sites_(std::move(sites)) {
    finish_.unit = static_cast<double>(layout.unit);
    finish_.inside_fill = band.inside_value();
    finish_.outside_fill = std::abs(band.outside);
    finish_.least_inside = layout.least_inside;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        finish_.origin[axis] = grid.origin[axis];
        finish_.spacing[axis] = grid.spacing[axis];
        finish_.per_spacing[axis] = finish_.unit / grid.spacing[axis];
    }
    finish_.outward = is_inside_out ? -1.0F : 1.0F;
}

Finishing::Finishing(const LatticeView& lattice, std::shared_ptr<const DeviceSites> sites, bool is_inside_out)
    : sites_(std::move(sites)) {
    finish_.unit = lattice.unit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        finish_.origin[axis] = lattice.origin[axis];
        finish_.spacing[axis] = lattice.unit;
        finish_.per_spacing[axis] = 1;
    }
    finish_.outward = is_inside_out ? -1.0F : 1.0F;
}

Finish Finishing::finish(std::uint32_t wanted, std::uint32_t in_double) const {
    Finish finish = finish_;
    finish.wanted = wanted;
    finish.in_double = in_double;
    finish.renumbered = static_cast<clsdf_uint32>(sites_->renumbered);
    finish.pieces = static_cast<clsdf_uint32>(sites_->pieces);
    finish.turned = static_cast<clsdf_uint32>(sites_->turned);
    return finish;
}

cl_uint Finishing::set_arguments(cl::Kernel& kernel, cl_uint first, const OutputBuffers& outputs) const {
    const cl::Buffer& unused = outputs[Output::distance];
    const auto given = [&](const auto& lease) -> const cl::Buffer& { return lease ? **lease : unused; };
    std::uint32_t wanted = 0;
    cl_uint argument = first + 3;
    for (const OutputInfo& row : extra_outputs()) {
        const cl::Buffer& buffer = outputs[row.output];
        if (buffer() != nullptr) wanted |= bit_of(row);
        kernel.setArg(argument++, buffer() != nullptr ? buffer : unused);
    }
    kernel.setArg(first, finish(wanted, outputs.in_double));
    kernel.setArg(first + 1, given(sites_->names));
    kernel.setArg(first + 2, given(sites_->normals));
    return argument;
}

}  // namespace clsdf::engine
