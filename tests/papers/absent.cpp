#include "support/throws.hpp"

#include <clsdf/distance_transform.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/papers.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <functional>

using namespace clsdf;

namespace {

void check_refused(const char* what, const std::function<void()>& action) {
    test::check_throws(ErrorCode::unsupported, {what, "-DCLSDF_BUILD_PAPERS=ON"}, action);
}

}  // namespace

BOOST_AUTO_TEST_CASE(leaned_polyhedra_by_bricks_need_no_published_method) {
    const Device device = Device::automatic();
    const Mesh cube = make_shape("cube");
    const Band band = Band::symmetric(0.2);
    const Grid grid = Grid::around(cube, 16, band);
    const Field expected = DistanceTransform(device, cube).compute(grid, band);
    for (const Scan scan : {Scan::automatic, Scan::bricks}) {
        const Field field = make_transform(device, cube, {.scan = scan}).compute(grid, band);
        BOOST_CHECK(std::ranges::equal(field.bytes(Output::distance), expected.bytes(Output::distance)));
    }
}

BOOST_AUTO_TEST_CASE(a_published_method_that_is_not_built_is_refused_with_its_name_and_the_remedy) {
    const Device device = Device::automatic();
    const Mesh cube = make_shape("cube");
    const auto make = [&](const PapersOptions& method) { make_transform(device, cube, method); };
    check_refused("mauch", [&] { make({.polyhedra = Polyhedra::mauch}); });
    check_refused("peikert-sigg", [&] { make({.polyhedra = Polyhedra::peikert_sigg}); });
    check_refused("leaned polyhedra scanned by slices", [&] { make({.scan = Scan::slices}); });
}

BOOST_AUTO_TEST_CASE(so_is_what_the_papers_ask_of_a_mesh) {
    const Mesh cube = make_shape("cube");
    constexpr std::array<std::uint32_t, 1> triangle{0};
    check_refused("classification", [&] { classify_convexity(cube); });
    check_refused("saddle", [&] { examine_saddles(cube); });
    check_refused("polyhedra", [&] { triangles_at(cube, 0); });
    check_refused("polyhedra", [&] { leaned_solids(cube, triangle, 0.1); });
    check_refused("polyhedra", [&] { peikert_sigg_solids(cube, triangle, 0.1); });
    check_refused("software", [&] { software_scan(cube, {}, 0.1, 1, {}); });
}
