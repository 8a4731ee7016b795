#pragma once

#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/mesh.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// The slow, plain specification that every kernel is held against. A target of its own, clsdf::reference: it uses
/// CGAL's AABB tree, whose licence is the GPL.
namespace clsdf::reference {

enum class Site : std::uint8_t { vertex0, vertex1, vertex2, edge0, edge1, edge2, face };

struct Nearest {
    double distance = 0;
    std::uint32_t triangle = no_triangle;  ///< the lowest index among equals
    Site site = Site::face;  ///< vertex before edge before face; edge k runs from vertex k to vertex k + 1
    Vec3 point{};            ///< the closest point of the mesh
};

/// Distance from a point to a closed triangle in double precision, right on slivers and on degenerate triangles; its
/// error is a few units of rounding of the farthest vertex's distance from the point. Sites are decided within that
/// rounding, in favour of the vertex, then the edge. `triangle` of the result is 0.
CLSDF_EXPORT Nearest nearest_on_triangle(const Vec3& query, const Vec3& a, const Vec3& b, const Vec3& c);

/// Every triangle looked at, in order.
CLSDF_EXPORT Nearest nearest_by_brute_force(const Mesh& mesh, const Vec3& query);

/// What a ray crosses on its way.
struct RayCount {
    int winding = 0;    ///< triangles left through their front, less those entered: the winding number of a closed mesh
    int crossings = 0;  ///< all of them
};

/// Distances by CGAL's AABB tree, equal to those by brute force to the last bit; signs by exact orientation predicates
/// on the coordinates as given. Rays run along +x. A ray through an edge or a vertex is decided as if it were moved by
/// (e, e^2) in (y, z) for an arbitrarily small e: a closed surface is crossed consistently, and triangles that have no
/// area seen along x, faces with repeated vertices among them, are not crossed at all.
/// Constant functions may be called from several threads at once. Once moved from, they throw Error(invalid_argument).
class CLSDF_EXPORT Oracle {
public:
    /// Keeps a copy of the mesh.
    explicit Oracle(const Mesh& mesh);
    Oracle(Oracle&&) noexcept;
    Oracle& operator=(Oracle&&) noexcept;
    ~Oracle();

    /// Throws Error(invalid_argument) where a coordinate is not finite, as do the others.
    Nearest nearest(const Vec3& query) const;

    /// The same where the distance is at most `bound`, and quicker; else nothing.
    std::optional<Nearest> nearest_within(const Vec3& query, double bound) const;

    /// The winding number of the surface around the point; nullopt where the point lies on the surface.
    std::optional<int> winding_number(const Vec3& query) const;

    /// Number of triangles a ray crosses; nullopt where the point lies on the surface.
    std::optional<int> crossings(const Vec3& query) const;

    /// Both for a whole row of points (x[i], y, z), x ascending: thousands of points cost little more than one.
    std::vector<std::optional<RayCount>> count_along_row(std::span<const double> x, double y, double z) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The field as it should be, with all outputs, computed plainly. Of equal distances it names the lowest triangle. Its
/// sign is that of the exact winding number (or parity) at the double nearest to the sample; a sample on the surface
/// carries +0. Throws what resolve_sign_rule() and the validation of grid and band throw.
CLSDF_EXPORT Field reference_field(const Mesh& mesh, const Grid& grid, const Band& band,
                                   SignRule sign = SignRule::automatic);

struct CheckOptions {
    std::size_t samples = 20000;  ///< 0, or not fewer than the grid has: every sample of the grid
    std::uint64_t seed = 1;
    double tolerance_voxels = 1e-5;  ///< an error is within the contract up to max(this, tolerance_ulp ulp)
    double tolerance_ulp = 2;
    double sign_margin_voxels = 1e-6;                 ///< nearer the surface than this, the sign is not judged
    std::function<void(double fraction)> progress{};  ///< one call at a time, from any thread
    /// Asked by any thread, by several at once; if it says true, Error(cancelled) is thrown.
    std::function<bool()> should_stop{};
};

/// A field held against the reference.
struct CheckReport {
    struct Finding {
        Index3 sample{};  ///< counted from the field's first one
        double expected = 0;
        double found = 0;
        std::string what;
    };

    std::size_t samples = 0;       ///< looked at
    std::size_t band_samples = 0;  ///< of these, with their distance within the band
    std::size_t wrong_values = 0;  ///< in the band, beyond the tolerance
    std::size_t wrong_signs = 0;
    std::size_t missed = 0;  ///< in the band, but with the fill value
    std::size_t leaked = 0;  ///< beyond the band, but not with the fill value
    /// Samples whose output breaks its contract (docs/accuracy.md), but of the distance: a triangle that is not
    /// nearest, a site that is not, or not named as the lowest triangle names it, a closest point off the surface or
    /// too far, and so on.
    PerOutput<detail::CountOf> wrong_outputs{};
    double max_error_voxels = 0;  ///< over all band samples
    double max_error_ulp = 0;     ///< over band samples farther than one voxel from the surface
    double rms_error_voxels = 0;
    std::vector<Finding> findings;  ///< the first ten

    bool passed() const {
        std::size_t wrong = wrong_values + wrong_signs + missed + leaked;
        visit_outputs([&](const char*, std::size_t count) { wrong += count; }, wrong_outputs);
        return wrong == 0;
    }
};

/// Holds a field against the band's contract. Half of the samples are drawn uniformly, half near the band's limits,
/// edges and vertices. A sample whose true distance is within the tolerance of a limit may carry its distance or the
/// fill value. A sample counts once in each way in which it is wrong; the result does not depend on the number of
/// threads. Positions and distances are formed beyond double precision where the grid is far from the origin.
/// Throws Error(invalid_argument) where an array of the field does not fit its grid, Error(invalid_mesh) where the mesh
/// cannot honour the field's sign rule, Error(cancelled).
CLSDF_EXPORT CheckReport check(const Mesh& mesh, const Field& field, const CheckOptions& options = {});

/// Two triangles, the lower index first.
using TrianglePair = std::pair<std::uint32_t, std::uint32_t>;

/// The pairs of triangles that meet in more than the vertices and edges they share, in order; of any mesh, exactly (by
/// CGAL's predicates). Vertices of equal coordinates count as one. A face without area is paired with itself and no
/// other, a face with repeated vertices not at all.
CLSDF_EXPORT std::vector<TrianglePair> find_self_intersections(const Mesh& mesh);

}  // namespace clsdf::reference
