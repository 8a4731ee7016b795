#pragma once

#include "scenes/searched_bodies.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace clsdf::scenes {

using Corners = std::array<Vec3, 3>;

/// A face where its body is.
struct PlacedFace {
    PlacedFace(const SearchedBody& body, std::uint32_t face);

    Corners corners;
    Vec3 normal;  ///< of length 1; not a number if the face has no area
};
/// How far a face extends from a point in it along a direction in its plane.
double extent(const PlacedFace& face, const Vec3& p, const Vec3& direction);

/// Decides which points of the bodies' faces are on the surface of their union: those with points near them that are
/// in no body.
///
/// Bodies are known to the rounding of their coordinates. So a gap between two of them that is narrower than
/// rounding() counts as closed, and a point that is deeper than that in another body is not on the union's surface. In
/// between, points a little in front of the face decide, beside the given point, too: other bodies may touch the face
/// there in a line or a point.
class UnionTest {
public:
    explicit UnionTest(const SearchedScene& scene);

    /// Above the rounding of a point p of the body, and of another one. In the scene's units.
    double rounding(std::uint32_t body, std::uint32_t other, const Vec3& p) const;

    /// p: on a face of a body, to rounding.
    bool is_on_union(const Vec3& p, std::uint32_t body, const PlacedFace& face) const;

    /// Whether the face is on the union on one of the sides of a line in it. p: on this line. along: of length 1.
    bool is_on_union_beside(const Vec3& p, const Vec3& along, std::uint32_t body, const PlacedFace& face) const;

    /// Calls visit(body), which returns false to end, for the bodies whose boxes are near a point.
    template <typename Visit>
    void visit_near(const Vec3& p, double within, const Visit& visit) const {
        const double margin = within + 16 * relative_rounding * (largest_ + largest_of(p));
        scene_.tree.visit_near(p, margin, [&](std::uint32_t body) { return visit(body) ? margin : -1; });
    }

    const SearchedScene& scene() const { return scene_; }

private:
    /// Whether a point a little in front of the face is in no other body.
    bool is_free(const Vec3& p, std::uint32_t body, const PlacedFace& face) const;
    /// The same beside p, in the face.
    bool is_free_towards(const Vec3& p, const Vec3& direction, std::uint32_t body, const PlacedFace& face) const;

    const SearchedScene& scene_;
    std::vector<double> largest_of_body_;
    double largest_ = 0;
};

}  // namespace clsdf::scenes
