#pragma once

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "points/sign_faces.hpp"
#include "tree/binary_tree.hpp"
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
    /// If kernels have found them: the pseudonormals of the sites that tell the side, as site_normals(); else null.
    std::shared_ptr<const device::BufferPool::Lease> normals{};

    std::size_t device_bytes() const { return sides.bytes() + (normals ? normals->bytes() : 0); }
};

/// Whether they cost less than the crossings of so many points that are asked for.
bool are_sides_worthwhile(std::size_t points, std::size_t faces);

/// By kernels, without a wait, of faces that kernels have made. tree: of the same positions. surface: is exact; its
/// rule is that of the sides. Throws Error(out_of_memory).
FaceSides find_face_sides(const engine::DeviceTools& tools, const engine::PointFaces& mesh,
                          const engine::FittedTree& tree, const DeviceSignFaces& surface);

/// The same by the host. Throws Error(out_of_memory).
FaceSides find_face_sides(const engine::DeviceTools& tools, const engine::SearchedMesh& searched, SignRule rule);

}  // namespace clsdf::points
