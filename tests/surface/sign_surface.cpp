// What decides the sign of meshes that are not balanced (docs/sign.md).

#include "surface/sign_surface.hpp"

#include <clsdf/topology.hpp>

#include "mesh/join_vertices.hpp"
#include "support/doubtful_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/throws.hpp"
#include "surface/topology.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace clsdf {

using namespace test;

namespace {

std::string warning_of(const Mesh& mesh, SignRule expected, SignRule asked = SignRule::automatic) {
    const ResolvedSignRule resolved = resolve_sign_rule(asked, describe_topology(mesh));
    BOOST_TEST(name_of(resolved.rule) == name_of(expected));
    return resolved.warning;
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// The clusters by comparing all pairs.
std::vector<JoinedVertex> joined_by_pairs(const std::vector<Vec3>& positions, double tolerance) {
    std::vector<std::uint32_t> set(positions.size());
    std::iota(set.begin(), set.end(), 0U);
    const auto are_near = [&](const Vec3& a, const Vec3& b, double length) {
        return std::abs(a[0] - b[0]) <= length && std::abs(a[1] - b[1]) <= length && std::abs(a[2] - b[2]) <= length;
    };
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        for (std::uint32_t j = 0; j < i; ++j)
            if (are_near(positions[i], positions[j], tolerance) && set[i] != set[j])
                std::ranges::replace(set, std::uint32_t{std::max(set[i], set[j])},
                                     std::uint32_t{std::min(set[i], set[j])});
    std::vector<JoinedVertex> joined;
    std::map<std::uint32_t, std::vector<std::uint32_t>> clusters;
    for (std::uint32_t i = 0; i < set.size(); ++i) clusters[set[i]].push_back(i);
    for (const auto& [root, cluster] : clusters) {
        Vec3 lower = positions[root], upper = lower;
        for (const std::uint32_t i : cluster)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                lower[axis] = std::min(lower[axis], positions[i][axis]);
                upper[axis] = std::max(upper[axis], positions[i][axis]);
            }
        if (!are_near(lower, upper, longest_cluster * tolerance)) continue;
        const std::uint32_t least = *std::ranges::min_element(cluster, {}, [&](auto i) { return positions[i]; });
        for (const std::uint32_t i : cluster)
            if (i != least) joined.push_back({i, least});
    }
    std::ranges::sort(joined, {}, &JoinedVertex::vertex);
    return joined;
}

}  // namespace

BOOST_AUTO_TEST_CASE(clusters_are_those_of_all_pairs) {
    std::size_t long_ones = 0;
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U})
        for (const double step : {0.0, 0.3, 0.9, 1.0, 2.0}) {
            BOOST_TEST_CONTEXT("seed " << seed << ", step " << step) {
                Random random(seed);
                // Crowds, chains and single points; whole multiples of the tolerance are at its very limit.
                const double tolerance = 0x1p-10;
                std::vector<Vec3> positions;
                for (int crowd = 0; crowd < 12; ++crowd) {
                    const Vec3 centre{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
                    const std::uint32_t size = 1 + random.index(40);
                    Vec3 at = centre;
                    for (std::uint32_t i = 0; i < size; ++i) {
                        for (std::size_t axis = 0; axis < 3; ++axis) {
                            const double length = step == 1.0 ? random.index(3) - 1.0 : random.uniform(-step, step);
                            at[axis] = (crowd % 2 == 0 ? at : centre)[axis] + tolerance * length;
                        }
                        positions.push_back(at);
                    }
                }
                std::ranges::sort(positions);
                positions.erase(std::ranges::unique(positions).begin(), positions.end());
                std::vector<std::uint32_t> all(positions.size());
                std::iota(all.begin(), all.end(), 0U);
                const auto found = join_vertices(positions, all, tolerance);
                const auto expected = joined_by_pairs(positions, tolerance);
                BOOST_TEST(found.size() == expected.size());
                BOOST_TEST(std::ranges::equal(found, expected, [](const JoinedVertex& a, const JoinedVertex& b) {
                    return a.vertex == b.vertex && a.least == b.least;
                }));
                long_ones += found.size() + 1 < positions.size() ? 1U : 0U;
            }
        }
    BOOST_TEST(long_ones > 0U);
}

BOOST_AUTO_TEST_CASE(a_crowd_is_joined_in_a_moment) {
    // Within one tolerance, and beside each other so that nothing separates them.
    Random random(3);
    std::vector<Vec3> positions;
    for (int i = 0; i < 200000; ++i)
        positions.push_back({random.uniform(0, 3e-13), random.uniform(0, 3e-13), random.uniform(0, 3e-13)});
    std::vector<std::uint32_t> all(positions.size());
    std::iota(all.begin(), all.end(), 0U);
    BOOST_TEST(join_vertices(positions, all, 1e-13).size() == positions.size() - 1);
    BOOST_TEST(join_vertices(positions, all, 0.5e-13).empty());  // too long: left apart
}

BOOST_AUTO_TEST_CASE(seams_that_differ_by_rounding_are_closed) {
    for (const Mesh& mesh : {seamed_torus(), seamed_ellipsoid()}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            const Topology topology = describe_topology(mesh);
            BOOST_TEST(topology.balanced);
            BOOST_TEST(!topology.inside_out);
            BOOST_TEST(topology.joined_vertices > 0U);
            BOOST_TEST(topology.open_edges == 0U);
            BOOST_TEST(topology.parts == 1U);
            BOOST_TEST(has(warning_of(mesh, SignRule::nonzero), "by rounding"));
        }
    }
}

