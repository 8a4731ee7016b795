#include "frusta/frames.hpp"
#include "pointwise.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"
#include "topology/face_order.hpp"

#include <clsdf/mesh.hpp>

#include <tbb/global_control.h>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

namespace clsdf::test {
namespace {

using engine::LatticeView;
using engine::to_vector;
using engine::Vector;

constexpr double half_width = 8;
constexpr double slack = 2e-3;

bool same_bytes(const LeanedFrusta& a, const LeanedFrusta& b) {
    return a.polyhedra.size() == b.polyhedra.size() &&
           std::memcmp(a.polyhedra.data(), b.polyhedra.data(), a.polyhedra.size() * sizeof(Polyhedron)) == 0;
}

Mesh changed(const Mesh& mesh, const auto& change) {
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& vertex : vertices) change(vertex);
    return {std::move(vertices), mesh.triangles(), mesh.name()};
}

Mesh single_triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
    return {{a, b, c}, {{0, 1, 2}}, "triangle"};
}

double norm(const Vec3& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}
Vec3 minus(const Vec3& a, const Vec3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

BOOST_AUTO_TEST_SUITE(records)

BOOST_AUTO_TEST_CASE(the_sums_of_the_floats_are_the_frame) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            LatticeView lattice{random.point(-50, 50), 0.5, {1, 2, 4}};
            const std::array<Vec3, 3> corners{random.point(-20, 20), random.point(-20, 20), random.point(-20, 20)};
            const Mesh mesh = single_triangle(corners[0], corners[1], corners[2]);
            const Polyhedron record = leaned_frusta(mesh, lattice).polyhedra.front();
            const PointwisePolyhedron pointwise(record, half_width, slack);
            const engine::TriangleFrame frame = engine::triangle_frame(corners, lattice);
            for (int i = 0; i < 20; ++i) {
                const Vec3 point = random.point(-100, 100);
                const Vector metric(point[0], 2 * point[1], 4 * point[2]);
                const Vector from_foot = metric - to_vector(frame.face.foot);
                const Vec3 found = pointwise.frame(point);
                const double size = from_foot.norm();
                BOOST_TEST(std::abs(found[0] - from_foot.dot(to_vector(frame.face.along))) <= 1e-13 * size);
                BOOST_TEST(std::abs(found[1] - from_foot.dot(to_vector(frame.face.across))) <= 1e-13 * size);
                BOOST_TEST(std::abs(found[2] - from_foot.dot(frame.normal)) <= 1e-13 * size);
            }
            // The corners are those given, in the order of the base.
            const std::array<Vec3, 3> ends = pointwise.corners();
            const std::uint32_t base = frame.base_edge;
            const std::array<std::size_t, 3> order{(base + 1) % 3, base, (base + 2) % 3};
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3 given = corners[order[i]];
                const Vec3 metric{lattice.origin[0] + 0.5 * ends[i][0], lattice.origin[1] + ends[i][1],
                                  lattice.origin[2] + 2 * ends[i][2]};
                BOOST_TEST(norm(minus(metric, given)) < 1e-11);
            }
            BOOST_TEST(std::abs(pointwise.altitude() - frame.face.altitude) <= 1e-13 * frame.face.altitude);
        }
    }
}

void check_orthonormal(const engine::TriangleFrame& frame) {
    const Vector along = to_vector(frame.face.along), across = to_vector(frame.face.across);
    for (const Vector& axis : {along, across, frame.normal}) BOOST_TEST(std::abs(axis.norm() - 1) < 1e-12);
    BOOST_TEST(std::abs(along.dot(across)) < 1e-12);
    BOOST_TEST((along.cross(across) - frame.normal).norm() < 1e-12);
}

BOOST_AUTO_TEST_CASE(the_frames_of_all_triangles_are_orthonormal) {
    for (std::uint64_t seed = 1; seed <= 20000; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const double size = seed % 4 == 1 ? std::pow(10, random.uniform(-250, 0)) : 1;
            const double height = seed % 2 == 0 ? 0 : std::pow(10, random.uniform(-20, -5));
            const auto on_samples = [&] { return std::round(random.uniform(-9, 9)); };
            Vec3 edge = random.point(-20, 20);
            if (seed % 4 == 0) edge = {on_samples(), on_samples(), on_samples()};
            const Vec3 a{0, 0, 0};
            const Vec3 b = along(a, size, edge);
            const Vec3 c = along(along(a, size * random.uniform(-1, 2), edge), size * height, random.direction());
            const engine::TriangleFrame frame = engine::triangle_frame({a, b, c}, {});
            check_orthonormal(frame);
            if (height == 0) BOOST_TEST(frame.is_box);
        }
    }
}

