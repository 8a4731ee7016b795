#pragma once

#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// The slow, plain specification that every kernel is compared with, in a separate target, clsdf::reference, because
/// CGAL's AABB tree is under the GPL.
namespace clsdf::reference {

enum class Site : std::uint8_t { vertex0 = 0, vertex1 = 1, vertex2 = 2, edge0 = 3, edge1 = 4, edge2 = 5, face = 6 };

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

/// The same for a mesh, by looking at every triangle in order.
CLSDF_EXPORT Nearest nearest_by_brute_force(const Mesh& mesh, const Vec3& query);

/// The crossings of a ray with a mesh.
struct RayCount {
    int winding =
        0;  ///< triangles left through their front minus triangles entered: the winding number of a closed mesh
    int crossings = 0;  ///< all of them
};

/// Distances by CGAL's AABB tree, equal to those by brute force to the last bit; signs by exact orientation predicates
/// on the coordinates as given. Rays run along +x. A ray through an edge or a vertex counts as moved by (e, e^2) in (y,
/// z) for an arbitrarily small e. So a closed surface is crossed consistently, and triangles without area seen along x,
/// such as faces with repeated vertices, are not crossed. Constant functions may be called from several threads at
/// once. Once moved from, they throw Error(invalid_argument).
class CLSDF_EXPORT Oracle {
public:
    /// Keeps a copy of the mesh.
    explicit Oracle(const Mesh& mesh);
    Oracle(Oracle&&) noexcept;
    Oracle& operator=(Oracle&&) noexcept;
    ~Oracle();

    /// Throws Error(invalid_argument) if a coordinate is not finite, as do the others.
    Nearest nearest(const Vec3& query) const;

    /// The same, but faster, if the distance is at most `bound`; else nothing.
    std::optional<Nearest> nearest_within(const Vec3& query, double bound) const;

    /// The winding number of the surface around the point; nullopt if the point lies on the surface.
    std::optional<int> winding_number(const Vec3& query) const;

    /// Number of triangles a ray crosses; nullopt if the point lies on the surface.
    std::optional<int> crossings(const Vec3& query) const;

    /// Both for a whole row of points (x[i], y, z), x ascending: thousands of points cost little more than one.
    std::vector<std::optional<RayCount>> count_along_row(std::span<const double> x, double y, double z) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The right field, with all outputs, computed plainly. If several triangles are equally near, it names the lowest. The
/// sign is that of the exact winding number (or parity) at the double nearest to the sample; a sample on the surface
/// has +0. floor: of the rule `below`, whose sign is that of close_down(). Throws the errors of resolve_sign_rule(), of
/// close_down() and of the validation of grid and band.
CLSDF_EXPORT Field reference_field(const Mesh& mesh, const Grid& grid, const Band& band,
                                   SignRule sign = SignRule::automatic, std::optional<double> floor = {});

struct CheckOptions {
    std::size_t samples = 20000;  ///< 0, or not fewer than the grid has: every sample of the grid
    std::uint64_t seed = 1;
    double tolerance_voxels = 1e-5;  ///< an error is within the contract up to max(this, tolerance_ulp ulp)
    double tolerance_ulp = 2;
    double sign_margin_voxels = 1e-6;  ///< the sign is not judged nearer to the surface than this
    /// Both are called on the calling thread. If the second one says true, Error(cancelled) is thrown.
    std::function<void(double fraction)> progress{};
    std::function<bool()> should_stop{};
};

/// The comparison of a field with the reference.
struct CheckReport {
    struct Finding {
        Index3 sample{};      ///< counted from the field's first one
        double expected = 0;  ///< the distance
        double found = 0;
        std::string what;
        bool of_distance = true;  ///< or of its sign; else of another output
    };

    std::size_t samples = 0;       ///< looked at
    std::size_t band_samples = 0;  ///< of these, with their distance within the band
    std::size_t wrong_values = 0;  ///< in the band, beyond the tolerance
    std::size_t wrong_signs = 0;
    std::size_t missed = 0;  ///< in the band, but with the fill value
    std::size_t leaked = 0;  ///< beyond the band, but not with the fill value
    /// The samples that break an output's contract (docs/accuracy.md), by the output's number: for instance a triangle
    /// or a site that is not nearest, or a closest point off the surface. The distance has the counts above.
    std::array<std::size_t, detail::most_outputs> wrong_outputs{};
    double max_error_voxels = 0;  ///< over all band samples; infinite if a value is
    double max_error_ulp = 0;     ///< over band samples farther than one voxel from the surface
    double rms_error_voxels = 0;
    std::vector<Finding> findings;  ///< the first ten

