#include "segments/rays.hpp"

#include "core/floating_point.hpp"
#include "core/parallel.hpp"
#include "mesh/mesh_arrays.hpp"
#include "segments/face_hits.hpp"
#include "segments/film_walls.hpp"
#include "segments/open_edges_of_rows.hpp"
#include "segments/walk.hpp"
#include "tree/ray_walk.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace clsdf::segments {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Two films nearer to each other than this part of the diagonal of the mesh's box, or of a shorter line, may be
/// missed.
constexpr double pair_of_films = 0x1p-10;

/// A hit or a wall on a line.
struct Stop {
    double place;
    std::uint32_t face, triangle;
    bool is_rounded;  ///< the place is place_of(); else it is near that
};

/// Looks for the faces on one line after the other. For one thread.
class Search {
public:
    Search(const SearchedFaces& searched, Hits hits)
        : searched_(searched), hits_wanted_(hits), per_unit_(1 / searched.mesh().lattice.unit) {}

    /// The first ones, as real numbers; of those at one place the lowest triangle. `end`: of the line; what lies
    /// farther may be missing.
    std::optional<Stop> first_face(const Line& line, const engine::TreeRay& ray, double end) {
        std::optional<FaceHit> best;
        float bound = ray.end_at(end);
        engine::visit_faces(searched_.tree, ray, bound, [&](std::size_t face) {
            FaceHit hit;
            if (!is_hit(line, face, hit) || (best && !is_before(line, hit, *best))) return false;
            best = hit;
            bound = std::min(bound, ray.end_at(hit.place + hit.error));
            return false;
        });
        if (!best) return std::nullopt;
        return Stop{best->place, best->face, searched_.faces.triangle(best->face), false};
    }

    /// Whether is_within(stop) holds for any face.
    template <typename IsWithin>
    bool finds_face(const Line& line, const engine::TreeRay& ray, double end, const IsWithin& is_within) {
        const float bound = ray.end_at(end);
        return engine::visit_faces(searched_.tree, ray, bound, [&](std::size_t face) {
            FaceHit hit;
            return is_hit(line, face, hit) && is_within(Stop{hit.place, hit.face, 0, false});
        });
    }

    /// Finds all faces up to `end`. Returns whether there are any.
    bool find_faces(const Line& line, const engine::TreeRay& ray, double end) {
        found_.clear();
        const float bound = ray.end_at(end);
        engine::visit_faces(searched_.tree, ray, bound, [&](std::size_t face) {
            FaceHit hit;
            if (is_hit(line, face, hit)) found_.push_back(hit);
            return false;
        });
        return !found_.empty();
    }

    /// The places where the line meets the faces that were found, in order.
    std::span<const Stop> stops(const Line& line) {
        stops_.clear();
        if (sort()) {
            for (const FaceHit& hit : found_) stops_.push_back(stop_at(hit));
            return stops_;
        }
        sort_exactly(line);
        for_each_place(std::span<const Crossed>(crossed_), by_place(line.exact), [&](std::span<const Crossed> faces) {
            stops_.push_back(stop_at(faces[0]));
            return false;
        });
        return stops_;
    }

    /// The winding numbers at the begin of a line without an end, whose faces were found.
    Windings windings_at_begin() const {
        Windings windings;
        for (const FaceHit& hit : found_) windings.add(hit.looks, -hit.change);
        return windings;
    }
    /// Those of any point.
    Windings windings_at(const Vec3& point) {
        const Box& box = searched_.mesh().box;
        const bool is_below = searched_.mesh().is_part || point[0] - box.lower[0] < box.upper[0] - point[0];
        const Vec3 direction{is_below ? -0.5 : 0.5, 0, 0};
        find_faces(Line::ray(engine::scaled(point, per_unit_), direction),
                   engine::tree_ray(searched_.mesh(), point, direction), infinity);
        return windings_at_begin();
    }

    /// Those of any point, with the film.
    Windings windings_with_film(const Vec3& point) {
        // The part of the open edges fits to rays towards -x.
        const Vec3 direction{-0.5, 0, 0}, at = engine::scaled(point, per_unit_);
        find_faces(Line::ray(at, direction), engine::tree_ray(searched_.mesh(), point, direction), infinity);
        Windings windings = windings_at_begin();
        const FilmTree& film = *searched_.mesh().film;
        windings.add(CLSDF_ALL_LOOKS, film.look(point).rounded);
        for_each_open_edge(film.boundary(), per_unit_, [&](const Vec3& a, const Vec3& b) {
            if (is_on_row(a, b, at[1], at[2]) && is_beyond(a, b, at))
                visit_looks_of_edge(a, b, at[1], at[2],
                                    [&](std::uint32_t looks, std::int32_t change) { windings.add(looks, change); });
        });
        return windings;
    }

