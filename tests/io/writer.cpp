#include "io/example_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

using namespace clsdf;
using namespace clsdf::test;

namespace {

// Twenty slices, so that slabs of any size cut bricks and leaves of trees.
Field tall_field(const Format& format) {
    FieldDescription description = example_field(format);
    description.grid = description.grid.part({0, 0, 0}, {4, 3, 1});
    description.grid.size[2] = 20;
    Field field(description, outputs_of(format));
    for (std::uint32_t i = 0; i < field.distance().size(); ++i) field.distance()[i] = static_cast<float>(i % 7) - 2.5F;
    for (std::uint32_t i = 0; i < field.triangle().size(); ++i) field.triangle()[i] = 3 * i;
    return field;
}

FieldSlab slices(const Field& field, std::size_t begin, std::size_t count) {
    FieldSlab slab;
    slab.set(Output::distance, field.distance().subspan(12 * begin, 12 * count));
    if (!field.triangle().empty()) slab.set(Output::triangle, field.triangle().subspan(12 * begin, 12 * count));
    return slab;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_field_written_slab_by_slab)

BOOST_AUTO_TEST_CASE(has_the_same_bytes_as_one_written_whole_however_it_is_cut) {
    for_each_format([](const TemporaryFolder& folder, const Format& format) {
        const Field field = tall_field(format);
        const std::string path = folder.file("field" + format.ending);
        write_field(field, path);
        const auto whole = all_contents(folder);
        for (const std::size_t step : {1U, 3U, 8U, 19U}) {
            FieldWriter writer(path, field, field.outputs());
            for (std::size_t begin = 0; begin < 20; begin += step)
                writer.append(slices(field, begin, std::min<std::size_t>(step, 20 - begin)));
            writer.finish();
            BOOST_TEST_CONTEXT("slabs of " << step << " slices") {
                BOOST_CHECK(all_contents(folder) == whole);
            }
        }
    });
}

BOOST_AUTO_TEST_CASE(leaves_nothing_where_it_is_not_finished) {
    for_each_format([](const TemporaryFolder& folder, const Format& format) {
        const Field field = tall_field(format);
        {
            FieldWriter writer(folder.file("field" + format.ending), field, field.outputs());
            writer.append(slices(field, 0, 9));
        }
        BOOST_TEST(folder.file_count() == 0U);
    });
}

BOOST_AUTO_TEST_CASE(is_refused_where_slices_are_missing_or_too_many_or_cut_or_of_other_outputs) {
    for_each_format([](const TemporaryFolder& folder, const Format& format) {
        const Field field = tall_field(format);
        const OutputSet outputs = field.outputs();
        const std::string path = folder.file("field" + format.ending);
        const auto refused = [&](const std::vector<std::string>& words, const FieldSlab& slab) {
            FieldWriter writer(path, field, outputs);
            writer.append(slices(field, 0, 2));
            check_throws(ErrorCode::invalid_argument, words, [&] { writer.append(slab); });
            check_throws(ErrorCode::invalid_argument, {"after a failure"}, [&] { writer.append(slices(field, 2, 1)); });
            check_throws(ErrorCode::invalid_argument, {"after a failure"}, [&] { writer.finish(); });
        };
        refused({"19 slices", "20"}, slices(field, 0, 19));
        FieldSlab cut = slices(field, 2, 2);
        cut.set(Output::distance, cut.distance().first(13));
        refused({"13 samples"}, cut);
        refused({"0 samples"}, {});
        FieldSlab other = slices(field, 2, 2);
        const std::vector<std::uint32_t> triangles(24);
        other.set(Output::triangle, other.triangle().empty() ? std::span(triangles) : std::span<const std::uint32_t>());
        refused({"triangle"}, other);

        FieldWriter writer(path, field, outputs);
        writer.append(slices(field, 0, 19));
        check_throws(ErrorCode::invalid_argument, {"19 of 20"}, [&] { writer.finish(); });
        BOOST_TEST(folder.file_count() == 0U);
    });
}

BOOST_AUTO_TEST_SUITE_END()
