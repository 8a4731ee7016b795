#include "mesh/moved_mesh.hpp"

#include "core/parallel.hpp"

#include <utility>

namespace clsdf::detail {

/// Makes meshes of arrays that need no check.
struct MeshAccess {
    static Mesh make(std::vector<Vec3> vertices, SharedTriangles triangles, std::string name, const Box& box) {
        return {std::move(vertices), std::move(triangles), std::move(name), box};
    }
    static const SharedTriangles& triangles(const Mesh& mesh) { return mesh.triangles_; }
    static void set_box(Mesh& mesh, const Box& box) { mesh.box_ = box; }
};

}  // namespace clsdf::detail

namespace clsdf::engine {

using clsdf::detail::MeshAccess;

Mesh mesh_of(MeshArrays arrays, const Box& box, std::string name) {
    return MeshAccess::make(std::move(arrays.vertices), std::move(arrays.triangles), std::move(name), box);
}

Mesh with_box(Mesh mesh, const Box& box) {
    MeshAccess::set_box(mesh, box);
    return mesh;
}

Mesh moved(const Mesh& mesh, std::vector<Vec3> positions, const Box& box) {
    return MeshAccess::make(std::move(positions), MeshAccess::triangles(mesh), mesh.name(), box);
}

Mesh moved(const Mesh& mesh, std::vector<Vec3> positions, std::span<const std::uint32_t> used) {
    constexpr std::size_t grain = 4096;
    const bool has_all = positions.size() == mesh.vertices().size();
    const Extent all = reduce_ranges(
        has_all ? used.size() : 0, grain, Extent(),
        [&](std::size_t begin, std::size_t end, Extent extent) {
            for (std::size_t i = begin; i != end; ++i) extent.add(positions[used[i]]);
            return extent;
        },
        [](Extent a, const Extent& b) {
            a.add(b);
            return a;
        });
    if (has_all && all.is_finite()) return moved(mesh, std::move(positions), without_negative_zeros(all.box));
    Mesh refused = mesh;
    refused.set_positions(std::move(positions));  // finds what is wrong, and throws
    return refused;
}

}  // namespace clsdf::engine
