#include <clsdf/picture.hpp>

#include "picture/canvas.hpp"
#include "picture/example.hpp"
#include "picture/rasters.hpp"
#include "picture/text.hpp"
#include "support/source_file.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cstdlib>
#include <limits>

using clsdf::Band;
using clsdf::ErrorCode;
using clsdf::Field;
using clsdf::Output;
using clsdf::picture::Axis;
using clsdf::picture::Colour;
using clsdf::picture::Colours;
using clsdf::picture::printable;
using clsdf::picture::Raster;
using clsdf::picture::SlicePictures;
using clsdf::test::check_throws;
using clsdf::test::content_of;
using clsdf::test::mean_difference;
using clsdf::test::part;
using clsdf::test::read_png;
using clsdf::test::source_file;
using clsdf::test::TemporaryFolder;
using clsdf::test::two_balls;

namespace {

// Pixels of a hue: more blue than red by so much, or the other way round.
std::size_t count_bluish(const Raster& raster, int by) {
    return static_cast<std::size_t>(std::count_if(raster.pixels.begin(), raster.pixels.end(), [&](std::uint32_t pixel) {
        return by > 0 ? part(pixel, 0) - part(pixel, 16) > by : part(pixel, 0) - part(pixel, 16) < by;
    }));
}

}  // namespace

BOOST_AUTO_TEST_SUITE(colours_of_distances)

BOOST_AUTO_TEST_CASE(tell_inside_from_outside) {
    const Colours colours(-1, 2, Band::symmetric(2.5), true);
    for (const double distance : {1e-6, 0.1, 0.5, 1.0}) {
        const Colour inside = colours(-distance);
        const Colour outside = colours(distance);
        BOOST_TEST(inside[2] > inside[0] + 0.05);
        BOOST_TEST(outside[0] > outside[2] + 0.05);
    }
}

BOOST_AUTO_TEST_CASE(grow_darker_away_from_the_surface) {
    for (const bool has_sign : {true, false}) {
        const Colours colours(has_sign ? -1 : 0, 1, Band::full(), has_sign);
        for (int step = 1; step <= 20; ++step)
            for (const double sign : {-1, 1}) {
                if (sign < 0 && !has_sign) continue;
                const double distance = 0.05 * step;
                const Colour near = colours(sign * (distance - 0.05));
                const Colour far = colours(sign * distance);
                BOOST_TEST(near[0] + near[1] + near[2] > far[0] + far[1] + far[2]);
            }
    }
}