BOOST_AUTO_TEST_CASE(the_vertex_that_counts_is_the_least_whatever_the_order) {
    const Mesh torus = seamed_torus();
    Random random(5);
    const auto positions_that_count = [](const Mesh& mesh) {
        const SignSurface surface = describe_mesh(mesh).surface;
        std::vector<Vec3> positions;
        for (std::uint32_t v = 0; v < mesh.vertices().size(); ++v)
            positions.push_back(mesh.vertices()[surface.vertex(v)]);
        std::ranges::sort(positions);
        positions.erase(std::ranges::unique(positions).begin(), positions.end());
        return positions;
    };
    BOOST_TEST((positions_that_count(torus) == positions_that_count(reordered(torus, random))));
    BOOST_TEST((positions_that_count(torus) == positions_that_count(weld(torus))));
}

BOOST_AUTO_TEST_CASE(nothing_is_joined_but_ends_of_unbalanced_edges) {
    // Two closed cubes that are a rounding apart stay two.
    const Mesh cubes = together({cube(1), shifted(cube(1), {2 + 0x1p-50, 0, 0})}, "cubes");
    BOOST_TEST(describe_topology(cubes).joined_vertices == 0U);
    BOOST_TEST(describe_mesh(cubes).surface.is_mesh());
    BOOST_TEST(describe_topology(cubes).parts == 2U);
    // A crack wider than the tolerance stays one, and so does a chain of twins that is too long.
    const auto cracked = [](double width) {
        const Mesh whole = cube(1);
        std::vector<Vec3> vertices = whole.vertices();
        vertices.push_back({vertices[7][0] + width, vertices[7][1], vertices[7][2]});
        std::vector<Triangle> triangles = whole.triangles();
        for (std::uint32_t& v : triangles.back())
            if (v == 7) v = 8;
        return Mesh(vertices, triangles, "cube with a crack");
    };
    BOOST_TEST(describe_topology(cracked(0x1p-43)).balanced);
    BOOST_TEST(!describe_topology(cracked(0x1p-41)).balanced);
    BOOST_TEST(describe_topology(weld(cracked(1e-7), 1e-6)).balanced);
    check_throws(ErrorCode::invalid_argument, {"-1", "0 or more"}, [&] { weld(cracked(0), -1); });
}

BOOST_AUTO_TEST_CASE(doubled_faces_count_once) {
    const Mesh solid = cube(1);
    const Triangle face = solid.triangles()[4];
    const auto topology_of = [&](const std::vector<Triangle>& more) {
        return describe_topology(with_faces(solid, more, "cube"));
    };
    const Topology twice = topology_of({face});
    BOOST_TEST(twice.balanced);
    BOOST_TEST(twice.duplicate_faces == 1U);
    BOOST_TEST(twice.uncounted_faces == 1U);
    BOOST_TEST(twice.open_edges == 0U);
    BOOST_TEST(twice.boundary_edges == 0U);
    BOOST_TEST(twice.non_manifold_edges == 3U);
    BOOST_TEST(has(warning_of(with_faces(solid, {face}, "cube"), SignRule::nonzero), "1 face is there twice"));
    BOOST_TEST(topology_of({{face[1], face[2], face[0]}}).balanced);
    BOOST_TEST(topology_of({face, face}).balanced);
    BOOST_TEST(topology_of({face, turned(face)}).balanced);  // as it is
    BOOST_TEST(topology_of({face, turned(face)}).uncounted_faces == 0U);
    BOOST_TEST(topology_of({face, face, turned(face)}).balanced);
    // All of it twice is balanced, and counts twice as before.
    std::vector<Triangle> all = solid.triangles();
    BOOST_TEST(topology_of(all).balanced);
    BOOST_TEST(topology_of(all).duplicate_faces == 12U);
    BOOST_TEST(topology_of(all).uncounted_faces == 0U);
}

BOOST_AUTO_TEST_CASE(faces_that_cancel_each_other_count_once_where_that_closes_the_mesh) {
    const Mesh solid = make_shape("sphere2");
    const std::vector<Triangle>& faces = solid.triangles();
    // The lowest of the two decides, so the first face of the second mesh looks the wrong way.
    for (const Mesh& mesh : {with_faces(solid, {turned(faces[0]), turned(faces[1]), turned(faces[9])}, "sphere"),
                             with_faces(with_turned(solid, {0}, ""), {faces[0]}, "sphere")}) {
        const Topology topology = describe_topology(mesh);
        BOOST_TEST(topology.balanced);
        const std::size_t more = mesh.triangles().size() - faces.size();
        BOOST_TEST(topology.uncounted_faces == more);
        BOOST_TEST(topology.reoriented_faces == (more == 1 ? 1U : 0U));
        const SignSurface surface = describe_mesh(mesh).surface;
        for (std::size_t face = 0; face < mesh.triangles().size(); ++face)
            BOOST_TEST(surface.count(face) == (face >= faces.size() ? 0 : more == 1 && face == 0 ? -1 : 1));
    }
    // A fin closes nothing; what is closed without it stays so.
    std::vector<Vec3> positions = solid.vertices();
    positions.push_back({3, 0, 0});
    const auto tip = static_cast<std::uint32_t>(positions.size() - 1);
    const Triangle fin{faces[4][0], faces[4][1], tip};
    std::vector<Triangle> with_fin = with_faces(solid, {turned(faces[7])}, "").triangles();
    with_fin.insert(with_fin.end(), {fin, turned(fin)});
    const Topology finned = describe_topology(Mesh(positions, with_fin));
    BOOST_TEST(finned.balanced);
    BOOST_TEST(finned.uncounted_faces == 3U);
    // With a hole elsewhere they cancel each other.
    std::vector<Triangle> with_hole = with_faces(solid, {turned(faces[7])}, "").triangles();
    with_hole.erase(with_hole.begin() + 40);
    BOOST_TEST(describe_topology(Mesh(solid.vertices(), with_hole)).boundary_edges == 6U);
}

