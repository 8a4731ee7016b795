#include "io/example_field.hpp"
#include "io/fields/field_files.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

const std::vector<float> six_values{0, 1, -2, 3.5F, -0.25F, 1e-30F};

const std::string vti_text =
    "<VTKFile type=\"ImageData\" byte_order=\"BigEndian\">\n"
    "<ImageData WholeExtent=\"2 4 -1 0 0 0\" Origin=\"1 2 3\" Spacing=\"0.5 1 2\" Direction=\"1 0 0 0 1 0 0 0 1\">\n"
    "<Piece Extent=\"2 4 -1 0 0 0\"><PointData Scalars=\"sdf\">"
    "<DataArray Name=\"other\" type=\"Int8\" format=\"ascii\">1 2 3 4 5 6</DataArray>\n"
    "<DataArray Name=\"sdf\" type=\"Float64\" format=\"appended\" offset=\"3\"/>\n"
    "</PointData></Piece></ImageData>\n"
    "<AppendedData encoding=\"raw\">\n _";

std::string vti_file(const std::string& text = vti_text, std::uint32_t bytes = 48) {
    const std::vector<double> doubles(six_values.begin(), six_values.end());
    return text + "xyz" + bytes_of(std::vector<std::uint32_t>{bytes}, std::endian::big) +
           bytes_of(doubles, std::endian::big) + "\n</AppendedData></VTKFile>\n";
}

// RFC 4648.
std::string base64_of(std::string bytes) {
    static constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t padding = (3 - bytes.size() % 3) % 3;
    bytes.append(padding, '\0');
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k) group = group << 8 | static_cast<unsigned char>(bytes[i + k]);
        for (int shift = 18; shift >= 0; shift -= 6) text += letters[group >> shift & 63U];
    }
    return text.replace(text.size() - padding, padding, padding, '=');
}

const std::string sdf_text = "3 2 1\n-1 0.5 2e1\n0.25\n0\n1\n-2\n3.5\n-0.25\n1e-30\n";

// One of the fields that do not fit this machine: 2048 samples on a side, 32 GiB.
FieldDescription huge_field() {
    FieldDescription field;
    field.grid.size = {2048, 2048, 2048};
    field.band = clsdf::Band::symmetric(3);
    field.sign = clsdf::SignRule::nonzero;
    return field;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_vti_field_of_another_program)

BOOST_AUTO_TEST_CASE(is_read_with_its_extent_as_the_part_of_a_lattice) {
    const TemporaryFolder folder;
    const Field field = read_field(folder.file("a.vti", vti_file()));
    BOOST_TEST(field.distance() == six_values, boost::test_tools::per_element());
    BOOST_CHECK(field.grid == (clsdf::Grid{{1, 2, 3}, {0.5, 1, 2}, {3, 2, 1}, {2, -1, 0}}));
    BOOST_TEST(field.band.outside == std::numeric_limits<double>::infinity());
    BOOST_CHECK(field.sign == clsdf::SignRule::automatic);
}

// VTK writes the range of vectors into their array, after the values.
BOOST_AUTO_TEST_CASE(is_read_with_elements_within_its_arrays) {
    const TemporaryFolder folder;
    std::string text = replaced(vti_text, "type=\"Float64\" format=\"appended\" offset=\"3\"/>",
                                "type=\"Float32\" format=\"binary\">\nAAAAGAAAAAA/gAAAwAAAAEBgAAC+gAAADaJCYA==\n"
                                "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\" length=\"2\">\n"
                                "<Value index=\"0\">0.99</Value>\n<Value index=\"1\">3.5</Value>\n"
                                "</InformationKey>\n</DataArray>");
    text = replaced(text, "<AppendedData encoding=\"raw\">\n _", "</VTKFile>\n");
    const Field field = read_field(folder.file("a.vti", text));
    BOOST_TEST(field.distance() == six_values, boost::test_tools::per_element());
}