BOOST_AUTO_TEST_CASE(are_flat_beyond_the_band) {
    const Colours colours(-1, 1, Band::symmetric(1), true);
    BOOST_TEST((colours(1) == colours(1.5)));
    BOOST_TEST((colours(-1) == colours(-1.5)));
    BOOST_TEST((colours(1) != colours(-1)));
    BOOST_TEST((colours(1) != colours(0.999)));
    BOOST_TEST((colours(std::numeric_limits<double>::infinity()) == colours(1)));
    BOOST_TEST((colours(std::nan("")) != colours(1)));
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(slice_pictures)

// If the picture is meant to change: CLSDF_NEW_GOLDEN=FILE makes this test write the picture to FILE. Look at it, then
// let it take the place of golden.png.
BOOST_AUTO_TEST_CASE(look_as_they_did) {
    const TemporaryFolder folder;
    const std::string path = folder.file("mosaic.png");
    const Field field = two_balls();
    SlicePictures(field, {240}).write_mosaic({16, 15, 9}, path);
    if (const char* target = std::getenv("CLSDF_NEW_GOLDEN"))
        std::filesystem::copy_file(path, target, std::filesystem::copy_options::overwrite_existing);
    const Raster golden = read_png(source_file("tests/picture/golden.png"));
    const Raster now = read_png(path);
    BOOST_REQUIRE(now.width == golden.width);
    BOOST_REQUIRE(now.height == golden.height);
    // Another version of cairo or of the font may draw slightly different positions.
    BOOST_TEST(mean_difference(now, golden) < 1.5);
}

BOOST_AUTO_TEST_CASE(have_both_hues_with_a_sign_and_no_orange_without) {
    const TemporaryFolder folder;
    const Field with_sign = two_balls();
    SlicePictures(with_sign, {200}).write_slice({Axis::z, 10}, folder.file("signed.png"));
    const Raster both = read_png(folder.file("signed.png"));
    BOOST_TEST(count_bluish(both, 60) > 1000U);
    BOOST_TEST(count_bluish(both, -60) > 1000U);
    const Field without = two_balls(false);
    SlicePictures(without, {200}).write_slice({Axis::z, 10}, folder.file("unsigned.png"));
    BOOST_TEST(count_bluish(read_png(folder.file("unsigned.png")), 60) > 1000U);
    BOOST_TEST(count_bluish(read_png(folder.file("unsigned.png")), -60) == 0U);
}

BOOST_AUTO_TEST_CASE(have_no_more_iso_lines_than_a_narrow_band_has_room_for) {
    const TemporaryFolder folder;
    const Field field = two_balls(true, 0.06);
    SlicePictures(field, {400}).write_slice({Axis::z, 10}, folder.file("narrow.png"));
    BOOST_TEST(count_bluish(read_png(folder.file("narrow.png")), -120) > 3500U);
}

BOOST_AUTO_TEST_CASE(are_the_same_bytes_on_every_run) {
    const TemporaryFolder folder;
    const Field field = two_balls();
    const SlicePictures pictures(field, {200});
    pictures.write_slice(pictures.middle(Axis::x), folder.file("one.png"));
    pictures.write_slice({Axis::x, 25}, folder.file("other.png"));
    BOOST_TEST((content_of(folder.file("one.png")) == content_of(folder.file("other.png"))));
}

BOOST_AUTO_TEST_CASE(grow_with_the_pixels_asked_for) {
    const TemporaryFolder folder;
    const Field field = two_balls();
    SlicePictures(field, {200}).write_slice({Axis::z, 10}, folder.file("small.png"));
    SlicePictures(field, {400}).write_slice({Axis::z, 10}, folder.file("large.png"));
    const Raster small = read_png(folder.file("small.png"));
    const Raster large = read_png(folder.file("large.png"));
    BOOST_TEST(small.width > 200);
    BOOST_TEST(std::abs(large.width - 2 * small.width) < 8);
    BOOST_TEST(std::abs(large.height - 2 * small.height) < 8);
}

BOOST_AUTO_TEST_CASE(are_drawn_of_the_strangest_fields) {
    const TemporaryFolder folder;
    const auto draw = [&](const Field& field) {
        SlicePictures(field, {100}).write_mosaic({0, 0, 0}, folder.file("strange.png"));
        SlicePictures(field, {100}).write_slice({Axis::y, 1}, folder.file("strange.pdf"));
        BOOST_TEST(read_png(folder.file("strange.png")).width > 100);
        BOOST_TEST(content_of(folder.file("strange.pdf")).starts_with("%PDF"));
    };
    Field field;
    field.grid = {{1e6, -1e-6, 0}, {1e-3, 1e-9, 1e9}, {2, 3, 2}, {}};
    field.mesh_name.assign(500, 'a');
    field.mesh_name += "\xff\xc0\n";
    field.sign = clsdf::SignRule::nonzero;
    field.resize(Output::distance, field.grid.sample_count());
    for (const float value :
         {0.0F, -0.0F, 1.0F, -1.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(),
          std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::max()})
        for (const Band& band : {Band::full(), Band::symmetric(1), Band{0, 1}, Band{1, 0}, Band::signs_only()}) {
            BOOST_TEST_CONTEXT("value " << value << ", band " << band.inside << ", " << band.outside) {
                field.band = band;
                std::ranges::fill(field.distance(), value);
                draw(field);
                field.distance()[4] = -1;
                draw(field);
            }
        }
}

BOOST_AUTO_TEST_CASE(appear_complete_or_not_at_all) {
    const TemporaryFolder folder;
    const Field field = two_balls();
    const SlicePictures pictures(field);
    check_throws(ErrorCode::invalid_argument, {"no sample 99 along z"}, [&] {
        pictures.write_slice({Axis::z, 99}, folder.file("slice.png"));
    });
    check_throws(ErrorCode::invalid_argument, {"no sample 99 along y"}, [&] {
        pictures.write_mosaic({0, 99, 0}, folder.file("slice.png"));
    });
    check_throws(ErrorCode::unsupported, {"slice.gif", "\".gif\"", ".png or .pdf"}, [&] {
        pictures.write_slice({Axis::z, 0}, folder.file("slice.gif"));
    });
    check_throws(ErrorCode::output_failure, {"no folder"}, [&] {
        pictures.write_slice({Axis::z, 0}, folder.file("none/slice.png"));
    });
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(need_a_field_that_fits_its_grid_and_pixels_that_make_sense) {
    Field field = two_balls();
    for (const int pixels : {-5, 0, 99, 10001})
        check_throws(ErrorCode::invalid_argument, {std::to_string(pixels), "100 to 10000"},
                     [&] { SlicePictures(field, {pixels}); });
    field.resize(Output::distance, field.distance().size() - 1);
    check_throws(ErrorCode::invalid_argument, {"33200", "33201"}, [&] { SlicePictures{field}; });
}

BOOST_AUTO_TEST_CASE(show_any_name) {
    BOOST_TEST(printable("Häschen.off", 48) == "Häschen.off");
    BOOST_TEST(printable("a\xff\xe4z", 48) == "a\uFFFD\uFFFDz");
    BOOST_TEST(printable("\xc0\x80", 48) == "\uFFFD\uFFFD");
    BOOST_TEST(printable("a\nb", 48) == "a\uFFFDb");
    BOOST_TEST(printable("\xed\xa0\x80", 48) == "\uFFFD\uFFFD\uFFFD");
    BOOST_TEST(printable("abcdefghij", 4) == "ab…ij");
    BOOST_TEST(clsdf::picture::in_ascii("−0.2 × 10⁻⁶ … Häschen") == "-0.2 x 10^-6 ... H?schen");
}

BOOST_AUTO_TEST_CASE(need_a_grid_whose_spacing_is_a_float_and_whose_samples_differ) {
    for (const double spacing : {1e300, 1e-310}) {
        Field strange = two_balls();
        strange.grid.spacing.fill(spacing);
        check_throws(ErrorCode::invalid_argument, {"spacing", "beyond the floats"}, [&] { SlicePictures{strange}; });
    }
    Field strange = two_balls();
    strange.grid.origin[1] = 1e20;
    check_throws(ErrorCode::invalid_argument, {"y = 1e+20", "same position"}, [&] { SlicePictures{strange}; });
}

BOOST_AUTO_TEST_SUITE_END()