BOOST_AUTO_TEST_CASE(doubled_faces_count_as_they_are_if_more_edges_would_be_unbalanced) {
    // Two boxes, one within the other, with a floor for each, and a hole.
    const Mesh boxes = weld(together({box({0, 0, 0}, {1, 1, 1}), box({0, 0, 0}, {1, 1, 2})}, "boxes"));
    std::vector<Triangle> triangles = boxes.triangles();
    std::erase(triangles, *std::ranges::find_if(triangles, [&](const Triangle& triangle) {
                   return std::ranges::all_of(triangle, [&](std::uint32_t v) { return boxes.vertices()[v][2] == 2; });
               }));
    const Topology topology = describe_topology(Mesh(boxes.vertices(), triangles));
    BOOST_TEST(topology.unbalanced_edges == 3U);
    BOOST_TEST(topology.duplicate_faces == 2U);
    BOOST_TEST(topology.uncounted_faces == 0U);
}

BOOST_AUTO_TEST_CASE(doubled_faces_never_open_what_is_closed) {
    // A wall that both boxes have, one of which is inside out, and a face that looks the wrong way.
    const Mesh boxes = weld(together({box({0, 0, 0}, {1, 1, 1}), reversed(box({1, 0, 0}, {2, 1, 1}))}, "boxes"));
    BOOST_TEST(describe_topology(boxes).balanced);
    std::size_t outer = 12;
    const auto is_at_wall = [&](std::size_t face) {
        return std::ranges::any_of(boxes.triangles()[face], [&](auto v) { return boxes.vertices()[v][0] == 1; });
    };
    while (is_at_wall(outer)) ++outer;
    const Topology topology = describe_topology(with_turned(boxes, {outer}, "boxes"));
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.duplicate_faces == 2U);
    BOOST_TEST(topology.uncounted_faces == 0U);
    BOOST_TEST(topology.reoriented_faces == 1U);
}

BOOST_AUTO_TEST_CASE(an_inner_wall_is_left_out) {
    const Mesh mesh = boxes_with_membrane();
    const Topology topology = describe_topology(mesh);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.open_edges == 0U);
    BOOST_TEST(topology.inner_wall_faces == 2U);
    BOOST_TEST(topology.sheet_faces == 2U);
    for (std::size_t k = 0; k < 3; ++k)
        BOOST_TEST(mesh.vertices()[mesh.triangles()[topology.first_inner_wall_face][k]][0] == 1);
    const std::string warning = warning_of(mesh, SignRule::nonzero);
    BOOST_TEST(has(warning, "2 faces of inner walls are left out"), warning);
    // However the wall and each of the boxes look.
    const auto place_of = [&](const Triangle& triangle) {
        double sum = 0;
        for (const std::uint32_t v : triangle) sum += mesh.vertices()[v][0];
        return sum < 3 ? 0U : sum > 3 ? 1U : 2U;
    };
    for (unsigned orientation = 0; orientation < 8; ++orientation) {
        std::vector<std::size_t> faces;
        for (std::size_t face = 0; face < mesh.triangles().size(); ++face)
            if ((orientation >> place_of(mesh.triangles()[face]) & 1U) != 0) faces.push_back(face);
        const Mesh turned = with_turned(mesh, faces, "");
        const Topology found = describe_topology(turned);
        BOOST_TEST_CONTEXT("orientation " << orientation) {
            BOOST_TEST(found.balanced);
            BOOST_TEST(found.inner_wall_faces == 2U);
            BOOST_TEST(place_of(mesh.triangles()[found.first_inner_wall_face]) == 2U);
            const SignSurface surface = describe_mesh(turned).surface;
            for (std::size_t face = 0; face < mesh.triangles().size(); ++face)
                BOOST_TEST((surface.count(face) == 0) == (place_of(mesh.triangles()[face]) == 2U));
        }
    }
    // The rule auto alone leaves it out.
    const Topology by_name = describe_mesh(mesh, SignRule::nonzero).topology;
    BOOST_TEST(by_name.open_edges == 4U);
    BOOST_TEST(by_name.boundary_edges == 0U);
    BOOST_TEST(by_name.inner_wall_faces == 2U);
    BOOST_TEST(by_name.sheet_faces == 0U);
    check_throws(ErrorCode::invalid_mesh, {"nonzero", "unbalanced"},
                 [&] { resolve_sign_rule(SignRule::nonzero, by_name); });
    check_throws(ErrorCode::invalid_mesh,
                 {"parity", "4 edges have an odd number of faces", "2 faces are an inner wall"},
                 [&] { resolve_sign_rule(SignRule::parity, by_name); });
    for (const SignRule rule : {SignRule::nonzero, SignRule::parity})
        check_throws(ErrorCode::invalid_mesh, {"2 faces of sheets or inner walls", "auto"},
                     [&] { resolve_sign_rule(rule, topology); });
    BOOST_TEST(describe_mesh(mesh, SignRule::solid_angle).surface.is_mesh());
}