    /// The walls among the faces that were found and those of the film, in order, on [first, last] of the line. At most
    /// `most` walls, and one behind `end`. Windings: of both ends.
    std::span<const Stop> walls_with_film(const Line& line, double first, double last, const Windings& at,
                                          const Windings& at_last, std::size_t most, double end) {
        stops_.clear();
        sort_exactly(line);
        double square = 0;
        for (const double x : line.along) square += x * x;
        const double size = std::min(searched_.extent.diagonal / std::sqrt(square), last - first);
        walk_with_film({{searched_.mesh(), searched_.tree},
                        line.exact,
                        line.from,
                        line.along,
                        first,
                        last,
                        film_places * size,
                        pair_of_films * size},
                       crossed_, searched_.rule, at, at_last, [&](const Wall& wall) {
                           stops_.push_back({wall.place, 0, wall.triangle, true});
                           return stops_.size() >= most || wall.place > end;
                       });
        return stops_;
    }

    /// The walls among the faces that were found, in order. windings: at the line's begin.
    std::span<const Stop> walls(const Line& line, Windings windings) {
        stops_.clear();
        const auto keep = [&](const auto& face) { stops_.push_back(stop_at(face)); };
        if (sort()) {
            walk(std::span<const FaceHit>(found_), one_by_one, searched_.rule, windings, keep);
            return stops_;
        }
        sort_exactly(line);
        walk(std::span<const Crossed>(crossed_), by_place(line.exact), searched_.rule, windings, keep);
        return stops_;
    }

    double rounded_place(const Line& line, const Stop& stop) const {
        return stop.is_rounded ? stop.place : crossing::place_of(corners_of(stop.face), line.exact);
    }

    Line ray(const Vec3& origin, const Vec3& direction) const {
        return Line::ray(engine::scaled(origin, per_unit_), direction);
    }
    Line segment(const Vec3& from, const Vec3& to) const {
        return Line::segment(engine::scaled(from, per_unit_), engine::scaled(to, per_unit_));
    }
    /// Keeps the faces that were found, while others are looked for.
    void keep() { found_.swap(kept_); }
    void restore() { found_.swap(kept_); }

private:
    engine::CrossedFaces::Corners corners_of(std::size_t face) const {
        return hits_wanted_ == Hits::faces ? searched_.faces.corners(face) : searched_.faces.sign_corners(face);
    }
    Stop stop_at(const FaceHit& hit) const { return {hit.place, hit.face, searched_.faces.triangle(hit.face), false}; }
    static Stop stop_at(const Crossed& face) { return {face.place, 0, face.triangle, true}; }

    bool is_hit(const Line& line, std::size_t face, FaceHit& hit) const {
        if (hits_wanted_ == Hits::walls && searched_.mesh().sign_count(face) == 0) return false;
        if (!meets(line, corners_of(face), hits_wanted_, hit)) return false;
        hit.face = static_cast<std::uint32_t>(face);
        hit.change = static_cast<std::int8_t>(searched_.mesh().sign_count(face) * hit.side);
        return true;
    }

    Crossed crossed_at(const Line& line, const FaceHit& hit) const {
        const engine::CrossedFaces::Corners corners = corners_of(hit.face);
        return {corners, crossing::place_of(corners, line.exact), searched_.faces.triangle(hit.face), hit.looks,
                hit.change};
    }

    /// Exactly; of two at one place the lower triangle.
    bool is_before(const Line& line, const FaceHit& a, const FaceHit& b) const {
        if (std::abs(a.place - b.place) > a.error + b.error) return a.place < b.place;
        std::array<Crossed, 2> both{crossed_at(line, a), crossed_at(line, b)};
        sort_by_place(line.exact, both);
        // Pieces of one face have one number.
        return both[0].triangle == searched_.faces.triangle(a.face) && both[0].corners == corners_of(a.face);
    }

    /// Sorts the faces that were found. Returns false if their places are too near each other for that.
    bool sort() {
        std::ranges::sort(found_, {}, &FaceHit::place);
        for (std::size_t i = 0; i < found_.size(); ++i) {
            if (!(found_[i].error < infinity)) return false;
            if (i > 0 && found_[i].place - found_[i - 1].place <= found_[i].error + found_[i - 1].error) return false;
        }
        return true;
    }
    void sort_exactly(const Line& line) {
        crossed_.clear();
        for (const FaceHit& hit : found_) crossed_.push_back(crossed_at(line, hit));
        sort_by_place(line.exact, crossed_);
    }

    const SearchedFaces& searched_;
    Hits hits_wanted_;
    double per_unit_;
    std::vector<FaceHit> found_, kept_;
    std::vector<Crossed> crossed_;
    std::vector<Stop> stops_;
};

