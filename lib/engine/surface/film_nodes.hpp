#pragma once

#include <clsdf/mesh.hpp>

#include "surface/film_bounds.hpp"
#include "surface/film_expansion.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace clsdf {

/// A tree over pieces of a film: of a surface that closes loops of open edges. Pieces far from a point count for the
/// winding number by their moments, with a bound of the error (docs/method.md, 'Sign of open meshes'). Lengths are in
/// any unit.
class FilmNodes {
public:
    struct Node {
        Vec3 lower, upper;              ///< the box of the corners
        Vec3 centre;                    ///< the centre of a ball around the film
        double radius;                  ///< the radius of the ball
        double area;                    ///< the area of the film
        double spread;                  ///< as of film_expansion_error()
        std::uint32_t corner, corners;  ///< its range in the order of corners_of()
        std::uint32_t second;           ///< the second child; the first one is the next node; 0: a leaf
        std::uint32_t expansion;        ///< no_expansion: exact turns cost no more
        // Sums over the tree do not read these.
        Vec3 normal;                   ///< the sum of its triangles' area vectors n dA
        std::array<double, 6> moment;  ///< the integral of n_j (x - centre)_k, symmetric: xx, yy, zz, xy, xz, yz

        bool is_leaf() const { return second == 0; }
    };
    struct Sum {
        double turns = 0;  ///< those of pieces far away, by expansions
        double error = 0;  ///< they may be off by that
    };
    /// Turns as a linear function around a point.
    struct Linear {
        double turns;  ///< at the point
        WindingChange change;
    };

    FilmNodes() = default;
    /// positions: of the corners, loop after loop. begins: where each loop begins, and the end of the last.
    FilmNodes(std::span<const Vec3> positions, std::span<const std::size_t> begins);

    std::span<const Node> all() const { return nodes_; }
    /// The numbers of a leaf's corners: of a loop, or of a part of one that a chord closes. All of a node's leaves have
    /// a range together.
    std::span<const std::uint32_t> corners_of(const Node& node) const {
        return std::span(corners_).subspan(node.corner, node.corners);
    }
    /// All of them, in the order of the nodes.
    std::span<const std::uint32_t> corners() const { return corners_; }
    /// Of a node that has one.
    const FilmExpansion& expansion_of(const Node& node) const { return expansions_[node.expansion]; }
    /// How much the expansion of a node may be off at a distance from its centre; infinite if it has none.
    static double error_of(const Node& node, double distance) {
        return node.expansion == no_expansion ? std::numeric_limits<double>::infinity()
                                              : film_expansion_error(node.radius, node.spread, distance);
    }
    /// What a node may be off by if all of the film may be off by `tolerance`.
    double share_of(const Node& node, double tolerance) const {
        return tolerance * static_cast<double>(node.corners) / static_cast<double>(corners_.size());
    }

    /// Visits a node and those below it, children after their parents. visit: whether all of a node is done.
    template <typename Visit>
    void walk(const Visit& visit, std::uint32_t top = 0) const;
    /// The turns by all that is far from a point. may_meet(node): whether the ray towards -x may meet the film; then
    /// its turns are not its solid angle. near(leaf): for the leaves that are not part of the sum. tolerance: the most
    /// that the sum may be off by.
    template <typename MayMeet, typename Near>
    Sum sum(const Vec3& point, double tolerance, const MayMeet& may_meet, const Near& near) const;
    /// The turns of a node's film in a ball around a point that lies at a distance from the film; none of the rays from
    /// there may meet it. Their change is infinite if the ball is too near.
    static Linear linear(const Node& node, const Vec3& point, double ball);

    std::size_t host_bytes() const {
        return corners_.size() * sizeof(corners_[0]) + nodes_.size() * sizeof(nodes_[0]) +
               expansions_.size() * sizeof(expansions_[0]);
    }

    static constexpr std::uint32_t no_expansion = ~std::uint32_t{0};

private:
    static constexpr double per_sphere = 0.25 * std::numbers::inv_pi;
    /// Nearer to a piece, in radii of it, edges between pieces would have rounding errors of their own.
    static constexpr double nearest = 0.25;

    std::vector<std::uint32_t> corners_;  // leaf after leaf, in the order of the tree
    std::vector<Node> nodes_;
    std::vector<FilmExpansion> expansions_;
};

template <typename Visit>
void FilmNodes::walk(const Visit& visit, std::uint32_t top) const {
    std::array<std::uint32_t, 64> open;  // more than the depth: every node halves its leaves
    std::size_t count = 0;
    if (!nodes_.empty()) open[count++] = top;
    while (count > 0) {
        const std::uint32_t number = open[--count];
        const Node& node = nodes_[number];
        if (!visit(node) && !node.is_leaf()) {
            open[count++] = node.second;
            open[count++] = number + 1;
        }
    }
}

template <typename MayMeet, typename Near>
FilmNodes::Sum FilmNodes::sum(const Vec3& point, double tolerance, const MayMeet& may_meet, const Near& near) const {
    Sum sum;
    walk([&](const Node& node) {
        const Vec3 r{node.centre[0] - point[0], node.centre[1] - point[1], node.centre[2] - point[2]};
        const double error = error_of(node, length(r));
        if (error <= share_of(node, tolerance) && !may_meet(node)) {
            sum.turns += expansion_of(node).at(r);
            sum.error += error;
            return true;
        }
        if (node.is_leaf()) near(node);
        return false;
    });
    return sum;
}

}  // namespace clsdf
