#include <clsdf/picture.hpp>

#include "picture/example.hpp"
#include "picture/rasters.hpp"
#include "support/source_file.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <stop_token>
#include <thread>

using clsdf::Device;
using clsdf::ErrorCode;
using clsdf::Field;
using clsdf::picture::Axis;
using clsdf::picture::Raster;
using clsdf::picture::SurfaceOptions;
using clsdf::picture::SurfacePictures;
using clsdf::test::check_throws;
using clsdf::test::content_of;
using clsdf::test::mean_difference;
using clsdf::test::part;
using clsdf::test::read_png;
using clsdf::test::TemporaryFolder;
using clsdf::test::two_balls;

namespace {

SurfaceOptions small(int width = 160) {
    SurfaceOptions options;
    options.width = width;
    return options;
}

Raster written(const Field& field, const SurfaceOptions& options) {
    const TemporaryFolder folder;
    SurfacePictures(field, Device::strongest()).write(options, folder.file("surface.png"));
    return read_png(folder.file("surface.png"));
}

}  // namespace

BOOST_AUTO_TEST_SUITE(surface_pictures)

// If the picture is meant to change: CLSDF_NEW_GOLDEN_SURFACE=FILE makes this test write the picture to FILE. Look at
// it, then let it take the place of golden_surface.png.
BOOST_AUTO_TEST_CASE(look_as_they_did) {
    const TemporaryFolder folder;
    const std::string path = folder.file("surface.png");
    const Field field = two_balls();
    SurfaceOptions options = small(280);
    options.view.up = Axis::z;
    options.cuts = {{Axis::x, 0.1}, {Axis::y, {}}};
    SurfacePictures(field, Device::strongest()).write(options, path);
    if (const char* target = std::getenv("CLSDF_NEW_GOLDEN_SURFACE"))
        std::filesystem::copy_file(path, target, std::filesystem::copy_options::overwrite_existing);
    const Raster golden = read_png(clsdf::test::source_file("tests/picture/golden_surface.png"));
    const Raster now = read_png(path);
    BOOST_REQUIRE(now.width == golden.width);
    BOOST_REQUIRE(now.height == golden.height);
    // Another device rounds differently, another version of the font has other letters.
    BOOST_TEST(mean_difference(now, golden) < 1.0);
}

BOOST_AUTO_TEST_CASE(are_the_same_bytes_on_every_run) {
    const TemporaryFolder folder;
    const Field field = two_balls();
    SurfaceOptions options = small();
    options.cuts = {{Axis::z, {}}};
    for (const char* name : {"one.png", "other.png"})
        SurfacePictures(field, Device::strongest()).write(options, folder.file(name));
    BOOST_TEST((content_of(folder.file("one.png")) == content_of(folder.file("other.png"))));
}

BOOST_AUTO_TEST_CASE(have_the_size_asked_for) {
    SurfaceOptions options = small();
    options.height = 70;
    const Raster both = written(two_balls(), options);
    BOOST_TEST(both.width == 160);
    BOOST_TEST(both.height == 70);
    // The two balls are wider than high, from the front.
    options = small();
    options.view.azimuth = options.view.elevation = 0;
    const Raster wide = written(two_balls(), options);
    BOOST_TEST(wide.width == 160);
    BOOST_TEST(wide.height > 80);
    BOOST_TEST(wide.height < 110);
}

BOOST_AUTO_TEST_CASE(have_a_white_background_or_none) {
    SurfaceOptions options = small();
    const auto alpha = [](std::uint32_t pixel) { return part(pixel, 24); };
    const Raster opaque = written(two_balls(), options);
    BOOST_TEST((opaque.pixels.front() & 0xFFFFFFU) == 0xFFFFFFU);
    options.transparent = true;
    const Raster clear = written(two_balls(), options);
    BOOST_TEST(alpha(clear.pixels.front()) == 0);
    const std::size_t middle = static_cast<std::size_t>(clear.height / 2 * clear.width + clear.width / 2);
    BOOST_TEST(alpha(clear.pixels[middle]) == 255);
    BOOST_TEST((clear.pixels[middle] & 0xFFFFFFU) == (opaque.pixels[middle] & 0xFFFFFFU));
}