BOOST_AUTO_TEST_CASE(faces_that_look_the_wrong_way_are_turned_around) {
    const Mesh sphere = make_shape("sphere2");
    const Mesh mesh = with_turned(sphere, {17, 18, 100}, "sphere");
    const Topology topology = describe_topology(mesh);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(!topology.inside_out);
    BOOST_TEST(topology.reoriented_faces == 3U);
    const SignSurface surface = describe_mesh(mesh).surface;
    for (std::size_t face = 0; face < sphere.triangles().size(); ++face)
        BOOST_TEST(surface.count(face) == (face == 17 || face == 18 || face == 100 ? -1 : 1));
    BOOST_TEST(has(warning_of(mesh, SignRule::nonzero), "3 faces look the wrong way"));
    // The sign rule parity needs no orientation.
    BOOST_TEST(has(warning_of(mesh, SignRule::parity, SignRule::parity), "3 faces look the wrong way"));
}

BOOST_AUTO_TEST_CASE(a_part_keeps_the_orientation_of_most_of_its_area) {
    // A cavity stays a cavity.
    const Mesh hollow = together({cube(1), reversed(cube(0.5))}, "hollow cube");
    const Mesh mesh = with_turned(hollow, {0, 13, 14}, "hollow");
    const SignSurface surface = describe_mesh(mesh).surface;
    const Topology topology = describe_topology(mesh);
    BOOST_TEST(topology.reoriented_faces == 3U);
    BOOST_TEST(topology.inward_parts == 0U);
    BOOST_TEST(topology.nested_parts == 0U);
    for (std::size_t face = 0; face < 24; ++face)
        BOOST_TEST((surface.count(face) == -1) == (face == 0 || face == 13 || face == 14));
    // Half of the area: the lowest face decides.
    std::vector<std::size_t> half{0, 1, 2, 3, 4, 5};
    const SignSurface tie = describe_mesh(with_turned(cube(1), half, "cube")).surface;
    for (std::size_t face = 0; face < 12; ++face) BOOST_TEST(tie.count(face) == (face < 6 ? 1 : -1));
    BOOST_TEST(describe_topology(with_turned(cube(1), half, "cube")).inside_out);
}

BOOST_AUTO_TEST_CASE(what_has_one_side_keeps_its_rule) {
    const Topology moebius = describe_topology(moebius_strip(24));
    BOOST_TEST(!moebius.closed);
    BOOST_TEST(moebius.reoriented_faces == 0U);
    // A Klein bottle beside a sphere with a turned face: nothing is turned.
    const Mesh bottle = parametric(28, 20, 2 * std::numbers::pi, "Klein bottle", [](double u, double v) {
        const double c = std::cos(u / 2), s = std::sin(u / 2);
        const double radius = 2 + c * std::sin(v) - s * std::sin(2 * v);
        return Vec3{radius * std::cos(u), radius * std::sin(u), s * std::sin(v) + c * std::sin(2 * v)};
    });
    const Topology alone = describe_topology(bottle);
    BOOST_TEST(alone.closed);
    BOOST_TEST(!alone.balanced);
    BOOST_TEST(alone.joined_vertices > 0U);
    const Mesh both = together({bottle, with_turned(shifted(make_shape("sphere2"), {9, 0, 0}), {5}, "sphere")}, "both");
    const Topology topology = describe_topology(both);
    BOOST_TEST(topology.closed);
    BOOST_TEST(topology.reoriented_faces == 0U);
    BOOST_TEST(has(warning_of(both, SignRule::parity), "even number of shells are outside"));
}

BOOST_AUTO_TEST_CASE(parts_that_look_inwards_beside_others_are_named) {
    const Mesh overlapping = together({cube(1), reversed(shifted(cube(1), {1, 1, 1}))}, "overlapping");
    const Topology topology = describe_topology(overlapping);
    BOOST_TEST(topology.parts == 2U);
    BOOST_TEST(topology.inward_parts == 1U);
    BOOST_TEST(topology.first_inward_face == 12U);
    BOOST_TEST(has(warning_of(overlapping, SignRule::nonzero), "1 of 2 parts looks inwards"));
    BOOST_TEST(has(warning_of(overlapping, SignRule::nonzero), "triangle 12"));
    // Apart, too; not a cavity, nor a cavity with a core.
    BOOST_TEST(describe_topology(together({cube(1), reversed(shifted(cube(0.5), {9, 0, 0}))}, "")).inward_parts == 1U);
    const Mesh onion = together({cube(1), reversed(cube(0.6)), cube(0.3), reversed(cube(0.1))}, "onion");
    BOOST_TEST(warning_of(onion, SignRule::nonzero).empty());
    // A bar that joins two parts, all of whose vertices lie in them.
    const auto dumbbell = [](double end) {
        return together({cube(1), shifted(cube(1), {8, 0, 0}), reversed(box({end - 9, -0.1, -0.1}, {8.5, 0.1, 0.1}))},
                        "");
    };
    BOOST_TEST(describe_topology(dumbbell(8.5)).first_inward_face == 24U);
    BOOST_TEST(describe_topology(dumbbell(8.5)).inward_parts == 1U);
    BOOST_TEST(describe_topology(dumbbell(17)).inward_parts == 0U);  // a cavity of one of them
    // Of a mesh that is inside out as a whole.
    const Topology all = describe_topology(reversed(onion));
    BOOST_TEST(all.inside_out);
    BOOST_TEST(all.inward_parts == 0U);
    BOOST_TEST(all.nested_parts == 0U);
}

