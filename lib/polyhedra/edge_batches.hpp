#pragma once

#include "polyhedra/side_of_plane.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace clsdf::polyhedra {

/// Two faces whose inward directions differ by less than this angle are folded onto each other.
inline constexpr double fold_angle = 1e-6;

/// `squared_apart`: the square of the distance of their unit inward directions at the edge.
inline bool folded(double squared_apart) {
    return squared_apart < fold_angle * fold_angle;
}

/// Pairs of faces at edges, a few of a processor's vectors at a time.
class WedgeBatch {
public:
    static constexpr std::size_t capacity = 24;

    /// An edge of two faces, as each of them has it.
    void set(std::size_t i, const TriangleFrame& first, std::uint32_t edge_of_first, const TriangleFrame& second,
             std::uint32_t edge_of_second) {
        const Vector& a = first.inwards[edge_of_first];
        const Vector& b = second.inwards[edge_of_second];
        for (int axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            first_[k][i] = a[axis];
            second_[k][i] = b[axis];
            normal_[k][i] = first.normal[axis];
        }
        turn_[i] = first.turn + second.turn;
    }

    struct Results {
        /// On which side of the first face's plane the second face lies: 1 above, -1 below; 0 where the frames do not
        /// tell, or the faces are folded onto each other.
        std::array<std::int32_t, capacity> side;
        /// The tangent of half the angle by which the wedge between the faces exceeds a straight one, seen from the
        /// side where it does; both faces have the same. Of folded faces it means nothing.
        std::array<float, capacity> slope;
        std::array<std::int32_t, capacity> folded;  ///< 1 or 0
    };
    void measure(Results& results) const;

private:
    using Lanes = std::array<double, capacity>;

    std::array<Lanes, 3> first_{};   // inward direction
    std::array<Lanes, 3> second_{};  // of the second face
    std::array<Lanes, 3> normal_{};  // of the first face
    Lanes turn_{};                   // of both frames, by rounding
};

/// The sides of planes on which points lie, a vector of points at a time, in twice the precision of double. This
/// decides nearly all points that double leaves open.
class PlaneSides {
public:
    static constexpr std::size_t capacity = 8;

    void set(std::size_t i, const OppositeVertex& vertex);

    /// side_of_plane() of each, where it is certain, else 0.
    using Sides = std::array<std::int32_t, capacity>;
    void measure(Sides& sides) const;

private:
    using Components = std::array<std::array<double, capacity>, 3>;

    std::array<Components, 4> points_{};  // lanes that were not set are padding
};

}  // namespace clsdf::polyhedra
