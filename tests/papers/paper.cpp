#include "papers/pieces.hpp"
#include "papers/scanned.hpp"
#include "support/hostile_meshes.hpp"
#include "support/test_meshes.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <cmath>

using namespace clsdf;
using namespace clsdf::test;
using clsdf::engine::to_vector;
using clsdf::engine::Vector;
using papers::BisectorPolyhedra;
using papers::BisectorPolyhedron;
using papers::peikert_sigg_polyhedra;

namespace {

Scanned scan_paper(const Mesh& mesh, const Grid& grid, const Band& band, PapersOptions options = {},
                   KernelBody body = KernelBody::automatic) {
    options.polyhedra = Polyhedra::peikert_sigg;
    return scan_slices(mesh, grid, band, options, body);
}

/// Whether the polyhedron holds the point with its planes moved outward by `by`.
bool holds(const BisectorPolyhedron& polyhedron, const Vector& point, double by) {
    BisectorPolyhedron moved = polyhedron;
    moved.half_width += by;
    for (double& shift : moved.shift) shift += by;
    return moved.contains(point);
}

/// The field is what the paper's polyhedra say: at every sample the least distance to a triangle whose polyhedron holds
/// it, by host and in double, if that does not hang on a plane within 3e-6 voxel of the sample.
void check_meaning(const Mesh& mesh, const Grid& grid, double half_width, const PapersOptions& options = {},
                   KernelBody body = KernelBody::automatic) {
    const Band band = Band::symmetric(half_width);
    const Scanned scanned = scan_paper(mesh, grid, band, options, body);
    check_intersections(scanned.statistics, options.slice_minimum == SliceMinimum::two_passes ? 2 : 1);
    const BisectorPolyhedra paper = peikert_sigg_polyhedra(mesh, half_width);
    const double hair = 3e-6 * grid.voxel();
    std::size_t decided = 0, held = 0;
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                const Vec3 position = grid.position(i, j, k);
                double least_narrow = uncovered, least_wide = uncovered;
                for (const BisectorPolyhedron& polyhedron : paper.polyhedra) {
                    if (!holds(polyhedron, to_vector(position), hair)) continue;
                    const auto& [a, b, c] = mesh.triangles()[polyhedron.triangle];
                    const double distance = reference::nearest_on_triangle(position, mesh.vertices()[a],
                                                                           mesh.vertices()[b], mesh.vertices()[c])
                                                .distance;
                    least_wide = std::min(least_wide, distance);
                    if (holds(polyhedron, to_vector(position), -hair)) least_narrow = std::min(least_narrow, distance);
                }
                const bool is_decided = least_narrow == least_wide || least_wide > half_width + hair;
                if (!is_decided || std::abs(least_wide - half_width) < hair) continue;
                ++decided;
                const std::size_t at = grid.offset(i, j, k);
                const double found = std::abs(static_cast<double>(scanned.field.distance()[at]));
                if (least_wide > half_width) {
                    BOOST_REQUIRE(found == static_cast<double>(static_cast<float>(half_width)));
                    BOOST_REQUIRE(scanned.field.triangle()[at] == no_triangle);
                    continue;
                }
                ++held;
                BOOST_TEST_CONTEXT(mesh.name() << " at sample " << i << ", " << j << ", " << k)
                BOOST_REQUIRE(std::abs(found - least_wide) <=
                              std::max(guaranteed.voxels * grid.voxel(), guaranteed.ulp * least_wide * 0x1p-23));
            }
    BOOST_TEST(held > 100U);
    BOOST_TEST(decided > grid.sample_count() - grid.sample_count() / 20);
}

}  // namespace

// To six digits, or what the position's own six leave of them. Beyond the band a field has the half width.
BOOST_AUTO_TEST_CASE(the_known_wrong_values_are_given) {
    std::size_t wrong_values = 0, without_value = 0;
    for (const Counterexample& example : all_counterexamples())
        for (const KnownSample& known : example.samples) {
            if (!known.paper) continue;
            constexpr std::int64_t reach = 3;
            const Grid grid = grid_at(known.position, example.half_width / 16, reach);
            for (const KernelBody body : both_bodies) {
                const Field field = scan_paper(example.mesh, grid, Band::symmetric(example.half_width),
                                               {.close_gaps = known.closed}, body)
                                        .field;
                const std::size_t at = grid.offset(reach, reach, reach);
                const double found = std::abs(static_cast<double>(field.distance()[at]));
                BOOST_TEST_CONTEXT(example.name()
                                   << " at (" << known.position[0] << ", " << known.position[1] << ", "
                                   << known.position[2] << "): " << found << ", known " << *known.paper) {
                    BOOST_TEST(known.distance < 0.999 * example.half_width);
                    if (*known.paper > example.half_width) {
                        BOOST_TEST(found == static_cast<double>(static_cast<float>(example.half_width)));
                        BOOST_TEST(field.triangle()[at] == no_triangle);
                        ++without_value;
                    } else {
                        BOOST_TEST(std::abs(found - *known.paper) <= std::max(5e-7 * *known.paper, known.tolerance));
                        BOOST_TEST(found > known.distance * 1.01);
                        ++wrong_values;
                    }
                }
            }
        }
    BOOST_TEST(wrong_values + without_value == 2 * 13U);
    BOOST_TEST(wrong_values >= 8U);
    BOOST_TEST(without_value >= 12U);
}