BOOST_AUTO_TEST_CASE(parts_that_overlap_are_named) {
    const Mesh overlapping = together({cube(1), tilted(shifted(cube(1), {0.5, 0.5, 0.5}))}, "overlapping");
    BOOST_TEST(describe_topology(overlapping).overlapping_parts == 2U);
    BOOST_TEST(describe_topology(overlapping).first_overlapping_face == 0U);
    BOOST_TEST(describe_topology(reversed(overlapping)).overlapping_parts == 2U);
    BOOST_TEST(has(warning_of(overlapping, SignRule::nonzero), "2 of 2 parts are partly within others"));
    // A bar that joins two parts.
    const Mesh dumbbell = together({cube(1), shifted(cube(1), {8, 0, 0}), box({0.5, -0.1, -0.1}, {7.5, 0.1, 0.1})}, "");
    BOOST_TEST(describe_topology(dumbbell).overlapping_parts == 3U);
    // Neither a shell within a shell, nor a cavity, nor parts that touch.
    for (const Mesh& mesh : {together({cube(1), tilted(cube(0.4))}, ""), together({cube(1), reversed(cube(0.4))}, ""),
                             together({cube(1), shifted(cube(0.5), {1.5, 0.2, 0.1})}, ""),
                             together({cube(1), shifted(cube(1), {2, 0, 0})}, "")})
        BOOST_TEST(describe_topology(mesh).overlapping_parts == 0U);
}

BOOST_AUTO_TEST_CASE(shells_within_shells_that_look_the_same_way_are_named) {
    const Mesh alike = together({cube(1), tilted(cube(0.4))}, "alike");
    BOOST_TEST(describe_topology(alike).nested_parts == 1U);
    BOOST_TEST(describe_topology(alike).first_nested_face == 12U);
    BOOST_TEST(has(warning_of(alike, SignRule::nonzero), "parity"));
    BOOST_TEST(warning_of(alike, SignRule::parity, SignRule::parity).empty());
    // Parts that overlap are no such shells, nor are parts that touch, nor is a bar between two parts.
    const Mesh dumbbell = together({cube(1), shifted(cube(1), {8, 0, 0}), box({0.5, -0.1, -0.1}, {7.5, 0.1, 0.1})}, "");
    BOOST_TEST(describe_topology(dumbbell).nested_parts == 0U);
    BOOST_TEST(describe_topology(together({cube(1), tilted(shifted(cube(1), {0.5, 0.5, 0.5}))}, "")).nested_parts ==
               0U);
    BOOST_TEST(warning_of(together({cube(1), shifted(cube(0.5), {1.5, 0.2, 0.1})}, ""), SignRule::nonzero).empty());
    BOOST_TEST(
        warning_of(together({make_shape("sphere3"), shifted(make_shape("sphere3"), {5, 0, 0})}, ""), SignRule::nonzero)
            .empty());
}

BOOST_AUTO_TEST_CASE(a_hole_elsewhere_does_not_keep_faces_from_being_turned) {
    const Mesh sphere = make_shape("sphere2");
    for (const bool is_one : {true, false}) {  // one face, or every second one
        std::vector<std::size_t> faces;
        for (std::size_t face = 3; face + 9 < sphere.triangles().size(); face += is_one ? 100000 : 3)
            faces.push_back(face);
        const Mesh holed = without_triangle(with_turned(sphere, faces, "sphere"), sphere.triangles().size() - 1);
        const Topology topology = describe_topology(holed);
        BOOST_TEST(topology.reoriented_faces == faces.size());
        BOOST_TEST(topology.unbalanced_edges == 3U);
        const SignSurface surface = describe_mesh(holed).surface;
        for (std::size_t face = 0; face < holed.triangles().size(); ++face)
            BOOST_TEST((surface.count(face) == -1) == std::ranges::binary_search(faces, face));
        BOOST_TEST(
            has(warning_of(holed, SignRule::solid_angle), is_one ? "1 face looks the wrong way" : "turned around"));
        BOOST_TEST(describe_mesh(holed, SignRule::solid_angle).topology.reoriented_faces == faces.size());
        BOOST_TEST(describe_mesh(holed, SignRule::none).surface.is_mesh());
    }
    // A small body far from the points that are tested, which are those of a hole and of a large body.
    const Mesh holed = with_chosen_faces(sphere, "ball", [&](std::size_t face) {
        return std::ranges::none_of(sphere.triangles()[face], [&](auto v) { return sphere.vertices()[v][0] == 1; });
    });
    for (std::size_t face = 0; face < 12; ++face) {
        const Mesh small = shifted(with_turned(cube(1), {face}, ""), {4, 0, 0});
        const Mesh three = together({holed, small, shifted(cube(40), {0, 0, 60})}, "three");
        BOOST_TEST(describe_topology(three).reoriented_faces == 1U);
        BOOST_TEST(has(warning_of(three, SignRule::solid_angle), "1 face looks the wrong way"));
    }
    // What has one side stays as given, and the rest is turned.
    const Mesh both = together({moebius_strip(24), shifted(with_turned(sphere, {5}, ""), {9, 0, 0})}, "both");
    BOOST_TEST(describe_topology(both).reoriented_faces == 1U);
    // A tie of areas: said in one breath.
    std::vector<std::size_t> half{0, 1, 2, 3, 4, 5};
    BOOST_TEST(has(warning_of(with_turned(cube(1), half, "cube"), SignRule::nonzero),
                   "turned to look alike, its faces look inwards"));
}

