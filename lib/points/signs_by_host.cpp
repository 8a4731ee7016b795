#include "points/signs_by_host.hpp"

#include "core/parallel.hpp"
#include "mesh/predicates.hpp"
#include "surface/ray_side.hpp"

#include "point_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace clsdf::points {

namespace {

using Corners = std::array<Vec3, 3>;

// Above all roundings of points in units, relative to their coordinates, and of distances; and above what joining moves
// the surface that decides the sign, of a mesh that is 512 units long.
constexpr double rounding = 1e-9;
static_assert(1.7321 * 512 * joined_extent < rounding);

/// 1: the point is in front of the face; -1: behind it; 0: in its plane.
int side_of_face(const Corners& corners, const Vec3& p) {
    const auto& [a, b, c] = corners;
    return orientation(a, b, c, p);
}

/// The sense in which the line p -> q turns around a -> b; 0 if they meet.
int turn_of(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
    return orientation(p, q, a, b);
}

/// Between a and b on their line.
bool is_on_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (p[axis] < std::min(a[axis], b[axis]) || p[axis] > std::max(a[axis], b[axis])) return false;
    return are_collinear(a, b, p);
}

bool is_on_triangle(const Corners& corners, const Vec3& p) {
    const auto& [a, b, c] = corners;
    if (side_of_face(corners, p) != 0) return false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t first = (axis + 1) % 3, second = (axis + 2) % 3;
        const int turn = side_of_line(a, b, c, first, second);
        if (turn == 0) continue;
        return turn * side_of_line(a, b, p, first, second) >= 0 && turn * side_of_line(b, c, p, first, second) >= 0 &&
               turn * side_of_line(c, a, p, first, second) >= 0;
    }
    return is_on_segment(a, b, p) || is_on_segment(b, c, p) || is_on_segment(c, a, p);
}

bool is_on_surface(const engine::SearchedMesh& searched, const Vec3& p, const Vec3& in_units) {
    return engine::visit_faces(searched.tree, engine::UnitBox(in_units),
                               [&](std::size_t face) { return is_on_triangle(searched.mesh.corners(face), p); });
}

/// Whether the face lies beyond the box of two points on an axis.
bool is_apart(const Corners& corners, const Vec3& p, const Vec3& q, std::size_t axis) {
    const auto [low, high] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
    return high < std::min(p[axis], q[axis]) || low > std::max(p[axis], q[axis]);
}

/// On the ray along x from a point that is not on the surface.
Crossings crossings_of_ray(const engine::SearchedMesh& searched, const Vec3& from, const Vec3& in_units,
                           bool is_forward) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const engine::PointMesh& mesh = searched.mesh;
    engine::UnitBox box(in_units);
    (is_forward ? box.upper : box.lower)[0] = static_cast<float>(is_forward ? infinity : -infinity);
    Vec3 to = from;
    to[0] = is_forward ? infinity : -infinity;
    Crossings crossings;
    engine::visit_faces(searched.tree, box, [&](std::size_t face) {
        const int count = mesh.sign_count(face);
        if (count == 0) return false;
        const Corners corners = mesh.sign_corners(face);
        const auto& [a, b, c] = corners;
        if (is_apart(corners, from, to, 1) || is_apart(corners, from, to, 2) || is_apart(corners, from, to, 0))
            return false;
        const int side = side_of_edges(a, b, c, from);
        if (side == 0) return false;
        // 1: the point is in front of the face. If that is `side`, the crossing has a smaller x than the point.
        const int front = side_of_face(corners, from);
        if ((front == side) == is_forward) return false;
        ++crossings.count;
        crossings.winding += count * (is_forward ? side : -side);
        return false;
    });
    return crossings;
}

/// The same to the nearer side of the mesh's box; of a part of a mesh to the lower one.
Crossings crossings_of_ray(const engine::SearchedMesh& searched, const Vec3& from, const Vec3& in_units) {
    const engine::PointMesh& mesh = searched.mesh;
    return crossings_of_ray(searched, from, in_units,
                            !mesh.is_part && from[0] - mesh.box.lower[0] > mesh.box.upper[0] - from[0]);
}

/// The same towards -x, to which the part of open edges fits.
int winding_of_ray(const engine::SearchedMesh& searched, const Vec3& from) {
    return crossings_of_ray(searched, from, searched.mesh.in_units(from), false).winding;
}

