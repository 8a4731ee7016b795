#include "papers/convex_polyhedron.hpp"
#include "support/random_meshes.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace clsdf::test {
namespace {

using engine::Vector;
using papers::clip;
using papers::ConvexPolyhedron;
using papers::HalfSpace;

const Box unit_box{{-1, -1, -1}, {1, 1, 1}};

Vector random_vector(Random& random, double size) {
    const Vec3 v = random.point(-size, size);
    return {v[0], v[1], v[2]};
}

Vector random_direction(Random& random) {
    const Vec3 v = random.direction();
    return {v[0], v[1], v[2]};
}

/// Neighbours use an edge in opposite directions, nothing is left over, and Euler's formula holds.
void check_topology(const ConvexPolyhedron& solid) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    std::set<std::uint32_t> used;
    bool is_closed = true;
    for (const ConvexPolyhedron::Face& face : solid.faces) {
        is_closed = is_closed && face.size >= 3;
        std::uint32_t from = solid.polygon(face).back();
        for (const std::uint32_t to : solid.polygon(face)) {
            is_closed = is_closed && from != to && edges.emplace(from, to).second;
            used.insert(to);
            from = to;
        }
    }
    for (const auto& [from, to] : edges) is_closed = is_closed && edges.count({to, from}) == 1;
    BOOST_TEST(is_closed);
    BOOST_TEST(used.size() == solid.vertices.size());
    if (!solid.is_empty()) BOOST_TEST(solid.vertices.size() + solid.faces.size() == edges.size() / 2 + 2);
}

/// Vertices satisfy every half-space and lie in the planes of their faces.
void check_planes(const ConvexPolyhedron& solid, const std::vector<HalfSpace>& half_spaces, double tolerance) {
    double outside = 0;
    for (const auto& [normal, offset] : half_spaces)
        for (const Vector& vertex : solid.vertices)
            outside = std::max(outside, (normal.dot(vertex) - offset) / normal.norm());
    BOOST_TEST(outside <= tolerance);
    double off_the_face = 0;
    for (const ConvexPolyhedron::Face& face : solid.faces) {
        if (face.half_space == ConvexPolyhedron::start_box) continue;
        const auto& [normal, offset] = half_spaces[face.half_space];
        for (const std::uint32_t vertex : solid.polygon(face))
            off_the_face =
                std::max(off_the_face, std::abs(normal.dot(solid.vertices[vertex]) - offset) / normal.norm());
    }
    BOOST_TEST(off_the_face <= tolerance);
}

double volume_seen_from(const ConvexPolyhedron& solid, const Vector& point) {
    double sum = 0;
    for (const ConvexPolyhedron::Face& face : solid.faces) {
        const auto ring = solid.polygon(face);
        Vector area = Vector::Zero();
        for (std::size_t i = 2; i < ring.size(); ++i)
            area += (solid.vertices[ring[i - 1]] - solid.vertices[ring[0]])
                        .cross(solid.vertices[ring[i]] - solid.vertices[ring[0]]);
        sum += std::abs(area.dot(solid.vertices[ring[0]] - point));
    }
    return sum / 6;
}

std::size_t edge_count(const ConvexPolyhedron& solid) {
    return solid.corners.size() / 2;
}

/// Generic ones, and ones through vertices that are there already, parallel, repeated, nearly repeated, and opposite.
std::vector<HalfSpace> random_half_spaces(Random& random, std::size_t count) {
    std::vector<HalfSpace> result;
    const double nearest = random.index(2) == 0 ? 0.9 : 0.1;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t kind = i == 0 ? 0 : random.index(8);
        HalfSpace next{random_direction(random), random.uniform(nearest, 1)};
        if (kind == 1) next = result[random.index(result.size())];
        if (kind == 2) next = {2 * result[random.index(result.size())].normal, random.uniform(0, 2)};
        if (kind == 3) {
            next = result[random.index(result.size())];
            next.normal += std::pow(10, random.uniform(-17, -6)) * random_direction(random);
            next.offset += std::pow(10, random.uniform(-17, -6)) * random.uniform(-1, 1);
        }
        if (kind == 4 || kind == 5) {
            const ConvexPolyhedron now = clip(unit_box, result);
            if (now.is_empty()) continue;
            const Vector at = now.vertices[random.index(now.vertices.size())];
            const Vector end = now.vertices[random.index(now.vertices.size())];
            next.normal = kind == 4 || at == end ? random_direction(random)
                                                 : Vector((end - at).cross(random_direction(random)).normalized());
            if (next.normal.dot(at) < 0) next.normal = -next.normal;
            next.offset = next.normal.dot(at);
        }
        if (kind == 6) {
            const double signs = random.uniform(-1, 1);
            next = {Vector(signs < 0 ? -1 : 1, random.index(2), random.index(2)), 0.5 * random.index(4)};
        }
        result.push_back(next);
    }
    return result;
}

