#pragma once

#include "core/uninitialized_vector.hpp"

#include <clsdf/mesh.hpp>

#include <cstdint>

namespace clsdf::polyhedra {

/// The triangles' indices by the Morton code of their centroids in the mesh's box (1024 cells along its longest side,
/// 256 for up to 131,072 triangles), equal codes by index. Neighbours in the list are neighbours in space, so the
/// device's caches are used well.
UninitializedVector<std::uint32_t> morton_order(const Mesh& mesh);

}  // namespace clsdf::polyhedra
