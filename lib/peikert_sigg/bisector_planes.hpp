#pragma once

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::peikert_sigg {

/// A vertex with a closed fan of faces around it, counter-clockwise seen from outside: face i lies between neighbours i
/// and i + 1.
struct Fan {
    Vec3 vertex{};
    std::vector<Vec3> neighbours;
    std::vector<std::uint8_t> is_flat;  ///< the faces i - 1 and i, at the edge to neighbour i, lie in one plane

    std::size_t size() const { return neighbours.size(); }
    std::size_t before(std::size_t i) const { return i == 0 ? size() - 1 : i - 1; }
    std::size_t after(std::size_t i) const { return i + 1 == size() ? 0 : i + 1; }
};

/// The planes at a fan: one at each edge, or those of the faces.
enum class PlaneKind { bisector, face };

/// The direction A_i x A_j times `weight`, A_i and A_j the normals of two planes.
struct PlaneLine {
    std::size_t i;
    std::size_t j;
    double weight;
};

/// The bisector planes of a fan's edges in an arithmetic: a Number, its square_root(), and whether one
/// is_surely_positive() or is_surely_zero(). Vectors are positive multiples of what they stand for.
template <typename Arithmetic>
class BisectorPlanes {
public:
    using Number = typename Arithmetic::Number;
    using Vector = std::array<Number, 3>;

    explicit BisectorPlanes(const Fan& fan) {
        const std::size_t count = fan.size();
        const Number scale(power_of_two_to_one(fan));
        const auto difference = [&](const Vec3& to, std::size_t axis) {
            return (Number(to[axis]) - Number(fan.vertex[axis])) * scale;
        };
        std::vector<Vector> spokes;
        for (const Vec3& to : fan.neighbours)
            spokes.push_back({difference(to, 0), difference(to, 1), difference(to, 2)});
        for (std::size_t i = 0; i < count; ++i) {
            normals_.push_back(cross(spokes[i], spokes[fan.after(i)]));
            areas_.push_back(Arithmetic::square_root(dot(normals_[i], normals_[i])));
        }
        for (std::size_t i = 0; i < count; ++i) {
            // The plane holds the edge and the sum of the unit normals. At a flat edge that is either face's normal,
            // which takes no root; if the two are surely not opposite.
            const Vector& before = normals_[fan.before(i)];
            const Vector& after = normals_[i];
            const bool is_plain = fan.is_flat[i] != 0 && Arithmetic::is_surely_positive(dot(before, after));
            planes_.push_back(
                cross(spokes[i], is_plain ? after : sum(areas_[i], before, areas_[fan.before(i)], after)));
        }
    }

    /// det(A_i, A_j, A_k), A_i the normal of the bisector plane at the edge to neighbour i, pointing out of face i.
    Number determinant(std::size_t i, std::size_t j, std::size_t k) const {
        return dot(cross(planes_[i], planes_[j]), planes_[k]);
    }

    /// The same of the faces' normals.
    Number normal_determinant(std::size_t i, std::size_t j, std::size_t k) const {
        return dot(cross(normals_[i], normals_[j]), normals_[k]);
    }

    /// The component of face i's normal along the average of the faces' unit normals. Faces without area have none.
    Number facing(std::size_t i) const {
        if (!average_) {
            Vector& average = average_.emplace(zero());
            for (std::size_t k = 0; k < normals_.size(); ++k)
                for (std::size_t axis = 0; axis < 3 && !Arithmetic::is_surely_zero(areas_[k]); ++axis)
                    average[axis] = average[axis] + normals_[k][axis] / areas_[k];
        }
        return dot(normals_[i], *average_);
    }

    /// The bisector planes' normals, or those of the faces.
    const std::vector<Vector>& normals(PlaneKind kind) const {
        return kind == PlaneKind::bisector ? planes_ : normals_;
    }

    /// The sum of lines in which planes of a kind meet.
    Vector sum_of_lines(PlaneKind kind, std::span<const PlaneLine> lines) const {
        Vector result = zero();
        for (const PlaneLine& line : lines) {
            const Vector direction = cross(normals(kind)[line.i], normals(kind)[line.j]);
            for (std::size_t axis = 0; axis < 3; ++axis)
                result[axis] = result[axis] + Number(line.weight) * direction[axis];
        }
        return result;
    }

    /// The component of a direction along the normal of plane k, times that normal's length.
    Number component(PlaneKind kind, const Vector& direction, std::size_t k) const {
        return dot(direction, normals(kind)[k]);
    }

private:
    /// A power of two that brings the fan to the size of one, as far as one in range can: what follows has up to
    /// fifteen factors of its size.
    static double power_of_two_to_one(const Fan& fan) {
        double size = 0;
        for (const Vec3& neighbour : fan.neighbours)
            for (std::size_t axis = 0; axis < 3; ++axis)
                size = std::max(size, std::abs(neighbour[axis] / 2 - fan.vertex[axis] / 2));
        if (!(size > 0)) return 1;
        constexpr int limit = 1000;
        return std::ldexp(1.0, std::clamp(-std::ilogb(size), -limit, limit));
    }

    static Vector zero() { return {Number(0), Number(0), Number(0)}; }
    static Vector cross(const Vector& a, const Vector& b) {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }
    static Number dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
    static Vector sum(const Number& p, const Vector& a, const Number& q, const Vector& b) {
        return {p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]};
    }

    std::vector<Vector> normals_;
    std::vector<Number> areas_;
    std::vector<Vector> planes_;
    mutable std::optional<Vector> average_;  // of the faces' unit normals
};

}  // namespace clsdf::peikert_sigg