BOOST_AUTO_TEST_SUITE(convex_polyhedron)

BOOST_AUTO_TEST_CASE(known_solids_have_their_volume_and_their_vertices_edges_and_faces) {
    struct Known {
        const char* name;
        std::vector<Vector> normals;
        double offset;
        double volume;
        std::size_t vertices, edges, faces;
    };
    const double golden = (1 + std::sqrt(5)) / 2;
    std::vector<Vector> corners;
    std::vector<Vector> edges;
    std::vector<Vector> pentagons;
    for (const double a : {-1.0, 1.0})
        for (const double b : {-1.0, 1.0}) {
            for (const double c : {-1.0, 1.0}) corners.emplace_back(a, b, c);
            edges.insert(edges.end(), {{a, b, 0}, {0, a, b}, {a, 0, b}});
            pentagons.insert(pentagons.end(), {{a, b * golden, 0}, {0, a, b * golden}, {b * golden, 0, a}});
        }
    // The volume of a dodecahedron of inradius 1 and side a is (15 + 7 sqrt 5) / 4 a^3.
    const double side = 2 / std::sqrt(2.5 + 1.1 * std::sqrt(5));
    const double dodecahedron = (15 + 7 * std::sqrt(5)) / 4 * side * side * side;
    const std::vector<Vector> tetrahedron{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    for (const Known& known :
         {Known{"cube", {}, 0, 8, 8, 12, 6},
          {"octahedron", corners, 1, 4.0 / 3, 6, 12, 8},
          {"cuboctahedron", corners, 2, 20.0 / 3, 12, 24, 14},
          {"truncated octahedron", corners, 1.5, 4, 24, 36, 14},
          {"rhombic dodecahedron", edges, 1, 2, 14, 24, 12},
          {"tetrahedron", tetrahedron, 1, 8.0 / 3, 4, 6, 4},
          {"dodecahedron", pentagons, 0.5 * std::sqrt(1 + golden * golden), dodecahedron / 8, 20, 30, 12}}) {
        std::vector<HalfSpace> half_spaces;
        for (const Vector& normal : known.normals) half_spaces.push_back({normal, known.offset});
        const ConvexPolyhedron solid = clip(unit_box, half_spaces);
        BOOST_TEST_CONTEXT(known.name) {
            BOOST_TEST(std::abs(solid.volume() - known.volume) < 1e-14);
            BOOST_TEST(solid.vertices.size() == known.vertices);
            BOOST_TEST(edge_count(solid) == known.edges);
            BOOST_TEST(solid.faces.size() == known.faces);
            check_topology(solid);
            check_planes(solid, half_spaces, 2e-13);
        }
    }
}

BOOST_AUTO_TEST_CASE(every_solid_is_a_sphere_whose_vertices_satisfy_the_half_spaces) {
    std::size_t empty = 0;
    std::size_t largest = 0;
    for (std::uint64_t seed = 1; seed <= 4000; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const std::vector<HalfSpace> half_spaces = random_half_spaces(random, 1 + random.index(80));
            const ConvexPolyhedron solid = clip(unit_box, half_spaces);
            check_topology(solid);
            check_planes(solid, half_spaces, 2e-13);
            if (solid.is_empty()) ++empty;
            largest = std::max(largest, solid.faces.size());
        }
    BOOST_TEST(empty > 50U);
    BOOST_TEST(empty < 2000U);
    BOOST_TEST(largest >= 18U);
}

// Rounding decides on which side of such a plane the vertices of another are.
BOOST_AUTO_TEST_CASE(planes_that_are_nearly_one_do_not_tear_the_solid) {
    for (std::uint64_t seed = 1; seed <= 40000; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const double difference = random.uniform(-16, -10);
            std::vector<HalfSpace> half_spaces;
            for (std::uint32_t planes = 1 + random.index(4); planes > 0; --planes) {
                const HalfSpace plane{random.index(2) == 0 ? random_direction(random) : Vector::UnitX(),
                                      random.uniform(-0.5, 1)};
                for (std::uint32_t copies = random.index(40); copies > 0; --copies) {
                    const Vector turn = std::pow(10, difference + random.uniform(0, 1)) * random_direction(random);
                    const double shift = std::pow(10, difference + random.uniform(-1, 1)) * random.uniform(-1, 1);
                    half_spaces.push_back({plane.normal + turn, plane.offset + shift});
                }
            }
            for (std::size_t i = half_spaces.size(); i > 1; --i)
                std::swap(half_spaces[i - 1], half_spaces[random.index(i)]);
            const ConvexPolyhedron solid = clip(unit_box, half_spaces);
            check_topology(solid);
            check_planes(solid, half_spaces, 2e-13);
        }
}

BOOST_AUTO_TEST_CASE(a_point_is_in_the_solid_where_it_satisfies_all_half_spaces) {
    std::size_t inside = 0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const std::vector<HalfSpace> half_spaces = random_half_spaces(random, 1 + random.index(20));
            const ConvexPolyhedron solid = clip(unit_box, half_spaces);
            for (int i = 0; i < 50; ++i) {
                const Vector point = random_vector(random, 1);
                double highest = -std::numeric_limits<double>::infinity();
                for (const auto& [normal, offset] : half_spaces)
                    highest = std::max(highest, (normal.dot(point) - offset) / normal.norm());
                if (std::abs(highest) < 1e-3) continue;  // a cone of that height has more volume than rounding
                // From a point inside, the cones over the faces make up the solid; from one outside they are more.
                const bool is_inside = !solid.is_empty() && volume_seen_from(solid, point) < solid.volume() + 1e-11;
                if (highest < 0) {
                    BOOST_TEST(is_inside);
                    ++inside;
                } else {
                    BOOST_TEST(!is_inside);
                }
            }
        }
    BOOST_TEST(inside > 5000U);
}