BOOST_AUTO_TEST_CASE(the_origin_is_the_sample_next_to_the_foot) {
    const Mesh mesh = single_triangle({0.1, 0.2, 7.3}, {10.1, 0.2, 7.3}, {4.6, 3.2, 7.3});
    const LatticeView lattice{{0, 0, 0}, 1, {1, 1, 2}};
    const Polyhedron record = leaned_frusta(mesh, lattice).polyhedra.front();
    BOOST_TEST(record.origin_x == 5);
    BOOST_TEST(record.origin_y == 0);
    BOOST_TEST(record.origin_z == 4);
    BOOST_TEST(PointwisePolyhedron(record, half_width, slack).distance({5, 1, 4}) == 0.7,
               boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(a_mesh_beyond_all_integers_keeps_its_place) {
    const double far = 1e10;
    const Mesh mesh = single_triangle({far, 0, 0}, {far + 4, 0, 0}, {far, 3, 0});
    const Polyhedron record = leaned_frusta(mesh, {}).polyhedra.front();
    BOOST_TEST(record.origin_x == 1 << 30);
    BOOST_TEST(std::abs(PointwisePolyhedron(record, half_width, slack).distance({far, 0, 5}) - 5) < 1e-3);
}

BOOST_AUTO_TEST_CASE(the_same_bytes_on_any_number_of_threads) {
    Random random(7);
    for (const Mesh& mesh : {make_shape("knot"), make_shape("noisy"), random_soup(random, 3000, 9000)}) {
        const LatticeView lattice{mesh.box().lower, 0.01, {1, 1, 1}};
        const auto with_threads = [&](std::size_t threads) {
            const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
            return leaned_frusta(mesh, lattice);
        };
        const LeanedFrusta one = with_threads(1);
        BOOST_TEST(same_bytes(one, with_threads(2)), mesh.name());
        BOOST_TEST(same_bytes(one, with_threads(5)), mesh.name());
    }
}

BOOST_AUTO_TEST_CASE(the_scale_of_the_coordinates_does_not_matter) {
    const Mesh mesh = make_shape("knot");
    const LatticeView lattice{mesh.box().lower, 0.01, {1, 1, 1}};
    const LeanedFrusta expected = leaned_frusta(mesh, lattice);
    for (const int exponent : {-300, -66, 66, 300}) {
        const double scale = std::ldexp(1.0, exponent);
        const auto enlarge = [scale](Vec3& v) { v = {v[0] * scale, v[1] * scale, v[2] * scale}; };
        LatticeView enlarged = lattice;
        enlarge(enlarged.origin);
        enlarged.unit *= scale;
        BOOST_TEST_CONTEXT("scale 2^" << exponent)
        BOOST_TEST(same_bytes(leaned_frusta(changed(mesh, enlarge), enlarged), expected));
    }
}

BOOST_AUTO_TEST_CASE(triangles_come_octant_by_octant) {
    // One in each of 8 x 8 x 8 cells, in random order. In Morton order, the three bits of each level are one after the
    // other: the first 64 lie in the lowest octant, the first eight in its lowest octant, and x runs fastest.
    Random random(4);
    std::vector<Index3> cells;
    for (std::int64_t i = 0; i < 512; ++i) cells.push_back({i % 8, i / 8 % 8, i / 64});
    for (std::size_t i = 511; i > 0; --i) std::swap(cells[i], cells[random.index(i + 1)]);
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < 512; ++i) {
        const auto at = [&](std::size_t axis) { return static_cast<double>(cells[i][axis]); };
        for (const double d : {0.1, 0.5, 0.9}) vertices.push_back({at(0) + d, at(1) + d * d, at(2) + 0.5});
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    vertices.insert(vertices.end(), {{0, 0, 0}, {8, 8, 8}});
    triangles.push_back({1536, 1537, 1537});  // the box
    const Mesh mesh(vertices, triangles, "cells");
    const auto order = engine::morton_order(mesh);
    std::int64_t expected = 0;
    for (const std::uint32_t triangle : order) {
        if (triangle == 512) continue;
        std::int64_t code = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t bit = 0; bit < 3; ++bit) code |= (cells[triangle][axis] >> bit & 1) << (3 * bit + axis);
        BOOST_TEST(code == expected);
        ++expected;
    }
}

BOOST_AUTO_TEST_CASE(triangles_of_equal_place_come_in_the_callers_order_and_every_one_once) {
    Random random(3);
    const Mesh mesh = random_soup(random, 500, 5000);
    const LeanedFrusta frusta = leaned_frusta(mesh, {{-1, -1, -1}, 0.01, {1, 1, 1}});
    std::vector<int> seen(mesh.triangles().size());
    for (std::size_t i = 0; i < seen.size(); ++i) ++seen[frusta.polyhedra[i].triangle];
    BOOST_TEST(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
    BOOST_TEST(frusta.polyhedra.size() == seen.size() + frusta.point_sites);

    const Mesh stack({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Triangle>(100, {0, 1, 2}), "stack");
    const LeanedFrusta stacked = leaned_frusta(stack, {});
    for (std::uint32_t i = 0; i < 100; ++i) BOOST_TEST(stacked.polyhedra[i].triangle == i);
}

BOOST_AUTO_TEST_CASE(vertices_that_no_triangle_uses_are_not_looked_at) {
    const Mesh clean = b2().mesh;
    std::vector<Vec3> vertices = clean.vertices();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    vertices.push_back({nan, std::numeric_limits<double>::infinity(), 1e300});
    const Mesh mesh(vertices, clean.triangles(), "unused");
    BOOST_TEST(same_bytes(leaned_frusta(mesh, {}), leaned_frusta(clean, {})));
}

BOOST_AUTO_TEST_CASE(degenerate_triangles_are_boxes_around_segments_and_points) {
    const Mesh mesh({{0, 0, 0}, {9, 0, 0}, {3, 0, 0}, {30, 0, 0}}, {{0, 1, 2}, {0, 0, 1}, {3, 3, 3}}, "degenerate");
    const LeanedFrusta frusta = leaned_frusta(mesh, {});
    BOOST_TEST(frusta.boxes == 3U);
    BOOST_TEST(frusta.point_sites == 0U);
    for (const Polyhedron& record : frusta.polyhedra) {
        const PointwisePolyhedron polyhedron(record, half_width, slack);
        const bool is_point = record.triangle == 2;
        const Vec3 start{is_point ? 30.0 : 0.0, 0, 0};
        const Vec3 end{is_point ? 30.0 : 9.0, 0, 0};
        Random random(11);
        for (int i = 0; i < 200; ++i) {
            const double t = random.uniform(0, 1);
            const Vec3 from{start[0] + t * (end[0] - start[0]), 0, 0};
            const Vec3 point = along(from, random.uniform(0, half_width), random.direction());
            const double x = std::clamp(point[0], start[0], end[0]);
            const double distance = norm(minus(point, {x, 0, 0}));
            BOOST_TEST(polyhedron.contains(point));
            BOOST_TEST(std::abs(polyhedron.distance(point) - distance) < 1e-12);
        }
        BOOST_TEST(static_cast<double>(record.slope_above[0]) * slack >= half_width);
    }
}

BOOST_AUTO_TEST_CASE(a_point_site_is_an_equilateral_triangle_shrunk_to_its_vertex) {
    const Counterexample example = h1();
    const LeanedFrusta frusta = leaned_frusta(example.mesh, {});
    BOOST_REQUIRE(frusta.point_sites == 1U);
    const Polyhedron& site = frusta.polyhedra.back();
    for (std::size_t half = 0; half < 2; ++half) {
        BOOST_TEST(site.base[half] == 0);
        BOOST_TEST(site.normal_along[half] == 0.8660254F);
        BOOST_TEST(site.normal_across[half] == 0.5F);
    }
    BOOST_TEST(site.exact_altitude == 0);
    BOOST_TEST(site.triangle == 0U);  // vertex 0's lowest
    // Bounded by the extreme rays of the normal cone, which has all of (1, 1, 1) / sqrt(3) around it.
    const PointwisePolyhedron polyhedron(site, half_width, slack);
    BOOST_TEST(polyhedron.contains({1, 1, 1}));
    BOOST_TEST(!polyhedron.contains({-1, -1, -2}));
    BOOST_TEST(polyhedron.distance({1, 2, 2}) == 3, boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(slopes_of_a_roof_are_those_of_its_bisector) {
    // Two faces that meet at a right angle, the edge up.
    const Mesh mesh({{0, 0, 0}, {0, 10, 0}, {6, 5, -6}, {-6, 5, -6}}, {{0, 2, 1}, {0, 1, 3}}, "roof");
    const LeanedFrusta frusta = leaned_frusta(mesh, {});
    for (const Polyhedron& record : frusta.polyhedra) {
        // The base is the edge they share; tan of half of 90 degrees.
        BOOST_TEST(record.base[0] == 5);
        BOOST_TEST(record.slope_above[CLSDF_EDGE_BASE] == 1, boost::test_tools::tolerance(2e-6F));
        BOOST_TEST(record.slope_above[CLSDF_EDGE_BASE] > 1);
        BOOST_TEST(record.slope_below[CLSDF_EDGE_BASE] == 0);
        BOOST_TEST(record.slope_above[CLSDF_EDGE_LEFT] == CLSDF_OPEN_SLOPE);
        BOOST_TEST(record.slope_below[CLSDF_EDGE_RIGHT] == CLSDF_OPEN_SLOPE);
    }
}

BOOST_AUTO_TEST_CASE(compact_polyhedra_are_bounded_by_their_lateral_planes_alone) {
    const Mesh mesh = make_shape("noisy");
    const LeanedFrusta frusta = leaned_frusta(mesh, {mesh.box().lower, 0.01, {1, 1, 1}});
    std::size_t compact = 0;
    for (const Polyhedron& record : frusta.polyhedra) {
        if (!(record.flags & CLSDF_POLYHEDRON_COMPACT)) continue;
        ++compact;
        for (std::size_t edge = 0; edge < 3; ++edge) {
            BOOST_TEST(record.slope_above[edge] <= 1);
            BOOST_TEST(record.slope_below[edge] <= 1);
        }
        BOOST_TEST(record.normal_along[0] > 0.15F);
        BOOST_TEST(record.normal_along[1] > 0.15F);
    }
    BOOST_TEST(compact > frusta.polyhedra.size() / 2);
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
