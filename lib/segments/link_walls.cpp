#include "segments/link_walls.hpp"

#include "points/signs_by_host.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::segments {

namespace {

/// A film is found to that part of a link; two films nearer to each other than this part may be missed.
constexpr double film_places = 0x1p-30, pair_of_films = 0x1p-6;

}  // namespace

void LinkWalls::cross(const crossing::Segment& segment, std::span<const std::uint32_t> faces, bool as_given) {
    crossed_.clear();
    for (const std::uint32_t face : faces) {
        const int count = as_given ? 1 : faces_.mesh.sign_count(face);
        if (count == 0) continue;
        const crossing::Corners corners = as_given ? faces_.corners(face) : faces_.sign_corners(face);
        const crossing::FaceCrossing found = crossing::crossing_of(corners, segment);
        if (found.looks == 0) continue;
        crossed_.push_back({corners, crossing::place_of(corners, segment), faces_.triangle(face),
                            static_cast<std::uint8_t>(found.looks), static_cast<std::int8_t>(count * found.side)});
    }
    sort_by_place(segment, crossed_);
}

Met LinkWalls::walls(const Place& from, const Place& to, std::span<const std::uint32_t> faces) {
    const crossing::Segment segment = crossing::segment(box_.position(from), box_.position(to));
    cross(segment, faces, false);
    if (faces_.mesh.film) return walls_with_film(from, to, segment);
    Met met;
    Windings at = sides_.windings(from);
    walk(segment, crossed_, inputs_.rule, at, [&](const Wall& wall) {
        if (met.count++ == 0) {
            met.q = wall.place;
            met.triangle = wall.triangle;
        }
        return false;
    });
    return met;
}

Met LinkWalls::faces(const Place& from, const Place& to, std::span<const std::uint32_t> faces) {
    const crossing::Segment segment = crossing::segment(box_.position(from), box_.position(to));
    cross(segment, faces, true);
    Met met;
    for (std::span<const Crossed> rest = crossed_; !rest.empty();
         rest = rest.subspan(count_at_first_place(segment, rest)))
        if (met.count++ == 0) {
            met.q = rest[0].place;
            met.triangle = rest[0].triangle;
        }
    return met;
}

// Between faces the winding number changes where it passes a half integer. There it is asked for at points, down to
// film_places.
Met LinkWalls::walls_with_film(const Place& from, const Place& to, const crossing::Segment& segment) {
    const FilmTree& film = *faces_.mesh.film;
    const double unit = 1 / box_.scale;
    const auto callers = [unit](const Vec3& p) { return Vec3{p[0] * unit, p[1] * unit, p[2] * unit}; };
    const Vec3 begin = box_.position(from), end = box_.position(to);
    double length = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) length += (end[axis] - begin[axis]) * (end[axis] - begin[axis]);
    length = std::sqrt(length);
    const auto point = [&](double place) {
        Vec3 p{};
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = std::fma(place, end[axis] - begin[axis], begin[axis]);
        return callers(p);
    };
    const auto windings_of = [&](const Place& sample) {
        Windings at = sides_.windings(sample);
        at.add(CLSDF_ALL_LOOKS, film.look(callers(box_.position(sample))).rounded);
        return at;
    };
    const auto winding_at = [&](double place) {
        return points::rounded_winding_number({faces_.mesh, *inputs_.tree}, point(place));
    };
    /// Whether open edges do not change the winding number there.
    const auto is_without_film = [&](double low, double high) {
        const Vec3 middle = point(0.5 * (low + high));
        const double change = film.change_within(middle, 0.5 * (high - low) * length * (1 + 1e-9));
        return change < 0.5 && change < film.look(middle, change).to_half;
    };
    Met met;
    Windings at = windings_of(from);
    bool is_inside = at.are_inside(inputs_.rule);
    const auto update = [&](double place, std::uint32_t triangle) {
        if (at.are_inside(inputs_.rule) == is_inside) return;
        is_inside = !is_inside;
        if (met.count++ == 0) met = {place, triangle, 1, triangle == no_triangle};
    };
    const auto set_winding = [&](double place, int winding) {
        at.add(CLSDF_ALL_LOOKS, winding - at.of_looks[0]);
        update(place, no_triangle);
    };
    // From `low` on, where the winding number is that of `at`, to `high`, where it is `winding`.
    const auto find = [&](const auto& self, double low, double high, int winding) -> void {
        if (winding == at.of_looks[0] && (high - low <= pair_of_films || is_without_film(low, high))) return;
        if (high - low <= film_places) return set_winding(0.5 * (low + high), winding);
        const double middle = 0.5 * (low + high);
        self(self, low, middle, winding_at(middle));
        self(self, middle, high, winding);
    };
    // The same to a face, where the winding number is not known.
    const auto find_to_face = [&](double low, double high) {
        while (high - low > film_places && !is_without_film(low, high)) {
            const double middle = 0.5 * (low + high);
            find(find, low, middle, winding_at(middle));
            low = middle;
        }
    };
    double low = 0;
    for (std::span<const Crossed> rest = crossed_; !rest.empty();) {
        const std::size_t count = count_at_first_place(segment, rest);
        find_to_face(low, rest[0].place);
        for (const Crossed& face : rest.first(count)) at.add(face.looks, face.change);
        low = rest[0].place;
        update(low, rest[0].triangle);
        rest = rest.subspan(count);
    }
    const Windings last = windings_of(to);
    // Looks differ at the end alone; the last wall is there then.
    find(find, low, 1, last.of_looks[0]);
    at = last;
    update(1, no_triangle);
    return met;
}

}  // namespace clsdf::segments
