#pragma once

#include "core/kept_array.hpp"
#include "plan/kept_mesh.hpp"
#include "points/kept_points.hpp"

#include <clsdf/topology.hpp>

#include <cstdint>
#include <vector>

namespace clsdf::points {

/// What KeptPoints of a whole mesh keep for the host and for processors, as the members of an archive, beside
/// engine::StoredMesh. Large arrays are borrowed, as there.
class StoredPoints {
public:
    StoredPoints() = default;
    /// Makes what is not made yet. kept_points must outlive it. Throws Error.
    StoredPoints(KeptPoints& kept_points, SignRule sign);

    template <typename Archive>
    void visit(Archive& archive) {
        archive(shape_);
        archive(sign_positions_);
        archive(sign_counts_);
        archive(is_joined_);
        archive(polyhedra_);
        archive(faces_);
        archive(nodes_);
        archive(leaves_);
        archive(sides_);
    }

    /// Whether the lengths of the arrays go together, for a mesh of so many faces and vertices.
    bool fits(std::size_t faces, std::size_t vertices) const;
    /// kept_points: of kept_mesh, which is that of the StoredMesh. The memory that was read must outlive them.
    void set(engine::KeptMesh& kept_mesh, KeptPoints& kept_points) const;

private:
    PointTree shape_{};
    KeptArray<Vec3> sign_positions_;
    KeptArray<std::int8_t> sign_counts_;
    std::vector<std::uint8_t> is_joined_;
    KeptArray<Polyhedron> polyhedra_;
    KeptArray<PointFace> faces_;
    KeptArray<PointNode> nodes_;
    KeptArray<PointLeaf> leaves_;
    KeptArray<std::uint16_t> sides_;  ///< empty if there are none
};

}  // namespace clsdf::points