/// On the way from `from`, whose crossings are known, straight to `to`; neither is on the surface. Nothing if it meets
/// an edge or runs in a face's plane: there exact predicates do not tell.
std::optional<Crossings> crossings_along(const engine::SearchedMesh& searched, const Vec3& from, const Vec3& to,
                                         const engine::UnitBox& box, Crossings crossings) {
    const engine::PointMesh& mesh = searched.mesh;
    const bool is_undecided = engine::visit_faces(searched.tree, box, [&](std::size_t face) {
        const int count = mesh.sign_count(face);
        if (count == 0) return false;
        const Corners corners = mesh.sign_corners(face);
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (is_apart(corners, from, to, axis)) return false;
        const auto& [a, b, c] = corners;
        const int before = side_of_face(corners, from), behind = side_of_face(corners, to);
        if (before == behind) return before == 0 && !are_collinear(a, b, c);
        if (before == 0 || behind == 0) return false;  // only an end is in the plane, and not on the face
        const std::array<int, 3> turns{turn_of(from, to, a, b), turn_of(from, to, b, c), turn_of(from, to, c, a)};
        const auto [least, most] = std::minmax({turns[0], turns[1], turns[2]});
        if (least < 0 && most > 0) return false;
        if (least == 0 || most == 0) return true;
        ++crossings.count;
        crossings.winding -= count * behind;
        return false;
    });
    return is_undecided ? std::nullopt : std::optional(crossings);
}

/// A ball without surface around a point whose crossings are known. Lengths are in units.
struct KnownBall {
    Vec3 centre;
    Vec3 callers;  ///< the same in the caller's coordinates
    double radius;
    Crossings crossings;
};

/// The last few of them.
class KnownBalls {
public:
    struct Found {
        const KnownBall* ball;  ///< whose centre is nearest; null if there is none
        double distance;        ///< of the centre
        bool is_free;           ///< no surface lies between
    };

    /// Finds a ball that contains the point, or whose centre is in the point's own ball; else the nearest ball.
    Found find(const Vec3& p, double radius) const {
        Found found{nullptr, std::numeric_limits<double>::infinity(), false};
        for (std::size_t i = 0; i < count_; ++i) {
            const KnownBall& ball = balls_[i];
            double squared = 0, size = 1;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double difference = p[axis] - ball.centre[axis];
                squared += difference * difference;
                size += std::abs(p[axis]) + std::abs(ball.centre[axis]);
            }
            const double distance = std::sqrt(squared);
            if (distance + rounding * size < std::max(radius, ball.radius)) return {&ball, distance, true};
            if (distance < found.distance) found = {&ball, distance, false};
        }
        return found;
    }

    void add(const KnownBall& ball) {
        balls_[next_] = ball;
        count_ = std::max(count_, ++next_);
        next_ %= balls_.size();
    }

private:
    std::array<KnownBall, 8> balls_{};
    std::size_t count_ = 0, next_ = 0;
};

/// The radius of the smallest ball that is kept, in units: nearer to an open edge, rounding may decide.
constexpr double least_free = 1e-5;
/// The part of a ball without surface in which the film is looked for: open edges may lie on the ball's border.
constexpr double share_without_edges = 0.75;

/// A way longer than that, in units, meets more faces than a ray.
constexpr double longest_way = 16;

/// is_apart: the point is not on the surface that decides the sign.
Crossings crossings_of(const engine::SearchedMesh& searched, const Vec3& p, const Vec3& in_units,
                       const KnownBalls::Found& known, bool is_apart) {
    if (known.is_free) return known.ball->crossings;
    if (is_apart && known.distance < longest_way && !searched.mesh.has_several_regions) {
        engine::UnitBox box(in_units);
        box.add(engine::UnitBox(known.ball->centre));
        if (const auto crossings = crossings_along(searched, known.ball->callers, p, box, known.ball->crossings))
            return *crossings;
    }
    return crossings_of_ray(searched, p, in_units);
}

/// The same of the walls of the rule `below`, to which no ball comes near that is kept.
int winding_number_with_walls(const engine::SearchedMesh& searched, const Vec3& p, const Vec3& in_units, double radius,
                              KnownBalls& balls) {
    if (const KnownBalls::Found known = balls.find(in_units, 0); known.is_free) return known.ball->crossings.winding;
    const Walls& walls = *searched.mesh.walls;
    const Crossings crossings{winding_of_ray(searched, p) + walls.crossings(p), 0};
    for (const double free : {radius, 0.25 * radius}) {
        if (!(free > least_free)) break;
        const Box around = widened({p, p}, free * searched.mesh.lattice.unit);
        if (walls.may_meet(around) || (around.lower[2] <= walls.floor() && around.upper[2] >= walls.floor())) continue;
        balls.add({in_units, p, free, crossings});
        break;
    }
    return crossings.winding;
}

