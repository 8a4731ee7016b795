#pragma once

#include <clsdf/mesh.hpp>

#include "surface/open_edges.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf {

class FilmTree;

/// The winding number of a surface at a point.
struct SeenWinding {
    int rounded = 0;       ///< to an integer, a half up
    double to_half = 0.5;  ///< the distance from the nearest half integer

    bool is_inside() const { return rounded != 0; }
    /// Whether it is more than 0.1 from an integer.
    bool is_in_doubt() const { return to_half < 0.4; }
};

/// Looks at the winding number of a surface: of triangles over a mesh's vertices, and their open edges. Keeps both.
class WindingView {
public:
    WindingView(const Mesh& mesh, std::span<const Triangle> triangles, const OpenLoops& loops);

    std::vector<SeenWinding> at(std::span<const Vec3> points) const;

private:
    const Mesh& mesh_;
    std::span<const Triangle> triangles_;
    double unit_;
    std::shared_ptr<const OpenBoundary> boundary_;
    std::shared_ptr<const FilmTree> film_;  // null if there are few open edges
};

/// A surface over vertices of its own: some faces of another one.
Mesh surface_of(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const std::uint32_t> faces);

/// Fixed points of a box: the Halton sequence with the bases 2, 3 and 5.
std::vector<Vec3> points_in(const Box& box, std::size_t count);

/// Points just above and just below some faces, in pairs, at so many fixed places that are spread by area; none if the
/// faces have no area. They are farther from the faces than float coordinates are rounded, by a millionth of the
/// longest side of the box of the faces that have a place.
std::vector<Vec3> points_beside(const Mesh& mesh, std::span<const Triangle> triangles,
                                std::span<const std::uint32_t> faces, std::size_t places);

/// The winding number at some points.
struct WindingTally {
    std::size_t tested = 0, doubtful = 0;
    std::size_t inside = 0, doubtful_inside = 0;
    std::int64_t sum = 0;  ///< of the rounded numbers

    void add(std::span<const SeenWinding> seen);
    /// At most a tenth is in doubt, and at most a tenth of those inside.
    bool is_clear() const { return 10 * doubtful <= tested && 10 * doubtful_inside <= inside; }
    /// The same with a fifth.
    bool is_nearly_clear() const { return 5 * doubtful <= tested && 5 * doubtful_inside <= inside; }
};

}  // namespace clsdf
