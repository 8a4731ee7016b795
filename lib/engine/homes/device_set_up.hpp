#pragma once

#include "device/buffer_pool.hpp"
#include "launch/commands.hpp"
#include "launch/device_tools.hpp"
#include "launch/programs.hpp"

#include <cstddef>
#include <memory>

namespace clsdf::engine {

/// Who makes which part of a mesh, and where its arrays are. It follows from the device, the body of its kernels and
/// the sizes of the mesh.
struct SetUpWays {
    /// vertices, faces: of the mesh; 0 if only the device matters.
    explicit SetUpWays(const DeviceTools& tools, std::size_t vertices = 0, std::size_t faces = 0);

    /// Kernels use arrays of the host in place. Otherwise the device gets copies, and each vertex walks around its
    /// faces there.
    bool arrays_are_shared;
    /// Kernels make the topology from the caller's arrays; the host would take longer.
    bool topology_by_kernels;
    /// Kernels make slopes and records; the host does of larger meshes.
    bool frusta_by_kernels;
    /// Kernels make lists of a part of the records, or sweep a part of the triangles.
    bool selections_by_kernels;
    /// Faces of a work-item.
    std::size_t item_faces;
};

/// Makes data of a mesh on the device.
struct DeviceSetUp {
    explicit DeviceSetUp(const DeviceTools& tools_in) : tools(tools_in), ways(tools_in) {}
    DeviceSetUp(const DeviceTools& tools_in, const SetUpWays& ways_in) : tools(tools_in), ways(ways_in) {}

    DeviceTools tools;
    SetUpWays ways;

    /// The launch of a kernel for so many faces.
    WorkItems items_of(std::size_t faces) const {
        return {(faces + ways.item_faces - 1) / ways.item_faces, ways.item_faces == 1 ? common_group : 1};
    }

    /// A buffer in an array of the host; it has no bytes of its own. It keeps `owner` alive, which has the array.
    template <class Values>
    device::BufferPool::Lease shared(const std::shared_ptr<const void>& owner, const Values& values,
                                     cl_mem_flags access = CL_MEM_READ_ONLY) const {
        if (values.empty()) return {};
        const std::shared_ptr<const void> memory(owner, values.data());
        const std::size_t bytes = values.size() * sizeof(values[0]);
        return {device::guarded([&] { return device::buffer_in(tools.context, memory, bytes, access); }), memory.get()};
    }
    /// Copies values to the device, and does not wait.
    template <class Values>
    device::BufferPool::Lease upload(const Values& values, const char* purpose) const {
        return values.empty() ? device::BufferPool::Lease()
                              : device::uploaded(tools.context, tools.pool, values, purpose);
    }
    /// Values of `owner` that kernels read: the host's own if they are shared, else a copy.
    template <class Values>
    device::BufferPool::Lease input(const std::shared_ptr<const void>& owner, const Values& values,
                                    const char* purpose) const {
        return ways.arrays_are_shared ? shared(owner, values) : upload(values, purpose);
    }
};

}  // namespace clsdf::engine