/// Rays of one call.
class RayFinder {
public:
    RayFinder(const SearchedFaces& searched, const RayOptions& options, const RayArrays& arrays)
        : searched_(searched),
          options_(options),
          arrays_(arrays),
          unit_exponent_(std::ilogb(searched.mesh().lattice.unit)),
          search_(searched, options.hits) {}

    void find(std::size_t i, const Vec3& origin, const Vec3& given_direction) {
        if (why_unusable(searched_.mesh(), origin, given_direction)) {
            store(i, {}, std::numeric_limits<double>::quiet_NaN());
            return;
        }
        // Places on the line are multiples of the direction divided by a power of two, in units.
        const int exponent = exponent_of(given_direction);
        const Vec3 direction = times_power(given_direction, -exponent);
        exponent_ = unit_exponent_ - exponent;
        const Line line = search_.ray(origin, direction);
        const engine::TreeRay ray = engine::tree_ray(searched_.mesh(), origin, direction);
        const double limit = std::ldexp(options_.limit, -exponent_);
        const double end = limit + (limit * 0x1p-49 + std::numeric_limits<double>::denorm_min());
        const bool is_first = arrays_.t.is_given() || arrays_.triangles.is_given();
        if (options_.hits == Hits::walls && searched_.mesh().film) {
            const std::size_t most = arrays_.counts.is_given() ? std::numeric_limits<std::size_t>::max()
                                                               : std::max<std::size_t>(arrays_.most, 1);
            store(i, within_limit(line, walls_with_film(line, ray, origin, most, end)));
        } else if (options_.hits == Hits::walls && searched_.mesh().is_part) {
            const Windings windings = search_.windings_at(origin);
            search_.find_faces(line, ray, end);
            store(i, within_limit(line, search_.walls(line, windings)));
        } else if (options_.hits == Hits::walls) {
            search_.find_faces(line, ray, infinity);
            const Windings windings = search_.windings_at_begin();
            store(i, within_limit(line, search_.walls(line, windings)));
        } else if (arrays_.counts.is_given() || (is_first && arrays_.most > 1)) {
            search_.find_faces(line, ray, end);
            store(i, within_limit(line, search_.stops(line)));
        } else if (is_first) {
            if (const std::optional<Stop> first = search_.first_face(line, ray, end))
                store(i, within_limit(line, std::span(&*first, 1)));
            else
                store(i, {});
        } else {
            const auto is_within = [&](const Stop& stop) {
                return std::isinf(options_.limit) || place_on(line, stop) <= options_.limit;
            };
            arrays_.any.set(i, 0, std::uint8_t{search_.finds_face(line, ray, end, is_within)});
        }
    }

private:
    std::span<const Stop> walls_with_film(const Line& line, const engine::TreeRay& ray, const Vec3& origin,
                                          std::size_t most, double end) {
        const auto [first, last] = within_ball(line);
        if (!(first < last)) return {};
        const Windings at = first > 0 ? Windings() : search_.windings_with_film(origin);
        search_.find_faces(line, ray, infinity);
        return search_.walls_with_film(line, first, last, at, {}, most, end);
    }
    /// The part of a ray in the ball beyond which nothing is inside.
    std::pair<double, double> within_ball(const Line& line) const {
        double along = 0, across = 0, squared = 0, far = 0;  // from the origin to the centre
        Vec3 to_centre{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            to_centre[axis] = searched_.extent.centre[axis] - line.from[axis];
            far = std::max(far, std::abs(to_centre[axis]));
            along += to_centre[axis] * line.along[axis];
            squared += line.along[axis] * line.along[axis];
        }
        const double nearest = along / squared;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double x = to_centre[axis] - nearest * line.along[axis];
            across += x * x;
        }
        const double radius = searched_.extent.radius + 0x1p-40 * far, rest = radius * radius - across;
        if (!(rest > 0)) return {0, 0};
        const double half = std::sqrt(rest / squared);
        return {std::max(nearest - half, 0.0), nearest + half};
    }

    /// In lengths of the direction.
    double place_on(const Line& line, const Stop& stop) const {
        return std::ldexp(search_.rounded_place(line, stop), exponent_);
    }

    /// The stops up to the limit; the first `most` of them have their places in lengths of the direction.
    std::span<const Stop> within_limit(const Line& line, std::span<const Stop> stops) {
        within_.assign(stops.begin(), stops.end());
        const bool is_limited = std::isfinite(options_.limit);
        for (std::size_t k = 0; k < within_.size() && (is_limited || k < arrays_.most); ++k) {
            within_[k].place = place_on(line, within_[k]);
            if (within_[k].place <= options_.limit) continue;
            within_.resize(k);
            break;
        }
        return within_;
    }

    void store(std::size_t i, std::span<const Stop> stops, double of_missing = infinity) const {
        for (std::size_t k = 0; k < arrays_.most; ++k) {
            const bool is_there = k < stops.size();
            if (arrays_.t.is_given()) arrays_.t.set_real(i, k, is_there ? stops[k].place : of_missing);
            if (arrays_.triangles.is_given()) arrays_.triangles.set(i, k, is_there ? stops[k].triangle : no_triangle);
        }
        if (arrays_.counts.is_given()) arrays_.counts.set(i, 0, static_cast<std::uint32_t>(stops.size()));
        if (arrays_.any.is_given()) arrays_.any.set(i, 0, std::uint8_t{!stops.empty()});
    }

    const SearchedFaces& searched_;
    const RayOptions& options_;
    const RayArrays& arrays_;
    int unit_exponent_, exponent_ = 0;
    Search search_;
    std::vector<Stop> within_;
};