BOOST_AUTO_TEST_CASE(a_plane_divides_the_volume) {
    for (std::uint64_t seed = 1; seed <= 2000; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            std::vector<HalfSpace> half_spaces = random_half_spaces(random, 2 + random.index(30));
            const HalfSpace last = half_spaces.back();
            half_spaces.pop_back();
            const double whole = clip(unit_box, half_spaces).volume();
            half_spaces.push_back(last);
            const double below = clip(unit_box, half_spaces).volume();
            half_spaces.back() = {-last.normal, -last.offset};
            const double above = clip(unit_box, half_spaces).volume();
            BOOST_TEST(below >= 0);
            BOOST_TEST(std::abs(below + above - whole) < 1e-11);
        }
}

BOOST_AUTO_TEST_CASE(the_order_of_the_half_spaces_changes_nothing) {
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            std::vector<HalfSpace> half_spaces = random_half_spaces(random, 2 + random.index(20));
            const ConvexPolyhedron first = clip(unit_box, half_spaces);
            for (std::size_t i = half_spaces.size(); i > 1; --i)
                std::swap(half_spaces[i - 1], half_spaces[random.index(i)]);
            const ConvexPolyhedron second = clip(unit_box, half_spaces);
            check_topology(second);
            BOOST_TEST(std::abs(first.volume() - second.volume()) < 1e-11);
            // As sets: the farthest vertex in any direction.
            if (first.is_empty() || second.is_empty()) continue;
            for (int i = 0; i < 20; ++i) {
                const Vector direction = random_direction(random);
                const auto extent = [&](const ConvexPolyhedron& solid) {
                    double farthest = -std::numeric_limits<double>::infinity();
                    for (const Vector& vertex : solid.vertices) farthest = std::max(farthest, direction.dot(vertex));
                    return farthest;
                };
                BOOST_TEST(std::abs(extent(first) - extent(second)) < 1e-5);  // nearly parallel planes meet anywhere
            }
        }
}

