// Rays and pairs of points against rational arithmetic, through the public interface. Walls are counted by eight rays
// that are really moved: on meshes with small whole coordinates a move of 2^-40 is as small as any.

#include "support/device_memory.hpp"
#include "support/exact_distance.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <boost/multiprecision/cpp_int.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <thread>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Hit {
    Rational t;
    std::uint32_t triangle;
    bool operator==(const Hit&) const = default;
};

RationalPoint sum(const RationalPoint& a, const Rational& times, const RationalPoint& b) {
    return {a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]};
}

/// The hits of closed triangles, by the points where the line meets their planes.
std::vector<Hit> hits_of_faces(const Mesh& mesh, const Vec3& from, const RationalPoint& along) {
    std::map<Rational, std::uint32_t> lowest;
    const RationalPoint p = rational(from);
    for (std::uint32_t triangle = 0; triangle < mesh.triangles().size(); ++triangle) {
        std::array<RationalPoint, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = rational(mesh.vertices()[mesh.triangles()[triangle][k]]);
        const RationalPoint normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
        const Rational approach = dot(normal, along);
        if (approach == 0) continue;
        const Rational t = dot(normal, minus(corners[0], p)) / approach;
        if (t < 0) continue;
        const RationalPoint meets = sum(p, t, along);
        bool is_within = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const RationalPoint edge = minus(corners[(k + 1) % 3], corners[k]);
            is_within = is_within && dot(normal, cross(edge, minus(meets, corners[k]))) >= 0;
        }
        if (is_within) lowest.emplace(t, triangle);  // keeps the first
    }
    std::vector<Hit> hits;
    for (const auto& [t, triangle] : lowest) hits.push_back({t, triangle});
    return hits;
}

/// Numbers of six hundred bits without memory of their own.
using Integer = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<
    640, 640, boost::multiprecision::signed_magnitude, boost::multiprecision::unchecked, void>>;
using IntegerPoint = std::array<Integer, 3>;

IntegerPoint difference(const IntegerPoint& a, const IntegerPoint& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
IntegerPoint product(const IntegerPoint& a, const IntegerPoint& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Integer inner(const IntegerPoint& a, const IntegerPoint& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Walls by moves of 2^-40, 2^-80 and 2^-120, for vertices, origins and directions that are multiples of 1/2 below 200.
class MovedRays {
public:
    MovedRays(const Mesh& mesh, SignRule rule) : mesh_(mesh), rule_(rule) {
        for (const Vec3& vertex : mesh.vertices()) vertices_.push_back(in_steps(vertex));
    }

    std::vector<Hit> walls(const Vec3& from, const Vec3& direction) const {
        struct Change {
            std::uint32_t triangle;
            std::array<int, 8> of_looks{};
        };
        std::map<Rational, Change> changes;
        std::array<int, 8> windings{};
        for (std::size_t look = 0; look < 8; ++look) {
            const IntegerPoint moved = moved_by(from, look);
            for (std::uint32_t triangle = 0; triangle < mesh_.triangles().size(); ++triangle) {
                // The other way out than the ray's, to which it must fit.
                windings[look] -= change_of(moved, {2, 0, 0}, triangle);
                const int change = change_of(moved, doubled(direction), triangle);
                if (change == 0) continue;
                Change& there = changes.try_emplace(place(from, direction, triangle), Change{triangle}).first->second;
                there.triangle = std::min(there.triangle, triangle);
                there.of_looks[look] += change;
            }
        }
        std::vector<Hit> walls;
        bool is_inside = are_inside(windings);
        for (const auto& [t, change] : changes) {
            for (std::size_t look = 0; look < 8; ++look) windings[look] += change.of_looks[look];
            if (are_inside(windings) == is_inside) continue;
            is_inside = !is_inside;
            walls.push_back({t, change.triangle});
        }
        return walls;
    }

    bool is_inside(const Vec3& point) const {
        std::array<int, 8> windings{};
        for (std::size_t look = 0; look < 8; ++look)
            for (std::uint32_t triangle = 0; triangle < mesh_.triangles().size(); ++triangle)
                windings[look] -= change_of(moved_by(point, look), {2, 0, 0}, triangle);
        return are_inside(windings);
    }

private:
    static IntegerPoint doubled(const Vec3& v) {
        IntegerPoint result;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            BOOST_REQUIRE(2 * v[axis] == std::round(2 * v[axis]));
            result[axis] = static_cast<long>(2 * v[axis]);
        }
        return result;
    }
    /// Steps of 2^-121.
    static IntegerPoint in_steps(const Vec3& v) {
        IntegerPoint result = doubled(v);
        for (Integer& coordinate : result) coordinate *= Integer(1) << 120;
        return result;
    }
    static IntegerPoint moved_by(const Vec3& from, std::size_t look) {
        IntegerPoint moved = in_steps(from);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Integer step = Integer(1) << static_cast<int>(80 - 40 * axis);
            moved[axis] += (look >> axis & 1) != 0 ? -step : step;
        }
        return moved;
    }
    /// Of the winding number along a ray that meets no edge.
    int change_of(const IntegerPoint& from, const IntegerPoint& along, std::uint32_t triangle) const {
        std::array<IntegerPoint, 3> to;
        for (std::size_t k = 0; k < 3; ++k) to[k] = difference(vertices_[mesh_.triangles()[triangle][k]], from);
        const IntegerPoint normal = product(difference(to[1], to[0]), difference(to[2], to[0]));
        const Integer approach = inner(normal, along);
        if (approach == 0) return 0;
        int turns = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Integer turn = inner(along, product(to[k], to[(k + 1) % 3]));
            BOOST_REQUIRE(turn != 0);
            turns += turn > 0 ? 1 : -1;
        }
        if (std::abs(turns) != 3) return 0;
        const Integer ahead = inner(normal, to[0]);
        BOOST_REQUIRE(ahead != 0);
        if ((ahead > 0) != (approach > 0)) return 0;
        return approach < 0 ? 1 : -1;
    }
    Rational place(const Vec3& from, const Vec3& direction, std::uint32_t triangle) const {
        std::array<RationalPoint, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = rational(mesh_.vertices()[mesh_.triangles()[triangle][k]]);
        const RationalPoint normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
        return dot(normal, minus(corners[0], rational(from))) / dot(normal, rational(direction));
    }
    bool are_inside(const std::array<int, 8>& windings) const {
        return std::ranges::all_of(
            windings, [&](int winding) { return rule_ == SignRule::parity ? winding % 2 != 0 : winding != 0; });
    }

    const Mesh& mesh_;
    SignRule rule_;
    std::vector<IntegerPoint> vertices_;
};

