#pragma once

#include "scenes/least_field.hpp"
#include "scenes/searched_bodies.hpp"
#include "targets/host_arrays.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Points among many bodies, by the host.
///
/// The value of a point is the least of the bodies' signed distances. First the bodies whose boxes hold the point are
/// asked, for their sign and their distance: no other body can have the point inside. The one whose box holds it
/// deepest comes first; a face of another one that is farther away than the least value so far counts only if the point
/// is inside that one. If it is in none of them, the others are searched, the nearest box first, within the least
/// distance so far.
namespace clsdf::scenes {

/// Packed results.
struct SceneArrays {
    targets::HostArrays arrays;  ///< the distance may have none
    std::uint8_t* is_own = nullptr;
    std::uint8_t* is_inside = nullptr;
};

/// The points that are not usable.
struct UnusableOfScene {
    std::size_t count = 0;
    std::size_t first = 0;
    bool is_finite = false;  ///< the first
};

/// A point and the body that it is looked up in.
struct Asked {
    std::uint32_t point;
    std::uint32_t body;
};

/// The outputs of points. Results do not depend on other points or on threads. A point beyond all half widths is beyond
/// the greatest one.
UnusableOfScene answer_points(const SearchedScene& scene, std::span<const Vec3> points, const HalfWidths& half_widths,
                              const SceneArrays& results);

/// The outputs of pairs: those of the body alone. All of the bodies are on. Of the points that are not usable, `first`
/// is a pair.
UnusableOfScene answer_pairs(const SearchedScene& scene, std::span<const Vec3> points, std::span<const Asked> pairs,
                             const HalfWidths& half_widths, const targets::HostArrays& arrays);

}  // namespace clsdf::scenes
