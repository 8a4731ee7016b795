// The outer surface: of unions of boxes against closed forms, of turned bodies against winding numbers.

#include "core/vectors.hpp"
#include "support/box_unions.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"
#include "support/winding.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/outer.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

namespace clsdf {

using namespace test;

namespace {

/// diagonals: which way each of its six faces is cut, as bits.
Mesh box_mesh(const Box& box, unsigned diagonals, bool looks_inwards = false) {
    std::vector<Vec3> vertices;
    for (unsigned i = 0; i < 8; ++i)
        vertices.push_back({(i & 1U) == 0 ? box.lower[0] : box.upper[0], (i & 2U) == 0 ? box.lower[1] : box.upper[1],
                            (i & 4U) == 0 ? box.lower[2] : box.upper[2]});
    constexpr std::array<std::array<std::uint32_t, 4>, 6> faces{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    std::vector<Triangle> triangles;
    for (std::size_t face = 0; face < 6; ++face) {
        const auto& [a, b, c, d] = faces[face];
        const bool other = (diagonals >> face & 1U) != 0;
        triangles.push_back(other ? Triangle{a, b, d} : Triangle{a, b, c});
        triangles.push_back(other ? Triangle{b, c, d} : Triangle{a, c, d});
    }
    if (looks_inwards)
        for (Triangle& triangle : triangles) std::swap(triangle[1], triangle[2]);
    return {std::move(vertices), std::move(triangles), "box"};
}

double distance_to(const Mesh& mesh, const Vec3& point) {
    // To each triangle: above it, or to its edges.
    double least = std::numeric_limits<double>::infinity();
    const auto to_edge = [&](const Vec3& a, const Vec3& b) {
        const Vec3 along = difference(b, a), from = difference(point, a);
        const double squared = dot(along, along);
        const double t = squared > 0 ? std::clamp(dot(along, from) / squared, 0.0, 1.0) : 0;
        return length(difference(from, {t * along[0], t * along[1], t * along[2]}));
    };
    for (const Triangle& triangle : mesh.triangles()) {
        const Vec3 &a = mesh.vertices()[triangle[0]], &b = mesh.vertices()[triangle[1]],
                   &c = mesh.vertices()[triangle[2]];
        const Vec3 normal = cross(difference(b, a), difference(c, a));
        const auto is_left = [&](const Vec3& p, const Vec3& q) {
            return dot(cross(difference(q, p), difference(point, p)), normal) >= 0;
        };
        if (length(normal) > 0 && is_left(a, b) && is_left(b, c) && is_left(c, a))
            least = std::min(least, std::abs(dot(normal, difference(point, a))) / length(normal));
        least = std::min({least, to_edge(a, b), to_edge(b, c), to_edge(c, a)});
    }
    return least;
}

/// Closed, and its winding number is one where that of the mesh as given is not zero, zero elsewhere.
void check_boundary(const Mesh& given, const OuterSurface& surface, Random& random, int points) {
    const Topology topology = describe_topology(surface.mesh);
    BOOST_TEST(topology.balanced, given.name());
    BOOST_TEST(topology.duplicate_faces == 0U);
    BOOST_TEST(surface.faces.size() == surface.mesh.triangles().size());
    BOOST_TEST(surface.whole_faces + surface.partial_faces + surface.hidden_faces == given.triangles().size());
    const Box& box = given.box();
    for (int i = 0; i < points; ++i) {
        Vec3 point;
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = random.uniform(box.lower[axis] - 0.1, box.upper[axis] + 0.1);
        const int expected = std::lround(winding_by_faces(given, point)) != 0 ? 1 : 0;
        BOOST_TEST(std::abs(winding_by_faces(surface.mesh, point) - expected) < 1e-6, given.name());
    }
}

void check_boxes(const std::vector<Box>& boxes, Random& random, const std::string& name) {
    std::vector<Mesh> meshes;
    for (const Box& box : boxes) meshes.push_back(box_mesh(box, random.index(64)));
    const Mesh given = together(meshes, name);
    const OuterSurface surface = outer(given);
    const Cells cells(boxes);
    BOOST_TEST(std::abs(surface.volume - cells.volume()) <= 1e-14 * cells.volume(), name);
    BOOST_TEST(std::abs(surface.area - cells.area()) <= 1e-14 * cells.area(), name);
    check_boundary(given, surface, random, 10);
    const double side = given.box().longest_side();
    for (int i = 0; i < 20; ++i) {
        const Vec3 point = random.point(-0.5, 2.5);
        BOOST_TEST(std::abs(distance_to(surface.mesh, point) - cells.distance(point)) <= 1e-15 * side, name);
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(boxes_in_all_positions) {
    Random random(1);
    const Box unit{{0, 0, 0}, {1, 1, 1}};
    check_boxes({unit}, random, "one box");
    check_boxes({unit, {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}}}, random, "nested");
    check_boxes({unit, {{1, 0, 0}, {2, 1, 1}}}, random, "a common face");
    check_boxes({unit, {{1, 0.25, 0.25}, {2, 0.75, 0.75}}}, random, "a face within a face");
    check_boxes({unit, {{0.5, 0, 0}, {1.5, 1, 1}}}, random, "overlapping coplanar faces");
    check_boxes({unit, {{0.5, 0.5, 0}, {1.5, 1.5, 1}}}, random, "crossing coplanar faces");
    check_boxes({unit, unit}, random, "twice the same");
    check_boxes({unit, unit, unit}, random, "three times the same");
    check_boxes({unit, {{1, 1, 1}, {2, 2, 2}}}, random, "a common vertex");
    check_boxes({unit, {{1, 1, 0}, {2, 2, 1}}}, random, "a common edge");
    check_boxes({unit, {{1, 1, 0.5}, {2, 2, 1.5}}}, random, "overlapping edges");
    check_boxes({unit, {{0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}}, {{0.25, 0.75, -0.5}, {0.75, 2, 0.5}}}, random, "three");
}

BOOST_AUTO_TEST_CASE(random_unions_of_boxes) {
    constexpr std::uint64_t seed = 20261129;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (int trial = 0; trial < 300; ++trial) {
        const double parts = std::array{4.0, 6.0, 7.0}[random.index(3)];
        std::vector<Box> boxes(2 + random.index(7));
        for (Box& box : boxes)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::uint32_t low = random.index(8), high = low + 1 + random.index(5);
                box.lower[axis] = low / parts;
                box.upper[axis] = high / parts;
            }
        check_boxes(boxes, random, "boxes " + std::to_string(trial));
    }
}

BOOST_AUTO_TEST_CASE(turned_bodies) {
    constexpr std::uint64_t seed = 7;
    BOOST_TEST_MESSAGE("seed " << seed);
    for (const double offset : {0.0, 1e6}) {
        Random random(seed);
        for (int trial = 0; trial < 6; ++trial) {
            std::vector<Mesh> bodies;
            for (int i = 0; i < 6; ++i) {
                const Mesh shape = make_shape(i % 2 == 0 ? "sphere2" : "sphere1");
                const Vec3 x = random.direction(), y = random.direction();
                Vec3 z = cross(x, y);
                const Vec3 middle = random.point(-0.8, 0.8);
                const double size = random.uniform(0.3, 1);
                std::vector<Vec3> vertices;
                for (const Vec3& v : shape.vertices()) {
                    Vec3 moved;
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        moved[axis] = offset + middle[axis] + size * (x[axis] * v[0] + y[axis] * v[1] + z[axis] * v[2]);
                    vertices.push_back(moved);
                }
                bodies.emplace_back(std::move(vertices), shape.triangles());
            }
            const Mesh given = together(bodies, "six bodies at " + std::to_string(offset));
            check_boundary(given, outer(given), random, 100);
        }
    }
}

BOOST_AUTO_TEST_CASE(tetrahedra_of_any_size) {
    constexpr std::uint64_t seed = 8;
    BOOST_TEST_MESSAGE("seed " << seed);
    for (const double scale : {1e-300, 1e-60, 1e-9, 1e9, 1e40, 1e150}) {
        Random random(seed);
        std::vector<Mesh> meshes;
        double volume = 0;
        for (int i = 0; i < 8; ++i) {
            std::vector<Vec3> vertices{random.point(0, 1), random.point(0, 1), random.point(0, 1), random.point(0, 1)};
            std::vector<Triangle> faces{{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
            const double twice = dot(cross(difference(vertices[1], vertices[0]), difference(vertices[2], vertices[0])),
                                     difference(vertices[3], vertices[0]));
            if (twice < 0)
                for (Triangle& face : faces) std::swap(face[0], face[1]);
            for (Vec3& vertex : vertices)
                for (double& x : vertex) x *= scale;
            meshes.emplace_back(vertices, faces);
            volume += std::abs(twice) / 6;
        }
        const OuterSurface surface = outer(together(meshes, "tetrahedra"));
        BOOST_TEST(describe_topology(surface.mesh).balanced);
        BOOST_TEST(surface.partial_faces > 0U);
        if (scale > 1e-100 && scale < 1e100) BOOST_TEST(surface.volume < volume * scale * scale * scale);
    }
}

// A ray must miss the edges of a fan, wherever they lie.
BOOST_AUTO_TEST_CASE(a_face_below_a_fan) {
    std::vector<Vec3> vertices{{0, 0, 0}, {27720, 0, 0}, {0, 27720, 0}, {0, 0, 1}, {27720, 0, 1}, {0, 27720, 1}};
    std::set<double> spokes;
    for (int a = 1; a <= 12; ++a)
        for (int b = 1; b <= 12; ++b) spokes.insert(std::round(27720.0 * a / (a + b)));
    std::vector<std::uint32_t> top{3};
    for (const double x : spokes) {
        top.push_back(static_cast<std::uint32_t>(vertices.size()));
        vertices.push_back({x, 0, 1});
    }
    top.push_back(4);
    std::vector<Triangle> faces{{1, 0, 2}, {0, 1, 4}, {2, 0, 3}, {2, 3, 5}, {1, 2, 5}, {1, 5, 4}};
    for (std::size_t i = 0; i + 1 < top.size(); ++i) {
        faces.push_back({5, top[i], top[i + 1]});
        faces.push_back({0, top[i + 1], top[i]});
    }
    const Mesh prism(vertices, faces, "prism");
    BOOST_TEST(outer(prism).whole_faces == faces.size());
}

BOOST_AUTO_TEST_CASE(houses_on_their_ground) {
    constexpr std::uint64_t seed = 4;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    std::vector<Box> boxes(12);
    for (Box& box : boxes) {
        box.lower = {random.uniform(0, 2), random.uniform(0, 2), 0};
        box.upper = {box.lower[0] + random.uniform(0.2, 1), box.lower[1] + random.uniform(0.2, 1),
                     random.uniform(0.1, 1)};
    }
    check_boxes(boxes, random, "houses");
}

/// Prisms around one axis that stand on one plane, the narrower ones higher, each a lid, a bottom and `corners` sides.
Mesh stacked_prisms(std::uint32_t corners, std::uint32_t count, bool is_widest_first) {
    std::vector<Mesh> meshes;
    for (std::uint32_t k = 0; k < count; ++k) {
        const std::uint32_t from_inside = is_widest_first ? count - k : k + 1;
        std::vector<Vec3> vertices;
        for (std::uint32_t i = 0; i < 2 * corners; ++i) {
            const double angle = 2 * std::numbers::pi * ((i % corners) + 0.3 * from_inside) / corners;
            vertices.push_back({from_inside * std::cos(angle), from_inside * std::sin(angle),
                                i < corners ? 0.0 : static_cast<double>(count + 1 - from_inside)});
        }
        std::vector<Triangle> triangles;
        for (std::uint32_t i = 0; i < corners; ++i) {
            const std::uint32_t next = (i + 1) % corners;
            triangles.push_back({i, next, corners + next});
            triangles.push_back({i, corners + next, corners + i});
            if (i == 0 || next == 0) continue;
            triangles.push_back({0, next, i});
            triangles.push_back({corners, corners + i, corners + next});
        }
        meshes.emplace_back(std::move(vertices), std::move(triangles), "prism");
    }
    return together(meshes, "prisms");
}

BOOST_AUTO_TEST_CASE(faces_of_one_plane_are_cut_by_outlines) {
    Random random(7);
    constexpr std::uint32_t corners = 64, count = 6;
    for (const bool is_widest_first : {true, false}) {
        const Mesh given = stacked_prisms(corners, count, is_widest_first);
        const OuterSurface surface = outer(given);
        check_boundary(given, surface, random, 20);
        // A disk has two triangles less than corners, a ring as many as corners on both circles, a band two for each of
        // its sides. Each triangle is a part of one face: so where an inner edge of a lid or of a band meets a circle,
        // there is a corner, and the faces on both sides have one triangle more.
        std::size_t met = (count - 1) * corners;  // by the bands
        for (std::uint32_t k = 1; k < count; ++k) {
            const auto at = [](std::uint32_t radius, std::uint32_t i) {
                const double angle = 2 * std::numbers::pi * (i + 0.3 * radius) / corners;
                return std::array{radius * std::cos(angle), radius * std::sin(angle)};
            };
            const auto first = at(k + 1, 0);
            for (std::uint32_t i = 2; i + 1 < corners; ++i) {
                const auto last = at(k + 1, i);
                const auto is_left = [&](const std::array<double, 2>& p) {
                    return (last[0] - first[0]) * (p[1] - first[1]) > (last[1] - first[1]) * (p[0] - first[0]);
                };
                for (std::uint32_t j = 0; j < corners; ++j) met += is_left(at(k, j)) != is_left(at(k, j + 1));
            }
        }
        std::size_t fewest = 2 * (corners - 2) + 2 * corners * count + 2 * corners * (count - 1) + 2 * met;
        // The bottom is of the prism with the lowest faces: in rings, or the widest one's alone.
        if (!is_widest_first) fewest += 2 * (corners * (count - 1) + met - (count - 1) * corners);
        BOOST_TEST(surface.mesh.triangles().size() == fewest);
    }
}

BOOST_AUTO_TEST_CASE(houses_on_a_slab_share_its_plane) {
    std::vector<Box> boxes{{{0, 0, -1}, {40, 40, 0}}};
    for (int i = 0; i < 400; ++i) {
        const double x = 2 * (i % 20) + 0.5, y = 2 * (i / 20) + 0.5;
        boxes.push_back({{x, y, 0}, {x + 1, y + 1, 1 + (i % 7) / 4.0}});
    }
    Random random(8);
    check_boxes(boxes, random, "houses on a slab");
    std::vector<Mesh> meshes;
    for (const Box& box : boxes) meshes.push_back(box_mesh(box, 0));
    // A house has walls and a roof. The slab's top has a hole below each house, and two halves: their edge meets the
    // outlines of the twenty houses on it in corners of holes.
    const std::size_t fewest = 400 * 10 + 10 + 400 * 6 + 2;
    BOOST_TEST(outer(together(meshes, "houses on a slab")).mesh.triangles().size() == fewest);
}

BOOST_AUTO_TEST_CASE(a_mesh_without_meetings_stays) {
    const Mesh sphere = make_shape("sphere3");
    const OuterSurface surface = outer(sphere);
    BOOST_TEST(surface.whole_faces == sphere.triangles().size());
    BOOST_TEST((surface.mesh.vertices().size() == sphere.vertices().size()));
    for (std::size_t face = 0; face < sphere.triangles().size(); ++face)
        for (std::size_t i = 0; i < 3; ++i)
            BOOST_TEST((surface.mesh.vertices()[surface.mesh.triangles()[face][i]] ==
                        sphere.vertices()[sphere.triangles()[face][i]]));
}

BOOST_AUTO_TEST_CASE(what_the_sign_does_is_done) {
    Random random(3);
    const Box unit{{0, 0, 0}, {1, 1, 1}}, small{{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}};
    const auto volume = [](const Mesh& mesh, SignRule rule = SignRule::automatic) { return outer(mesh, rule).volume; };
    // Cavities.
    BOOST_TEST(volume(together({box_mesh(unit, 5), box_mesh(small, 9, true)}, "cavity")) == 0.875);
    BOOST_TEST(volume(together({box_mesh(unit, 5), box_mesh(small, 9)}, "filled")) == 1);
    BOOST_TEST(volume(together({box_mesh(unit, 5), box_mesh(small, 9)}, "parity"), SignRule::parity) == 0.875);
    // Inside out: the faces are turned.
    const Mesh inside_out =
        together({box_mesh(unit, 0, true), box_mesh({{0.5, 0, 0}, {2, 1, 1}}, 0, true)}, "inside out");
    BOOST_TEST(volume(inside_out) == 2);
    check_boundary(inside_out, outer(inside_out), random, 20);
    // A face that looks the wrong way, one that is there twice, a sheet beside the box.
    std::vector<Triangle> turned = box_mesh(unit, 0).triangles(), doubled = turned, beside = turned;
    std::swap(turned[3][0], turned[3][1]);
    BOOST_TEST(volume({box_mesh(unit, 0).vertices(), turned}) == 1);
    doubled.push_back(doubled[4]);
    BOOST_TEST(volume({box_mesh(unit, 0).vertices(), doubled}) == 1);
    std::vector<Vec3> vertices = box_mesh(unit, 0).vertices();
    vertices.insert(vertices.end(), {{0.25, 0.5, 2}, {0.75, 0.5, 2}, {0.5, 0.5, 3}});
    beside.push_back({8, 9, 10});
    const OuterSurface without_sheet = outer({vertices, beside});
    BOOST_TEST(without_sheet.volume == 1);
    BOOST_TEST(without_sheet.hidden_faces == 1U);
    // Seams that differ by rounding.
    Mesh seam = together({box_mesh(unit, 0)}, "seam");
    std::vector<Vec3> apart = seam.vertices();
    std::vector<Triangle> faces = seam.triangles();
    apart.push_back({1 + 0x1p-52, 1, 1});
    std::replace(faces[2].begin(), faces[2].end(), 7U, 8U);
    BOOST_TEST(std::abs(volume({apart, faces}) - 1) < 1e-15);
}

/// A box whose lids are divided into n x n squares, and whose sides are two triangles each.
Mesh box_with_fine_lids(std::uint32_t n) {
    std::vector<Vec3> vertices;
    for (std::uint32_t z = 0; z < 2; ++z)
        for (std::uint32_t y = 0; y <= n; ++y)
            for (std::uint32_t x = 0; x <= n; ++x)
                vertices.push_back({2.0 * x / n, 2.0 * y / n, static_cast<double>(z)});
    const std::uint32_t row = n + 1, lid = row * row;
    std::vector<Triangle> triangles;
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t a = y * row + x, b = a + 1, c = b + row, d = a + row;
            triangles.insert(triangles.end(), {{a, c, b}, {a, d, c}});
            triangles.insert(triangles.end(), {{lid + a, lid + b, lid + c}, {lid + a, lid + c, lid + d}});
        }
    const std::array<std::uint32_t, 4> around{0, n, lid - 1, lid - row};
    for (std::size_t k = 0; k < 4; ++k) {
        const std::uint32_t a = around[k], b = around[(k + 1) % 4];
        triangles.insert(triangles.end(), {{a, b, lid + b}, {a, lid + b, lid + a}});
    }
    return {std::move(vertices), std::move(triangles), "box with fine lids"};
}

BOOST_AUTO_TEST_CASE(corners_in_edges_close_the_surface) {
    Random random(4);
    for (const std::uint32_t n : {2U, 3U, 7U})
        for (const double angle : {0.0, 0.6}) {  // corners on the edges, and beside them by rounding
            const Mesh plain = box_with_fine_lids(n), mesh = angle == 0 ? plain : tilted(plain, angle);
            std::string warning;
            const OuterSurface surface =
                outer(mesh, SignRule::automatic, {.log = [&](const std::string& text) { warning += text; }});
            BOOST_TEST_CONTEXT(n << " squares, angle " << angle) {
                BOOST_TEST(std::abs(surface.volume - 4) < 1e-13);
                BOOST_TEST(std::abs(surface.area - 16) < 1e-12);
                BOOST_TEST(describe_topology(surface.mesh).balanced);
                BOOST_TEST(surface.whole_faces + surface.partial_faces == mesh.triangles().size());
                BOOST_TEST(std::ranges::all_of(surface.faces,
                                               [&](std::uint32_t face) { return face < mesh.triangles().size(); }));
                BOOST_TEST(
                    warning.find(std::to_string(8 * (n - 1)) + " corners of faces lie in edges") != std::string::npos,
                    warning);
            }
            // Overlapping another body.
            if (angle > 0) continue;
            const Mesh two = together({mesh, shifted(mesh, {1, 1, 0.5})}, "two");
            BOOST_TEST(std::abs(outer(two).volume - 7.5) < 1e-12);
            check_boundary(two, outer(two), random, 20);
        }
    // A corner farther off is none.
    std::vector<Vec3> vertices = box_with_fine_lids(2).vertices();
    vertices[1][1] = -1e-7;
    check_throws(ErrorCode::unsupported, {"open edges"}, [&] { outer({vertices, box_with_fine_lids(2).triangles()}); });
}

BOOST_AUTO_TEST_CASE(gaps_of_a_rounding_are_closed) {
    std::string warning;
    const auto check = [&](const Mesh& mesh, double volume, double area) {
        warning.clear();
        const OuterSurface surface =
            outer(mesh, SignRule::automatic, {.log = [&](const std::string& text) { warning += text; }});
        BOOST_TEST_CONTEXT(mesh.name()) {
            BOOST_TEST(std::abs(surface.volume - volume) < 1e-12 * volume);
            BOOST_TEST(std::abs(surface.area - area) < 1e-11 * area);
            BOOST_TEST(describe_topology(surface.mesh).balanced);
            BOOST_TEST(warning.find("stay apart") == std::string::npos, warning);
        }
    };
    for (const double side : {0.07, 0.1, 0.3}) {
        std::vector<Mesh> cubes;
        for (int i = 0; i < 50; ++i)
            cubes.push_back(box_mesh({{i * side, 0, 0}, {i * side + side, side, side}}, static_cast<unsigned>(i)));
        const Mesh row = together(cubes, "row of " + std::to_string(side));
        check(row, 50 * side * side * side, 202 * side * side);
        for (const double angle : {0.5, 1.1}) check(tilted(row, angle), 50 * side * side * side, 202 * side * side);
    }
    // Boxes that touch in a part of a side, and planks laid crosswise: no corner of one is near the other.
    const double above = std::nextafter(0.3, 1);
    const Mesh part =
        together({box_mesh({{0, 0, 0}, {1, 1, 0.3}}, 3), box_mesh({{0.25, 0.5, above}, {2, 2, 1}}, 6)}, "part");
    const Mesh planks = together(
        {box_mesh({{-5, -0.5, 0}, {5, 0.5, 0.3}}, 1), box_mesh({{-0.5, -5, above}, {0.5, 5, 0.6}}, 2)}, "planks");
    for (const double angle : {0.0, 0.5}) {
        const auto placed = [&](const Mesh& mesh) { return angle == 0 ? mesh : tilted(mesh, angle); };
        check(placed(part), 0.3 + 1.75 * 1.5 * 0.7, 3.2 + 2 * (1.75 * 1.5 + 1.75 * 0.7 + 1.5 * 0.7) - 2 * 0.75 * 0.5);
        check(placed(planks), 6, 2 * (2 * (10 + 3 + 0.3) - 1));
    }
    // A block of 27.
    std::vector<Mesh> cubes;
    for (int n = 0; n < 27; ++n) {
        const double x = 0.1 * (n % 3), y = 0.1 * (n / 3 % 3), z = 0.1 * (n / 9);
        cubes.push_back(box_mesh({{x, y, z}, {x + 0.1, y + 0.1, z + 0.1}}, static_cast<unsigned>(n)));
    }
    check(together(cubes, "block"), 0.027, 0.54);
    // Wider gaps stay, and a warning says so.
    const Mesh apart = together({box_mesh({{0, 0, 0}, {1, 1, 1}}, 0), box_mesh({{1 + 1e-12, 0, 0}, {2, 1, 1}}, 0)}, "");
    const OuterSurface surface =
        outer(apart, SignRule::automatic, {.log = [&](const std::string& text) { warning = text; }});
    BOOST_TEST(std::abs(surface.area - 12) < 1e-11);
    BOOST_TEST(warning.find("stay apart") != std::string::npos, warning);
}

BOOST_AUTO_TEST_CASE(gaps_are_closed_where_some_vertices_are_common) {
    constexpr std::uint64_t seed = 20261201;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (int trial = 0; trial < 64; ++trial) {
        const auto common = static_cast<unsigned>(trial % 16);  // bits of the four vertices of the side
        const double angle = random.uniform(0, 1.5), size = random.uniform(0.3, 3);
        const auto turned = [&](const Mesh& mesh) {
            std::vector<Vec3> vertices;
            for (const Vec3& v : mesh.vertices())
                vertices.push_back({size * (std::cos(angle) * v[0] - std::sin(angle) * v[1]),
                                    size * (std::sin(angle) * v[0] + std::cos(angle) * v[1]), size * v[2]});
            return Mesh(std::move(vertices), mesh.triangles(), mesh.name());
        };
        const Mesh one = turned(box_mesh({{0, 0, 0}, {1, 1, 1}}, random.index(64)));
        const Mesh straight = turned(box_mesh({{1, 0, 0}, {2, 1, 1}}, random.index(64)));
        std::vector<Vec3> vertices = straight.vertices();
        unsigned n = 0;
        for (std::size_t v = 0; v < 8; v += 2, ++n)  // of the low side along x; the next ones are of the high one
            for (double& x : vertices[v] = one.vertices()[v + 1])
                if ((common >> n & 1U) == 0) x = std::nextafter(x, random.index(2) == 0 ? -10 : 10);
        const OuterSurface surface =
            outer(together({one, Mesh(vertices, straight.triangles(), "other")}, "two boxes " + std::to_string(trial)));
        BOOST_TEST(std::abs(surface.area - 10 * size * size) < 1e-12 * size * size, trial << ": " << surface.area);
        BOOST_TEST(std::abs(surface.volume - 2 * size * size * size) < 1e-12 * size * size * size);
    }
}

BOOST_AUTO_TEST_CASE(edges_that_are_divided_on_both_sides_are_closed) {
    const double third = 1.0 / 3, two_thirds = 2.0 / 3;
    const Mesh given({{0, 0, 0},
                      {0, 0, 1},
                      {0, 1, 0},
                      {0, 1, 1},
                      {third, 1, 0},
                      {third, 1, 1},
                      {0.5, 0, 1},
                      {0.5, 1, 1},
                      {two_thirds, 1, 0},
                      {two_thirds, 1, 1},
                      {1, 0, 0},
                      {1, 0, 1},
                      {1, 1, 0},
                      {1, 1, 1}},
                     {{0, 2, 10},
                      {2, 12, 10},
                      {1, 6, 7},
                      {1, 7, 3},
                      {6, 11, 13},
                      {6, 13, 7},
                      {0, 10, 11},
                      {0, 11, 1},
                      {2, 3, 4},
                      {3, 5, 4},
                      {4, 5, 8},
                      {5, 9, 8},
                      {8, 9, 12},
                      {9, 13, 12},
                      {0, 1, 2},
                      {1, 3, 2},
                      {10, 12, 11},
                      {12, 13, 11}},
                     "box");
    const OuterSurface surface = outer(given);
    BOOST_TEST(std::abs(surface.volume - 1) < 1e-14);
    BOOST_TEST(std::abs(surface.area - 6) < 1e-14);
}

BOOST_AUTO_TEST_CASE(groups_and_faces_as_given) {
    Mesh two =
        together({box_mesh({{0, 0, 0}, {1, 1, 1}}, 0), box_mesh({{0.5, 0.25, 0.25}, {1.5, 0.75, 0.75}}, 0)}, "two");
    std::vector<std::uint32_t> numbers(24, 0);
    std::fill(numbers.begin() + 12, numbers.end(), 1U);
    two.set_groups({{"big", "small"}, numbers});
    const OuterSurface surface = outer(two);
    BOOST_REQUIRE(surface.mesh.groups().numbers.size() == surface.faces.size());
    for (std::size_t i = 0; i < surface.faces.size(); ++i)
        BOOST_TEST(surface.mesh.groups().numbers[i] == (surface.faces[i] < 12 ? 0U : 1U));
    // Of equal faces the lowest counts.
    const Box unit{{0, 0, 0}, {1, 1, 1}};
    for (const std::uint32_t face : outer(together({box_mesh(unit, 21), box_mesh(unit, 42)}, "twice")).faces)
        BOOST_TEST(face < 12U);
}

BOOST_AUTO_TEST_CASE(refusals_name_the_remedy) {
    const Mesh box = box_mesh({{0, 0, 0}, {1, 1, 1}}, 0);
    const Mesh open(box.vertices(), {box.triangles().begin(), box.triangles().end() - 1}, "open box");
    check_throws(ErrorCode::unsupported, {"closed mesh", "open edges"}, [&] { outer(open); });
    check_throws(ErrorCode::invalid_mesh, {"unbalanced"}, [&] { outer(open, SignRule::nonzero); });
    check_throws(ErrorCode::unsupported, {"none"}, [&] { outer(box, SignRule::none); });
    check_throws(ErrorCode::unsupported, {"below"}, [&] { outer(box, SignRule::below); });
    int asked = 0;
    check_throws(ErrorCode::cancelled, {"outer surface"},
                 [&] { outer(box, SignRule::automatic, {.should_stop = [&] { return ++asked == 2; }}); });
    // A sheet on both sides has no inside.
    const Mesh sheet({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}, "sheet");
    check_throws(ErrorCode::invalid_mesh, {"nothing is inside"}, [&] { outer(sheet); });
}

}  // namespace clsdf