/// The distance of two doubles that follow each other at t.
Rational ulp_of(const Rational& t) {
    const double nearest = std::abs(t.convert_to<double>());
    return Rational(std::nextafter(nearest, infinity)) - Rational(nearest);
}

struct Rays {
    std::vector<Vec3> origins, directions;

    void add(const Vec3& origin, const Vec3& direction) {
        if (direction == Vec3{}) return;
        origins.push_back(origin);
        directions.push_back(direction);
    }
};

/// All that can be asked of rays, `most` hits of each.
struct Answers {
    std::size_t most = 0;
    std::vector<double> t;
    std::vector<std::uint32_t> triangles, counts;
    std::vector<std::uint8_t> any;
    TransformStatistics statistics;
};

Answers answers_of(const DistanceTransform& transform, const Rays& rays, const RayOptions& options,
                   std::size_t most = 4, const CallOptions& call = {}) {
    const std::size_t count = rays.origins.size();
    Answers answers;
    answers.most = most;
    answers.t.resize(count * most);
    answers.triangles.resize(count * most);
    answers.counts.resize(count);
    answers.any.resize(count);
    answers.statistics = transform.rays(
        rays.origins, rays.directions, options,
        {.most = most, .t = answers.t, .triangles = answers.triangles, .counts = answers.counts, .any = answers.any},
        call);
    return answers;
}

/// Compares all answers of one ray.
bool agree(const Answers& answers, std::size_t i, const std::vector<Hit>& expected) {
    bool agrees = answers.counts[i] == expected.size() && answers.any[i] == (expected.empty() ? 0 : 1);
    for (std::size_t k = 0; k < answers.most; ++k) {
        const double t = answers.t[i * answers.most + k];
        const std::uint32_t triangle = answers.triangles[i * answers.most + k];
        if (k >= expected.size()) {
            agrees = agrees && t == infinity && triangle == no_triangle;
            continue;
        }
        const Rational& exact = expected[k].t;
        agrees = agrees && std::isfinite(t) && triangle == expected[k].triangle &&
                 abs(Rational(t) - exact) * 100 <= ulp_of(exact) * 51;
    }
    return agrees;
}

std::string text_of(const Rays& rays, std::size_t i) {
    const Vec3 &o = rays.origins[i], &d = rays.directions[i];
    return "ray " + std::to_string(i) + " from (" + std::to_string(o[0]) + ", " + std::to_string(o[1]) + ", " +
           std::to_string(o[2]) + ") along (" + std::to_string(d[0]) + ", " + std::to_string(d[1]) + ", " +
           std::to_string(d[2]) + ")";
}

