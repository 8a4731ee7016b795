#include "segments/link_walls.hpp"

#include "segments/film_walls.hpp"

namespace clsdf::segments {

namespace {

/// Two films nearer to each other than this part of a link may be missed.
constexpr double pair_of_films = 0x1p-6;

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
    walk(std::span<const Crossed>(crossed_), by_place(segment), inputs_.rule, at, [&](const Crossed& face) {
        if (met.count++ == 0) {
            met.q = face.place;
            met.triangle = face.triangle;
        }
    });
    return met;
}

Met LinkWalls::faces(const Place& from, const Place& to, std::span<const std::uint32_t> faces) {
    const crossing::Segment segment = crossing::segment(box_.position(from), box_.position(to));
    cross(segment, faces, true);
    Met met;
    for_each_place(std::span<const Crossed>(crossed_), by_place(segment), [&](std::span<const Crossed> faces_there) {
        if (met.count++ == 0) {
            met.q = faces_there[0].place;
            met.triangle = faces_there[0].triangle;
        }
        return false;
    });
    return met;
}

Met LinkWalls::walls_with_film(const Place& from, const Place& to, const crossing::Segment& segment) {
    const FilmTree& film = *faces_.mesh.film;
    const double unit = 1 / box_.scale;
    const Vec3 begin = box_.position(from), end = box_.position(to);
    Vec3 along{};
    for (std::size_t axis = 0; axis < 3; ++axis) along[axis] = end[axis] - begin[axis];
    const auto windings_of = [&](const Place& sample) {
        Windings at = sides_.windings(sample);
        Vec3 p = box_.position(sample);
        for (double& x : p) x *= unit;
        at.add(CLSDF_ALL_LOOKS, film.look(p).rounded);
        return at;
    };
    Met met;
    walk_with_film({{faces_.mesh, *inputs_.tree}, segment, begin, along, 0, 1, film_places, pair_of_films}, crossed_,
                   inputs_.rule, windings_of(from), windings_of(to), [&](const Wall& wall) {
                       if (met.count++ == 0) met = {wall.place, wall.triangle, 1, wall.triangle == no_triangle};
                       return false;
                   });
    return met;
}

}  // namespace clsdf::segments
