#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::transform {

/// Which of the known fields: what decides which kernels compute it.
struct KnownFieldKind {
    bool wide = false;         ///< no band; else one of a few voxels, with other limits inside than outside
    bool is_signed = true;     ///< negative inside
    bool long_bricks = false;  ///< samples farther apart along z
    bool large = false;        ///< triangles with many rows of samples; else with few
};

/// A small field whose values are known: of a cube, a closed fan whose saddle vertex has a gap between its triangles'
/// polyhedra, and a sliver, on a grid across the corner of eight coarse bricks. The values come from plain
/// arithmetic in double precision: the least distance to all triangles, and the winding number along rows. It shares
/// nothing with the polyhedra and the kernels.
class KnownField {
public:
    explicit KnownField(const KnownFieldKind& kind);

    const Mesh& mesh() const { return mesh_; }
    const Grid& grid() const { return grid_; }
    const Band& band() const { return band_; }

    /// Describes values that differ from the known ones by more than a distance's error: the first sample and the
    /// number of samples. Nothing if all agree. `triangle` may be empty.
    std::optional<std::string> difference(std::span<const float> distance,
                                          std::span<const std::uint32_t> triangle) const;

private:
    double distance_to(std::uint32_t triangle, const Vec3& point) const;
    /// Negative inside, but where the field has no sign.
    std::vector<double> values() const;
    /// 1 outside, -1 inside.
    void find_signs(std::vector<double>& signs) const;

    KnownFieldKind kind_;
    Mesh mesh_;
    Grid grid_;
    Band band_;
};

}  // namespace clsdf::transform