// As VTK compresses: the number of blocks, the bytes of one and of the last one, those of each by zlib; and the blocks.
BOOST_AUTO_TEST_CASE(is_read_if_zlib_has_compressed_it_and_refused_if_it_is_damaged) {
    const TemporaryFolder folder;
    const std::string sizes = "AAAAAgAAACAAAAAQAAAAFQAAABI=";
    const std::string blocks = "eJxjYIAA+w8Q+gCU78ADoQEp7AI8eJzbf4EBDCy3ePiAaAAiEAMR";
    const std::string compressed =
        replaced(vti_text, "type=\"ImageData\"", "type=\"ImageData\" compressor=\"vtkZLibDataCompressor\"");
    const auto in_place = [&](const std::string& stored) {
        const std::string text =
            replaced(compressed, "format=\"appended\" offset=\"3\"/>", "format=\"binary\">" + stored + "</DataArray>");
        return replaced(text, "<AppendedData encoding=\"raw\">\n _", "</VTKFile>\n");
    };
    const auto appended = [&](const std::string& stored) {
        return replaced(compressed, "encoding=\"raw\"", "encoding=\"base64\"") + "xyz" + stored +
               "\n</AppendedData></VTKFile>\n";
    };
    const auto with_sizes = [&](const std::vector<std::uint32_t>& numbers) {
        return in_place(base64_of(bytes_of(numbers, std::endian::big)) + blocks);
    };
    const auto refused = [&](const std::string& content, const std::string& fragment) {
        const std::string path = folder.file("a.vti", content);
        check_throws(ErrorCode::unreadable_input, {path, fragment}, [&] { read_field(path); });
    };
    constexpr std::uint32_t first = 21, second = 18;
    for (const std::string& content : {in_place(" " + sizes + "\n" + blocks + " "), appended(sizes + blocks),
                                       with_sizes({2, 32, 16, first, second})}) {
        const Field field = read_field(folder.file("a.vti", content));
        BOOST_TEST(field.distance() == six_values, boost::test_tools::per_element());
    }
    refused(with_sizes({2, 32, 0, first, second}), "unused");
    refused(with_sizes({2, 32, 8, first, second}), "do not fit");
    refused(with_sizes({2, 16, 32, first, second}), "sizes of its compressed blocks are wrong");
    refused(with_sizes({2, 24, 24, first, second}), "block 0 is damaged");
    refused(with_sizes({2, 32, 16, first - 1, second}), "block 0 is damaged");
    refused(with_sizes({2, 32, 16, first, second - 1}), "block 1 is damaged");
    refused(with_sizes({2, 32, 16, first, second + 3}), "compressed values are truncated");
    refused(with_sizes({2, 4000000000, 16, first, second}), "sizes of its compressed blocks are wrong");
    refused(with_sizes({4000000000, 32, 16, first, second}), "truncated");
    refused(with_sizes({0, 0, 0}), "do not fit");
    refused(in_place(sizes), "truncated");
    refused(in_place(sizes + blocks + "AAAA"), "more than");
    refused(appended(sizes + blocks.substr(0, 8)), "truncated");
    refused(appended("!"), "base64");
    std::string damaged = blocks;
    for (char& letter : damaged) {
        const char whole = std::exchange(letter, letter == 'A' ? 'B' : 'A');
        const std::string path = folder.file("a.vti", appended(sizes + damaged));
        try {
            read_field(path);
        } catch (const Error& error) {
            BOOST_CHECK(error.code() == ErrorCode::unreadable_input);
        }
        letter = whole;
    }
}

BOOST_AUTO_TEST_CASE(that_says_something_else_is_refused) {
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& content, const std::string& fragment) {
        const std::string path = folder.file("a.vti", content);
        check_throws(ErrorCode::unreadable_input, {path, fragment}, [&] { read_field(path); });
    };
    const auto changed = [&](const std::string& from, const std::string& to, const std::string& fragment) {
        refused(vti_file(replaced(vti_text, from, to)), fragment);
    };
    changed("type=\"ImageData\"", "type=\"PolyData\"", "PolyData");
    changed("type=\"ImageData\"", "type=\"ImageData\" compressor=\"vtkZLibDataCompressor\"", "compress");
    changed("Direction=\"1 0", "Direction=\"1 0.1", "Direction");
    changed("WholeExtent=\"2 4", "WholeExtent=\"2 x", "WholeExtent");
    changed("WholeExtent=\"2 4", "WholeExtent=\"0 4", "piece");
    changed("Spacing=\"0.5", "Spacing=\"-0.5", "spacing");
    changed("Scalars=\"sdf\"", "Scalars=\"none\"", "distance");
    changed("offset=\"3\"", "offset=\"-3\"", "-3");
    changed("offset=\"3\"", "offset=\"3000\"", "3000");
    changed("offset=\"3\"", "offset=\"9223372036854775807\"", "9223372036854775807");
    changed("type=\"Float64\"", "type=\"UInt32\"", "UInt32");
    changed("type=\"Float64\"", "type=\"Float64\" NumberOfComponents=\"3\"", "NumberOfComponents");
    changed("encoding=\"raw\"", "encoding=\"base64\"", "base64");
    changed("format=\"appended\"", "format=\"ascii\"", "ascii");
    changed("</PointData>", "", "mismatched");
    changed(" _", " ", "'_'");
    changed("<VTKFile", "<!DOCTYPE x [<!ENTITY a \"aaa\">]><VTKFile", "document type");
    refused(vti_file(vti_text, 44), "truncated");
    refused(vti_file(vti_text, 56), "unused");
    refused(vti_file(vti_text, 4000000000), "4000000000");
    refused("", "truncated");
    refused("<svg/>", "VTKFile");
    std::string deep = "<VTKFile type=\"ImageData\">";
    for (int i = 0; i < 100; ++i) deep += "<a>";
    refused(deep, "nested");
    const std::string extents[] = {"2 4 -1 0 0 0", "0 3000000 0 3000000 0 3000000"};
    std::string huge = replaced(replaced(vti_text, extents[0], extents[1]), extents[0], extents[1]);
    refused(vti_file(huge), "3000001");
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(an_sdf_field_of_another_program)

