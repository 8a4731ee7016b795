#include "support/throws.hpp"

#include <clsdf/mesh.hpp>
#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include <array>
#include <functional>

using namespace clsdf;

BOOST_AUTO_TEST_CASE(a_reference_that_is_not_built_is_refused_with_the_remedy) {
    const Mesh cube = make_shape("cube");
    const Field field;
    const std::array<Field, 1> fields{};
    const std::function<void()> calls[] = {
        [&] { reference::check(cube, field); },
        [&] { reference::check(cube, fields); },
        [&] { reference::check_points(cube, {}, {}); },
        [&] { reference::find_self_intersections(cube); },
        [&] { reference::Oracle oracle(cube); },
        [&] { reference::nearest_by_brute_force(cube, {}); },
        [&] { reference::nearest_on_triangle({}, {}, {}, {}); },
        [&] { reference::reference_field(cube, {}, Band::full()); },
    };
    for (const std::function<void()>& call : calls)
        test::check_throws(ErrorCode::unsupported, {"no reference", "GPL", "-DCLSDF_BUILD_REFERENCE=ON"}, call);
}
