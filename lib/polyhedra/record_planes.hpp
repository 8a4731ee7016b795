#pragma once

#include "polyhedra/face_edges.hpp"
#include "polyhedra/lateral_plane.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/prefetch.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace clsdf::polyhedra {

/// What the lateral planes of polyhedra are made of, read from the device's records: the frames to a rounding of their
/// own, the slopes as the device has them.
class RecordPlanes {
public:
    /// `edges`: with the frames' bases.
    RecordPlanes(std::span<const Polyhedron> records, std::span<const FaceEdges> edges, const LatticeView& lattice)
        : records_(records), edges_(edges), per_spacing_(to_vector(lattice.spacing_in_units).cwiseInverse()) {}

    Vector normal(std::size_t face) const { return column(face, 2); }

    LateralPlane plane(const Corner& edge) const {
        const Polyhedron& record = records_[edge.face];
        const std::uint32_t base = edges_[edge.face].base;
        const std::uint32_t k = edge.vertex + (edge.vertex >= base ? 0 : 3) - base;
        // Components of the edges' inward directions, in the record's order.
        const std::array<double, 3> along{0, -record.exact_normal_along[CLSDF_HALF_RIGHT],
                                          record.exact_normal_along[CLSDF_HALF_LEFT]};
        const std::array<double, 3> across{1, -record.exact_normal_across[CLSDF_HALF_RIGHT],
                                           -record.exact_normal_across[CLSDF_HALF_LEFT]};
        return {normal(edge.face), along[k] * column(edge.face, 0) + across[k] * column(edge.face, 1),
                record.slope_above[k], record.slope_below[k]};
    }

    /// Starts to bring a face's record near the processor.
    void fetch_ahead(std::size_t face) const {
        const Polyhedron& record = records_[face];
        prefetch(record.slope_above);
        prefetch(record.exact_gradient_x);
        prefetch(record.exact_gradient_z);
        prefetch(record.exact_normal_across);
    }

private:
    /// X, Y or Z of a face's frame.
    Vector column(std::size_t face, std::size_t i) const {
        const Polyhedron& record = records_[face];
        return Vector(record.exact_gradient_x[i], record.exact_gradient_y[i], record.exact_gradient_z[i])
            .cwiseProduct(per_spacing_);
    }

    std::span<const Polyhedron> records_;
    std::span<const FaceEdges> edges_;
    Vector per_spacing_;
};

}  // namespace clsdf::polyhedra
