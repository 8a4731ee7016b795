#pragma once

#include <clsdf/field.hpp>
#include <clsdf/mesh.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
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

/// Distance from a point to a closed triangle in double precision, right on slivers and on degenerate triangles.
Nearest nearest_on_triangle(const Vec3& query, const Vec3& a, const Vec3& b, const Vec3& c);

/// Every triangle looked at, in order.
Nearest nearest_by_brute_force(const Mesh& mesh, const Vec3& query);

/// Distances by CGAL's AABB tree, signs by exact orientation predicates on the coordinates as given.
class Oracle {
public:
    explicit Oracle(const Mesh& mesh);
    ~Oracle();

    Nearest nearest(const Vec3& query) const;

    /// The winding number of the surface around the point; nullopt where the point lies on the surface.
    std::optional<int> winding_number(const Vec3& query) const;

    /// Number of triangles a ray crosses; nullopt where the point lies on the surface.
    std::optional<int> crossings(const Vec3& query) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

struct CheckOptions {
    std::size_t samples = 20000;  ///< 0: every sample of the grid
    std::uint64_t seed = 1;
    double tolerance_voxels = 1e-5;  ///< an error is within the contract up to max(this, tolerance_ulp ulp)
    double tolerance_ulp = 2;
    double sign_margin_voxels = 1e-6;  ///< nearer the surface than this, the sign is not judged
};

/// A field held against the reference.
struct CheckReport {
    struct Finding {
        Index3 sample{};
        double expected = 0;
        double found = 0;
        std::string what;
    };

    std::size_t samples = 0;       ///< looked at
    std::size_t band_samples = 0;  ///< of these, with their distance within the band
    std::size_t wrong_values = 0;  ///< in the band, beyond the tolerance
    std::size_t wrong_signs = 0;
    std::size_t missed = 0;           ///< in the band, but with the fill value
    std::size_t leaked = 0;           ///< beyond the band, but not with the fill value
    std::size_t wrong_triangles = 0;  ///< the triangle named is not a nearest one
    double max_error_voxels = 0;      ///< over all band samples
    double max_error_ulp = 0;         ///< over band samples farther than one voxel from the surface
    double rms_error_voxels = 0;
    std::vector<Finding> findings;  ///< the first ten

    bool passed() const { return wrong_values + wrong_signs + missed + leaked + wrong_triangles == 0; }
};

/// Half of the samples are drawn uniformly, half near the band's limits, edges and vertices; the result does not depend
/// on the number of threads.
CheckReport check(const Mesh& mesh, const Field& field, const CheckOptions& options = {});

}  // namespace clsdf::reference
