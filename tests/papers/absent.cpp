#include "support/throws.hpp"

#include <clsdf/mesh.hpp>
#include <clsdf/papers.hpp>

#include <boost/test/unit_test.hpp>

#include <array>

using namespace clsdf;

namespace {

void check_refused(const char* what, const std::function<void()>& action) {
    test::check_throws(ErrorCode::unsupported, {what, "-DCLSDF_BUILD_PAPERS=ON"}, action);
}

}  // namespace

BOOST_AUTO_TEST_CASE(leaned_polyhedra_by_bricks_need_no_published_method) {
    BOOST_CHECK(papers_method({}) == nullptr);
    BOOST_CHECK(papers_method({.scan = Scan::bricks}) == nullptr);
}

BOOST_AUTO_TEST_CASE(a_published_method_that_is_not_built_is_refused_with_its_name_and_the_remedy) {
    check_refused("mauch", [] { papers_method({.polyhedra = Polyhedra::mauch}); });
    check_refused("peikert-sigg", [] { papers_method({.polyhedra = Polyhedra::peikert_sigg}); });
    check_refused("leaned polyhedra scanned by slices", [] { papers_method({.scan = Scan::slices}); });
}

BOOST_AUTO_TEST_CASE(so_is_what_the_papers_ask_of_a_mesh) {
    const Mesh cube = make_shape("cube");
    constexpr std::array<std::uint32_t, 1> triangle{0};
    check_refused("classification", [&] { classify(cube); });
    check_refused("saddle", [&] { examine_saddles(cube); });
    check_refused("polyhedra", [&] { triangles_at(cube, 0); });
    check_refused("polyhedra", [&] { leaned_solids(cube, triangle, 0.1); });
    check_refused("polyhedra", [&] { peikert_sigg_solids(cube, triangle, 0.1); });
    check_refused("software", [&] { software_scan(cube, {}, 0.1, 1, {}); });
}