BOOST_AUTO_TEST_CASE(have_the_colour_asked_for_and_smooth_edges) {
    SurfaceOptions options = small();
    options.colour = {0.2, 0.4, 0.8};
    options.transparent = true;
    const Raster raster = written(two_balls(), options);
    std::size_t blue = 0;
    std::size_t covered = 0;
    std::size_t partly = 0;
    for (const std::uint32_t pixel : raster.pixels) {
        const int alpha = part(pixel, 24);
        covered += alpha == 255;
        partly += alpha > 0 && alpha < 255;
        blue += alpha == 255 && part(pixel, 0) > part(pixel, 8) && part(pixel, 8) > part(pixel, 16);
    }
    BOOST_TEST(covered > 5000U);
    BOOST_TEST(blue == covered);
    BOOST_TEST(partly > 200U);
}

BOOST_AUTO_TEST_CASE(have_a_title_and_a_colour_bar_beside_a_cut_unless_they_are_to_be_bare) {
    SurfaceOptions options = small();
    const Raster whole = written(two_balls(), options);
    options.cuts = {{Axis::z, {}}};
    const Raster cut = written(two_balls(), options);
    options.bare = true;
    const Raster bare = written(two_balls(), options);
    BOOST_TEST(bare.width == whole.width);
    BOOST_TEST(bare.height == whole.height);
    BOOST_TEST(mean_difference(bare, whole) > 3);
    BOOST_TEST(cut.width > bare.width + 15);
    BOOST_TEST(cut.height > bare.height + 8);
}

BOOST_AUTO_TEST_CASE(can_be_cancelled_and_then_leave_nothing) {
    const TemporaryFolder folder;
    std::stop_source source;
    SurfaceOptions options = small(400);
    const std::thread::id caller = std::this_thread::get_id();
    options.should_stop = [&] {
        BOOST_TEST((std::this_thread::get_id() == caller));
        return source.stop_requested();
    };
    double last = 0;
    options.progress = [&](double fraction) {
        BOOST_TEST((std::this_thread::get_id() == caller));
        BOOST_TEST(fraction > last);
        last = fraction;
        source.request_stop();
    };
    const Field field = two_balls();
    const SurfacePictures pictures(field, Device::strongest());
    check_throws(ErrorCode::cancelled, {"cancelled"}, [&] { pictures.write(options, folder.file("surface.png")); });
    BOOST_TEST(last < 1);
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(are_refused_where_an_option_makes_no_sense) {
    const TemporaryFolder folder;
    const Field field = two_balls();
    const SurfacePictures pictures(field, Device::strongest());
    const auto refused = [&](const std::vector<std::string>& fragments, const auto& change) {
        SurfaceOptions options = small();
        change(options);
        check_throws(ErrorCode::invalid_argument, fragments,
                     [&] { pictures.write(options, folder.file("surface.png")); });
    };
    refused({"width of 7", "16 to 10000"}, [](auto& options) { options.width = 7; });
    refused({"height of 10001"}, [](auto& options) { options.height = 10001; });
    refused({"rays of 9", "1 to 8"}, [](auto& options) { options.rays = 9; });
    refused({"colour", "1.5"}, [](auto& options) { options.colour[1] = 1.5; });
    refused({"elevation 91"}, [](auto& options) { options.view.elevation = 91; });
    refused({"perspective of 120"}, [](auto& options) { options.view.perspective = 120; });
    refused({"cut at x = 7", "from -1.2 to 1.3"}, [](auto& options) { options.cuts = {{Axis::x, 7}}; });
    refused({"two cuts across y"}, [](auto& options) { options.cuts = {{Axis::y, {}}, {Axis::y, 0.1}}; });
    check_throws(ErrorCode::unsupported, {".pdf", "choose .png"},
                 [&] { pictures.write(small(), folder.file("surface.pdf")); });
    check_throws(ErrorCode::output_failure, {"no folder"},
                 [&] { pictures.write(small(), folder.file("none/surface.png")); });
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(need_a_grid_whose_spacing_is_a_float_and_whose_samples_differ) {
    for (const double spacing : {1e300, 1e-310}) {
        Field strange = two_balls();
        strange.grid.spacing.fill(spacing);
        check_throws(ErrorCode::invalid_argument, {"spacing", "beyond the floats"},
                     [&] { SurfacePictures(strange, Device::strongest()); });
    }
    Field endless = two_balls();
    std::ranges::fill(endless.distance(), std::numeric_limits<float>::infinity());
    check_throws(ErrorCode::invalid_argument, {"none of its distances is finite"},
                 [&] { SurfacePictures(endless, Device::strongest()); });
    Field strange = two_balls();
    strange.grid.origin[1] = 1e20;
    check_throws(ErrorCode::invalid_argument, {"y = 1e+20", "same position"},
                 [&] { SurfacePictures(strange, Device::strongest()); });
}

BOOST_AUTO_TEST_SUITE_END()
