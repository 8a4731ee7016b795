#include "io/example_field.hpp"
#include "support/small_disk.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>

using namespace clsdf;
using namespace clsdf::test;

BOOST_AUTO_TEST_SUITE(writing_a_field)

BOOST_AUTO_TEST_CASE(leaves_nothing_where_the_disk_is_full) {
    for_each_format([](const TemporaryFolder& folder, const Format& format) {
        const Field field = large_field(format);
        {
            const SmallDisk disk(100000);
            const std::string reason = format.ending == ".vdb" ? "field.vdb': File too large" : "File too large";
            check_throws(ErrorCode::output_failure, {"field", reason},
                         [&] { write_field(field, folder.file("field" + format.ending)); });
        }
        BOOST_TEST(folder.file_count() == 0U);
    });
}

BOOST_AUTO_TEST_CASE(that_fails_keeps_the_field_that_was_there) {
    for_each_format([](const TemporaryFolder& folder, const Format& format) {
        write_field(example_field(format), folder.file("field" + format.ending));
        const std::size_t files = folder.file_count();
        const std::string before = content_of(folder.file("field" + format.ending));
        Field field = large_field(format);
        field.erase(Output::triangle);
        {
            const SmallDisk disk(100000);
            check_throws(ErrorCode::output_failure, {"field"},
                         [&] { write_field(field, folder.file("field" + format.ending)); });
        }
        BOOST_CHECK(content_of(folder.file("field" + format.ending)) == before);
        BOOST_TEST(folder.file_count() == files);
        BOOST_CHECK(read_field(folder.file("field" + format.ending)).grid.size == example_field(format).grid.size);
    });
}

BOOST_AUTO_TEST_CASE(of_results_at_points_is_complete_or_nothing) {
    const std::vector<Vec3> points(30000, Vec3{0.1, 1.0 / 3, -7});
    const std::vector<float> distance(points.size(), 0.3F);
    FieldSlab results;
    check_throws(ErrorCode::invalid_argument, {"distance", "double", "float"},
                 [&] { results.set(Output::distance, std::vector<double>(4)); });
    results.set(Output::distance, std::span(distance));
    for (const char* name : {"points.npy", "points.csv", "points.ply"}) {
        const TemporaryFolder folder;
        const auto fails = [&] {
            const SmallDisk disk(100000);
            check_throws(ErrorCode::output_failure, {name}, [&] { write_points(points, results, folder.file(name)); });
        };
        fails();
        BOOST_TEST(folder.file_count() == 0U);
        const std::string before = content_of(folder.file(name, "earlier"));
        fails();
        BOOST_TEST(content_of(folder.file(name)) == before);
        BOOST_TEST(folder.file_count() == 1U);
        write_points(points, results, folder.file(name));
        BOOST_TEST(content_of(folder.file(name)).size() > 100000U);
    }
}

// The last bytes of a file are written when it is closed, after other files of the field are complete.
BOOST_AUTO_TEST_CASE(that_fails_with_its_last_byte_keeps_all_files_that_were_there) {
    for_each_format(&Format::has_extras, [](const TemporaryFolder& folder, const Format& format) {
        if (format.ending == ".vdb") return;  // compressed, and in one file
        const std::string path = folder.file("field" + format.ending);
        Field field = large_field(format);
        field.erase(Output::triangle);
        field.resize(Output::site, field.distance().size());
        std::ranges::fill(field.site(), std::uint8_t{1});
        write_field(field, path);
        const auto before = all_contents(folder);
        field.distance().back() += 1;
        std::ranges::fill(field.site(), std::uint8_t{2});
        {
            const SmallDisk disk(std::filesystem::file_size(path) - 1);
            check_throws(ErrorCode::output_failure, {"field"}, [&] { write_field(field, path); });
        }
        BOOST_CHECK(all_contents(folder) == before);
    });
}