bool is_visible(const SearchedFaces& searched, Search& search, const Vec3& from, const Vec3& to, Hits hits) {
    if (why_unusable_pair(searched.mesh(), from, to)) return false;
    if (from == to) return true;
    // A pair and its reverse are one segment: what is found of a film depends on its direction.
    if (hits == Hits::walls && searched.mesh().film && to < from) return is_visible(searched, search, to, from, hits);
    const Line line = search.segment(from, to);
    const int exponent = exponent_of(line.along);
    const engine::TreeRay ray = engine::tree_ray(searched.mesh(), from, times_power(line.along, -exponent));
    const double end = std::ldexp(1 + 0x1p-40, exponent);
    if (hits == Hits::faces) return !search.finds_face(line, ray, end, [](const Stop&) { return true; });
    if (searched.mesh().film) {
        const Windings at = search.windings_with_film(from), at_last = search.windings_with_film(to);
        search.find_faces(line, ray, end);
        return search.walls_with_film(line, 0, 1, at, at_last, 1, 1).empty();
    }
    if (!search.find_faces(line, ray, end)) return true;
    search.keep();
    const Windings windings = search.windings_at(from);
    search.restore();
    return search.walls(line, windings).empty();
}

std::optional<std::string> why_unusable_point(const engine::PointMesh& mesh, const Vec3& p, const char* name) {
    if (!is_finite(p)) return std::string(name) + " is not finite";
    if (!engine::is_exact_in_units(p, 1 / mesh.lattice.unit))
        return std::string(name) +
               " has a coordinate that is not 0 and nearer to it than 2^-300, or farther than 2^300, of 1/256 of "
               "the mesh";
    return std::nullopt;
}

/// Divided by a power of two, so that the greatest component is 1/2 to 1. A component that becomes 0 is too small, too.
bool is_exact_direction(const Vec3& direction) {
    const Vec3 scaled = times_power(direction, -exponent_of(direction));
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (scaled[axis] == 0 && direction[axis] != 0) return false;
    return engine::is_exact_in_units(scaled, 1);
}

// Rays of a task: some hundred microseconds.
constexpr std::size_t grain = 256;

}  // namespace

std::optional<std::string> why_unusable(const engine::PointMesh& mesh, const Vec3& origin, const Vec3& direction) {
    if (auto reason = why_unusable_point(mesh, origin, "its origin")) return reason;
    if (!is_finite(direction)) return "its direction is not finite";
    if (direction == Vec3{}) return "its direction is 0";
    if (!is_exact_direction(direction))
        return "its direction has a component that is not 0 and less than 2^-300 of the greatest one";
    return std::nullopt;
}

std::optional<std::string> why_unusable_pair(const engine::PointMesh& mesh, const Vec3& from, const Vec3& to) {
    if (auto reason = why_unusable_point(mesh, from, "its first point")) return reason;
    return why_unusable_point(mesh, to, "its second point");
}

void find_hits(const SearchedFaces& searched, std::span<const Vec3> origins, std::span<const Vec3> directions,
               const RayOptions& options, const RayArrays& arrays, std::size_t begin, std::size_t end) {
    for_each_range(
        end - begin,
        [&](std::size_t first, std::size_t last) {
            const DefaultFloatingPoint usual_rounding;
            RayFinder finder(searched, options, arrays);
            for (std::size_t i = begin + first; i != begin + last; ++i) finder.find(i, origins[i], directions[i]);
        },
        grain);
}

void find_visible(const SearchedFaces& searched, std::span<const Vec3> from, std::span<const Vec3> to, Hits hits,
                  const targets::ResultArray& visible, std::size_t begin, std::size_t end) {
    for_each_range(
        end - begin,
        [&](std::size_t first, std::size_t last) {
            const DefaultFloatingPoint usual_rounding;
            Search search(searched, hits);
            for (std::size_t i = begin + first; i != begin + last; ++i)
                visible.set(i, 0, std::uint8_t{is_visible(searched, search, from[i], to[i], hits)});
        },
        grain);
}

}  // namespace clsdf::segments
