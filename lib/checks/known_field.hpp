#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include "checks/known_outputs.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace clsdf::checks {

/// A kind of known fields. It decides which kernels compute the field.
struct KnownFieldKind {
    bool wide = false;            ///< no band; else one of a few voxels, with other limits inside than outside
    bool long_bricks = false;     ///< samples farther apart along z
    bool on_surface = false;      ///< a grid of another lattice, with samples on vertices and faces
    bool fine = false;            ///< a fine grid: no polyhedron overlaps one coarse brick inside and one outside
    bool many_at_vertex = false;  ///< another surface: more faces at a vertex than CLSDF_LISTED_FACES
};

/// In the order of packed samples.
std::vector<Vec3> positions_of(const Grid& grid);

/// A small field whose values are known: of a cube, a closed fan whose saddle vertex has a gap between its triangles'
/// polyhedra, and a sliver, on a grid across the corner of eight coarse bricks, or a fine one through a face. The
/// values come from plain arithmetic in double precision: the least distance to all triangles, and the winding number
/// along rows. It shares nothing with the polyhedra and the kernels. The other outputs come from KnownOutputs. All
/// kinds have the same mesh, but for the surface of many_at_vertex.
class KnownField {
public:
    explicit KnownField(const KnownFieldKind& kind);

    const Mesh& mesh() const { return mesh_; }
    const Grid& grid() const { return grid_; }
    const Band& band() const { return band_; }

    /// The same samples with a band of this half width on both sides, as points have it.
    KnownField within(double half_width) const;

    /// Describes values that differ from the known ones by more than their error: the first sample and the number of
    /// samples. Nothing if all agree. found: packed samples; the distance alone, with the triangle, or with all
    /// outputs.
    std::optional<std::string> difference(const targets::HostArrays& found) const;
    /// The samples whose distance is less than the half width on their side.
    std::size_t band_samples(const targets::HostArrays& found) const;

private:
    /// Each describes what is wrong, or returns an empty text.
    std::string wrong_distance(const targets::HostArrays& found, const KnownSample& sample) const;
    std::string wrong_triangle(const targets::HostArrays& found, const KnownSample& sample) const;

    /// The half width on this side of the surface, as elements of the array have it.
    double limit(bool negative, const targets::HostArray& distance) const;
    double error() const;
    double distance_to(std::uint32_t triangle, const Vec3& point) const;
    /// Negative inside.
    std::vector<double> values() const;
    /// 1 outside, -1 inside.
    std::vector<double> signs() const;

    Mesh mesh_;
    Grid grid_;
    Band band_;
    KnownOutputs outputs_;
};

}  // namespace clsdf::checks