/// The first hit alone, without its neighbours: another search.
void check_first(const DistanceTransform& transform, const Rays& rays, const RayOptions& options, const Answers& all) {
    const std::size_t count = rays.origins.size();
    std::vector<double> t(count);
    std::vector<std::uint32_t> triangles(count);
    std::vector<std::uint8_t> any(count);
    transform.rays(rays.origins, rays.directions, options, {.t = t, .triangles = triangles});
    transform.rays(rays.origins, rays.directions, options, {.any = any});
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < count; ++i)
        if (t[i] != all.t[i * all.most] || triangles[i] != all.triangles[i * all.most] || any[i] != all.any[i]) ++wrong;
    BOOST_TEST(wrong == 0U);
}

/// From lattice points and the mesh's vertices, edges and faces, along few directions and to such points.
Rays rays_about(const Mesh& mesh, Random& random, std::size_t count) {
    const auto round_to_half = [](double x) { return std::round(2 * x) / 2; };
    const auto corner = [&](std::uint32_t triangle, std::size_t k) {
        return mesh.vertices()[mesh.triangles()[triangle][k % 3]];
    };
    const auto special = [&]() -> Vec3 {
        const auto triangle = random.index(mesh.triangles().size());
        const Vec3 a = corner(triangle, 0), b = corner(triangle, 1 + random.index(2));
        Vec3 p{};
        const std::uint32_t kind = random.index(4);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double lower = mesh.box().lower[axis] - 2, upper = mesh.box().upper[axis] + 2;
            p[axis] = kind == 0   ? a[axis]
                      : kind == 1 ? round_to_half((a[axis] + b[axis]) / 2)
                                  : round_to_half(random.uniform(lower, upper));
        }
        return p;
    };
    Rays rays;
    while (rays.origins.size() < count) {
        const Vec3 from = special(), to = special();
        Vec3 direction{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            direction[axis] = rays.origins.size() % 3 == 0 ? std::round(random.uniform(-2, 2)) : to[axis] - from[axis];
        rays.add(from, direction);
    }
    return rays;
}

Mesh soup_of_tetrahedra(Random& random, std::size_t count) {
    std::vector<Mesh> all;
    for (std::size_t i = 0; i < count; ++i) all.push_back(random_lattice_tetrahedron(random, i % 2 == 0 ? 1 : 0.5));
    return together(all, "soup of tetrahedra");
}

Mesh octahedron(double radius, const Vec3& at) {
    std::vector<Vec3> vertices;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {-radius, radius}) {
            vertices.push_back(at);
            vertices.back()[axis] += side;
        }
    std::vector<Triangle> triangles;
    for (std::uint32_t k = 0; k < 8; ++k) {
        const std::uint32_t x = k & 1, y = 2 + (k >> 1 & 1), z = 4 + (k >> 2 & 1);
        const bool is_even = (k & 1) + (k >> 1 & 1) + (k >> 2 & 1) == 1 || k == 7;
        triangles.push_back(is_even ? Triangle{x, y, z} : Triangle{x, z, y});
    }
    return {vertices, triangles, "octahedron"};
}

struct Case {
    Mesh mesh;
    SignRule rule;
};

std::vector<Case> lattice_cases(Random& random) {
    const Mesh unit = box({0, 0, 0}, {3, 3, 3});
    std::vector<Case> cases;
    for (const Mesh& mesh :
         {box({2, 2, 2}, {5, 5, 5}, "cube"), octahedron(3, {1, 1, 1}), octahedron(2.5, {0.5, 0, 0}),
          together({unit, shifted(unit, {3, 0, 0})}, "touching at a face"),
          together({unit, shifted(unit, {3, 3, 0})}, "touching at an edge"),
          together({unit, shifted(unit, {1, 1, 0})}, "overlapping"),
          together({unit, box({1, 1, 0}, {2, 2, 2})}, "nested with a common face"),
          together({unit, reversed(box({1, 1, 0}, {2, 2, 2}))}, "a notch"), together({unit, unit}, "doubled"),
          box({0, 0, 0}, {40, 40, 0.5}, "plate"), reversed(unit), soup_of_tetrahedra(random, 6),
          soup_of_tetrahedra(random, 6), soup_of_tetrahedra(random, 10)})
        for (const SignRule rule : {SignRule::nonzero, SignRule::parity}) cases.push_back({mesh, rule});
    return cases;
}

}  // namespace