/// The winding number of a point, rounded to an integer, a half up. radius: of a ball without surface around it.
int winding_number_with_film(const engine::SearchedMesh& searched, const Vec3& p, const Vec3& in_units, double radius,
                             KnownBalls& balls) {
    if (const KnownBalls::Found known = balls.find(in_units, 0); known.is_free) return known.ball->crossings.winding;
    const FilmTree& film = *searched.mesh.film;
    const FilmTree::View view = film.look(p);
    const Crossings crossings{winding_of_ray(searched, p) + view.rounded, 0};
    // The change in a ball grows with its radius, at least as fast: so the film is as far away as this says.
    const double most = share_without_edges * radius, change = film.change_within(p, most);
    const double free = change > view.to_half ? most * (view.to_half / change) : most;
    if (free > least_free) balls.add({in_units, p, free, crossings});
    return crossings.winding;
}

}  // namespace

bool is_inside_walls(const engine::SearchedMesh& searched, const Vec3& point) {
    return winding_of_ray(searched, point) + searched.mesh.walls->crossings(point) != 0;
}

std::optional<int> rounded_winding_number(const engine::SearchedMesh& searched, const Vec3& centre, double radius) {
    const FilmTree& film = *searched.mesh.film;
    const double change = film.change_within(centre, radius);
    if (!(change < 0.5)) return std::nullopt;
    const FilmTree::View view = film.look(centre, change);
    if (!(change < view.to_half)) return std::nullopt;
    return winding_of_ray(searched, centre) + view.rounded;
}

int rounded_winding_number(const engine::SearchedMesh& searched, const Vec3& point) {
    return winding_of_ray(searched, point) + searched.mesh.film->look(point).rounded;
}

double winding_number(const engine::SearchedMesh& searched, const OpenBoundary& boundary, const Vec3& point) {
    if (searched.mesh.walls) return winding_of_ray(searched, point) + searched.mesh.walls->crossings(point);
    return winding_of_ray(searched, point) + angle_of(boundary, point, searched.mesh.lattice.unit).turns;
}

Crossings count_crossings(const engine::SearchedMesh& searched, const Vec3& point, const Vec3& in_units) {
    return crossings_of_ray(searched, point, in_units);
}

void find_signs(const engine::SearchedMesh& searched, SignRule rule, const LocatedPoints& points,
                std::span<std::uint8_t> signs) {
    constexpr std::size_t together = 256;
    const engine::PointMesh& mesh = searched.mesh;
    const Box sign_box = mesh.sign_box();
    for_each_chunk(points.order.size(), together, [&](std::size_t, std::size_t begin, std::size_t end) {
        KnownBalls balls;
        for (std::size_t i = begin; i < end; ++i) {
            if (signs[i] != CLSDF_POINT_UNDECIDED) continue;
            signs[i] = CLSDF_POINT_OUTSIDE;
            const Vec3& p = points.callers[points.order[i]];
            if (!mesh.film && !engine::contains(sign_box, p)) continue;
            const double distance = std::sqrt(points.squared[i]), radius = distance * (1 - rounding) - rounding;
            const Vec3 in_units = mesh.in_units(p);
            if (distance < CLSDF_NEARLY_ON_SURFACE && is_on_surface(searched, p, in_units)) {
                signs[i] = CLSDF_POINT_ON_SURFACE;
                continue;
            }
            if (rule == SignRule::none) continue;
            if (mesh.film) {
                if (winding_number_with_film(searched, p, in_units, radius, balls) != 0) signs[i] = CLSDF_POINT_INSIDE;
                continue;
            }
            if (mesh.walls) {
                if (winding_number_with_walls(searched, p, in_units, radius, balls) != 0) signs[i] = CLSDF_POINT_INSIDE;
                continue;
            }
            const KnownBalls::Found known = balls.find(in_units, radius);
            // On the surface with joined vertices a point has the crossings of either side: no way begins or ends
            // there.
            const bool is_apart = mesh.sign_positions.empty() || radius > 0;
            const Crossings crossings = crossings_of(searched, p, in_units, known, is_apart);
            if (crossings.are_inside(rule)) signs[i] = CLSDF_POINT_INSIDE;
            if (!known.is_free && is_apart) balls.add({in_units, p, radius, crossings});
        }
    });
}

}  // namespace clsdf::points
