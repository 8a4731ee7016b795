#pragma once

#include "core/kept_array.hpp"
#include "outputs.h"
#include "plan/kept_mesh.hpp"
#include "plan/region_part.hpp"
#include "plan/stored_values.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace clsdf::engine {

/// What a KeptMesh of a whole mesh keeps, but for lattices, as the members of an archive. Large arrays are borrowed:
/// from the KeptMesh, to write them, or from the memory that they are read from.
class StoredMesh {
public:
    StoredMesh() = default;
    /// Makes what is not made yet. The vertices must not have moved. kept_mesh must outlive it. Throws Error.
    StoredMesh(KeptMesh& kept_mesh, const SignOfWhole& sign);

    template <typename Archive>
    void visit(Archive& archive);

    /// Whether the lengths of the arrays go together.
    bool fits() const;
    SignOfWhole sign() const;
    std::size_t face_count() const { return order_.size(); }
    /// In use.
    std::size_t vertex_count() const { return vertices_.size(); }
    /// The memory that was read must outlive it.
    std::unique_ptr<KeptMesh> make(device::Context& context, const std::shared_ptr<device::BufferPool>& pool,
                                   const KeptMesh::Options& options) const;

private:
    std::int32_t sign_ = 0;
    std::uint32_t has_floor_ = 0, is_negative_ = 0, has_loops_ = 0, loops_have_floor_ = 0, are_paired_ = 0;
    double floor_ = 0, loops_floor_ = 0;
    Topology described_;
    std::vector<char> name_;
    Box box_;
    // As the caller gave them.
    std::uint64_t vertex_count_ = 0;
    std::vector<std::uint32_t> numbers_here_;
    KeptArray<Vec3> positions_;
    KeptArray<Triangle> triangles_;
    // Of the sign.
    std::vector<std::uint32_t> surface_vertices_;
    std::vector<SignSurface::Use> surface_faces_;
    std::vector<std::uint32_t> loop_vertices_;
    std::vector<std::size_t> loop_begins_{0};
    // MeshTopology
    KeptArray<std::uint32_t> order_, vertices_, starts_, corners_;
    KeptArray<Triangle> faces_;
    KeptArray<FaceEdges> edges_;
    std::vector<std::uint32_t> non_manifold_ends_;
    // Frusta
    std::vector<StoredSite> sites_;
    std::vector<std::uint32_t> slivers_;
    std::uint64_t saddle_vertices_ = 0, boxes_ = 0;
    KeptArray<Vec3> ordered_positions_;
    KeptArray<FaceSlopes> slopes_;
    // For kernels.
    KeptArray<std::uint32_t> names_;
    KeptArray<TriangleSites> site_names_;
    KeptArray<float> site_normals_;
};

template <typename Archive>
void StoredMesh::visit(Archive& archive) {
    archive(sign_);
    for (std::uint32_t* flag : {&has_floor_, &is_negative_, &has_loops_, &loops_have_floor_, &are_paired_})
        archive(*flag);
    for (double* z : {&floor_, &loops_floor_}) archive(*z);
    visit_topology(described_, archive);
    archive(name_);
    archive(box_);
    archive(vertex_count_);
    archive(numbers_here_);
    archive(positions_);
    archive(triangles_);
    archive(surface_vertices_);
    archive(surface_faces_);
    archive(loop_vertices_);
    archive(loop_begins_);
    for (KeptArray<std::uint32_t>* array : {&order_, &vertices_, &starts_, &corners_}) archive(*array);
    archive(faces_);
    archive(edges_);
    archive(non_manifold_ends_);
    archive(sites_);
    archive(slivers_);
    archive(saddle_vertices_);
    archive(boxes_);
    archive(ordered_positions_);
    archive(slopes_);
    archive(names_);
    archive(site_names_);
    archive(site_normals_);
}

}  // namespace clsdf::engine
