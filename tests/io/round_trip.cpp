#include "io/example_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

namespace {

double any_double(std::mt19937_64& random) {
    double value = 0;
    do value = std::bit_cast<double>(random());
    while (!std::isfinite(value) || std::abs(value) > 1e300);
    return value;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_field_that_was_written)

BOOST_AUTO_TEST_CASE(is_read_with_the_same_bits_grid_band_sign_and_name) {
    for_each_format(&Format::is_described, [](const TemporaryFolder& folder, const Format& format) {
        const Field written = example_field(format);
        write_field(written, folder.file("field" + format.ending));
        const Field read = read_field(folder.file("field" + format.ending));
        BOOST_CHECK(same_bits(read.distance(), written.distance()));
        BOOST_CHECK(std::ranges::equal(read.triangle(), written.triangle()));
        BOOST_CHECK(read.grid == written.grid);
        BOOST_TEST(read.band.inside == written.band.inside);
        BOOST_TEST(read.band.outside == written.band.outside);
        BOOST_CHECK(read.sign == written.sign);
        BOOST_TEST(!read.positive_inside);
        BOOST_TEST(read.mesh_name == written.mesh_name);
    });
}

BOOST_AUTO_TEST_CASE(says_that_its_sign_is_that_of_an_open_mesh) {
    for_each_format(&Format::is_described, [](const TemporaryFolder& folder, const Format& format) {
        Field written = example_field(format);
        written.sign = SignRule::solid_angle;
        write_field(written, folder.file("field" + format.ending));
        BOOST_CHECK(read_field(folder.file("field" + format.ending)).sign == SignRule::solid_angle);
    });
}

BOOST_AUTO_TEST_CASE(says_where_the_floor_of_a_terrain_is) {
    for_each_format(&Format::is_described, [](const TemporaryFolder& folder, const Format& format) {
        Field written = example_field(format);
        written.sign = SignRule::below;
        written.floor = -0.1;
        write_field(written, folder.file("field" + format.ending));
        const Field read = read_field(folder.file("field" + format.ending));
        BOOST_CHECK(read.sign == SignRule::below);
        BOOST_TEST(read.floor.value_or(0) == -0.1);
        written.sign = SignRule::nonzero;
        check_throws(ErrorCode::invalid_argument, {"field", "-0.1", "sign rule below", "nonzero", "leave it out"},
                     [&] { write_field(written, folder.file("field" + format.ending)); });
    });
}

BOOST_AUTO_TEST_CASE(says_that_its_signs_are_exact) {
    for_each_format(&Format::is_described, [](const TemporaryFolder& folder, const Format& format) {
        Field written = example_field(format);
        written.band = written.band.with_exact_signs();
        write_field(written, folder.file("field" + format.ending));
        BOOST_CHECK(read_field(folder.file("field" + format.ending)).band == written.band);
    });
}

BOOST_AUTO_TEST_CASE(says_that_it_is_positive_inside_or_is_refused) {
    for_each_format(&Format::is_described, [](const TemporaryFolder& folder, const Format& format) {
        const std::string path = folder.file("field" + format.ending);
        Field written = example_field(format);
        written.sign = SignRule::nonzero;
        written.positive_inside = true;
        if (format.ending == ".vdb" || format.ending == ".nvdb") {
            check_throws(ErrorCode::unsupported, {format.ending == ".vdb" ? "OpenVDB" : "NanoVDB", "another format"},
                         [&] { write_field(written, path); });
            BOOST_TEST(folder.file_count() == 0U);
        } else {
            write_field(written, path);
            BOOST_TEST(read_field(path).positive_inside);
            BOOST_CHECK(same_bits(read_field(path).distance(), written.distance()));
        }
        written.sign = SignRule::none;
        check_throws(ErrorCode::invalid_argument, {"without a sign", "positive inside"},
                     [&] { FieldWriter(path, written); });
        written.sign = SignRule::nonzero;
        written.band = Band::signs_only();
        check_throws(ErrorCode::invalid_argument, {"signs alone", "positive inside"},
                     [&] { FieldWriter(path, written); });
    });
}

BOOST_AUTO_TEST_CASE(has_every_output_bit_by_bit) {
    for_each_format(&Format::has_extras, [](const TemporaryFolder& folder, const Format& format) {
        Field written = example_field(format);
        written.band = Band::symmetric(1);
        std::mt19937_64 random(1);
        const auto fill = [&](auto values) {
            using Value = std::remove_cvref_t<decltype(values[0])>;
            for (std::size_t i = 0; i < values.size(); ++i)
                values[i] = static_cast<Value>(i % 5 == 4 ? 0 : random() % 200);
        };
        for (const OutputInfo& info : output_table().subspan(1)) {
            const std::span<std::byte> bytes = written.resize(info.output, written.grid.sample_count());
            switch (info.type) {
                case ElementType::uint8:
                    fill(detail::values_in<std::uint8_t>(bytes));
                    break;
                case ElementType::uint32:
                    fill(detail::values_in<std::uint32_t>(bytes));
                    break;
                case ElementType::float32:
                    fill(detail::values_in<float>(bytes));
                    break;
                default:
                    BOOST_REQUIRE((info.type == ElementType::float64));
                    fill(detail::values_in<double>(bytes));
                    break;
            }
            // Beyond the band every bit is set.
            std::memset(bytes.data(), 0xFF, info.sample_bytes());
        }
        write_field(written, folder.file("field" + format.ending));
        const Field read = read_field(folder.file("field" + format.ending));
        BOOST_TEST(read.outputs().bits() == written.outputs().bits());
        for (const OutputInfo& info : output_table())
            BOOST_TEST(std::ranges::equal(read.bytes(info.output), written.bytes(info.output)), info.name);
    });
}

BOOST_AUTO_TEST_CASE(has_all_its_values_where_it_is_read_in_parts_on_all_cores) {
    for_each_format([](const TemporaryFolder& folder, const Format& format) {
        FieldDescription description = example_field(format);
        description.grid.size = {129, 127, 131};  // eight megabytes
        Field written(description);
        for (std::uint32_t i = 0; i < written.grid.sample_count(); ++i)
            written.distance()[i] = static_cast<float>(i * 2654435761U >> 8);
        const std::string path = folder.file("field" + format.ending);
        write_field(written, path);
        BOOST_CHECK(same_bits(read_field(path).distance(), written.distance()));
    });
}

BOOST_AUTO_TEST_CASE(has_every_number_of_its_grid_and_band_bit_by_bit) {
    for_each_format(&Format::is_described, [](const TemporaryFolder& folder, const Format& format) {
        constexpr unsigned seed = 5;
        std::mt19937_64 random(seed);
        const std::string path = folder.file("field" + format.ending);
        for (int round = 0; round < 100; ++round) {
            BOOST_TEST_CONTEXT("seed " << seed << ", round " << round) {
                FieldDescription written;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const double origin = any_double(random), spacing = std::abs(any_double(random));
                    written.grid.origin[axis] = format.any_spacing ? origin : 1e6 * std::remainder(origin, 1);
                    written.grid.spacing[axis] = format.any_spacing ? spacing : 0.1 + round;
                    written.grid.first[axis] = static_cast<std::int64_t>(random() % 1000) - 500;
                }
                written.grid.size = {1, 2, 1};
                written.band = {std::abs(any_double(random)), std::abs(any_double(random))};
                Field field(written);
                field.distance()[0] = 1;
                field.distance()[1] = -1;
                write_field(field, path);
                const Field read = read_field(path);
                BOOST_CHECK(read.grid == written.grid);
                BOOST_TEST(read.band.inside == written.band.inside);
                BOOST_TEST(read.band.outside == written.band.outside);
            }
        }
    });
}

