#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

using namespace clsdf;
using namespace clsdf::test;

namespace {

void check_at_some_widths(const Mesh& mesh, std::int64_t resolution) {
    for (const double share : {0.02, 0.1}) {
        const Band band = Band::symmetric(share * mesh.box().longest_side());
        check_exact(mesh, Grid::around(mesh, resolution, band), band);
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_shape_is_exact) {
    for (const char* name : {"sphere0", "sphere1", "sphere4", "torus", "knot", "seashell", "stairs", "plate", "needle",
                             "tetrahedron", "noisy", "nested"})
        check_at_some_widths(make_shape(name), 40);
}

BOOST_AUTO_TEST_CASE(some_shapes_are_exact_without_a_band) {
    for (const char* name : {"sphere2", "knot", "stairs", "needle", "nested"}) {
        const Mesh mesh = make_shape(name);
        check_exact(mesh, Grid::around(mesh, 32, Band::full()), Band::full());
    }
}

BOOST_AUTO_TEST_CASE(random_tetrahedra_are_exact) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = random_lattice_tetrahedron(random, 0.5);
            if (mesh.box().longest_side() > 0)
                check_exact(mesh, grid_around(mesh, 24, 4), Band::symmetric(1), nearly_aimed);
        }
}

BOOST_AUTO_TEST_CASE(random_flaps_are_exact) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh flap = random_flap(random);
            check_at_some_widths(seed % 2 == 0 ? tilted(flap, random.uniform(0, 3)) : flap, 32);
        }
}

BOOST_AUTO_TEST_CASE(random_stairs_are_exact) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh stairs = random_stairs(random, 4 + random.index(8));
            check_at_some_widths(seed % 2 == 0 ? tilted(stairs, random.uniform(0, 3)) : stairs, 32);
        }
}

BOOST_AUTO_TEST_CASE(random_spikes_are_exact) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            check_at_some_widths(random_sphere(random, "sphere2", 0.9), 32);
        }
}

BOOST_AUTO_TEST_CASE(noisy_scans_are_exact) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            check_at_some_widths(random_sphere(random, "sphere4", 0.05), 32);
        }
}

BOOST_AUTO_TEST_CASE(closed_meshes_that_intersect_themselves_are_exact) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            check_at_some_widths(random_closed(random, 6), 32);
        }
}

BOOST_AUTO_TEST_CASE(soups_are_exact) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            check_at_some_widths(random_soup(random, 12, 60), 32);
            check_at_some_widths(random_slivers(random, 60), 32);
        }
}

// Adjacency that is not seen may cost time, but no accuracy.
BOOST_AUTO_TEST_CASE(an_unwelded_mesh_is_exact) {
    check_at_some_widths(unwelded(make_shape("knot")), 32);
}
