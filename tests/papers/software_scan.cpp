#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/test_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/papers.hpp>

#include <algorithm>
#include <limits>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// For the rounding of floats of some tens of voxels, and for polygons that are larger by their slack.
constexpr double tolerance_voxels = 3e-4;

struct Scanned {
    Field field;
    SoftwareScanCounts counts;
};

Scanned scan(const Mesh& mesh, const Grid& grid, double half_width, std::size_t threads = 0) {
    Scanned result{Field({grid, Band::symmetric(half_width), SignRule::nonzero, {}}), {}};
    result.counts = software_scan(mesh, grid, half_width, threads, result.field.distance());
    return result;
}

void check_right(const Mesh& mesh, const Grid& grid, double half_width) {
    reference::CheckOptions options;
    options.samples = 0;
    options.tolerance_voxels = tolerance_voxels;
    const reference::CheckReport report = reference::check(mesh, scan(mesh, grid, half_width).field, options);
    BOOST_TEST_CONTEXT("mesh " << mesh.name() << ", half width of " << half_width / grid.voxel() << " voxels") {
        BOOST_TEST(report.band_samples > 100U);
        BOOST_TEST(report.wrong_values == 0U);
        BOOST_TEST(report.wrong_signs == 0U);
        BOOST_TEST(report.missed == 0U);
        BOOST_TEST(report.leaked == 0U);
        for (const reference::CheckReport::Finding& finding : report.findings)
            BOOST_TEST_MESSAGE("  at (" << finding.sample[0] << ", " << finding.sample[1] << ", " << finding.sample[2]
                                        << "): " << finding.found << " instead of " << finding.expected << ": "
                                        << finding.what);
    }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(software)

BOOST_AUTO_TEST_CASE(closed_manifolds_have_their_distances_and_signs) {
    for (const char* name :
         {"sphere0", "sphere1", "sphere4", "torus", "knot", "seashell", "stairs", "plate", "tetrahedron", "noisy"}) {
        const Mesh mesh = tilted(make_shape(name));
        for (const double share : {0.04, 0.1}) {
            const double half_width = share * mesh.box().longest_side();
            check_right(mesh, Grid::around(mesh, 60, Band::symmetric(half_width)), half_width);
        }
    }
}

BOOST_AUTO_TEST_CASE(nothing_is_lost_at_concave_edges_obtuse_corners_and_saddle_vertices) {
    for (const Counterexample& example : all_counterexamples()) {
        if (example.name() == "h6") continue;  // it cuts itself
        // Signs pass from sample to sample if the band is wider than a voxel or two.
        const Grid grid = grid_around(example.mesh, 40, 8);
        check_right(example.mesh, grid,
                    std::clamp(example.half_width, 2 * grid.voxel(), 0.2 * example.mesh.box().longest_side()));
    }
}

BOOST_AUTO_TEST_CASE(a_part_of_a_grid_has_its_own_place) {
    const Mesh mesh = make_shape("sphere3");
    const double half_width = 0.1 * mesh.box().longest_side();
    const Grid whole = Grid::around(mesh, 50, Band::symmetric(half_width));
    check_right(mesh, whole.part({3, 5, 11}, {40, 30, 21}), half_width);
}

BOOST_AUTO_TEST_CASE(any_number_of_threads_gives_the_same_bytes) {
    const Mesh mesh = make_shape("knot");
    const double half_width = 0.1 * mesh.box().longest_side();
    const Grid grid = Grid::around(mesh, 60, Band::symmetric(half_width));
    BOOST_TEST((bits_of(scan(mesh, grid, half_width, 1).field.distance()) ==
                bits_of(scan(mesh, grid, half_width, 0).field.distance())));
}

// On a convex surface every face, edge and vertex has a polyhedron; most samples lie in only one.
BOOST_AUTO_TEST_CASE(every_site_of_a_sphere_is_scanned) {
    const Mesh mesh = make_shape("sphere4");
    const double half_width = 0.1 * mesh.box().longest_side();
    const Grid grid = Grid::around(mesh, 60, Band::symmetric(half_width));
    const Scanned scanned = scan(mesh, grid, half_width);
    BOOST_TEST(scanned.counts.polyhedra == 2048U + 3072U + 1026U);
    std::size_t band = 0;
    for (const float value : scanned.field.distance())
        band += std::abs(static_cast<double>(value)) < half_width * (1 - 1e-6) ? 1U : 0U;
    BOOST_TEST(scanned.counts.distances >= band);
    BOOST_TEST(static_cast<double>(scanned.counts.distances) < 1.15 * static_cast<double>(band));
}

BOOST_AUTO_TEST_CASE(a_mesh_that_is_not_closed_or_not_of_one_orientation_is_refused) {
    const Grid grid = grid_at({0, 0, 0}, 0.1, 4);
    std::vector<float> distance(grid.sample_count());
    const Mesh sphere = make_shape("sphere1");
    std::vector<Triangle> open(sphere.triangles().begin() + 1, sphere.triangles().end());
    std::vector<Triangle> turned = sphere.triangles(), twice = sphere.triangles();
    std::swap(turned[0][0], turned[0][1]);
    twice.push_back(twice.front());
    for (const std::vector<Triangle>& triangles : {open, turned, twice})
        check_throws(ErrorCode::invalid_mesh, {"closed manifold mesh", "ball"}, [&] {
            software_scan({sphere.vertices(), triangles, "ball"}, grid, 0.3, 1, distance);
        });
}

BOOST_AUTO_TEST_CASE(arguments_out_of_range_are_refused) {
    const Grid grid = grid_at({0, 0, 0}, 0.1, 4);
    std::vector<float> distance(grid.sample_count());
    const Mesh sphere = make_shape("sphere1");
    for (const double half_width : {0.0, -1.0, std::numeric_limits<double>::infinity()})
        check_throws(ErrorCode::invalid_argument, {"half width"},
                     [&] { software_scan(sphere, grid, half_width, 1, distance); });
    distance.pop_back();
    check_throws(ErrorCode::invalid_argument, {"728", "729"}, [&] { software_scan(sphere, grid, 0.3, 1, distance); });
}

BOOST_AUTO_TEST_CASE(unequal_spacing_is_refused) {
    Grid grid = grid_at({0, 0, 0}, 0.1, 4);
    grid.spacing[1] = 0.2;
    std::vector<float> distance(grid.sample_count());
    check_throws(ErrorCode::unsupported, {"equal spacing"},
                 [&] { software_scan(make_shape("sphere1"), grid, 0.3, 1, distance); });
}

BOOST_AUTO_TEST_SUITE_END()