BOOST_AUTO_TEST_CASE(a_plane_that_only_touches_makes_nothing_new) {
    const ConvexPolyhedron cube = clip(unit_box, {});
    const std::vector<HalfSpace> touching{
        {{1, 0, 0}, 1}, {{1, 1, 0}, 2},     {{1, 1, 1}, 3},        {{2, 0, 0}, 2},       {{1, 1e-17, 0}, 1},
        {{1, 0, 0}, 9}, {{0, 0, 0}, 0},     {{0, 0, 0}, 1},        {{1, 1e-15, 0}, 1},   {{-1, 0, 0}, 1},
        {{1, 2, 3}, 6}, {{1, 1, 1e-16}, 2}, {{1, 1, 1}, INFINITY}, {{0, 0, 1}, INFINITY}};
    const ConvexPolyhedron solid = clip(unit_box, touching);
    BOOST_TEST((solid.vertices == cube.vertices));
    BOOST_TEST((solid.corners == cube.corners));
    for (const ConvexPolyhedron::Face& face : solid.faces) BOOST_TEST(face.half_space == ConvexPolyhedron::start_box);
    // A diagonal plane goes through four vertices and two edges.
    const std::vector<HalfSpace> halves{{{1, 1, 0}, 0}, {{1, 1, 0}, 0}, {{3, 3, 0}, 0}};
    const ConvexPolyhedron half = clip(unit_box, halves);
    BOOST_TEST(half.vertices.size() == 6U);
    BOOST_TEST(half.faces.size() == 5U);
    BOOST_TEST(half.faces.back().half_space == 0U);
    BOOST_TEST(std::abs(half.volume() - 4) < 1e-15);
}

BOOST_AUTO_TEST_CASE(what_has_no_volume_is_empty) {
    const auto is_empty = [](const Box& box, const std::vector<HalfSpace>& half_spaces) {
        const ConvexPolyhedron solid = clip(box, half_spaces);
        BOOST_TEST(solid.is_empty() == solid.vertices.empty());
        BOOST_TEST((!solid.is_empty() || solid.volume() == 0));
        return solid.is_empty();
    };
    BOOST_TEST(is_empty({{0, 0, 0}, {1, 1, 0}}, {}));
    BOOST_TEST(is_empty({{0, 0, 0}, {1, -1, 1}}, {}));
    BOOST_TEST(is_empty(unit_box, {{{1, 0, 0}, -1}}));
    BOOST_TEST(is_empty(unit_box, {{{1, 0, 0}, -2}}));
    BOOST_TEST(is_empty(unit_box, {{{1, 1, 1}, -3}}));
    BOOST_TEST(is_empty(unit_box, {{{0, 0, 0}, -1}}));
    BOOST_TEST(is_empty(unit_box, {{{1, 0, 0}, -INFINITY}}));
    BOOST_TEST(is_empty(unit_box, {{{1, 2, 3}, 0.5}, {{-1, -2, -3}, -0.5}}));
    BOOST_TEST(is_empty(unit_box, {{{1, 2, 3}, 0.5}, {{-1, -2, -3}, -0.6}, {{1, 0, 0}, 0}}));
    BOOST_TEST(!is_empty(unit_box, {{{1, 2, 3}, 0.5}, {{-1, -2, -3}, -0.5 + 1e-9}}));
}

BOOST_AUTO_TEST_CASE(size_is_no_matter) {
    for (std::uint64_t seed = 1; seed <= 300; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            std::vector<HalfSpace> half_spaces = random_half_spaces(random, 1 + random.index(20));
            const ConvexPolyhedron expected = clip(unit_box, half_spaces);
            const double scale = std::ldexp(1, 200);
            for (HalfSpace& half_space : half_spaces) half_space.offset *= scale;
            const ConvexPolyhedron solid = clip({{-scale, -scale, -scale}, {scale, scale, scale}}, half_spaces);
            BOOST_TEST((solid.corners == expected.corners));
            for (std::size_t i = 0; i < solid.vertices.size(); ++i)
                BOOST_TEST((solid.vertices[i] == scale * expected.vertices[i]));
        }
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