BOOST_AUTO_TEST_CASE(has_no_triangles_where_it_had_none_even_beside_old_ones) {
    for_each_format(&Format::has_extras, [](const TemporaryFolder& folder, const Format& format) {
        const std::string path = folder.file("field" + format.ending);
        Field field = example_field(format);
        write_field(field, path);
        field.erase(Output::triangle);
        write_field(field, path);
        BOOST_TEST(read_field(path).triangle().empty());
    });
}

BOOST_AUTO_TEST_CASE(is_read_without_its_triangles_where_their_file_was_left_behind) {
    for_each_format(&Format::extras_beside, [](const TemporaryFolder& folder, const Format& format) {
        write_field(example_field(format), folder.file("field" + format.ending));
        BOOST_REQUIRE(std::filesystem::remove(folder.file("field_triangle" + format.ending)));
        const Field read = read_field(folder.file("field" + format.ending));
        BOOST_TEST(read.triangle().empty());
        BOOST_TEST(read.distance().size() == 24U);
    });
}

BOOST_AUTO_TEST_CASE(is_read_with_only_the_outputs_that_are_wanted) {
    for_each_format([](const TemporaryFolder& folder, const Format& format) {
        const std::string path = folder.file("field" + format.ending);
        const Field field = example_field(format);
        write_field(field, path);
        BOOST_CHECK(read_field(path, {}).outputs() == clsdf::OutputSet(Output::distance));
        BOOST_CHECK(read_field(path, Output::triangle).outputs() == field.outputs());
        if (!format.extras_beside) return;
        const std::string damaged = folder.file("field_triangle" + format.ending);
        std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) - 1);
        BOOST_CHECK(same_bits(read_field(path, {}).distance(), field.distance()));
        check_throws(clsdf::ErrorCode::unreadable_input, {"truncated"}, [&] { read_field(path); });
    });
}

BOOST_AUTO_TEST_CASE(is_refused_with_the_triangles_of_another_grid) {
    for_each_format(&Format::extras_beside, [](const TemporaryFolder& folder, const Format& format) {
        const std::string path = folder.file("field" + format.ending);
        Field other = example_field(format);
        other.grid.size = {2, 3, 4};
        write_field(other, folder.file("other" + format.ending));
        write_field(example_field(format), path);
        std::filesystem::rename(folder.file("other_triangle" + format.ending),
                                folder.file("field_triangle" + format.ending));
        check_throws(clsdf::ErrorCode::unreadable_input, {"field_triangle" + format.ending, "compute both again"},
                     [&] { read_field(path); });
    });
}

BOOST_AUTO_TEST_CASE(has_the_same_bytes_at_another_time) {
    const TemporaryFolder folder;
    const auto write_all = [&] {
        for (const Format& format : all_formats())
            write_field(example_field(format), folder.file("field" + format.ending));
        return all_contents(folder);
    };
    const auto before = write_all();
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // files count seconds
    for (const auto& [name, content] : write_all()) BOOST_TEST(content == before.at(name), name);
}

BOOST_AUTO_TEST_SUITE_END()
