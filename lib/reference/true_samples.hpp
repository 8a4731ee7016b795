#pragma once

#include <clsdf/field.hpp>

#include "triangle.hpp"
#include "triangle_tree.hpp"

#include "surface/sign_surface.hpp"
#include "surface/topology.hpp"

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace clsdf::reference {

/// The true values of one sample.
struct TrueSample {
    double distance = 0;  ///< unsigned; infinite if it is beyond the reach
    std::uint32_t triangle = no_triangle;
    Site site = Site::face;  ///< of that triangle, and the closest point, within the reach
    Vec3 point{};
    bool inside = false;
    bool in_doubt = false;    ///< by the rule solid_angle: the winding number is about one half; by the rule below: the
                              ///< sample is so near to a wall or the floor that rounding may decide
    bool on_surface = false;  ///< the double nearest to the sample, which decides the sign, lies on the surface
    double rounding =
        0;  ///< largest distance of the sample from that double; the sign is uncertain that near to the surface

    double signed_distance() const { return inside ? -distance : distance; }
};

/// The truth at the samples of a grid. Constant functions may be called from several threads at once.
class TrueSamples {
public:
    /// Distances beyond `reach` are not needed. The mesh must outlive this. The rule is resolved against the mesh.
    /// floor: of the rule `below`.
    TrueSamples(const Mesh& mesh, const Grid& grid, SignRule sign, std::optional<double> floor, double reach);

    SignRule sign() const { return sign_; }
    bool is_signed() const { return sign_ != SignRule::none; }
    const TriangleTree& tree() const { return tree_; }
    /// The surface that decides the sign; the mesh if there is no sign.
    const SignSurface& sign_surface() const { return surface_; }

    TrueSample at(const Index3& index) const { return at(position(index)); }
    /// The same at any position.
    TrueSample at(const ExactPosition& position) const;

    /// All samples (i, j, k) of one row, i = 0 ... size - 1.
    void row(std::int64_t j, std::int64_t k, std::vector<TrueSample>& samples) const;

    ExactPosition position(const Index3& sample) const { return exact_position(grid_, sample); }

    double distance_to(std::uint32_t triangle, const Index3& sample) const {
        return tree_.distance_to(triangle, exact_position(grid_, sample));
    }

private:
    TrueSamples(const Mesh& mesh, const Grid& grid, SignRule sign, std::optional<double> floor, DescribedMesh described,
                double reach);
    void measure(const ExactPosition& position, double bound, TrueSample& sample) const;
    void take_sign(const std::optional<RayCount>& count, TrueSample& sample) const;
    /// By the solid angles of all faces.
    void take_sign(const Vec3& point, TrueSample& sample) const;
    /// By the rule `below`.
    void doubt_near_walls(const ExactPosition& position, TrueSample& sample) const;

    Grid grid_;
    SignRule sign_;
    SignSurface surface_;
    double reach_;
    TriangleTree tree_;
    std::vector<std::array<Vec3, 2>> open_edges_;  ///< if the rule is solid_angle
    std::unique_ptr<const Mesh> sign_mesh_;        ///< null if it is the mesh
    std::unique_ptr<const TriangleTree> sign_tree_;
    RayCounter rays_;
};

/// The half width that a sample's side of the surface has.
inline double half_width(const Band& band, bool is_signed, bool inside) {
    return is_signed && inside ? band.inside : band.outside;
}

/// The largest distance a sample of the band can have.
inline double widest(const Band& band, bool is_signed) {
    return is_signed ? band.widest() : band.outside;
}

/// Samples of a field for a check: half drawn uniformly, half near the band's limits, edges and vertices. The same for
/// the same seed on every platform.
std::vector<Index3> choose_samples(const TrueSamples& truth, const Field& field, std::size_t count, std::uint64_t seed);

}  // namespace clsdf::reference
