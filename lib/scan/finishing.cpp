#include "scan/finishing.hpp"

#include "core/parallel.hpp"
#include "core/per_output.hpp"
#include "polyhedra/sites.hpp"

#include <cstring>

namespace clsdf::scan {

namespace {

template <typename Value>
device::BufferPool::Lease upload(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                                 const UninitializedVector<Value>& values, const char* purpose) {
    const std::size_t bytes = values.size() * sizeof(Value);
    auto lease = pool->lease(bytes, purpose);
    if (bytes > 0)
        device::guarded([&] { context.queue().enqueueWriteBuffer(*lease, CL_TRUE, 0, bytes, values.data()); });
    return lease;
}

}  // namespace

DeviceSites upload_sites(device::Context& context, const std::shared_ptr<device::BufferPool>& pool, const Mesh& mesh,
                         bool with_normals, std::span<const std::uint32_t> numbers) {
    polyhedra::Sites sites = polyhedra::make_sites(mesh, with_normals);
    if (!numbers.empty()) {
        constexpr std::size_t of_entry = sizeof(TriangleSites) / sizeof(std::uint32_t);
        for (TriangleSites& triangle : sites.triangles)
            for (clsdf_uint32& lowest : triangle.triangle) lowest = numbers[lowest];
        sites.triangles.resize(numbers.size() + stretch_count(numbers.size(), of_entry));
        std::memcpy(&sites.triangles[numbers.size()], numbers.data(), numbers.size_bytes());
    }
    return {
        upload(context, pool, sites.triangles, "names of the sites"),
        with_normals ? upload(context, pool, sites.normals, "pseudonormals of the sites") : device::BufferPool::Lease(),
        sites.encloses_negative_volume, numbers.size()};
}

Finishing::Finishing(const Grid& grid, const Layout& layout, std::shared_ptr<const DeviceSites> sites,
                     bool is_inside_out)
    : sites_(std::move(sites)) {
    finish_.unit = static_cast<double>(layout.unit);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        finish_.origin[axis] = grid.origin[axis];
        finish_.spacing[axis] = grid.spacing[axis];
        finish_.per_spacing[axis] = finish_.unit / grid.spacing[axis];
    }
    finish_.outward = is_inside_out ? -1.0F : 1.0F;
}

Finishing::Finishing(const polyhedra::LatticeView& lattice, std::shared_ptr<const DeviceSites> sites,
                     bool is_inside_out)
    : sites_(std::move(sites)) {
    finish_.unit = lattice.unit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        finish_.origin[axis] = lattice.origin[axis];
        finish_.spacing[axis] = lattice.unit;
        finish_.per_spacing[axis] = 1;
    }
    finish_.outward = is_inside_out ? -1.0F : 1.0F;
}

void Finishing::set_arguments(cl::Kernel& kernel, cl_uint first, const OutputBuffers& outputs) const {
    Finish finish = finish_;
    finish.in_double = outputs.in_double;
    finish.renumbered = static_cast<clsdf_uint32>(sites_->renumbered);
    const cl::Buffer& unused = *sites_->triangles;
    cl_uint argument = first + 3;
    for_each_extra(
        [&](const OutputRow& row, const cl::Buffer& buffer) {
            if (buffer() != nullptr) finish.wanted |= row.bit;
            kernel.setArg(argument++, buffer() != nullptr ? buffer : unused);
        },
        outputs);
    kernel.setArg(first, finish);
    kernel.setArg(first + 1, *sites_->triangles);
    kernel.setArg(first + 2, sites_->normals.bytes() > 0 ? *sites_->normals : unused);
}

}  // namespace clsdf::scan
