#include "support/throws.hpp"

#include <clsdf/picture.hpp>

#include <boost/test/unit_test.hpp>

#include <functional>

using namespace clsdf;

BOOST_AUTO_TEST_CASE(pictures_that_are_not_built_are_refused_with_the_remedy) {
    const Field field;
    picture::View view;
    const std::function<void()> calls[] = {
        [] { picture::parse_axis("z"); },
        [&] { picture::set_direction(view, "front"); },
        [&] { picture::set_up(view, "z"); },
        [] { picture::SlicePictures::check_path("slice.png"); },
        [] { picture::SurfacePictures::check_path("surface.png"); },
        [&] { picture::SlicePictures pictures(field); },
        [&] { picture::SurfacePictures pictures(field, Device::automatic()); },
    };
    for (const std::function<void()>& call : calls)
        test::check_throws(ErrorCode::unsupported, {"no pictures", "-DCLSDF_BUILD_PICTURE=ON", "slice_picture"}, call);
}
