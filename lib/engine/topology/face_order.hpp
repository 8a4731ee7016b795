#pragma once

#include <clsdf/mesh.hpp>

#include "core/kept_array.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::engine {

/// The triangles' indices by the Morton code of their centroids in the mesh's box (1024 cells along its longest side,
/// 256 for up to 131,072 triangles), equal codes by index. Neighbours in the list are neighbours in space, so the
/// device's caches are used well.
UninitializedVector<std::uint32_t> morton_order(const Mesh& mesh);

/// The faces of a mesh in another order. Its vertices are numbered as those faces first name them, without unused ones,
/// so neighbours in one list are near each other in the others.
struct OrderedFaces {
    KeptArray<Triangle> triangles;
    KeptArray<std::uint32_t> vertices;  ///< the mesh's index of each
};

/// Bits of a cell's number on an axis of that order, a digit of a sort. Fewer bits suffice for few faces, and are
/// sorted faster.
constexpr unsigned morton_bits(std::size_t faces) {
    return faces <= std::size_t{1} << 17 ? 8 : 10;
}

/// `order`: the mesh's index of each face. Throws Error(unsupported) for 2^30 faces or more.
OrderedFaces ordered_faces(const Mesh& mesh, std::span<const std::uint32_t> order);

}  // namespace clsdf::engine
