#pragma once

#include "solid_angle.h"
#include "surface/open_edges.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clsdf {

/// A tree over pieces of a film: of a surface that closes the holes of a mesh. Pieces far from a point count for the
/// winding number by their moments, with a bound of the error (docs/method.md, 'Sign of open meshes'). So one point
/// costs much less than the sum over all open edges. Safe to use from several threads.
class FilmTree {
public:
    /// unit: as of angle_of().
    FilmTree(std::shared_ptr<const OpenBoundary> boundary, double unit);

    struct View {
        int rounded;     ///< SolidAngle::rounded
        double to_half;  ///< the winding number is farther from every half integer; may be negative
    };
    /// The open edges as a point sees them. If the moments show no distance greater than `least_to_half`, the sum over
    /// all open edges is taken. So `rounded` is the same by both ways wherever the sum is right.
    View look(const Vec3& point, double least_to_half = 0) const;
    /// The same from the moments alone, unless they do not tell how it is rounded.
    View look_by_moments(const Vec3& point) const;

    /// How much the winding number changes in a ball around a point, at most. radius: in the unit.
    double change_within(const Vec3& centre, double radius) const;

    /// Without the boundary.
    std::size_t host_bytes() const;

private:
    struct Piece {
        std::size_t begin, end;  ///< a range of corners_
    };
    struct Node {
        Vec3 lower, upper;             ///< the box of the corners, in the unit
        Vec3 centre;                   ///< the centre of a ball around the film
        double radius;                 ///< the radius of the ball
        double area;                   ///< the area of the film
        Vec3 normal;                   ///< the sum of its triangles' area vectors n dA
        std::array<double, 6> moment;  ///< the integral of n_j (x - centre)_k, symmetric: xx, yy, zz, xy, xz, yz
        std::uint32_t piece;           ///< the leaf's piece
        std::uint32_t second;          ///< the second child; the first one is the next node; 0: a leaf
    };
    struct Sum {
        Turns near = no_turns();  ///< the turns of the pieces near the point
        double far = 0;           ///< those of all others, by moments
        double error = 0;         ///< `far` may be off by that
    };

    void cut(std::span<const std::uint32_t> polygon);
    std::uint32_t build(std::span<Node> leaves);
    Node leaf(std::uint32_t number) const;
    static Node parent(const Node& a, const Node& b);
    static void set_ball(Node& node);
    Vec3 scaled(const Vec3& position) const;
    std::span<const std::uint32_t> corners_of(std::uint32_t piece) const {
        return std::span(corners_).subspan(pieces_[piece].begin, pieces_[piece].end - pieces_[piece].begin);
    }
    template <typename Function>
    void for_each_edge(std::uint32_t number, const Function& f) const;
    template <typename Visit>
    void walk(const Visit& visit) const;
    Sum sum(const Vec3& point, double tolerance) const;

    std::shared_ptr<const OpenBoundary> boundary_;
    double unit_;
    std::vector<std::uint32_t> corners_;  // the boundary's corners, piece after piece
    std::vector<Piece> pieces_;
    std::vector<Node> nodes_;
};

}  // namespace clsdf