    /// The samples that break the contract of an output other than the distance.
    std::size_t wrong(Output output) const { return wrong_outputs[detail::index_of(output)]; }

    bool passed() const {
        std::size_t wrong = wrong_values + wrong_signs + missed + leaked;
        for (const std::size_t count : wrong_outputs) wrong += count;
        return wrong == 0;
    }
};

/// Compares a field with the contract of docs/accuracy.md. Half of the samples are drawn uniformly, half near the
/// band's limits, edges and vertices. If the true distance of a sample is within the tolerance of a limit, its distance
/// and the fill value are both right. A sample counts once for each kind of fault. The result does not depend on the
/// number of threads. Positions and distances are formed beyond double precision if the grid is far from the origin.
/// Throws Error(invalid_argument) if an array of the field does not fit its grid, or if it has the sign rule `below`
/// and no floor; Error(invalid_mesh) if the mesh cannot honour the field's sign rule, Error(cancelled).
CLSDF_EXPORT CheckReport check(const Mesh& mesh, const Field& field, const CheckOptions& options = {});

/// The same for several fields of one problem, as by several programs; a report for each, in order. The truth, which
/// takes most of the time, is found once. Throws Error(invalid_argument) also if their grids, bands or sign rules
/// differ.
CLSDF_EXPORT std::vector<CheckReport> check(const Mesh& mesh, std::span<const Field> fields,
                                            const CheckOptions& options = {});

/// A body of a scene where it is.
struct PlacedBody {
    Mesh mesh;
    SignRule sign = SignRule::automatic;
};

/// Compares a field of a scene, as Scene::compute() gives it, with the least of the bodies' signed distances; triangles
/// count within their body, and Output::body is a body's place in the list. If several bodies are nearest within the
/// tolerance, each is right. Throws as the others; Error(invalid_argument) if there is no body.
CLSDF_EXPORT CheckReport check(std::span<const PlacedBody> bodies, const Field& field,
                               const CheckOptions& options = {});

/// What a program found at points, a value for each of them. Arrays other than the distances may be empty.
struct PointResults {
    std::span<const double> distances{};  ///< negative inside
    std::span<const Vec3> closest{};
    std::span<const Vec3> gradients{};  ///< unit vectors, away from the surface outside and to it inside
    std::span<const std::uint32_t> triangles{};
};

struct PointCheckOptions {
    SignRule sign = SignRule::automatic;
    std::optional<double> floor{};  ///< of the rule `below`
    /// Of distances, in the mesh's units. If it is not given: 1e-5 of 1/256 of the mesh's longest side, or 2 units in
    /// the last place of a float, whichever is more.
    std::optional<double> tolerance{};
};

/// The comparison of results at points with the reference.
struct PointCheckReport {
    struct Finding {
        std::size_t point = 0;
        std::string what;
    };

    std::size_t points = 0;           ///< judged: all that are finite
    std::size_t wrong_distances = 0;  ///< beyond the tolerance, or no number
    std::size_t wrong_signs = 0;
    std::size_t wrong_closest = 0;    ///< off the surface, or at another distance
    std::size_t wrong_gradients = 0;  ///< no direction from a nearest point
    std::size_t wrong_triangles = 0;  ///< not nearest within the tolerance
    double max_error = 0;             ///< of a distance, in the mesh's units; infinite if one is no number
    std::vector<Finding> findings;    ///< the first ten

    bool passed() const {
        return wrong_distances + wrong_signs + wrong_closest + wrong_gradients + wrong_triangles == 0;
    }
};

/// Compares the results of any program at points with the contract of docs/accuracy.md, 'Points'. The sign is judged at
/// every point that is not on the surface, by exact predicates. By the rule `solid_angle` it is not judged where the
/// winding number is within rounding of one half. The result does not depend on the number of threads. Throws
/// Error(invalid_argument) if an array has another size than the points, Error(invalid_mesh) if the mesh cannot honour
/// the sign rule.
CLSDF_EXPORT PointCheckReport check_points(const Mesh& mesh, std::span<const Vec3> points, const PointResults& results,
                                           const PointCheckOptions& options = {});

/// Two triangles, the lower index first.
using TrianglePair = std::pair<std::uint32_t, std::uint32_t>;

/// The pairs of triangles that meet in more than the vertices and edges that they share, in order, for any mesh, by
/// CGAL's exact predicates. Vertices of equal coordinates count as one. A face without area is paired with itself only.
/// A face with repeated vertices is in no pair.
CLSDF_EXPORT std::vector<TrianglePair> find_self_intersections(const Mesh& mesh);

}  // namespace clsdf::reference