BOOST_AUTO_TEST_CASE(rays_meet_the_walls_of_eight_moved_rays_and_all_faces) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const auto& [mesh, rule] : lattice_cases(random)) {
        const DistanceTransform transform(test_device(), mesh, {.sign = rule});
        const MovedRays moved(mesh, rule);
        const Rays rays = rays_about(mesh, random, 50);
        const Answers walls = answers_of(transform, rays, {}),
                      faces = answers_of(transform, rays, {.hits = Hits::faces});
        std::size_t wrong = 0, wrong_faces = 0, odd = 0;
        for (std::size_t i = 0; i < rays.origins.size(); ++i) {
            const std::vector<Hit> expected = moved.walls(rays.origins[i], rays.directions[i]);
            if (!agree(walls, i, expected) && ++wrong == 1)
                BOOST_TEST_MESSAGE(text_of(rays, i) << ": " << walls.counts[i] << " walls for " << expected.size());
            const std::vector<Hit> touched = hits_of_faces(mesh, rays.origins[i], rational(rays.directions[i]));
            if (!agree(faces, i, touched) && ++wrong_faces == 1)
                BOOST_TEST_MESSAGE(text_of(rays, i) << ": " << faces.counts[i] << " hits for " << touched.size());
            if ((walls.counts[i] % 2 != 0) != moved.is_inside(rays.origins[i])) ++odd;
        }
        BOOST_TEST(wrong == 0U, mesh.name() << ", " << name_of(rule) << ": " << wrong << " rays with wrong walls");
        BOOST_TEST(wrong_faces == 0U, mesh.name() << ": " << wrong_faces << " rays with wrong faces");
        BOOST_TEST(odd == 0U, mesh.name() << ": the number of walls belies the side of " << odd << " origins");
        check_first(transform, rays, {}, walls);
        check_first(transform, rays, {.hits = Hits::faces}, faces);
    }
}

BOOST_AUTO_TEST_CASE(rays_meet_all_faces_of_any_mesh) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const Mesh& mesh : {random_soup(random, 20, 40), random_slivers(random, 30), sliver(), fins(), cone(20),
                             shifted(random_closed(random, 3), {1e6, -3e5, 7e5}),
                             scaled(random_soup(random, 20, 40), 0x1p-100), without_triangle(cube(1), 3)}) {
        const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::none});
        const double side = mesh.box().longest_side();
        Rays rays;
        for (std::size_t i = 0; i < 120; ++i) {
            const auto triangle = random.index(mesh.triangles().size());
            const auto corner = [&](std::size_t k) { return mesh.vertices()[mesh.triangles()[triangle][k]]; };
            Vec3 from = random.point(-side, side), to{};
            const double part = i % 3 == 0 ? 0 : random.uniform(0, 1);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                from[axis] += mesh.box().lower[axis];
                to[axis] = corner(0)[axis] + part * (corner(1)[axis] - corner(0)[axis]);
                if (i % 10 == 9) from[axis] *= 1e5;
            }
            if (i % 4 == 3) from = corner(2);
            // Sums of coordinates are exact for some; the others miss what they aim at by rounding.
            const double length = std::ldexp(1.0, static_cast<int>(random.index(600)) - 300);
            rays.add(from, {(to[0] - from[0]) * length, (to[1] - from[1]) * length, (to[2] - from[2]) * length});
        }
        const Answers faces = answers_of(transform, rays, {.hits = Hits::faces});
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < rays.origins.size(); ++i) {
            const auto expected = hits_of_faces(mesh, rays.origins[i], rational(rays.directions[i]));
            if (!agree(faces, i, expected) && ++wrong == 1)
                BOOST_TEST_MESSAGE(text_of(rays, i) << ": " << faces.counts[i] << " hits for " << expected.size());
        }
        BOOST_TEST(wrong == 0U, mesh.name() << ": " << wrong << " rays with wrong faces");
        check_first(transform, rays, {.hits = Hits::faces}, faces);
    }
}

BOOST_AUTO_TEST_CASE(the_number_of_walls_has_the_parity_of_the_side_that_a_query_has) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    std::vector<Triangle> turned = tilted(cube(1)).triangles();
    std::swap(turned[3][0], turned[3][1]);
    // Vertices that are joined for the sign.
    std::vector<Vec3> apart = unwelded(tilted(cube(1))).vertices();
    for (Vec3& vertex : apart)
        for (double& x : vertex) x += random.uniform(-1e-15, 1e-15);
    for (const Mesh& mesh : {tilted(together({cube(1), reversed(cube(1))}, "double-sided")),
                             Mesh(tilted(cube(1)).vertices(), turned, "turned face"),
                             Mesh(apart, unwelded(cube(1)).triangles(), "vertices apart"), tilted(overlapping_cubes()),
                             random_closed(random, 4), make_shape("knot"),
                             tilted(together({cube(1), shifted(cube(1), {2, 0, 0})}, "touching"))}) {
        const DistanceTransform transform(test_device(), mesh);
        BOOST_TEST((transform.sign() == SignRule::nonzero || transform.sign() == SignRule::parity), mesh.name());
        const double side = mesh.box().longest_side();
        Rays rays;
        for (std::size_t i = 0; i < 2000; ++i) rays.add(random.point(-side / 2, side / 2), random.direction());
        for (Vec3& origin : rays.origins)
            for (std::size_t axis = 0; axis < 3; ++axis)
                origin[axis] += (mesh.box().lower[axis] + mesh.box().upper[axis]) / 2;
        const Answers answers = answers_of(transform, rays, {});
        std::vector<float> distance(rays.origins.size());
        transform.query(rays.origins, infinity, distance);
        std::size_t wrong = 0, inside = 0;
        for (std::size_t i = 0; i < distance.size(); ++i) {
            inside += distance[i] < 0 ? 1U : 0U;
            if ((answers.counts[i] % 2 != 0) != (distance[i] < 0)) ++wrong;
        }
        BOOST_TEST(wrong == 0U, mesh.name() << ": " << wrong);
        BOOST_TEST(inside > 0U, mesh.name());
    }
}

