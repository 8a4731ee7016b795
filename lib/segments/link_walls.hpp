#pragma once

#include "segments/links.hpp"
#include "segments/sample_sides.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::segments {

/// What is found on a link, from its sample on.
struct Met {
    double q = 0;
    std::uint32_t triangle = no_triangle;
    std::uint32_t count = 0;  ///< 0: nothing is met
    bool is_film = false;     ///< the first wall is one

    /// What is said of the first wall.
    SegmentFlag flag() const {
        if (is_film) return SegmentFlag::film;
        return triangle == no_triangle ? SegmentFlag::closing : SegmentFlag::none;
    }
};

/// Finds the walls on a link from the faces that may cross it. For one thread.
class LinkWalls {
public:
    LinkWalls(const LinkInputs& inputs, const engine::CrossedFaces& faces, const SampleBox& box, const BoxSides& sides)
        : inputs_(inputs), faces_(faces), box_(box), sides_(sides) {}

    /// faces: those that may be crossed, and no other face is.
    Met walls(const Place& from, const Place& to, std::span<const std::uint32_t> faces);
    /// The faces as given.
    Met faces(const Place& from, const Place& to, std::span<const std::uint32_t> faces);

private:
    /// Sets crossed_ and sorts it.
    void cross(const crossing::Segment& segment, std::span<const std::uint32_t> faces, bool as_given);
    Met walls_with_film(const Place& from, const Place& to, const crossing::Segment& segment);

    const LinkInputs& inputs_;
    const engine::CrossedFaces& faces_;
    const SampleBox& box_;
    const BoxSides& sides_;
    std::vector<Crossed> crossed_;
};

}  // namespace clsdf::segments
