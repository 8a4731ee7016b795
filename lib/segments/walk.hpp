#pragma once

#include "mesh/segment_crossings.hpp"

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// From the faces that a segment crosses to the walls on it.
namespace clsdf::segments {

/// The winding number of a point in each of the eight looks (kernels/common/segment_crossings.h), for the rule
/// parity its number of crossings. Off the surface all are equal.
struct Windings {
    std::array<std::int32_t, 8> of_looks{};

    Windings() = default;
    explicit Windings(std::int32_t all) { of_looks.fill(all); }

    void add(std::uint32_t looks, std::int32_t change) {
        for (std::size_t look = 0; look < 8; ++look)
            if ((looks >> look & 1U) != 0) of_looks[look] += change;
    }
    /// In every look; so a point on a wall is outside.
    bool are_inside(SignRule rule) const {
        return std::ranges::all_of(of_looks, [rule](std::int32_t winding) {
            return rule == SignRule::parity ? winding % 2 != 0 : winding != 0;
        });
    }
};

/// A face that a segment crosses.
struct Crossed {
    crossing::Corners corners;  ///< those by which it is crossed
    double place;               ///< place_of()
    std::uint32_t triangle;     ///< the caller's number
    std::uint8_t looks;         ///< in which it is crossed; not 0
    std::int8_t change;         ///< of the winding number along the segment
};

/// Sorts by place, exactly: faces at one place, as real numbers, follow each other by triangle.
void sort_by_place(const crossing::Segment& segment, std::span<Crossed> crossed);
/// The number of faces at the place of the first one. crossed: sorted, not empty.
std::size_t count_at_first_place(const crossing::Segment& segment, std::span<const Crossed> crossed);

/// That number, for the functions below.
inline auto by_place(const crossing::Segment& segment) {
    return [&segment](std::span<const Crossed> sorted) { return count_at_first_place(segment, sorted); };
}
/// Of faces that all have places of their own.
inline constexpr auto one_by_one = [](const auto&) { return std::size_t{1}; };

/// Calls visit(faces) for the faces of each place, in order, until it returns true. count_at_first(sorted): how many
/// are at the place of the first one.
template <typename Face, typename Count, typename Visit>
void for_each_place(std::span<const Face> sorted, const Count& count_at_first, const Visit& visit) {
    while (!sorted.empty()) {
        const std::size_t count = count_at_first(sorted);
        if (visit(sorted.first(count))) return;
        sorted = sorted.subspan(count);
    }
}

/// Calls visit(face) for the first face of each wall, in order. `at`: the windings at the segment's begin; then those
/// behind the last place. Faces at one place change the side together.
template <typename Face, typename Count, typename Visit>
void walk(std::span<const Face> sorted, const Count& count_at_first, SignRule rule, Windings& at, const Visit& visit) {
    bool is_inside = at.are_inside(rule);
    for_each_place(sorted, count_at_first, [&](std::span<const Face> faces) {
        for (const Face& face : faces) at.add(face.looks, face.change);
        if (at.are_inside(rule) != is_inside) {
            is_inside = !is_inside;
            visit(faces[0]);
        }
        return false;
    });
}

}  // namespace clsdf::segments
