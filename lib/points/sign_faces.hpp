#pragma once

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "point_order.h"
#include "tree/point_mesh.hpp"

#include <clsdf/topology.hpp>

#include <cstddef>

namespace clsdf::points {

/// The surface that decides the signs of points, for kernels that cross it (kernels/points/point_signs.cl), beside its
/// triangles. Positions are in units, from the origin of the caller's coordinates.
struct DeviceSignFaces {
    /// Whether the kernels' decisions are exact: each coordinate is 0, or of a size from 2^-300 to 2^300 units. If not,
    /// there is nothing else here.
    bool are_exact = false;
    SignFaces faces{};
    device::BufferPool::Lease positions;       ///< of the mesh
    device::BufferPool::Lease sign_positions;  ///< if the surface has others
    device::BufferPool::Lease counts;          ///< how often each face counts, if not always once
    device::BufferPool::Lease corners;         ///< of the open edges that count, loop after loop
    device::BufferPool::Lease begins;          ///< of the loops, and the end
    std::size_t corner_count = 0;

    std::size_t device_bytes() const {
        return positions.bytes() + sign_positions.bytes() + counts.bytes() + corners.bytes() + begins.bytes();
    }
};

/// Of faces that kernels have made. Throws Error(out_of_memory).
DeviceSignFaces make_sign_faces(const engine::DeviceTools& tools, const engine::PointFaces& mesh, SignRule rule);
/// boundary: the open edges that count, or null. Does not wait. Throws Error(out_of_memory).
DeviceSignFaces make_sign_faces(const engine::DeviceTools& tools, const engine::PointMesh& mesh, SignRule rule,
                                const OpenBoundary* boundary);

}  // namespace clsdf::points