BOOST_AUTO_TEST_CASE(is_read_as_sdfgen_writes_it) {
    const TemporaryFolder folder;
    for (const std::string& text : {sdf_text, replaced(sdf_text, "2e1\n", "20\r\n")}) {
        const Field field = read_field(folder.file("a.sdf", text));
        BOOST_TEST(field.distance() == six_values, boost::test_tools::per_element());
        BOOST_CHECK(field.grid == (clsdf::Grid{{-1, 0.5, 20}, {0.25, 0.25, 0.25}, {3, 2, 1}, {}}));
        BOOST_CHECK(field.sign == clsdf::SignRule::automatic);
    }
}

/// A text that is read and written in many pieces, with values in succession that are the same.
struct LongText {
    std::vector<float> values;
    std::string text = "100 90 80\n0 0 0\n0.5\n";
    std::vector<std::size_t> ends;  ///< of each value's line

    LongText() {
        for (std::uint32_t i = 0; i < 100 * 90 * 80; ++i) {
            const std::uint32_t scattered = i / 5 * 2654435761U;
            values.push_back(static_cast<float>(static_cast<std::int32_t>(scattered)) * 1e-12F);
            text += fmt::format("{}\n", values.back());
            ends.push_back(text.size());
        }
    }
};

BOOST_AUTO_TEST_CASE(of_many_pieces_has_all_its_values_in_their_order) {
    const TemporaryFolder folder;
    const LongText many;
    const Field field = read_field(folder.file("a.sdf", many.text));
    BOOST_CHECK(same_bits(field.distance(), many.values));
    write_field(field, folder.file("b.sdf"));
    BOOST_CHECK(content_of(folder.file("b.sdf")) == many.text);
}

BOOST_AUTO_TEST_CASE(of_many_pieces_is_refused_for_its_first_damage) {
    const TemporaryFolder folder;
    const LongText many;
    const auto refused = [&](const std::string& content, const std::string& fragment) {
        const std::string path = folder.file("a.sdf", content);
        check_throws(ErrorCode::unreadable_input, {path, fragment}, [&] { read_field(path); });
    };
    for (const std::size_t value : {std::size_t{0}, std::size_t{300000}, many.values.size() - 2}) {
        std::string damaged = many.text;
        damaged.insert(many.ends[value], "first ");
        damaged.insert(damaged.size() - 1, "second");
        refused(damaged, "'first'");
        refused(many.text.substr(0, many.ends[value]), "truncated");
        std::string longer = many.text;
        longer.insert(many.ends[value], "1\n");
        refused(longer, "more values");
    }
    refused(many.text + "behind", "more values");
    refused(many.text.substr(0, many.text.size() - 1), "truncated");
}

BOOST_AUTO_TEST_CASE(that_says_something_else_is_refused) {
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& content, const std::string& fragment) {
        const std::string path = folder.file("a.sdf", content);
        check_throws(ErrorCode::unreadable_input, {path, fragment}, [&] { read_field(path); });
    };
    refused("", "missing");
    refused(replaced(sdf_text, "3 2 1", "3 2 x"), "'x'");
    refused(replaced(sdf_text, "3 2 1", "3 2 0"), "0 samples");
    refused(replaced(sdf_text, "3 2 1", "3 2 2"), "missing");
    refused(replaced(sdf_text, "3 2 1", "3 1 1"), "more values");
    refused(replaced(sdf_text, "3 2 1", "3000000 3000000 3000000"), "3000000");
    refused(replaced(sdf_text, "0.25\n", "0\n"), "spacing");
    refused(replaced(sdf_text, "-2\n", "-2,5\n"), "-2,5");
    refused(replaced(sdf_text, "-2\n", fmt::format("{}\n", std::string(10000, '7'))), "777");
    refused(sdf_text.substr(0, sdf_text.size() - 1), "truncated");
    refused(replaced(sdf_text, "3.5\n", fmt::format("3.5\n{}\n", std::string(1000000, '7'))), "longer than numbers");
}

