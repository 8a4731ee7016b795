#pragma once

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "tree/wide_tree.hpp"

#include <clsdf/topology.hpp>

#include <cstddef>
#include <memory>

namespace clsdf::points {

/// The sign on either side of each face, on the device: CLSDF_SIDES_ bits of kernels/tree/point_tree.h.
///
/// The segment from a point to its closest point meets no other face. So the sign of the point follows from the side
/// of its nearest face on which it lies. A face has known sides if all faces that share no vertex with it are farther
/// away than all rounding, and if it is not folded onto a neighbour. Then the front sides of neighbouring faces bound
/// one region, and the crossings of one point decide the sign of all these sides. docs/method.md, 'Sides of faces',
/// proves it.
struct FaceSides {
    device::BufferPool::Lease sides;
    std::size_t known = 0;  ///< faces whose sides are

    std::size_t device_bytes() const { return sides.bytes(); }
};

/// Whether they cost less than the crossings of so many points that are asked for.
bool are_sides_worthwhile(std::size_t points, std::size_t faces);

/// Throws Error(out_of_memory).
FaceSides find_face_sides(const engine::DeviceTools& tools, const engine::SearchedMesh& searched, SignRule rule);

}  // namespace clsdf::points