BOOST_AUTO_TEST_CASE(every_sample_has_the_least_distance_of_the_polyhedra_that_hold_it) {
    for (const Counterexample& example : {a1_step(), b1(), b2(), w1(), w2()})
        check_meaning(example.mesh, grid_around(example.mesh, 24, 2), example.half_width);
    for (std::uint64_t seed = 1; seed <= 4; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh sphere = random_sphere(random, "sphere1", 0.5);
            const Grid grid = grid_around(sphere, 22, 3);
            check_meaning(sphere, grid, 0.13 * sphere.box().longest_side());
            const Mesh closed = random_closed(random, 2);
            check_meaning(closed, grid_around(closed, 20, 3), 0.1 * closed.box().longest_side(),
                          {.slice_minimum = SliceMinimum::two_passes}, KernelBody::by_group);
        }
}

BOOST_AUTO_TEST_CASE(unequal_spacing_changes_nothing_of_that) {
    Random random(9);
    const Mesh mesh = random_sphere(random, "sphere1", 0.5);
    Grid grid = grid_around(mesh, 40, 3);
    grid.spacing[1] *= 2.5;
    grid.spacing[2] *= 4;
    grid.size = {grid.size[0], grid.size[1] * 2 / 5, grid.size[2] / 4};
    check_meaning(mesh, grid, 0.1 * mesh.box().longest_side());
}

BOOST_AUTO_TEST_CASE(a_convex_solid_of_smooth_shape_is_all_but_exact) {
    const Mesh mesh = make_shape("sphere4");
    const Grid grid = grid_around(mesh, 40, 4);
    const Scanned scanned = scan_paper(mesh, grid, Band::symmetric(3 * grid.voxel()));
    reference::CheckOptions options;
    options.samples = 0;
    const reference::CheckReport report = reference::check(mesh, scanned.field, options);
    BOOST_TEST(report.wrong_values + report.missed == 0U);
    BOOST_TEST(report.wrong_signs == 0U);
    BOOST_TEST(report.band_samples > 1000U);
}

BOOST_AUTO_TEST_CASE(the_sign_is_exact_where_the_distance_is_not) {
    const Mesh mesh = make_shape("stairs");
    const Grid grid = grid_around(mesh, 48, 4);
    reference::CheckOptions options;
    options.samples = 0;
    const reference::CheckReport report =
        reference::check(mesh, scan_paper(mesh, grid, Band::symmetric(0.1 * mesh.box().longest_side())).field, options);
    BOOST_TEST(report.wrong_values > 0U);
    BOOST_TEST(report.wrong_signs == 0U);
    BOOST_TEST(report.leaked == 0U);
}

// Shares of the band, in percent, that have a wrong distance or none; what prototypes in double precision found for
// shapes of the same kind (docs/papers.md, 'What they miss'): 2.2 and 2.8 of the stairs at 3 and 10%, 0.1 of the
// seashell at 10%.
BOOST_AUTO_TEST_CASE(the_share_of_wrong_samples_is_that_of_the_paper) {
    const auto wrong_share = [](const char* name, double share) {
        const Mesh mesh = tilted(make_shape(name));
        const double extent = mesh.box().longest_side();
        const Band band = Band::symmetric(share * extent);
        const Grid grid = Grid::around(mesh, 80, band);
        const Field field = scan_paper(mesh, grid, band).field;
        const Field exact = compute(mesh, grid, band);
        std::size_t in_band = 0, wrong = 0;
        for (std::size_t at = 0; at < exact.distance().size(); ++at) {
            if (exact.triangle()[at] == no_triangle) continue;
            ++in_band;
            wrong += field.triangle()[at] == no_triangle ||
                     std::abs(static_cast<double>(field.distance()[at]) - static_cast<double>(exact.distance()[at])) >
                         1e-6 * extent;
        }
        return 100 * static_cast<double>(wrong) / static_cast<double>(in_band);
    };
    const double stairs_3 = wrong_share("stairs", 0.03), stairs_10 = wrong_share("stairs", 0.1);
    const double seashell_10 = wrong_share("seashell", 0.1), sphere_10 = wrong_share("sphere4", 0.1);
    BOOST_TEST_MESSAGE("stairs " << stairs_3 << " and " << stairs_10 << ", seashell " << seashell_10 << ", sphere "
                                 << sphere_10);
    BOOST_TEST((1.7 < stairs_3 && stairs_3 < 2.7));
    BOOST_TEST((2.4 < stairs_10 && stairs_10 < 3.4));
    BOOST_TEST((0.02 < seashell_10 && seashell_10 < 0.15));
    BOOST_TEST(sphere_10 == 0);
}
