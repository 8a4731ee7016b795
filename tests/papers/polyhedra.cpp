#include "papers/pieces.hpp"

#include "papers/random_fans.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>

using namespace clsdf;
using namespace clsdf::test;
using clsdf::engine::to_vector;
using clsdf::engine::Vector;
using papers::BisectorPolyhedra;
using papers::BisectorPolyhedron;
using papers::GapClosing;
using papers::peikert_sigg_polyhedra;

namespace {

/// The least distance to a triangle whose polyhedron holds the point.
double distance(const Mesh& mesh, const BisectorPolyhedra& polyhedra, const Vec3& point) {
    double least = uncovered;
    for (const BisectorPolyhedron& polyhedron : polyhedra.polyhedra) {
        if (!polyhedron.contains(to_vector(point))) continue;
        const auto& [a, b, c] = mesh.triangles()[polyhedron.triangle];
        const reference::Nearest nearest =
            reference::nearest_on_triangle(point, mesh.vertices()[a], mesh.vertices()[b], mesh.vertices()[c]);
        least = std::min(least, nearest.distance);
    }
    return least;
}

/// How far `point` lies beyond the planes of `polyhedron` at the vertex; <= 0 within them.
double beyond_planes_at(const Mesh& mesh, const BisectorPolyhedron& polyhedron, std::uint32_t vertex,
                        const Vector& point) {
    const Triangle& triangle = mesh.triangles()[polyhedron.triangle];
    double beyond = -uncovered;
    for (std::size_t k = 0; k < 3; ++k)
        if (triangle[k] == vertex || triangle[(k + 1) % 3] == vertex)
            beyond = std::max(beyond, polyhedron.bisector[k].dot(point - polyhedron.corners[k]) - polyhedron.shift[k]);
    return beyond;
}

bool has_vertex(const Mesh& mesh, const BisectorPolyhedron& polyhedron, std::uint32_t vertex) {
    const Triangle& triangle = mesh.triangles()[polyhedron.triangle];
    return std::find(triangle.begin(), triangle.end(), vertex) != triangle.end();
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_papers_polyhedra_give_the_known_wrong_values) {
    std::size_t known_values = 0;
    for (const Counterexample& example : all_counterexamples())
        for (const KnownSample& known : example.samples) {
            if (!known.paper) continue;
            ++known_values;
            const BisectorPolyhedra polyhedra = peikert_sigg_polyhedra(example.mesh, example.half_width, known.closed);
            const double found = distance(example.mesh, polyhedra, known.position);
            BOOST_TEST_CONTEXT(example.name() << " at (" << known.position[0] << ", " << known.position[1] << ", "
                                              << known.position[2] << "): " << found << ", known " << *known.paper) {
                // Six digits, or what the position's own six leave of them.
                const double tolerance = std::max(5e-7 * *known.paper, known.tolerance);
                BOOST_TEST((found == *known.paper || std::abs(found - *known.paper) <= tolerance));
                BOOST_TEST(*known.paper > known.distance * 1.01);
            }
        }
    BOOST_TEST(known_values == 13U);
}

BOOST_AUTO_TEST_CASE(gaps_that_successive_planes_do_not_find_are_not_closed) {
    for (const Counterexample& example : {g1(), g2()}) {
        for (const GapClosing& closing : peikert_sigg_polyhedra(example.mesh, example.half_width).closings)
            BOOST_TEST(closing.vertex != 0U);
    }
}

BOOST_AUTO_TEST_CASE(over_the_middle_of_a_face_its_own_polyhedron_counts) {
    const Mesh mesh = b1().mesh;
    const BisectorPolyhedra polyhedra = peikert_sigg_polyhedra(mesh, 0.25);
    for (const BisectorPolyhedron& polyhedron : polyhedra.polyhedra) {
        const Vector middle = (polyhedron.corners[0] + polyhedron.corners[1] + polyhedron.corners[2]) / 3;
        BOOST_TEST(polyhedron.contains(middle + 0.2499 * polyhedron.normal));
        BOOST_TEST(polyhedron.contains(middle));
        BOOST_TEST(!polyhedron.contains(middle + 0.2501 * polyhedron.normal));
        BOOST_TEST(!polyhedron.contains(middle - 0.2501 * polyhedron.normal));
    }
}

// Proved in the paper's appendix. Near the vertex only the planes there matter.
BOOST_AUTO_TEST_CASE(as_many_polyhedra_hold_a_point_near_a_vertex_as_hold_its_antipode) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        Random random(seed);
        const Mesh mesh = random_saddle_fan(random);
        const BisectorPolyhedra polyhedra = peikert_sigg_polyhedra(mesh, 1, false);
        const auto multiplicity = [&](const Vector& point) {
            return std::count_if(polyhedra.polyhedra.begin(), polyhedra.polyhedra.end(),
                                 [&](const BisectorPolyhedron& polyhedron) { return polyhedron.contains(point); });
        };
        for (int i = 0; i < 50; ++i) {
            const Vector u = 1e-3 * to_vector(random.direction());
            BOOST_TEST_CONTEXT("seed " << seed << ", u = " << u.transpose())
            BOOST_TEST(multiplicity(u) == multiplicity(-u));
        }
    }
}

