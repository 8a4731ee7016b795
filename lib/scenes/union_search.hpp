#pragma once

#include "scenes/least_field.hpp"
#include "scenes/meeting_lines.hpp"
#include "scenes/searched_bodies.hpp"
#include "scenes/union_test.hpp"

#include <cstdint>

namespace clsdf::scenes {

/// The nearest point on the surface of the union of the bodies, of a point that is inside it.
///
/// The closest point of the union is the closest point of a face, if the face is on the union around it; else it lies
/// where this face meets another body (docs/scenes.md has the proof). So the candidates are the closest points of the
/// faces, the nearest first, as far as they are on the union; and the lines in which bodies meet.
class UnionSearch {
public:
    UnionSearch(const SearchedScene& scene, const MeetingLines& lines) : lines_(lines), test_(scene) {}

    struct Nearest {
        std::uint32_t body = no_body;  ///< no_body: nothing is within the limit
        std::uint32_t face = CLSDF_NO_FACE;
        bool is_cut = false;  ///< the closest point is on a meeting line
        Vec3 closest{};       ///< in the scene's coordinates
        double distance = 0;
    };
    /// least: no point of the surface is nearer. For callers that have made a DefaultFloatingPoint; for any number of
    /// threads.
    Nearest nearest(const Vec3& p, double least, double most) const;

private:
    /// In one body: changes `found` if that is nearer.
    void search_body(std::uint32_t body, const Vec3& p, double least, double most, Nearest& found) const;

    const MeetingLines& lines_;
    UnionTest test_;
};

}  // namespace clsdf::scenes
