#pragma once

#include "binary_tree.h"
#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "tree/point_mesh.hpp"

#include <cstddef>
#include <memory>

/// The tree in which GPUs look for the nearest triangle of a point (kernels/tree/binary_tree.h), for the body by_group.
namespace clsdf::engine {

/// How the faces of a mesh are divided. It serves later positions, too; results do not depend on it.
struct DividedFaces {
    BinaryTree tree{};
    std::size_t node_count = 0;
    unsigned depth = 0;               ///< nodes between the root and a leaf, both ends included
    double area = 0;                  ///< FittedTree::area when the faces were divided
    device::BufferPool::Lease order;  ///< the face of each place
    device::BufferPool::Lease nodes;  ///< NodePlaces of each node; the root is the first

    std::size_t device_bytes() const { return order.bytes() + nodes.bytes(); }
};

/// The tree at the positions of PointFaces.
struct FittedTree {
    std::shared_ptr<const DividedFaces> divided;
    double area = 0;                  ///< half of the areas of all boxes, per square of the mesh's longest side
    device::BufferPool::Lease nodes;  ///< BinaryNode
    device::BufferPool::Lease faces;  ///< PlacedFace of each place

    std::size_t device_bytes() const { return nodes.bytes() + faces.bytes(); }
};

/// positions: Vec3 of each vertex. triangles: of each face, numbers of vertices. before: the division at earlier
/// positions of the same triangles, or null. The faces are divided anew if its boxes have become twice as large. Waits
/// once, for a number, if they are not. Throws Error(out_of_memory or device_failure).
FittedTree fitted_tree(const DeviceTools& tools, const PointFaces& mesh, const cl::Buffer& positions,
                       const cl::Buffer& triangles, std::shared_ptr<const DividedFaces> before);

/// Faces that kernels make, and their tree.
struct FacesAndTree {
    PointFaces faces;  ///< not usable if found.special is not 0: the host makes them then
    FittedTree tree;
};

/// before: as above. Waits once, for all that is found, if the faces are not divided anew. Throws
/// Error(invalid_argument, out_of_memory or device_failure).
FacesAndTree make_faces_and_tree(const DeviceTools& tools, const Box& box, const std::string& name,
                                 const GeometryOnDevice& geometry, std::shared_ptr<const DividedFaces> before);

}  // namespace clsdf::engine