BOOST_AUTO_TEST_CASE(to_a_device_that_is_full_says_so) {
    for_each_format([](const TemporaryFolder& folder, const Format& format) {
        const std::string name = "full" + format.ending;
        std::filesystem::create_symlink("/dev/full", folder.file(name));
        const bool needs_seeks = format.ending == ".vdb" || format.ending == ".nvdb";
        const std::string reason = needs_seeks ? "regular file" : "No space left";
        check_throws(ErrorCode::output_failure, {name, reason},
                     [&] { write_field(example_field(format), folder.file(name)); });
    });
}

BOOST_AUTO_TEST_CASE(refuses_arrays_that_do_not_fit_the_grid_and_unknown_endings) {
    const TemporaryFolder folder;
    Field field = example_field();
    check_throws(ErrorCode::unsupported, {"field.vtk", ".nrrd", ".npy", ".vti"},
                 [&] { write_field(field, folder.file("field.vtk")); });
    shorten(field, Output::triangle);
    check_throws(ErrorCode::invalid_argument, {"triangle", "23", "24"},
                 [&] { write_field(field, folder.file("f.nrrd")); });
    field = example_field();
    shorten(field, Output::distance);
    check_throws(ErrorCode::invalid_argument, {"distance", "23", "24"},
                 [&] { write_field(field, folder.file("f.nrrd")); });
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(can_be_checked_before_and_leaves_nothing) {
    const TemporaryFolder folder;
    check_field_path(folder.file("field.nrrd"));
    check_field_path(folder.file("FIELD.NPY"));
    check_throws(ErrorCode::unsupported, {"field", ".nrrd"}, [&] { check_field_path(folder.file("field")); });
    check_throws(ErrorCode::output_failure, {"missing"}, [&] { check_field_path(folder.file("missing/a.nrrd")); });
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(needs_names_that_are_not_too_long_before_the_first_slab) {
    const TemporaryFolder folder;
    const OutputSet triangle = Output::triangle;
    const std::string letters(250, 'a');  // of 255
    const Field field = example_field();
    for (const std::string& path : {folder.file(letters + ".nrrd"), folder.file(letters + ".npy")})
        check_throws(ErrorCode::output_failure, {letters, "File name too long"},
                     [&] { FieldWriter(path, field, triangle); });
    check_throws(ErrorCode::output_failure, {letters, "File name too long"},
                 [&] { check_field_path(folder.file(letters + ".nrrd1.nrrd")); });
    check_throws(ErrorCode::output_failure, {letters, "File name too long"},
                 [&] { check_points_path(folder.file(letters + letters + ".csv")); });
    BOOST_TEST(folder.file_count() == 0U);
}

// Other files of the field state the name, as JSON or XML.
BOOST_AUTO_TEST_CASE(needs_a_name_in_utf8_where_another_file_states_it) {
    const TemporaryFolder folder;
    const OutputSet triangle = Output::triangle;
    for (const std::string name : {"a\xff.npy", "a\xff.h5"}) {
        const std::string path = folder.file(name);
        check_throws(ErrorCode::unsupported, {path, "UTF-8", "choose another"},
                     [&] { check_field_path(path, triangle); });
        check_throws(ErrorCode::unsupported, {path, "UTF-8"}, [&] { write_field(example_field(), path); });
    }
    check_field_path(folder.file("a\xff.nrrd"), triangle);
    check_field_path(folder.file("a\xff.npy"));
    check_field_path(folder.file("H\u00e4schen.npy"), triangle);
    check_field_path(folder.file("H\u00e4schen.h5"), triangle);
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(a_file_that_cannot_be_read_is_named) {
    const TemporaryFolder folder;
    check_throws(ErrorCode::unreadable_input, {"missing.nrrd"}, [&] { read_field(folder.file("missing.nrrd")); });
    check_throws(ErrorCode::unsupported, {"field.vtk"}, [&] { read_field(folder.file("field.vtk", "x")); });
    std::filesystem::create_directory(folder.file("folder.nrrd"));
    check_throws(ErrorCode::unreadable_input, {"folder.nrrd"}, [&] { read_field(folder.file("folder.nrrd")); });
}

BOOST_AUTO_TEST_SUITE_END()