BOOST_AUTO_TEST_CASE(a_body_that_is_there_on_both_sides_counts_once) {
    const auto both_ways = [](const Mesh& mesh) {
        return together({mesh, reversed(mesh)}, mesh.name() + " both ways");
    };
    const Mesh solid = tilted(cube(1)), ball = shifted(make_shape("sphere2"), {5, 0, 0});
    for (const Mesh& mesh :
         {both_ways(solid), weld(both_ways(solid)), unwelded(both_ways(solid)), reversed(both_ways(solid)),
          together({both_ways(solid), ball}, "beside a ball"), together({ball, both_ways(solid)}, "after a ball"),
          together({without_triangle(ball, 7), both_ways(solid)}, "beside a ball with a hole")}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            const Topology topology = describe_topology(mesh);
            BOOST_TEST(topology.double_sided_faces == 12U);
            BOOST_TEST(topology.uncounted_faces == 12U);
            BOOST_TEST(!topology.inside_out);
            BOOST_TEST(topology.inward_parts == 0U);
            BOOST_TEST(has(warning_of(mesh, topology.balanced ? SignRule::nonzero : SignRule::solid_angle),
                           "there on both sides"));
        }
    }
    // The lowest faces look this way and that.
    const Mesh mixed = both_ways(with_turned(solid, {2, 3, 7, 11}, "mixed"));
    BOOST_TEST(describe_topology(mixed).balanced);
    BOOST_TEST(describe_topology(mixed).double_sided_faces == 12U);
    BOOST_TEST(!describe_topology(mixed).inside_out);
    // With a hole; only for the rules that take one.
    const Mesh holed = both_ways(without_triangle(make_shape("sphere2"), 40));
    BOOST_TEST(describe_topology(holed).double_sided_faces == holed.triangles().size() / 2);
    BOOST_TEST(has(warning_of(holed, SignRule::solid_angle), "there on both sides"));
    BOOST_TEST(describe_mesh(holed, SignRule::nonzero).surface.is_mesh());
    // A large hole: no sign, which is told.
    BOOST_TEST(has(warning_of(both_ways(without_triangle(cube(1), 5)), SignRule::none), "the mesh is not closed"));
    // A cavity stays one.
    const Mesh hollow = both_ways(together({cube(1), reversed(cube(0.5))}, "hollow"));
    for (const Mesh& mesh : {hollow, reversed(hollow)}) {
        const Topology topology = describe_topology(mesh);
        BOOST_TEST(topology.double_sided_faces == 24U);
        BOOST_TEST(topology.nested_parts + topology.inward_parts == 0U);
        BOOST_TEST(!topology.inside_out);
    }
    // A fin that is there on both sides, too, does not count.
    std::vector<Vec3> positions = solid.vertices();
    positions.push_back({4, 0, 0});
    std::vector<Triangle> faces = both_ways(solid).triangles();
    for (Triangle& face : faces)
        for (std::uint32_t& v : face) v %= 8;
    faces.insert(faces.end(), {{0, 1, 8}, {1, 0, 8}});
    const Topology finned = describe_topology(Mesh(positions, faces));
    BOOST_TEST(finned.balanced);
    BOOST_TEST(finned.double_sided_faces == 12U);
    BOOST_TEST(finned.uncounted_faces == 12U);
}

BOOST_AUTO_TEST_CASE(faces_that_cancel_each_other_and_bound_no_body_stay) {
    const Mesh sheet({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}, "sheet");
    const Mesh both = together({sheet, reversed(sheet)}, "sheet on both sides");
    const Mesh bowl =
        with_chosen_faces(make_shape("sphere2"), "bowl", [](std::size_t face) { return face % 128 < 60; });
    const Mesh solid = shifted(cube(3), {0.5, 0.5, 0.25});
    const Mesh touching = together({box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1})}, "touching");
    const Mesh buried = together({cube(3), tilted(cube(1)), reversed(tilted(cube(1)))}, "a core on both sides");
    for (const Mesh& mesh : {both, weld(both), together({both, solid}, "plate within a body"), touching, weld(touching),
                             together({bowl, reversed(bowl)}, "bowl on both sides"), buried}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            BOOST_TEST(describe_mesh(mesh).surface.is_mesh());
            BOOST_TEST(describe_topology(mesh).double_sided_faces == 0U);
            BOOST_TEST(describe_topology(mesh).balanced);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_cavity_that_is_there_twice_is_named) {
    const Mesh cavity = reversed(cube(0.5));
    const Mesh mesh = together({cube(1), cavity, cavity}, "hollow");
    const Topology topology = describe_topology(mesh);
    BOOST_TEST(topology.doubled_cavity_faces == 12U);
    BOOST_TEST(topology.first_doubled_cavity_face == 12U);
    BOOST_TEST(has(warning_of(mesh, SignRule::nonzero), "12 faces of cavities are there twice"));
    BOOST_TEST(describe_mesh(mesh).surface.is_mesh());
    BOOST_TEST(describe_topology(together({cube(1), cube(1)}, "")).doubled_cavity_faces == 0U);
}