BOOST_AUTO_TEST_CASE(has_no_place_for_triangles_or_unequal_spacing) {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.sdf");
    Field field = example_field();
    check_throws(ErrorCode::unsupported, {path, "triangle"}, [&] { write_field(field, path); });
    check_throws(ErrorCode::unsupported, {path, "triangle"}, [&] { check_field_path(path, Output::triangle); });
    field.erase(Output::triangle);
    check_throws(ErrorCode::unsupported, {path, "one spacing"}, [&] { write_field(field, path); });
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(an_h5_field)

BOOST_AUTO_TEST_CASE(that_says_it_has_no_checksums_but_is_of_the_newer_format_is_refused) {
    const TemporaryFolder folder;
    write_field(example_field(), folder.file("a.h5"));
    std::string content = content_of(folder.file("a.h5"));
    BOOST_TEST(content[8] >= 2);  // the version of the superblock
    content[8] = 0;
    check_throws(ErrorCode::unreadable_input, {"old.h5", "superblock"},
                 [&] { read_field(folder.file("old.h5", content)); });
    check_throws(ErrorCode::unreadable_input, {"text.h5", "not an HDF5 file"},
                 [&] { read_field(folder.file("text.h5", "text")); });
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(a_field_of_32_gibibytes)

// The slices between are holes in the file.
BOOST_AUTO_TEST_CASE(has_its_last_slice_where_it_belongs) {
    for (const std::string ending : {".vti", ".h5"}) {
        BOOST_TEST_CONTEXT("format " << ending) {
            const TemporaryFolder folder;
            const std::string path = folder.file("huge" + ending);
            const FieldDescription field = huge_field();
            constexpr std::size_t slice = 2048 * 2048;
            const std::vector<float> distance(slice, -2.5F);
            std::vector<std::uint32_t> triangle(slice, 7);
            triangle.back() = 8;
            const auto writer = clsdf::format_of(path, ErrorCode::unsupported).writer(path, field, Output::triangle);
            FieldSlab slab;
            slab.set(Output::distance, std::span(distance));
            slab.set(Output::triangle, std::span<const std::uint32_t>(triangle));
            writer->append(slab, 0);
            writer->append(slab, 2047);
            writer->finish();

            // The triangles are the last array; of .vti, some closing tags follow.
            const std::string tail = ending == ".vti" ? "\n  </AppendedData>\n</VTKFile>\n" : "";
            std::ifstream file(path, std::ios::binary);
            file.seekg(-static_cast<std::streamoff>(8 + tail.size()), std::ios::end);
            BOOST_TEST(static_cast<std::uint64_t>(file.tellg()) > std::uint64_t{2} * 2048 * slice * 4 - 8);
            std::string end(8 + tail.size(), '\0');
            file.read(end.data(), static_cast<std::streamsize>(end.size()));
            BOOST_CHECK(end == bytes_of(std::vector<std::uint32_t>{7, 8}, std::endian::little) + tail);
        }
    }
}

BOOST_AUTO_TEST_CASE(has_a_description_that_is_refused_where_the_file_is_cut_off) {
    const TemporaryFolder folder;
    for (const std::string ending : {".vti", ".h5", ".nrrd", ".npy"}) {
        BOOST_TEST_CONTEXT("format " << ending) {
            const std::string path = folder.file("huge" + ending);
            const std::vector<float> distance(2048 * 2048);
            {
                const auto writer = clsdf::format_of(path, ErrorCode::unsupported).writer(path, huge_field(), {});
                FieldSlab slab;
                slab.set(Output::distance, std::span(distance));
                writer->append(slab, 0);
                writer->finish();
            }
            std::filesystem::resize_file(path, 1 << 20);
            check_throws(ErrorCode::unreadable_input, {path, "truncated"}, [&] { read_field(path); });
        }
    }
}

BOOST_AUTO_TEST_SUITE_END()
