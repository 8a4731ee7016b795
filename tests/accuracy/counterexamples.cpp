#include "support/exact_field.hpp"
#include "support/test_meshes.hpp"

using namespace clsdf;
using namespace clsdf::test;

// Bands of 8 to 20 voxels: a distance that long is rounded more than twice, by up to 3e-6 voxel in all.

// Samples that are known to be wrong with the polyhedra of the literature, each with a neighbourhood.
BOOST_AUTO_TEST_CASE(every_known_sample_has_its_distance) {
    for (const Counterexample& example : all_counterexamples())
        for (const KnownSample& known : example.samples)
            BOOST_TEST_CONTEXT(example.name() << " at (" << known.position[0] << ", " << known.position[1] << ", "
                                              << known.position[2] << ")") {
                constexpr std::int64_t reach = 9;
                const Grid grid = grid_at(known.position, example.half_width / 8, reach);
                const Band band = Band::symmetric(example.half_width);
                const Field field = compute(example.mesh, grid, band);
                const double found = std::abs(static_cast<double>(field.distance()[grid.offset(reach, reach, reach)]));
                BOOST_TEST(std::abs(found - known.distance) <= known.tolerance + 2e-7 * known.distance);
                BOOST_TEST(check_exact(example.mesh, field, guaranteed).band_samples > 0U);
            }
}

BOOST_AUTO_TEST_CASE(every_counterexample_is_exact_in_its_band) {
    for (const Counterexample& example : all_counterexamples()) {
        const Band band = Band::symmetric(example.half_width);
        check_exact(example.mesh, Grid::around(example.mesh, 44, band), band, guaranteed);
    }
}

BOOST_AUTO_TEST_CASE(every_counterexample_is_exact_without_a_band) {
    for (const Counterexample& example : all_counterexamples())
        check_exact(example.mesh, Grid::around(example.mesh, 30, Band::full()), Band::full(), guaranteed);
}

// Vertices that need a point site: the lattice around the vertex on which the gaps were found.
BOOST_AUTO_TEST_CASE(gaps_at_a_vertex_are_closed) {
    for (const Counterexample& example : {h1(), h2(), h3(), h4(), h5()})
        check_exact(example.mesh, grid_at({0, 0, 0}, 0.125, 14), Band::symmetric(1), guaranteed);
    check_exact(h6().mesh, grid_at({0, 0, 0}, 1, 24), Band::symmetric(20), guaranteed);
}