BOOST_AUTO_TEST_CASE(closing_a_gap_moves_the_planes_there_just_far_enough) {
    std::size_t closings = 0;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        Random random(seed);
        const Mesh mesh = random_saddle_fan(random);
        const BisectorPolyhedra closed = peikert_sigg_polyhedra(mesh, 1);
        const std::vector<std::uint32_t> gaps = examine_saddles(mesh).adjacent_gaps;
        BOOST_TEST_CONTEXT("seed " << seed) {
            BOOST_REQUIRE(closed.closings.size() == gaps.size());
            double least_slack = 0;
            for (std::size_t i = 0; i < gaps.size(); ++i) {
                const GapClosing& closing = closed.closings[i];
                BOOST_TEST(closing.vertex == gaps[i]);
                const Vector vertex = to_vector(mesh.vertices()[closing.vertex]);
                double tightest = -uncovered;
                for (const BisectorPolyhedron& polyhedron : closed.polyhedra) {
                    if (!has_vertex(mesh, polyhedron, closing.vertex)) continue;
                    for (const double side : {1.0, -1.0}) {
                        const double beyond =
                            beyond_planes_at(mesh, polyhedron, closing.vertex, vertex + side * closing.point);
                        BOOST_TEST(beyond <= 1e-12);
                        tightest = std::max(tightest, beyond);
                    }
                }
                least_slack = std::max(least_slack, -tightest);
            }
            if (gaps.size() == 1) BOOST_TEST(least_slack <= 1e-12);
            closings += gaps.size();
        }
    }
    BOOST_TEST(closings > 10U);
}

BOOST_AUTO_TEST_CASE(only_planes_at_gaps_move) {
    const Mesh mesh = w1().mesh;
    const BisectorPolyhedra closed = peikert_sigg_polyhedra(mesh, 0.3);
    const BisectorPolyhedra open = peikert_sigg_polyhedra(mesh, 0.3, false);
    std::vector<bool> is_closed(mesh.vertices().size(), false);
    for (const GapClosing& closing : closed.closings) is_closed[closing.vertex] = true;
    BOOST_TEST(is_closed[0]);
    for (std::size_t i = 0; i < closed.polyhedra.size(); ++i) {
        const Triangle& triangle = mesh.triangles()[i];
        for (std::size_t k = 0; k < 3; ++k) {
            const bool at_gap = is_closed[triangle[k]] || is_closed[triangle[(k + 1) % 3]];
            BOOST_TEST((closed.polyhedra[i].shift[k] > 0) == at_gap);
            BOOST_TEST(open.polyhedra[i].shift[k] == 0);
        }
    }
}