BOOST_AUTO_TEST_CASE(sheets_never_have_an_inside) {
    const Mesh ball = make_shape("sphere3");
    const auto half_pipe = [](double radius, double arc) {  // along (1, 1, 1)
        std::vector<Vec3> vertices;
        std::vector<Triangle> triangles;
        const double s3 = 1 / std::sqrt(3.0), s2 = 1 / std::sqrt(2.0), s6 = s2 * s3;
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; j <= 12; ++j) {
                const double turn = arc * (j / 12.0 - 0.5), along = i / 40.0 * s3;
                const double u = radius * std::sin(turn) * s2, w = radius * std::cos(turn) * s6;
                vertices.push_back({along + u - w, along - u - w, along + 2 * w});
            }
        for (std::uint32_t i = 0; i < 40; ++i)
            for (std::uint32_t j = 0; j < 12; ++j) {
                const std::uint32_t a = 13 * i + j, b = a + 13;
                triangles.push_back({a, b, b + 1});
                triangles.push_back({a, b + 1, a + 1});
            }
        return Mesh(std::move(vertices), std::move(triangles), "half a pipe");
    };
    std::vector<Mesh> sheets{round_mesh(8, 1, {0, 0, 0}, true, "bowl")};
    for (const double radius : {0.01, 0.02, 0.03})
        for (const double arc : {0.8, 1.0, 1.2}) sheets.push_back(half_pipe(radius, arc * std::numbers::pi));
    for (const Mesh& sheet : sheets)
        for (const Mesh& mesh : {sheet, reversed(sheet)}) {
            BOOST_TEST(has(warning_of(mesh, SignRule::none), "by walls and a floor"));
            // Beside a body it has none, or is left out.
            const Mesh both = together({mesh, shifted(scaled(ball, 0.2), {4, 4, 4})}, "");
            const Topology topology = describe_topology(both);
            BOOST_TEST((topology.sheet_faces == mesh.triangles().size() || !topology.closed));
            BOOST_TEST(topology.unclear_parts == (topology.closed ? 0U : 1U));
        }
    BOOST_TEST(describe_topology(together({sheets[0], shifted(scaled(ball, 0.2), {4, 4, 4})}, "")).enclosing_faces ==
               sheets[0].triangles().size());
}

BOOST_AUTO_TEST_CASE(thin_and_scattered_bodies_with_a_hole_have_their_sign) {
    std::vector<Mesh> bars;
    for (const double y : {0.0, 1.0})
        for (const double z : {0.0, 1.0}) bars.push_back(box({0, y, z}, {1.02, y + 0.02, z + 0.02}));
    const std::vector<Mesh> balls{make_shape("sphere2"), shifted(make_shape("sphere2"), {75, 0, 0}),
                                  shifted(make_shape("sphere2"), {0, 75, 75})};
    for (const Mesh& mesh : {together(bars, "bars"), together(balls, "balls")})
        for (const std::size_t face : {std::size_t{8}, mesh.triangles().size() - 1}) {  // at the ends of bars
            const Mesh holed = without_triangle(mesh, face);
            BOOST_TEST(describe_topology(holed).inside_points > 50U);
            BOOST_TEST(!has(warning_of(holed, SignRule::solid_angle), "perhaps"));
        }
}

BOOST_AUTO_TEST_CASE(sheets_that_enclose_nothing_are_left_out_beside_bodies) {
    const auto wall = [](double x, double low, double high) {
        return Mesh({{x, low, low}, {x, high, low}, {x, high, high}, {x, low, high}}, {{0, 1, 2}, {0, 2, 3}}, "sheet");
    };
    const Mesh tank = box({0, 0, 0}, {4, 2, 2});
    const Mesh baffles = together({tank, wall(1, 0.2, 2.5), wall(2, 0.1, 1.5), wall(3, 0, 3)}, "tank with baffles");
    const Mesh ground({{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}}, {{0, 1, 2}, {0, 2, 3}}, "ground");
    const Mesh town =
        together({ground, box({0, 0, 0}, {1, 1, 3}), box({2, 0, 0}, {3, 1, 2}), box({0, 4, 0}, {1, 5, 2})}, "town");
    std::vector<Triangle> attached = tank.triangles();
    std::vector<Vec3> positions = tank.vertices();
    positions.push_back({2, 1, 5});
    attached.push_back({4, 5, 8});  // shares an edge with the tank
    for (const auto& [mesh, count] :
         {std::pair(baffles, 6U), {town, 2U}, {Mesh(positions, attached, "attached"), 1U}}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            const Topology topology = describe_topology(mesh);
            BOOST_TEST(topology.balanced);
            BOOST_TEST(topology.sheet_faces == count);
            BOOST_TEST(topology.uncounted_faces == 0U);
            BOOST_TEST(has(warning_of(mesh, SignRule::nonzero), "left out"));
            BOOST_TEST(describe_mesh(mesh, SignRule::solid_angle).surface.is_mesh());
        }
    }
    // With turned faces, and with a hole.
    BOOST_TEST(describe_topology(with_turned(baffles, {3, 8}, "")).reoriented_faces == 2U);
    const Mesh holed = without_triangle(together({make_shape("sphere3"), wall(0, -0.7, 0.7)}, ""), 9);
    BOOST_TEST(describe_topology(holed).sheet_faces == 2U);
    BOOST_TEST(describe_topology(holed).unclear_parts == 0U);
    BOOST_TEST(describe_topology(holed).boundary_edges == 3U);
    // Panels of a car body and its closed wheels; a tank without its lid and a bolt.
    std::vector<Mesh> panels;
    for (std::size_t side = 0; side < 5; ++side)
        panels.push_back(with_chosen_faces(tank, "panel", [&](std::size_t face) { return face / 2 == side; }));
    panels.push_back(shifted(cube(0.3), {1, 2.5, 0}));
    const Mesh open_tank = together({open_box({0, 0, 0}, {4, 2, 2}, 5), shifted(cube(0.3), {9, 9, 9})}, "");
    for (const Mesh& mesh : {together(panels, "panels"), open_tank}) {
        const Topology topology = describe_topology(mesh);
        BOOST_TEST(topology.sheet_faces == 0U);
        BOOST_TEST(topology.enclosing_faces == 10U);
        BOOST_TEST(has(warning_of(mesh, SignRule::none), "enclose something"));
    }
}

