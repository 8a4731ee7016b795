#include "coverage.hpp"
#include "stress_points.hpp"
#include "support/test_meshes.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>

/// docs/method.md, 'Counterexamples'.
namespace clsdf::test {
namespace {

/// The lattice of step 1/8 on [-12, 12]^3.
constexpr double step = 0.125;
constexpr std::int64_t limit = 96;

/// h6 is the one in voxels.
bool in_eighths(const Counterexample& example) {
    return example.name() != "h6";
}

double voxel_of(const Counterexample& example) {
    return in_eighths(example) ? step : 1;
}

CoverageTest coverage_test(const Counterexample& example, double slack, const engine::FrustaOptions& options = {}) {
    engine::LatticeView lattice;
    lattice.unit = voxel_of(example);
    return {example.mesh, lattice, example.half_width / lattice.unit, slack, options};
}

CoverageTest coverage_test(const Counterexample& example, const engine::FrustaOptions& options = {}) {
    return coverage_test(example, least_slack(example.half_width / voxel_of(example)), options);
}

constexpr engine::FrustaOptions without_lean{false, true};
constexpr engine::FrustaOptions without_point_sites{true, false};

BOOST_AUTO_TEST_SUITE(counterexamples)

BOOST_AUTO_TEST_CASE(every_sample_of_the_band_lies_in_the_polyhedron_of_a_nearest_triangle) {
    for (const Counterexample& example : all_counterexamples()) {
        if (!in_eighths(example)) continue;
        BOOST_TEST_CONTEXT(example.name()) {
            const CoverageTest test = coverage_test(example);
            const Coverage in_double = test.look_at_lattice(-limit, limit, false);
            const Coverage in_float = test.look_at_lattice(-limit, limit, true);
            BOOST_CHECK_MESSAGE(in_double.failures() == 0, in_double.text());
            BOOST_CHECK_MESSAGE(in_float.failures() == 0, "in float: " << in_float.text());
            BOOST_TEST(in_double.points > 10000U);
        }
    }
}

BOOST_AUTO_TEST_CASE(the_samples_that_other_polyhedra_miss_have_their_true_distance) {
    for (const Counterexample& example : all_counterexamples()) {
        const CoverageTest test = coverage_test(example);
        const double voxel = voxel_of(example);
        for (const KnownSample& sample : example.samples) {
            const auto& [x, y, z] = sample.position;
            BOOST_TEST_CONTEXT(example.name() << " at (" << x << ", " << y << ", " << z << ")") {
                const Vec3 point{x / voxel, y / voxel, z / voxel};
                BOOST_TEST(std::abs(test.found(point) * voxel - sample.distance) <= sample.tolerance);
                BOOST_TEST(std::abs(test.found(point) - test.distance(point)) <= 1e-9);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(without_point_sites_gaps_leave_the_stated_number_of_samples_uncovered) {
    struct Stated {
        Counterexample example;
        std::size_t point_sites = 0;
        std::size_t uncovered = 0;
        std::size_t band_samples = 0;
    };
    for (const Stated& stated : {Stated{h1(), 1, 154, 48058}, Stated{h2(), 1, 199, 347338}, Stated{h3(), 2, 64, 64535},
                                 Stated{h4(), 1, 30, 73879}, Stated{h5(), 2, 48, 58528}}) {
        BOOST_TEST_CONTEXT(stated.example.name()) {
            Counterexample example = stated.example;
            example.half_width += 1e-9;  // many samples lie at the band's limit
            const double slack = 1e-6;   // no more than that covers samples in the gaps
            const Coverage without =
                coverage_test(example, slack, without_point_sites).look_at_lattice(-limit, limit, false);
            BOOST_TEST(without.points == stated.band_samples);
            BOOST_TEST(without.uncovered == stated.uncovered);
            BOOST_TEST(without.wrong == 0U);

            const CoverageTest test = coverage_test(example, slack);
            BOOST_TEST(test.frusta().point_sites == stated.point_sites);
            const Coverage with = test.look_at_lattice(-limit, limit, false);
            BOOST_CHECK_MESSAGE(with.failures() == 0, with.text());
        }
    }
}

BOOST_AUTO_TEST_CASE(without_the_lean_obtuse_corners_lose_samples) {
    BOOST_TEST(coverage_test(b1(), without_lean).look_at_lattice(-limit, limit, false).failures() > 100U);
    BOOST_TEST(coverage_test(b2(), without_lean).look_at_lattice(-limit, limit, false).failures() > 100U);
}

BOOST_AUTO_TEST_CASE(thin_folded_sheets_have_their_gaps_found) {
    const Counterexample example = h6();
    const auto& [x, y, z] = example.samples.front().position;
    BOOST_TEST(std::isinf(coverage_test(example, without_point_sites).found({x, y, z})));
    const CoverageTest test = coverage_test(example);
    const auto at_origin = [](const Polyhedron& record) {
        return record.origin_x == 0 && record.origin_y == 0 && record.origin_z == 0 && record.exact_altitude == 0;
    };
    BOOST_TEST(std::any_of(test.frusta().polyhedra.begin(), test.frusta().polyhedra.end(), at_origin));
    Random random(1);
    StressPoints points(example.mesh, test, example.half_width, random);
    Coverage coverage;
    for (int i = 0; i < 50000; ++i) test.look(points.next(), coverage);
    BOOST_CHECK_MESSAGE(coverage.failures() == 0, coverage.text());
}

BOOST_AUTO_TEST_CASE(saddles_are_counted_and_only_saddles_have_gaps) {
    BOOST_TEST(coverage_test(a1_step()).frusta().saddle_vertices == 2U);
    BOOST_TEST(coverage_test(a3_flap()).frusta().saddle_vertices == 4U);
    for (const Counterexample& convex : {b1(), b2()}) BOOST_TEST(coverage_test(convex).frusta().saddle_vertices == 0U);
    for (const Counterexample& example : {a1_step(), a3_flap(), b1(), b2()})
        BOOST_TEST(coverage_test(example).frusta().point_sites == 0U);
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
