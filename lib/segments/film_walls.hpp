#pragma once

#include "segments/walk.hpp"
#include "tree/wide_tree.hpp"

#include <cstdint>
#include <functional>
#include <span>

/// Walls on a segment or a ray that meets an open mesh whose open edges count for the sign.
namespace clsdf::segments {

/// Walls of a film are found to that part of a link, or of the diagonal of the mesh's box, or of a shorter ray.
constexpr double film_places = 0x1p-30;

/// Where the side changes.
struct Wall {
    double place;
    std::uint32_t triangle;  ///< the lowest of those that are crossed there
};

/// The part [first, last] of a segment or a ray, in places on it.
struct FilmLine {
    engine::SearchedMesh searched;  ///< with a film
    const crossing::Segment& exact;
    Vec3 from, along;  ///< in units, from the origin of the caller's coordinates
    double first, last;
    double resolution;  ///< walls of the film are found to that
    double pair;        ///< two of them that are nearer to each other may be missed
};

/// Calls visit(wall) for the walls in order until it returns true. crossed: sorted. at, at_last: the windings at both
/// ends, with the film. A wall of the film has no triangle.
void walk_with_film(const FilmLine& line, std::span<const Crossed> crossed, SignRule rule, const Windings& at,
                    const Windings& at_last, const std::function<bool(const Wall&)>& visit);

}  // namespace clsdf::segments