BOOST_AUTO_TEST_CASE(small_open_parts_at_a_body_are_details_of_it) {
    const Mesh body = box({0, 0, 0}, {8, 8, 4});
    const auto lamp = [](const Vec3& at, double width, double height, std::size_t open_side = 4) {
        return open_box(at, {at[0] + width, at[1] + width, at[2] + height}, open_side);
    };
    // Open towards the body, above a gap; a lamp on a lamp.
    const Mesh on_body = lamp({1, 1, 4.1}, 1, 2), on_lamp = lamp({1.25, 1.25, 6.1}, 0.5, 1);
    std::vector<Mesh> buttons{body};  // tiny ones, in doubt everywhere
    for (int i = 0; i < 6; ++i) buttons.push_back(lamp({i + 0.5, 1, 4.02}, 0.3, 0.06));
    for (const auto& [mesh, parts] : {std::pair(together({body, on_body}, "lamp"), 1U),
                                      {together({body, on_body, on_lamp}, "lamps"), 2U},
                                      {together({on_lamp, body, on_body}, "a lamp first"), 2U},
                                      {together(buttons, "buttons"), 6U}}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            const Topology topology = describe_topology(mesh);
            BOOST_TEST(topology.unclear_parts == 0U);
            BOOST_TEST(topology.sheet_faces == 0U);
            BOOST_TEST(topology.enclosing_faces == 0U);
            BOOST_TEST(topology.detail_parts == parts);
            BOOST_TEST(topology.detail_faces == 10 * parts);
            BOOST_TEST(topology.first_detail_face == (mesh.name() == "a lamp first" ? 0U : 12U));
            const std::string warning = warning_of(mesh, SignRule::solid_angle);
            BOOST_TEST(has(warning, "follows from the winding number"));
            BOOST_TEST(has(warning,
                           parts == 1 ? "1 small open part is a detail" : "small open parts are details of the body"));
            BOOST_TEST(describe_mesh(mesh).surface.vertices.empty());
            // The rule by name does not ask whether the mesh has a sign.
            const Topology by_name = describe_mesh(mesh, SignRule::solid_angle).topology;
            BOOST_TEST(by_name.detail_parts == 0U);
            BOOST_TEST(!has(resolve_sign_rule(SignRule::solid_angle, by_name).warning, "detail"));
        }
    }
    // Open to the other side, as a pot; far away; too large; a dome, in doubt everywhere; a bowl and a trough on a
    // floor.
    const Mesh dome = round_mesh(8, 1, {0, 0, 0}, true, "dome"), floor = box({-40, -40, 0}, {40, 40, 4});
    const auto trough = [&](double length) {
        std::vector<Vec3> vertices = dome.vertices();
        for (Vec3& vertex : vertices) vertex = {length * vertex[0], -vertex[1], 5 - vertex[2]};
        return Mesh(std::move(vertices), dome.triangles(), "trough");
    };
    for (const Mesh& mesh :
         {together({body, lamp({1, 1, 4.1}, 1, 2, 5)}, "pot"), together({body, lamp({1, 1, 6}, 1, 2)}, "lamp apart"),
          together({body, lamp({1, 1, 4.1}, 3, 6)}, "large lamp"), together({body, shifted(dome, {4, 4, 4})}, "dome"),
          together({floor, trough(1)}, "bowl"), together({floor, trough(4)}, "trough"),
          together({body, on_body, lamp({1, 1, -9}, 1, 2)}, "a lamp and a lamp apart")}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            BOOST_TEST(describe_topology(mesh).unclear_parts == 1U);
            BOOST_TEST(describe_topology(mesh).detail_parts == 0U);  // one part without a sign is enough
            BOOST_TEST(has(warning_of(mesh, SignRule::none), "enclose something"));
        }
    }
}

}  // namespace clsdf