BOOST_AUTO_TEST_CASE(no_ray_slips_through_an_edge_or_a_vertex) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    Rays rays;
    for (std::size_t i = 0; i < 20000; ++i) {
        const auto triangle = random.index(mesh.triangles().size());
        const Vec3 &a = mesh.vertices()[mesh.triangles()[triangle][0]],
                   &b = mesh.vertices()[mesh.triangles()[triangle][1]];
        const Vec3 from = i % 4 == 0 ? Vec3{} : random.point(-0.4, 0.4);
        const double part = i % 2 == 0 ? 0 : random.uniform(0, 1);
        Vec3 direction{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            direction[axis] = a[axis] + part * (b[axis] - a[axis]) - from[axis];
        rays.add(from, direction);
    }
    for (const Hits hits : {Hits::walls, Hits::faces}) {
        const Answers answers = answers_of(transform, rays, {.hits = hits}, 1);
        BOOST_TEST(std::ranges::count(answers.any, 1) == std::ssize(answers.any));
        BOOST_TEST(std::ranges::count_if(answers.counts, [](std::uint32_t count) { return count != 1; }) == 0);
    }
}

BOOST_AUTO_TEST_CASE(the_limit_and_the_length_of_the_direction_scale_t) {
    const DistanceTransform transform(test_device(), box({1, -1, -1}, {2, 1, 1}));
    for (const double length : {1.0, 3.0, 0x1p-1000, 5e-324, 0x1p1000, 1e308}) {
        Rays rays;
        rays.add({}, {length, 0, 0});
        rays.add({1.5, 0, 0}, {length, 0, 0});
        for (const Hits hits : {Hits::walls, Hits::faces}) {
            const Answers all = answers_of(transform, rays, {.hits = hits});
            BOOST_TEST(all.counts == (std::vector<std::uint32_t>{2, 1}), boost::test_tools::per_element());
            BOOST_TEST(all.t[0] == 1 / length);
            BOOST_TEST(all.t[1] == 2 / length);
            BOOST_TEST(all.t[4] == 0.5 / length);
            for (const double share : {0.0, 0.49, 0.5, 0.999, 1.0, 1.5, 2.0}) {
                const double limit = share / length;
                if (!std::isfinite(limit)) continue;
                const Answers limited = answers_of(transform, rays, {hits, limit});
                for (std::size_t i = 0; i < 2; ++i) {
                    const auto expected = static_cast<std::uint32_t>(
                        std::count_if(all.t.begin() + static_cast<std::ptrdiff_t>(4 * i),
                                      all.t.begin() + static_cast<std::ptrdiff_t>(4 * i + all.counts[i]),
                                      [&](double t) { return t <= limit; }));
                    BOOST_TEST(limited.counts[i] == expected);
                    BOOST_TEST(limited.any[i] == (expected > 0 ? 1 : 0));
                }
                check_first(transform, rays, {hits, limit}, limited);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(pairs_see_each_other_if_nothing_is_between_and_so_do_their_reverse) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const auto& [mesh, rule] : lattice_cases(random)) {
        const DistanceTransform transform(test_device(), mesh, {.sign = rule});
        const MovedRays moved(mesh, rule);
        const Rays rays = rays_about(mesh, random, 50);
        const std::size_t count = rays.origins.size();
        std::vector<Vec3> ends(count);
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                ends[i][axis] = rays.origins[i][axis] + rays.directions[i][axis];
        for (const Hits hits : {Hits::walls, Hits::faces}) {
            std::vector<std::uint8_t> visible(count, 7), reverse(count, 7);
            transform.visible(rays.origins, ends, visible, hits);
            transform.visible(ends, rays.origins, reverse, hits);
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const auto on_ray = hits == Hits::walls
                                        ? moved.walls(rays.origins[i], rays.directions[i])
                                        : hits_of_faces(mesh, rays.origins[i], rational(rays.directions[i]));
                // The ray enters a wall in which the segment's end lies, and is outside.
                const bool is_visible = hits == Hits::walls
                                            ? std::ranges::none_of(on_ray, [](const Hit& hit) { return hit.t < 1; }) &&
                                                  moved.is_inside(rays.origins[i]) == moved.is_inside(ends[i])
                                            : std::ranges::none_of(on_ray, [](const Hit& hit) { return hit.t <= 1; });
                if (visible[i] != (is_visible ? 1 : 0) && ++wrong == 1) BOOST_TEST_MESSAGE(text_of(rays, i));
            }
            BOOST_TEST(wrong == 0U, mesh.name() << ", " << name_of(rule) << ": " << wrong << " pairs");
            BOOST_TEST(visible == reverse, boost::test_tools::per_element());
        }
    }
}

BOOST_AUTO_TEST_CASE(rays_that_are_not_usable_have_no_hits_and_are_told) {
    const DistanceTransform transform(test_device(), cube(1));
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    Rays rays;
    rays.add({0, 0, -2}, {0, 0, 1});
    rays.add({nan, 0, 0}, {0, 0, 1});
    rays.add({0, infinity, 0}, {0, 0, 1});
    rays.origins.push_back({0, 0, -2});
    rays.directions.push_back({0, -0.0, 0});
    rays.add({0, 0, -2}, {0, 0, nan});
    rays.add({0, 0, -2}, {0, infinity, 1});
    rays.add({0, 0, -2}, {1e-200, 0, 1});
    rays.add({0, 1e-200, -2}, {0, 0, 1});
    std::string told;
    CallOptions call;
    call.log = [&](const std::string& message) { told += message; };
    for (const Hits hits : {Hits::walls, Hits::faces}) {
        told.clear();
        const Answers answers = answers_of(transform, rays, {.hits = hits}, 2, call);
        BOOST_TEST(answers.statistics.unusable_points == 7U);
        BOOST_TEST(
            told.find("7 of 8 rays have no hits and t = NaN; the first, ray 1, counted from 0, (nan, 0, 0)") == 0U,
            told);
        BOOST_TEST(answers.t[0] == 1);
        BOOST_TEST(answers.t[1] == 3);
        for (std::size_t i = 1; i < 8; ++i) {
            BOOST_TEST(std::isnan(answers.t[2 * i]));
            BOOST_TEST(answers.triangles[2 * i] == no_triangle);
            BOOST_TEST(answers.counts[i] == 0U);
            BOOST_TEST(answers.any[i] == 0);
        }
    }
    call.refuse_unusable_points = true;
    check_throws(ErrorCode::invalid_argument, {"ray 1, counted from 0", "its origin is not finite; leave it out"},
                 [&] { answers_of(transform, rays, {}, 1, call); });
    std::vector<std::uint8_t> visible(3, 7);
    const std::vector<Vec3> from{{0, 0, 0}, {0, 0, nan}, {5, 5, 5}}, to{{0, 0, 0.5}, {0, 0, 0}, {5, 5, infinity}};
    call.refuse_unusable_points = false;
    told.clear();
    BOOST_TEST(transform.visible(from, to, visible, Hits::walls, call).unusable_points == 2U);
    BOOST_TEST(told.find("2 of 3 pairs count as not visible; the first, pair 1") == 0U, told);
    BOOST_TEST(visible == (std::vector<std::uint8_t>{1, 0, 0}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(a_component_far_below_the_greatest_makes_a_ray_unusable_at_any_length) {
    // It begins in the plane of the cube's upper side: by this component it has two walls, without it none.
    const DistanceTransform transform(test_device(), cube(1));
    const auto answers = [&](const Vec3& direction) {
        Rays rays;
        rays.add({-3, 0.1, 1}, direction);
        return answers_of(transform, rays, {}, 1);
    };
    constexpr double least = std::numeric_limits<double>::denorm_min();
    // Divided by the greatest component, the last three are below the least double.
    for (const Vec3& direction : {Vec3{1, 0, -1e-300}, Vec3{1, 0, -least}, Vec3{0x1p60, 0, -least},
                                  Vec3{1e200, 0, -1e-300}, Vec3{1e308, 0, -least}}) {
        const Answers none = answers(direction);
        BOOST_TEST(none.statistics.unusable_points == 1U, direction[0] << ", " << direction[2]);
        BOOST_TEST(std::isnan(none.t[0]));
        BOOST_TEST(none.counts[0] == 0U);
    }
    for (const Vec3& direction : {Vec3{1, 0, -1e-80}, Vec3{0x1p900, 0, -0x1p610}, Vec3{0x1p-900, 0, -least}}) {
        const Answers found = answers(direction);
        BOOST_TEST(found.statistics.unusable_points == 0U, direction[0] << ", " << direction[2]);
        BOOST_TEST(found.t[0] == 2 / direction[0]);
        BOOST_TEST(found.counts[0] == 2U);
    }
}

BOOST_AUTO_TEST_CASE(arrays_have_any_type_and_stride_and_what_cannot_be_is_refused) {
    const DistanceTransform transform(test_device(), cube(1));
    struct Row {
        float origin[3], direction[3];
    };
    const std::vector<Row> rows{{{0, 0, -3}, {0, 0, 2}}, {{0, 0, 0}, {3, 0, 0}}, {{9, 9, 9}, {1, 0, 0}}};
    const InputArray origins(&rows[0].origin[0], rows.size(), sizeof(Row)),
        directions(&rows[0].direction[0], rows.size(), sizeof(Row));
    std::vector<float> t(3 * 4, -1);
    std::vector<std::int32_t> triangles(2 * 3);
    OutputArray strided(t.data(), {4 * sizeof(float), 0, 0});
    strided.component_stride = 2 * sizeof(float);
    transform.rays(origins, directions, {}, {.most = 2, .t = strided, .triangles = triangles});
    const float none = std::numeric_limits<float>::infinity();
    BOOST_TEST(t == (std::vector<float>{1, -1, 2, -1, 1 / 3.0F, -1, none, -1, none, -1, none, -1}),
               boost::test_tools::per_element());
    BOOST_TEST(triangles[3] == -1);
    BOOST_TEST(triangles[0] < 2);

    std::vector<double> one(3), two(6);
    std::vector<Vec3> from(3), along(3, Vec3{1, 0, 0});
    const auto refused = [&](const std::vector<std::string>& fragments, const RayOptions& options,
                             const RayTargets& targets) {
        check_throws(ErrorCode::invalid_argument, fragments, [&] { transform.rays(from, along, options, targets); });
    };
    refused({"limit -1"}, {.limit = -1}, {.t = one});
    refused({"limit nan"}, {.limit = std::numeric_limits<double>::quiet_NaN()}, {.t = one});
    refused({"no array"}, {}, {});
    refused({"0 hits"}, {}, {.most = 0, .t = one});
    refused({"array t", "room for 3", "6 are needed"}, {}, {.most = 2, .t = one});
    refused({"array t", "origins", "same bytes"}, {}, {.t = OutputArray(&from[1][0])});
    refused({"array t", "array triangles", "same bytes"}, {},
            {.t = one, .triangles = OutputArray(reinterpret_cast<std::uint32_t*>(one.data()))});
    const cl::Buffer closed(device::context_of(test_device()).context(), CL_MEM_READ_WRITE | CL_MEM_HOST_NO_ACCESS, 64);
    check_throws(ErrorCode::unsupported, {"array t", "CL_MEM_HOST_NO_ACCESS"},
                 [&] { transform.rays(from, along, {}, {.t = closed()}); });
    check_throws(ErrorCode::unsupported, {"array t", "uint8"}, [&] {
        transform.rays(
            from, along, {},
            {.t = std::vector<std::uint8_t>(3)[0] == 0 ? OutputArray(reinterpret_cast<std::uint8_t*>(one.data()))
                                                       : OutputArray()});
    });
    along.pop_back();
    refused({"3 origins and 2 directions"}, {}, {.t = one});
    along.push_back({1, 0, 0});
    const DistanceTransform unsigned_one(test_device(), without_triangle(cube(1), 3), {.sign = SignRule::none});
    check_throws(ErrorCode::unsupported, {"no sign", "faces"}, [&] { unsigned_one.rays(from, along, {}, {.t = one}); });
    unsigned_one.rays(from, along, {Hits::faces}, {.t = one});
    BOOST_TEST(one[0] == 1);
    const std::vector<Vec3> none_at_all;
    transform.rays(none_at_all, none_at_all, {}, {.any = OutputArray(reinterpret_cast<std::uint8_t*>(one.data()))});
}

BOOST_AUTO_TEST_CASE(threads_and_moved_vertices_give_the_same_bytes) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = make_shape("knot"), turned = tilted(mesh);
    DistanceTransform transform(test_device(), mesh);
    const DistanceTransform fresh(test_device(), turned);
    Rays rays;
    for (std::size_t i = 0; i < 3000; ++i) rays.add(random.point(-2, 2), random.direction());
    const Answers before = answers_of(transform, rays, {});
    transform.set_positions(turned.vertices());
    const Answers expected = answers_of(fresh, rays, {});
    BOOST_TEST(before.t != expected.t);
    std::array<Answers, 4> all;
    {
        std::vector<std::jthread> threads;
        for (Answers& answers : all) threads.emplace_back([&] { answers = answers_of(transform, rays, {}); });
    }
    for (const Answers& answers : all) {
        BOOST_TEST((answers.t == expected.t));
        BOOST_TEST((answers.triangles == expected.triangles));
        BOOST_TEST((answers.counts == expected.counts));
    }
    // One at a time.
    for (std::size_t i = 0; i < 100; ++i) {
        Rays one;
        one.add(rays.origins[i], rays.directions[i]);
        BOOST_TEST(answers_of(transform, one, {}, 1).t[0] == expected.t[4 * i]);
    }
}

BOOST_AUTO_TEST_CASE(rays_and_pairs_lie_in_memory_of_the_device) {
    const DistanceTransform transform(test_device(), make_shape("sphere3"));
    const device::Context& context = device::context_of(test_device());
    // Origins and directions side by side; results with a stride between them.
    std::vector<std::array<Vec3, 2>> pairs;
    for (std::size_t i = 0; i < 300; ++i) {
        const auto x = static_cast<double>(i);
        pairs.push_back({Vec3{2 * std::sin(x), 2 * std::cos(1.7 * x), 0.01 * x - 1.5},
                         Vec3{std::cos(2.3 * x), std::sin(0.7 * x), 0.3}});
    }
    std::vector<Vec3> from, to;
    for (const auto& [first, second] : pairs) {
        from.push_back(first);
        to.push_back(second);
    }
    const auto buffer_of = [&](std::size_t bytes, const void* values) {
        return cl::Buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes,
                          const_cast<void*>(values));  // which is only read
    };
    const cl::Buffer memory = buffer_of(pairs.size() * 48, pairs.data());
    InputArray first(memory(), ElementType::float64, pairs.size()), second = first;
    first.strides[0] = second.strides[0] = 48;
    second.offset = 24;
    const std::vector<float> sevens(4 * pairs.size(), 7);
    const cl::Buffer results = buffer_of(sevens.size() * 4, sevens.data());
    OutputArray t(results(), ElementType::float32), any(results(), ElementType::uint8);
    t.strides[0] = any.strides[0] = 16;
    t.offset = 4;
    any.offset = 12;
    std::vector<float> expected_t(pairs.size());
    std::vector<std::uint8_t> expected_any(pairs.size()), visible(pairs.size());
    transform.rays(from, to, {}, {.t = expected_t, .any = expected_any});
    transform.visible(from, to, visible);
    const auto wrong = [&](const std::vector<std::uint8_t>& bytes, bool with_t) {
        const auto found = read<std::array<float, 4>>(context, results, pairs.size());
        std::size_t count = 0;
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            std::uint8_t byte = 0;
            std::memcpy(&byte, &found[i][3], 1);
            count +=
                found[i][0] != 7 || found[i][1] != (with_t ? expected_t[i] : 7) || found[i][2] != 7 || byte != bytes[i];
        }
        return count;
    };
    BOOST_TEST(std::ranges::count(visible, 1) > 10);
    BOOST_TEST(std::ranges::count(visible, 0) > 10);
    transform.visible(first, second, any);
    BOOST_TEST(wrong(visible, false) == 0);
    transform.rays(first, second, {}, {.t = t, .any = any});
    BOOST_TEST(wrong(expected_any, true) == 0);
    OutputArray there(memory(), ElementType::uint8);
    check_throws(ErrorCode::invalid_argument, {"the array any", "origins", "same bytes"},
                 [&] { transform.rays(first, second, {}, {.any = there}); });
    first.count = second.count = pairs.size() + 1;
    check_throws(ErrorCode::invalid_argument, {"origins", "their memory holds"},
                 [&] { transform.rays(first, second, {}, {.any = any}); });
}

BOOST_AUTO_TEST_CASE(no_rays_have_no_hits) {
    const DistanceTransform transform(test_device(), cube(1));
    const std::vector<Vec3> none;
    std::vector<double> t;
    transform.rays(none, none, {}, {.t = t});
    transform.rays(none, none, {}, {});
    check_throws(ErrorCode::invalid_argument, {"no array for results"}, [&] {
        const std::vector<Vec3> one{{0, 0, 1}};
        transform.rays(one, one, {}, {});
    });
}

BOOST_AUTO_TEST_CASE(a_call_of_rays_reports_and_stops) {
    const DistanceTransform transform(test_device(), cube(1));
    const std::vector<Vec3> from(200000, Vec3{0, 0, -2}), along(from.size(), Vec3{0, 0, 1});
    std::vector<float> t(from.size());
    std::vector<double> fractions;
    CallOptions call;
    call.progress = [&](const Progress& progress) { fractions.push_back(progress.fraction); };
    transform.rays(from, along, {}, {.t = t}, call);
    BOOST_TEST(fractions.size() > 2U);
    BOOST_TEST(std::ranges::is_sorted(fractions));
    BOOST_TEST(fractions.back() == 1);
    call.should_stop = [&] { return true; };
    check_throws(ErrorCode::cancelled, {"cancelled"}, [&] { transform.rays(from, along, {}, {.t = t}, call); });
}
