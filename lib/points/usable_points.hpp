#pragma once

#include <clsdf/mesh.hpp>

#include "targets/host_arrays.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::points {

/// Throws Error(invalid_argument) unless a half width is one that points can be looked up within.
void check_half_width(double half_width);

/// Where points have a distance that can be given.
struct UsableRange {
    Box limits;
    bool is_limit_of_floats = false;  ///< too far for a float, not for voxels
};
/// box: of the mesh.
UsableRange usable_range(const Box& box);

/// The points that are not usable for one reason.
struct UnusablePoints {
    bool are_finite = false;  ///< but too far
    std::size_t count = 0;
    std::size_t first = 0;
    Vec3 position{};  ///< of the first
};
/// Throws Error(invalid_argument) that names the first of them.
[[noreturn]] void refuse_unusable(const UnusablePoints& unusable, const UsableRange& range);
/// How many of all points are not usable, the first of them, and what they get; empty if there is none. unusable: those
/// that are not finite, and those too far.
std::string warning_of(const std::array<UnusablePoints, 2>& unusable, std::size_t all, const UsableRange& range,
                       double half_width);

/// The points of a query, of which some may be marks of what is not there: not finite, or too far from the mesh for a
/// distance. They have no nearest triangle.
class UsablePoints {
public:
    /// are_refused: a point that is not usable is an error.
    UsablePoints(std::span<const Vec3> points, bool are_refused) : given_(points), are_refused_(are_refused) {}

    /// Finds the points that are not usable. box: of the mesh. Throws Error(invalid_argument) that names the first if
    /// they are refused.
    void find(const Box& box);

    /// As many as given: after find() another point lies in the place of each that is not usable.
    std::span<const Vec3> points() const { return replaced_.empty() ? given_ : replaced_; }
    std::size_t unusable() const { return unusable_.size(); }
    /// The number of points if none is usable.
    std::size_t first_usable() const { return first_usable_; }

    /// Stores the outputs of those that are not usable among points [begin, begin + count), whose packed arrays these
    /// are: beside the distance, every bit is set. The distance is NaN; half_width, outside, if that and the point are
    /// finite.
    void store(std::size_t begin, std::size_t count, double half_width, const targets::HostArrays& arrays) const;

    /// How many are not usable, the first of them, and what they get; empty if there is none.
    std::string warning(double half_width) const;

private:
    struct Unusable {
        std::size_t index = 0;
        bool is_finite = false;  ///< but too far
    };

    std::span<const Vec3> given_;
    bool are_refused_;
    UsableRange range_;
    std::size_t first_usable_ = 0;
    std::vector<Unusable> unusable_;  // in ascending order
    std::vector<Vec3> replaced_;      // empty if all are usable
};

}  // namespace clsdf::points
