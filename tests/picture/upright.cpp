#include "picture/balls_and_boxes.hpp"

#include <clsdf/picture.hpp>

#include <boost/test/unit_test.hpp>

using clsdf::Band;
using clsdf::Device;
using clsdf::Field;
using clsdf::Vec3;
using clsdf::picture::Axis;
using clsdf::picture::Hits;
using clsdf::picture::SurfaceOptions;
using clsdf::picture::SurfacePictures;
using clsdf::test::distance_to_box;
using clsdf::test::field_of;
using clsdf::test::norm;

namespace {

using Distance = std::function<double(const Vec3&)>;

/// A solid that is described with z upwards, in a field that has another axis there.
Field field_with_up(Axis up, const Distance& distance) {
    const clsdf::Grid grid{{-1.6, -1.6, -1.6}, {0.08, 0.08, 0.08}, {41, 41, 41}, {}};
    return field_of(grid, Band::symmetric(0.3), [&](const Vec3& point) {
        return distance(up == Axis::y ? Vec3{point[0], -point[2], point[1]} : point);
    });
}

Axis upright(const Field& field) {
    return SurfacePictures(field, Device::strongest()).upright();
}

double distance_to_ball(const Vec3& point, const Vec3& centre, double radius) {
    return norm({point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]}) - radius;
}

/// A foot, and a body above it that would not lie on its side without rolling.
double statue(const Vec3& point) {
    return std::min(
        distance_to_box({point[0], point[1], point[2] + 1.1}, {0.6, 0.5, 0.2}),
        std::min(distance_to_ball(point, {0, 0.1, -0.3}, 0.7), distance_to_ball(point, {0, 0.5, 0.7}, 0.5)));
}

}  // namespace

BOOST_AUTO_TEST_SUITE(the_axis_that_is_up)

BOOST_AUTO_TEST_CASE(is_the_one_along_which_the_solid_stands) {
    for (const Axis up : {Axis::y, Axis::z}) BOOST_CHECK(upright(field_with_up(up, statue)) == up);
}

BOOST_AUTO_TEST_CASE(is_z_where_the_solid_stands_as_firmly_on_both) {
    BOOST_CHECK(upright(field_with_up(Axis::z, [](const Vec3& point) { return norm(point) - 1; })) == Axis::z);
    const auto cube = [](const Vec3& point) { return distance_to_box(point, {1, 1, 1}); };
    BOOST_CHECK(upright(field_with_up(Axis::z, cube)) == Axis::z);
}

BOOST_AUTO_TEST_CASE(is_y_where_the_solid_stands_on_neither) {
    const auto balls = [](const Vec3& point) {
        return std::min(distance_to_ball(point, {-0.7, 0.5, 0.5}, 0.3),
                        distance_to_ball(point, {0.7, -0.7, -0.7}, 0.3));
    };
    BOOST_CHECK(upright(field_with_up(Axis::z, balls)) == Axis::y);
}

BOOST_AUTO_TEST_CASE(is_that_of_a_view_that_names_none) {
    const Field field = field_with_up(Axis::y, statue);
    const SurfacePictures pictures(field, Device::strongest());
    SurfaceOptions options;
    options.width = 60;
    const Hits guessed = pictures.hits(options);
    const auto differences = [&](Axis up) {
        options.view.up = up;
        const Hits stated = pictures.hits(options);
        if (stated.width != guessed.width || stated.height != guessed.height) return std::size_t{1000};
        std::size_t count = 0;
        for (std::size_t i = 0; i < stated.pixels.size(); ++i)
            if (stated.pixels[i].position != guessed.pixels[i].position) ++count;
        return count;
    };
    BOOST_TEST(differences(Axis::y) == 0U);
    BOOST_TEST(differences(Axis::z) > 100U);
}

BOOST_AUTO_TEST_SUITE_END()
