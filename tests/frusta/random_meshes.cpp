#include "awkward_meshes.hpp"
#include "coverage.hpp"
#include "stress_points.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <boost/test/unit_test.hpp>

#include <cfenv>
#include <cstdlib>

/// Environment: CLSDF_COVERAGE_MESHES, the number of random meshes (2000 unless set); CLSDF_COVERAGE_SEED, the first
/// seed (1). A mesh depends on its own seed alone, which is printed if a point is missed.
namespace clsdf::test {
namespace {

std::uint64_t environment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

struct Finding {
    std::string mesh;
    Coverage coverage;
    Coverage in_float;
};

/// Whether a sample lies in the polyhedron of a nearest triangle as a device decides it.
void look_in_float(const CoverageTest& test, const Vec3& sample, double half_width, double slack, Coverage& coverage) {
    const double distance = test.distance(sample);
    if (distance > half_width) return;
    double found = std::numeric_limits<double>::infinity();
    for (const Polyhedron& record : test.frusta().polyhedra)
        if (contains_in_float(record, sample, static_cast<float>(half_width), static_cast<float>(slack)))
            found = std::min(found, PointwisePolyhedron(record, half_width, slack).distance(sample));
    coverage.add(sample, distance, found);
}

Finding look_at_mesh(std::uint64_t seed) {
    Random random(seed);
    const Mesh mesh = awkward_mesh(random);
    const double half_width = random.index(2) == 0 ? random.uniform(0.1, 3) : random.uniform(3, 25);
    engine::LatticeView lattice;
    lattice.origin = random.point(-100, 100);
    if (random.index(4) == 0) lattice.spacing_in_units = {1, random.uniform(1, 3), 100};
    const double slack = least_slack(half_width);

    const CoverageTest test(mesh, lattice, half_width, slack);
    StressPoints points(mesh, test, half_width, random);
    Finding finding{mesh.name(), {}, {}};
    for (int i = 0; i < 200; ++i) {
        Vec3 point = points.next();
        test.look(point, finding.coverage);
        for (double& coordinate : point) coordinate = std::round(coordinate);
        look_in_float(test, point, half_width, slack, finding.in_float);
    }
    return finding;
}

BOOST_AUTO_TEST_SUITE(random_meshes)

BOOST_AUTO_TEST_CASE(every_point_of_the_band_lies_in_the_polyhedron_of_a_nearest_triangle) {
    const std::uint64_t meshes = environment("CLSDF_COVERAGE_MESHES", 2000);
    const std::uint64_t first = environment("CLSDF_COVERAGE_SEED", 1);
    std::vector<Finding> findings(meshes);
    tbb::parallel_for(std::uint64_t{0}, meshes, [&](std::uint64_t i) { findings[i] = look_at_mesh(first + i); });
    std::size_t points = 0;
    for (std::uint64_t i = 0; i < meshes; ++i) {
        BOOST_TEST_CONTEXT("seed " << first + i << ": " << findings[i].mesh) {
            BOOST_CHECK_MESSAGE(findings[i].coverage.failures() == 0, findings[i].coverage.text());
            BOOST_CHECK_MESSAGE(findings[i].in_float.failures() == 0, "in float: " << findings[i].in_float.text());
        }
        points += findings[i].coverage.points + findings[i].in_float.points;
    }
    BOOST_TEST_MESSAGE(points << " points");
    BOOST_TEST(points > 50 * meshes);
}

BOOST_AUTO_TEST_CASE(nothing_is_divided_by_zero_nor_invalid) {
    // Programs may trap such operations. The flags are those of a thread.
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
        Random random(seed);
        const Mesh mesh = awkward_mesh(random);
        std::feclearexcept(FE_ALL_EXCEPT);
        leaned_frusta(mesh, {});
        const int raised = std::fetestexcept(FE_INVALID | FE_DIVBYZERO);
        BOOST_TEST(raised == 0, "seed " << seed << ": " << mesh.name());
    }
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
