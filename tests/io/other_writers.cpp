#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "written_files.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <vector>

/// Files as other programs write them: each states what is read, and what a reading warns of.
using namespace clsdf;
using namespace clsdf::test;

namespace {

/// The warnings of reading the file, without its name, which each begins with.
std::vector<std::string> warnings_of(const std::string& name, const std::string& content) {
    const TemporaryFolder folder;
    const std::string path = folder.file(name, content);
    std::vector<std::string> warnings;
    read_mesh(path, {.log = [&](const std::string& message) {
                  BOOST_TEST(message.starts_with(path + ": "));
                  warnings.push_back(message.substr(path.size() + 2));
              }});
    return warnings;
}

/// Checks that the file is the unit square, and that reading it gives one warning with these fragments, or none.
void check_is_square_with(const std::string& name, const std::string& content,
                          const std::vector<std::string>& fragments) {
    check_is_square(name, content);
    BOOST_TEST_CONTEXT(name << ":\n" << content) {
        const std::vector<std::string> warnings = warnings_of(name, content);
        BOOST_TEST_REQUIRE(warnings.size() == (fragments.empty() ? 0U : 1U));
        for (const std::string& fragment : fragments)
            BOOST_TEST(warnings[0].find(fragment) != std::string::npos, "no '" << fragment << "': " << warnings[0]);
    }
}

/// The unit square in a PLY file. counts and indices: the types of a face's list, with which `number` writes.
template <typename Count, typename Index>
std::string binary_ply(std::endian order, const char* counts, const char* indices, std::vector<Index> corners,
                       Count count) {
    std::string content = fmt::format(
        "ply\nformat binary_{}_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list {} {} vertex_indices\nend_header\n",
        order == std::endian::big ? "big" : "little", counts, indices);
    for (const Vec3& vertex : square)
        for (const double x : vertex) content += bytes_of(static_cast<float>(x), order);
    content += bytes_of(count, order);
    for (const Index corner : corners) content += bytes_of(corner, order);
    return content;
}

std::string small_ply(std::endian order = std::endian::little) {
    return binary_ply<std::uint8_t, std::int32_t>(order, "uchar", "int", {0, 1, 2, 3}, 4);
}

const std::string off_body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

}  // namespace

BOOST_AUTO_TEST_CASE(the_ends_of_text_stl_may_be_two_words) {
    const std::string facet1 =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nend loop\nend facet\n";
    const std::string facet2 =
        "FACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 1 0\nVERTEX 0 1 0\nEND LOOP\nEnd\n Facet\n";
    check_is_square("a.stl", "solid a\n" + facet1 + facet2 + "end solid a\n");
    check_is_square("a.stl", "solid end\n" + facet1 + "End Solid end\nsolid b\n" + facet2 + "endsolid b\n");
    check_is_square("a.stl", "solid a\n" + facet1 + replaced(facet2, "END LOOP", "ENDLOOP") + "END SOLID");
    check_is_square("a.stl", with_line_ends("solid a\n" + facet1 + facet2 + "end solid a\n", "\n\r"));
    check_is_refused("a.stl", "solid a\n" + replaced(facet1, "end loop", "end lop"), unreadable,
                     {"line 7", "'vertex' or 'endloop'", "'end'"});
    check_is_refused("a.stl", "solid a\n" + replaced(facet1, "end facet", "end lop"), unreadable,
                     {"line 8", "'endfacet'", "'end'"});
}

BOOST_AUTO_TEST_CASE(text_stl_is_read_as_other_programs_take_it_and_each_irregularity_has_a_warning) {
    const std::string
        facet1 = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n",
        facet2 = replaced(facet1, "vertex 1 0 0\nvertex 1 1 0", "vertex 1 1 0\nvertex 0 1 0"), facets = facet1 + facet2;
    const auto check = [](const std::string& text, const std::string& warning) {
        check_is_square_with("a.stl", text, {warning});
    };
    check_is_square_with("a.stl", "solid a\n" + facets + "endsolid a\n", {});

    // A name joined to its keyword.
    check("solid Scene\n" + facets + "endsolidScene\n", "1 name is joined to its 'solid' or 'endsolid', at line 16");
    check("solid Scene\n" + facets + "EndSolid_1 Scene", "1 name is joined to its 'solid' or 'endsolid', at line 16");
    check("solidScene\n" + facets + "endsolidScene\n",
          "2 names are joined to their 'solid' or 'endsolid', the first at line 1");
    // No endsolid.
    for (const char* end : {"", "\n\n", " "})
        check("solid a\n" + facets + end, "the text ends without 'endsolid' and may be cut off, at line 15");
    check("solid a\n" + facet1 + "solid b\n" + facet2 + "endsolid b\n",
          "1 solid begins before the one before it ends, at line 9");
    check("solid a\nsolid b\nsolid c\n" + facets + "endsolid c\n",
          "2 solids begin before the ones before them end, the first at line 2");
    check("solid a\n" + facets + "endsolid a\nendsolid b\n", "1 'endsolid' ends no solid, at line 17");
    // What files are filled up with.
    for (const std::string& after : {std::string(1, '\0'), std::string("\x1A"), std::string("\n\0\r\n ", 5)})
        check("solid a\n" + facets + "endsolid a" + after, "1 byte of zeros or Ctrl-Z after the text is skipped");
    for (const std::size_t zeros : {std::size_t{7}, std::size_t{5000}}) {
        const std::string warning = fmt::format("{} bytes of zeros or Ctrl-Z after the text are skipped", zeros + 1);
        check("solid a\n" + facets + "endsolid a\n\x1A" + std::string(zeros, '\0'), warning);
        check("solid a\n" + facets + "endsolid a\n" + std::string(zeros, '\0') + "\n\x1A\r\n", warning);
    }
    // No normal.
    for (const char* begin : {"facet", "facet normal", "facet 0 0 1", "FACET\t\n\n"}) {
        check("solid a\n" + replaced(facet1, "facet normal 0 0 1", begin) + facet2 + "endsolid",
              "1 facet has no normal, at line 2");
        check("solid a\n" + replaced(facet1, "facet normal 0 0 1", begin) +
                  replaced(facet2, "facet normal 0 0 1", begin) + "endsolid",
              "2 facets have no normal, the first at line 2");
    }
    // A loop without a facet, a facet without an end.
    const std::string loop1 = replaced(facet1, "facet normal 0 0 1\n", ""), bare1 = replaced(loop1, "endfacet\n", "");
    const std::string bare2 = replaced(replaced(facet2, "facet normal 0 0 1\n", ""), "endfacet\n", "");
    check("solid a\n" + loop1 + facet2 + "endsolid a\n", "1 loop is in no facet, at line 2");
    check("solid a\n" + facet1 + bare2 + "endsolid a\n", "1 loop is in no facet, at line 9");
    check("solid a\n" + bare1 + bare2 + "endsolid a\n", "2 loops are in no facet, the first at line 2");
    check("solid a\n" + replaced(facet1, "endfacet\n", "") + facet2 + "endsolid a\n",
          "1 facet has no 'endfacet', at line 2");
    check("solid a\n" + replaced(facet1, "endfacet", "") + replaced(facet2, "endfacet\n", "") + "endsolid a\n",
          "2 facets have no 'endfacet', the first at line 2");
    // Colours.
    for (const char* colour : {"color 1 0.5 0", "COLOR 255 0 0 1", "colour red", "  color"}) {
        const std::string line = std::string(colour) + "\n";
        check("solid a\n" + line + facets + "endsolid a\n", "1 colour is skipped, at line 2");
        check("solid a\n" + facet1 + line + facet2 + "endsolid a\n", "1 colour is skipped, at line 9");
        check("solid a\n" + replaced(facet1, "outer loop\n", line + "outer loop\n") + facet2 + line + "endsolid a\n",
              "2 colours are skipped, the first at line 3");
        check("solid a\n" + replaced(facet1, "endloop\n", "endloop\n" + line) + facet2 + "endsolid a\n",
              "1 colour is skipped, at line 8");
    }
    check_is_square_with("a.stl", "solid color 1 0 0\n" + facets + "endsolid color 1 0 0\n", {});
    // Comments.
    check("# made by hand\n#\n\nsolid a\n" + facets + "endsolid a\n", "2 comments are skipped, the first at line 1");
    check("\xEF\xBB\xBF# made by hand\r\n" + with_line_ends("solid a\n" + facets + "endsolid a\n", "\r\n"),
          "1 comment is skipped, at line 1");
    check("solid a\n#facet\n" + facets + "endsolid a\n", "1 comment is skipped, at line 2");
    check("solid a\n" + replaced(facet1, "1 0 0\n", "1 0 0 # the second\n# vertex 2 0 0\n") + facet2 +
              "endsolid a\n# end",
          "3 comments are skipped, the first at line 5");
    check_is_square_with("a.stl", "solid part #1\n" + facets + "endsolid part #1\n", {});
    // On one line.
    const auto one_line = [](const std::string& text) { return with_line_ends(text, " "); };
    for (const char* name : {"", "a\n", "a facet of a name\n", "normal outer loop\n"})
        for (const std::string& end : {std::string("endsolid "), std::string("endsolid ") + name + "\n"})
            check(one_line(std::string("solid\n") + name + facets) + end,
                  "1 facet begins on the line of its solid's name, at line 1");
    check(one_line("solid a\n" + facet1 + "endsolid a\nsolid b\n" + facet2 + "endsolid b\n"),
          "2 facets begin on the lines of their solids' names, the first at line 1");
    check(one_line("solid a\n" + facet1 + "endsolid a") + "\n" + one_line("solid b\n" + facet2 + "endsolid b"),
          "2 facets begin on the lines of their solids' names, the first at line 1");
    check("solid a " + facets + "endsolid", "1 facet begins on the line of its solid's name, at line 1");
    check_is_square_with("a.stl", "solid a\n" + facet1 + "endsolid a solid b\n" + facet2 + "endsolid b", {});
    check_is_square_with("a.stl",
                         "solid facet\n" + facet1 + "endsolid solid facet\nsolid solid\n" + facet2 + "endsolid", {});

    // Several at once.
    const std::vector<std::string> all =
        warnings_of("a.stl", one_line("solid a\n" + replaced(bare1, "endloop", "endloop color 1 0 0") + bare2) +
                                 std::string(9, '\0'));
    BOOST_TEST(all.size() == 5U);

    // What is cut within a facet, or is no STL, stays an error.
    check_is_refused("a.stl", "solid a\n" + facet1 + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\n", unreadable,
                     {"line 11", "'vertex' or 'endloop'", "file ends"});
    check_is_refused("a.stl", "solid a\n" + facet1 + "facet\n", unreadable, {"line 9", "file ends"});
    check_is_refused("a.stl", "solid a\n" + facet1 + "endsol", unreadable, {"line 9", "'endsol'"});
    check_is_refused("a.stl", "solid a\n" + facet1 + std::string(3, '\0') + facet2 + "endsolid a\n", unreadable,
                     {"'facet' or 'endsolid'"});
    check_is_refused("a.stl", "solid a\n" + facets + "endsolid a\n" + facet1, unreadable, {"line 17", "'solid'"});
    check_is_refused("a.stl", "solid a\n" + replaced(facet1, "normal 0 0 1", "0 0") + facet2, unreadable, {"'outer'"});
    check_is_refused("a.stl", "solid a\n" + replaced(facet1, "normal", "norml") + facet2, unreadable,
                     {"line 2", "'normal'", "'norml'"});
    check_is_refused("a.stl", "solid a\n" + replaced(facet1, "endfacet", bare2 + "endfacet"), unreadable,
                     {"'endfacet'", "'outer'"});
}

BOOST_AUTO_TEST_CASE(ply_may_have_integers_of_64_bits) {
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        const std::vector<std::int64_t> of_signed{0, 1, 2, 3};
        const std::vector<std::uint64_t> of_unsigned{0, 1, 2, 3};
        check_is_square("a.ply", binary_ply<std::uint8_t>(order, "uchar", "int64", of_signed, 4));
        check_is_square("a.ply", binary_ply<std::uint8_t>(order, "uchar", "uint64", of_unsigned, 4));
        check_is_square("a.ply", binary_ply<std::int64_t>(order, "int64", "int64", of_signed, 4));
        check_is_square("a.ply", binary_ply<std::uint64_t>(order, "uint64", "uint64", of_unsigned, 4));
        for (const std::int64_t far :
             {std::int64_t{4}, std::int64_t{-1}, std::int64_t{1} << 32, std::numeric_limits<std::int64_t>::min()})
            check_is_refused("a.ply",
                             binary_ply<std::uint8_t, std::int64_t>(order, "uchar", "int64", {0, 1, 2, far}, 4),
                             invalid, {"row 0", "index " + std::to_string(far)});
        check_is_refused("a.ply",
                         binary_ply<std::uint8_t, std::uint64_t>(
                             order, "uchar", "uint64", {0, 1, 2, std::numeric_limits<std::uint64_t>::max()}, 4),
                         unreadable, {"row 0", "18446744073709551615"});
        for (const std::uint64_t count : {std::uint64_t{5}, std::uint64_t{1} << 40, std::uint64_t{1} << 63})
            check_is_refused("a.ply", binary_ply<std::uint64_t>(order, "uint64", "uint64", of_unsigned, count),
                             unreadable, {"row 0"});
    }
    for (const char* type : {"int64", "uint64"}) {
        const std::string text = fmt::format(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty {0} z\n"
            "element face 1\nproperty list {0} {0} vertex_index\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n",
            type);
        check_is_square("a.ply", text);
        check_is_refused("a.ply", replaced(text, "4 0 1 2 3", "4 0 1 2 4294967299"), invalid, {"4294967299"});
    }
}

BOOST_AUTO_TEST_CASE(bytes_after_the_last_row_of_a_binary_ply_are_skipped) {
    for (const std::endian order : {std::endian::little, std::endian::big}) {
        const std::string content = small_ply(order);
        check_is_square_with("a.ply", content + std::string(3, '\0'), {"3 bytes after the last row are skipped"});
        check_is_square_with("a.ply", content + "x", {"1 byte after the last row is skipped"});
        const TemporaryFolder folder;
        std::string warning;
        const auto log = [&](const std::string& message) { warning += message; };
        BOOST_TEST(read_points(folder.file("points.ply", content + "x"), log).size() == 4U);
        BOOST_TEST(warning.find("1 byte after the last row is skipped") != std::string::npos, warning);
        check_is_square_with("a.ply", content + " \r\n", {});
    }
}

BOOST_AUTO_TEST_CASE(header_lines_of_ply_end_in_any_way) {
    const std::string content = small_ply();
    const std::size_t length = content.find("end_header\n") + 11;
    const std::string header = content.substr(0, length), rows = content.substr(length);
    for (const char* line_end : {"\n", "\r\n", "\n\r", "\r"}) {
        check_is_square_with("a.ply", with_line_ends(header, line_end) + rows, {});
        // Mixed with LF.
        std::string mixed = with_line_ends(header, line_end);
        check_is_square_with("a.ply", "ply\n" + mixed.substr(mixed.find("format")) + rows, {});
        // The first byte of the rows may be that of a line end.
        for (const char first : {'\n', '\r'}) {
            const std::string padded = replaced(mixed, "element vertex",
                                                fmt::format("element pad 1{0}property uchar a{0}"
                                                            "element vertex",
                                                            line_end));
            check_is_square_with("a.ply", padded + first + rows, {});
        }
    }
    check_is_square_with("a.ply", replaced(header, "end_header\n", "end_header\n\r") + rows, {});
    check_is_square_with("a.ply", replaced(header, "end_header\n", "end_header\r\n") + rows, {});
    for (const char* line_end : {"\n\r", "\r"})
        check_is_square("a.off", with_line_ends("OFF\n4 2 5\n" + off_body, line_end));
}

BOOST_AUTO_TEST_CASE(header_lines_of_ply_that_are_no_comment_are_skipped) {
    const std::string content = small_ply();
    const std::string line = "Created by Blender3D 2.47 - www.blender.org, source file: a.blend\n";
    check_is_square_with("a.ply", replaced(content, "element vertex", line + "element vertex"),
                         {"1 line of the header", "line 3, 'Created'"});
    check_is_square_with("a.ply", replaced(content, "element vertex", "Comment a\nCOMMENT b\nelement vertex"), {});
    // What may be a keyword or a type would change the meaning of the rows.
    for (const char* slip : {"propertyy uchar red\n", "Property uchar red\n", "elemnt pad 1\n", "uchar red\n",
                             "list uchar int a\n", "end_heder\n", "3 4 5\n"})
        check_is_refused("a.ply", replaced(content, "element face", slip + std::string("element face")), unreadable,
                         {"line 7", "expected format, element, property"});
}

BOOST_AUTO_TEST_CASE(white_space_is_free_in_off) {
    const std::string body = with_line_ends(off_body, " ");
    for (const std::string& content : std::vector<std::string>{
             "OFF 4 2 5 " + body, "OFF\n4 2 5 " + body, "OFF\n4 2 5\n" + body, "OFF 4\n2 5 0 0\n" + body.substr(4),
             "OFF # here\n4 2 # there\n5 0 0 0 1 0 0 1 # a vertex\n1 0 0 1 0 3 0\n1 2 3 0 2 3\n",
             "off\n4 2 5\n" + off_body, "Off 4 2 5\n" + off_body, "4 2 5 " + body})
        check_is_square_with("a.off", content, {});
    check_is_square("a.off", "COFF 4 1 0 0 0 0 1 1 1 1 1 0 0 1 1 1 1 1 1 0 1 1 1 1 0 1 0 1 1 1 1 4 0 1 2 3");
    check_is_square("a.off", "coff 4 1 0 0 0 0 255 0 0 1 0 0 255 0 0 1 1 0 255 0 0 0 1 0 255 0 0 4 0 1 2 3");
    check_is_square("a.off", "NOFF 4 1 0 0 0 0 0 0 1 1 0 0 0 0 1 1 1 0 0 0 1 0 1 0 0 0 1 4 0 1 2 3");
    // Errors are those of free text if the file has fewer lines.
    check_is_refused("a.off", "OFF 4 2 5 " + body.substr(0, body.size() - 9), unreadable, {"after 1 of 2 faces"});
    check_is_refused("a.off", "OFF 4 2 5 " + replaced(body, "3 0 2 3", "3 0 2 4"), invalid, {"index 4"});
    check_is_refused("a.off", "OFF 4 2 5 " + body + "7", unreadable, {"4 vertices and 2 faces"});
    check_is_refused("a.off", "OFF 4 2 5 " + replaced(body, "1 1 0", "1 1 x"), unreadable, {"coordinate", "'x'"});
    // Lines for all vertices and faces are no free text, though their numbers would fit.
    check_is_refused("a.off", "OFF\n4 2 5\n0 0\n1 0 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n", unreadable,
                     {"line 3", "coordinate"});
    for (const char* keyword : {"OFF BINARY\n", "off binary\n", "OFF\tBinary\n"})
        check_is_refused("a.off", keyword + std::string("\0\0\0\4", 4), ErrorCode::unsupported,
                         {"binary", "convert it to text"});
    check_is_refused("a.off", "4off\n4 2 5\n" + off_body, ErrorCode::unsupported, {"'4off'", "three dimensions"});
}

BOOST_AUTO_TEST_CASE(faces_of_one_or_two_corners_are_skipped_and_counted) {
    const std::string text = "1 face of fewer than three corners is skipped, the first at ";
    check_is_square_with("a.off", "OFF\n4 3 5\n" + off_body + "2 0 1\n", {text + "line 9"});
    check_is_square_with("a.off", "OFF 4 3 5 " + with_line_ends(off_body, " ") + "1 0", {text + "line 1"});
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    check_is_square_with("a.obj", vertices + "f 1 2\nf 1 2 3 4\n", {text + "line 5"});
    check_is_square_with("a.obj", vertices + "f 1/1\nf 1 2 3 4\nf 2//3 1\n",
                         {"2 faces of fewer than three corners are skipped, the first at line 5"});
    check_is_refused("a.obj", vertices + "f 1 5\nf 1 2 3 4\n", invalid, {"line 5", "index 5"});
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 1\n4 0 1 2 3\n";
    check_is_square_with("a.ply", ply, {text + "line 14"});
    check_is_refused("a.ply", replaced(ply, "2 0 1", "2 0 4"), invalid, {"line 14", "index 4"});
    const std::string binary = replaced(small_ply(), "element face 1", "element face 2") + std::string("\1", 1) +
                               bytes_of(std::int32_t{3}, std::endian::little);
    check_is_square_with("a.ply", binary, {text + "row 1 of 'face'"});
    check_is_refused("a.obj", vertices + "f 1 2\n", invalid, {"no triangle", "1 face of fewer than three corners"});
}

BOOST_AUTO_TEST_CASE(the_fourth_number_of_an_obj_vertex_divides_the_others) {
    check_is_square_with("a.obj", "v 0 0 0 2\nv 2 0 0 2\nv -1 -1 0 -1\nv 0 1 0 1\nf 1 2 3 4\n",
                         {"3 vertices have a fourth number w other than 1, the first at line 1 (w is 2)", "divided"});
    check_is_square_with("a.obj", "v 0 0 0 1.0\nv 1 0 0 .5 .5 .5\nv 1 1 0 2 2 2 2\nv 0 1 0\nf 1 2 3 4\n", {});
    check_is_refused("a.obj", "v 0 0 0\nv 1 0 0 0\nv 1 1 0\nf 1 2 3\n", invalid, {"line 2", "weight w 0"});
    check_is_refused("a.obj", "v 0 0 0\nv 1 0 0 inf\nv 1 1 0\nf 1 2 3\n", invalid, {"line 2", "weight w inf"});
    check_is_refused("a.obj", "v 0 0 0\nv 1 0 0 red\nv 1 1 0\nf 1 2 3\n", unreadable, {"line 2", "weight", "'red'"});
}

BOOST_AUTO_TEST_CASE(lines_of_obj_with_unknown_keywords_are_counted) {
    const std::string mesh = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    check_is_square_with("a.obj", "mtllib a.mtl\ng\ns off\nusemtl x\nl 1 2\np 1\nvp 0.3\ncstype bezier\n" + mesh, {});
    check_is_square_with(
        "a.obj", mesh + "something new\nelse\n",
        {"2 lines with keywords that OBJ does not have are skipped, the first at line 6, 'something'"});
    check_is_refused("a.obj", "this is\nno mesh\n", invalid,
                     {"no triangle", "2 lines with keywords", "line 1, 'this'"});
}

BOOST_AUTO_TEST_CASE(numbers_of_text_files_may_be_as_fortran_writes_them) {
    const auto of = [](const std::string& text, const std::string& one, const std::string& zero) {
        std::string result;
        for (const char c : text) result += c == '@' ? one : c == '$' ? zero : std::string(1, c);
        return result;
    };
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n$ $ $\n@ $ $\n@ @ $\n$ @ $\n4 0 1 2 3\n";
    const std::string stl =
        "solid\nfacet normal 0 0 1\nouter loop\nvertex $ $ $\nvertex @ $ $\nvertex @ @ $\nendloop\nendfacet\n"
        "facet normal 0 0 1\nouter loop\nvertex $ $ $\nvertex @ @ $\nvertex $ @ $\nendloop\nendfacet\nendsolid\n";
    for (const char* one :
         {"1.0D+00", "1.D0", ".1d1", "+0.1D+01", "10.0D-1", "1d0", "1.0Q+0", "1000.0-3", "0.01+2", "0.01E+002"})
        for (const char* zero : {"0.0D+00", "-0d0", "1.0-400", "1.0D-400"}) {
            check_is_square("a.off", of("OFF\n4 1 0\n$ $ $\n@ $ $\n@ @ $\n$ @ $\n4 0 1 2 3\n", one, zero));
            check_is_square("a.obj", of("v $ $ $\nv @ $ $\nv @ @ $ @\nv $ @ $ 1\nf 1 2 3 4\n", one, zero));
            check_is_square("a.ply", of(ply, one, zero));
            check_is_square("a.stl", of(stl, one, zero));
        }
    const TemporaryFolder folder;
    const std::vector<Vec3> points{{-150, 2.5e120, 1e-120}};
    BOOST_TEST((read_points(folder.file("a.csv", "x,y,z\n-1.5D+02,2.5+120,1.0-120\n")) == points));
    for (const char* other : {"1.0D", "1.0D+", "1.0D+1.5", "D+00", "1-3", "1+3", "1.0+2+2", "1.0E+2-3", "1.0De0",
                              "infD0", "1.0-", "2020-11-28"})
        check_is_refused("a.obj", fmt::format("v 0 0 {}\n", other), unreadable, {"line 1", "coordinate", other});
    check_is_refused("a.off", "OFF\n3 1 0\n0 0 0\n1.0D+400 0 0\n0 1 0\n3 0 1 2\n", invalid, {"vertex 1", "inf"});
}

BOOST_AUTO_TEST_CASE(vertices_that_no_face_uses_may_be_what_windows_writes_for_nan) {
    for (const char* word : {"1.#QNAN", "-1.#IND", "1.#INF", "-1.#INF00", "1.#QNAN0", "nan(ind)", "-nan"}) {
        const TemporaryFolder folder;
        const std::string off = fmt::format("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n{0} {0} {0} # unused\n3 0 1 2\n", word);
        BOOST_TEST(read_mesh(folder.file("a.off", off)).triangles().size() == 1U, word);
        const std::string ply = fmt::format(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement "
            "face 1\n"
            "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n{0} {0} {0}\n3 0 1 2\n",
            word);
        BOOST_TEST(read_mesh(folder.file("a.ply", ply)).triangles().size() == 1U, word);
        const std::string obj = fmt::format("v 0 0 0\nv 1 0 0\nv 1 1 0\nv {0} {0} {0}\nf 1 2 3\n", word);
        BOOST_TEST(read_mesh(folder.file("a.obj", obj)).triangles().size() == 1U, word);
    }
    check_is_square("a.off", "OFF\n4 2 5\n" + replaced(off_body, "1 0 0\n", "1.#a comment\n0\n0\n"));
}

namespace {

/// A cube of six strips with the list's numbers in `order`, or in text if there is none.
std::string strips_ply(std::optional<std::endian> order, const std::vector<std::vector<std::int32_t>>& rows) {
    std::string content = fmt::format(
        "ply\nformat {} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        "element tristrips {}\nproperty list int int vertex_indices\nend_header\n",
        !order                       ? "ascii"
        : *order == std::endian::big ? "binary_big_endian"
                                     : "binary_little_endian",
        rows.size());
    for (int k = 0; k < 8; ++k)
        for (int axis = 0; axis < 3; ++axis) {
            const int x = k >> axis & 1;
            content += order ? bytes_of(static_cast<float>(x), *order) : fmt::format("{}{}", x, axis == 2 ? "\n" : " ");
        }
    for (const std::vector<std::int32_t>& row : rows) {
        const auto length = static_cast<std::int32_t>(row.size());
        content += order ? bytes_of(length, *order) : fmt::format("{}", length);
        for (const std::int32_t index : row) content += order ? bytes_of(index, *order) : fmt::format(" {}", index);
        if (!order) content += '\n';
    }
    return content;
}

}  // namespace

BOOST_AUTO_TEST_CASE(ply_may_have_triangle_strips) {
    const std::vector<std::int32_t> sides{0, 1, 4, 5, 6, 7, 2, 3, 0, 1}, right{1, 3, 5, 7}, left{0, 4, 2, 6};
    const auto joined = [](std::vector<std::int32_t> strip, const std::vector<std::int32_t>& more,
                           std::initializer_list<std::int32_t> between) {
        strip.insert(strip.end(), between);
        strip.insert(strip.end(), more.begin(), more.end());
        return strip;
    };
    const TemporaryFolder folder;
    for (const std::optional<std::endian> order :
         {std::optional<std::endian>(), std::optional(std::endian::little), std::optional(std::endian::big)}) {
        // Each row a strip; all in one row; -1 at the end and twice; a strip that goes on over repeated corners.
        for (const std::vector<std::vector<std::int32_t>>& rows : std::vector<std::vector<std::vector<std::int32_t>>>{
                 {sides, right, left},
                 {joined(joined(sides, right, {-1}), left, {-1})},
                 {joined(joined(sides, right, {-1, -1}), left, {-1}), {-1}, {}},
                 {joined(sides, right, {1, 1}), left}}) {
            const Mesh mesh = read_mesh(folder.file("a.ply", strips_ply(order, rows)));
            BOOST_TEST(mesh.triangles().size() == 12U);
            const Topology topology = describe_topology(mesh);
            BOOST_TEST(topology.balanced);
            BOOST_TEST(!topology.inside_out);
            BOOST_TEST(topology.reoriented_faces == 0U);
        }
        check_is_refused("a.ply", strips_ply(order, {sides, {1, 3, 8, 7}}), invalid, {"index 8", "8 vertices"});
        check_is_refused("a.ply", strips_ply(order, {sides, {1, 3, -2, 7}}), invalid, {"index -2"});
        check_is_refused("a.ply", strips_ply(order, {{1, 2}}), invalid, {"no triangle"});
    }
    const std::string text = strips_ply({}, {sides});
    check_is_refused("a.ply", replaced(text, "vertex_indices", "indices"), unreadable, {"'tristrips'"});
    check_is_refused("a.ply", replaced(text, "list int int", "list int float"), unreadable, {"no list of integers"});
    // Beside single faces.
    const std::string both = replaced(strips_ply({}, {sides, right}), "element tristrips",
                                      "element face 2\nproperty list uchar int vertex_index\nelement tristrips");
    BOOST_TEST(
        describe_topology(read_mesh(folder.file("a.ply", replaced(both, "1 1 1\n", "1 1 1\n3 0 4 2\n3 4 6 2\n"))))
            .balanced);
}

BOOST_AUTO_TEST_CASE(off_may_state_that_it_has_three_dimensions) {
    check_is_square("a.off", "nOFF\n3\n4 2 5\n" + off_body);
    check_is_square("a.off", "nOFF 3\n4 2 5\n" + off_body);
    check_is_square("a.off", "nOFF 3 4 2 5 " + with_line_ends(off_body, " "));
    check_is_square("a.off",
                    "CnOFF\n3\n4 1 5\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n1 1 0 1 1 1 1\n0 1 0 1 1 1 1\n4 0 1 2 3\n");
    for (const char* header : {"nOFF\n4\n", "nOFF 2\n", "4nOFF\n3\n"})
        check_is_refused("a.off", header + ("4 2 5\n" + off_body), ErrorCode::unsupported, {"three dimensions"});
    check_is_refused("a.off", "nOFF\nx\n4 2 5\n" + off_body, unreadable, {"line 2", "'x'"});
}

namespace {

/// Reads the file with bad facets, which the message without the option names. `left_out`: the begin of the warning.
Mesh read_without_bad_facets(const std::string& name, const std::string& content, const std::string& left_out) {
    check_is_refused(name, content, invalid, {"--skip-bad-facets (skip_bad_facets"});
    const TemporaryFolder folder;
    std::string warning;
    const std::string path = folder.file(name, content);
    Mesh mesh =
        read_mesh(path, {.log = [&](const std::string& message) { warning += message; }, .skip_bad_facets = true});
    BOOST_TEST(warning.starts_with(path + ": " + left_out), warning);
    return mesh;
}

std::string binary_stl(const std::vector<std::array<float, 9>>& triangles) {
    std::string content(80, ' ');
    content += bytes_of(static_cast<std::uint32_t>(triangles.size()), std::endian::little);
    for (const auto& triangle : triangles) {
        content += std::string(12, '\0');
        for (const float x : triangle) content += bytes_of(x, std::endian::little);
        content += std::string(2, '\0');
    }
    return content;
}

}  // namespace

BOOST_AUTO_TEST_CASE(bad_facets_are_left_out_if_that_is_asked_for) {
    const std::string two = "2 faces with a vertex that does not exist or is not finite are left out, the first at ";
    const auto is_square = [](const Mesh& mesh) {
        BOOST_CHECK(mesh.triangles() == two_triangles);
        for (std::size_t v = 0; v < 4; ++v) BOOST_CHECK(mesh.vertices()[v] == square[v]);
    };
    const std::string vertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 nan 0\n";
    is_square(read_without_bad_facets("a.off", "OFF\n5 4 0\n" + vertices + "3 0 1 2\n4 0 1 2 4\n3 0 2 3\n3 0 1 5\n",
                                      two + "line 9 (a vertex is (0, nan, 0))"));
    is_square(read_without_bad_facets("a.off",
                                      "OFF 5 4 0 " + with_line_ends(vertices, " ") + "3 0 -1 2 3 0 1 2 3 0 2 3 3 0 1 4",
                                      two + "line 1 (there is no vertex -1)"));
    // Of .obj faces come before vertices, too, and relative numbers count back.
    is_square(read_without_bad_facets(
        "a.obj", "f 1 2 3\nf 5 1 2 3\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv inf 0 0\nf -5 -3 -2\nf 1 2 0\n",
        two + "line 2 (a vertex is (inf, 0, 0))"));
    for (const char* missing : {"6", "-6", "0", "5000000000"})
        is_square(read_without_bad_facets(
            "a.obj", fmt::format("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0\nf 1 2 {}\nf 1 2 3\nf 1 3 4\n", missing),
            fmt::format(
                "1 face with a vertex that does not exist or is not finite is left out, the first at line 6 (there "
                "is no vertex {})",
                missing)));
    const std::string header = "ply\nformat ascii 1.0\n",
                      of_vertices =
                          "element vertex 5\nproperty float x\n"
                          "property float y\nproperty float z\n",
                      of_faces = "element face 4\nproperty list uchar int vertex_indices\n",
                      faces = "3 0 1 2\n3 4 1 2\n4 0 1 2 9\n3 0 2 3\n";
    is_square(read_without_bad_facets("a.ply", header + of_vertices + of_faces + "end_header\n" + vertices + faces,
                                      two + "line 16 (a vertex is (0, nan, 0))"));
    is_square(read_without_bad_facets("a.ply", header + of_faces + of_vertices + "end_header\n" + faces + vertices,
                                      two + "line 11 (a vertex is (0, nan, 0))"));
    // Each triangle of a strip by itself.
    const Mesh strip = read_without_bad_facets("a.ply", strips_ply({}, {{0, 1, 2, 3, 99, 4, 5, 6}}),
                                               "3 faces with a vertex that does not exist");
    BOOST_TEST(strip.triangles().size() == 3U);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    is_square(read_without_bad_facets("a.stl",
                                      binary_stl({{0, 0, 0, 1, 0, 0, 1, 1, 0},
                                                  {0, 0, nan, 1, 0, 0, 1, 1, 0},
                                                  {5, 5, 5, 1, nan, 0, 1, 1, 0},
                                                  {0, 0, 0, 1, 1, 0, 0, 1, 0}}),
                                      two + "triangle 1, counted from 0 (a vertex is (0, 0, nan))"));
    const auto facet = [](const std::string& third) {
        return "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex " + third + "\nendloop\nendfacet\n";
    };
    const std::string last = replaced(facet("0 1 0"), "1 0 0", "1 1 0");
    is_square(read_without_bad_facets(
        "a.stl", "solid\n" + facet("1 1 0") + facet("1.#QNAN 1 0") + facet("1 1 -inf") + last + "endsolid\n",
        two + "line 9 (a vertex is (nan, 1, 0))"));
    // What is left must be a mesh, and other damage stays an error.
    const TemporaryFolder folder;
    check_throws(invalid, {"no triangle", "1 face with a vertex"},
                 [&] { read_mesh(folder.file("a.obj", "v 0 0 0\nf 1 1 2\n"), {.skip_bad_facets = true}); });
    check_throws(unreadable, {"line 4", "'x'"}, [&] {
        read_mesh(folder.file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n"), {.skip_bad_facets = true});
    });
}

BOOST_AUTO_TEST_CASE(a_bad_facet_of_a_text_stl_of_many_megabytes_has_its_line) {
    std::string text = "solid\n";
    for (int t = 0; t < 20000; ++t)
        text += fmt::format(
            "facet normal 0 0 1\n outer loop\n  vertex {0} 0 0\n  vertex {1} 0 0\n  vertex {0} {0} 1\n "
            "endloop\nendfacet\n",
            t, t == 19000 ? "nan" : fmt::format("{}", t + 1));
    const Mesh mesh =
        read_without_bad_facets("a.stl", text + "endsolid\n",
                                "1 face with a vertex that does not exist or is not finite is left out, the "
                                "first at line 133002 (a vertex is (nan, 0, 0))");
    BOOST_TEST(mesh.triangles().size() == 19999U);
}

BOOST_AUTO_TEST_CASE(a_cloud_of_points_is_named) {
    const std::vector<std::string> fragments{"no triangle", "; its 3 vertices are a cloud of points",
                                             "reconstruct a surface", "POINTS of clsdf query"};
    check_is_refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", invalid, fragments);
    check_is_refused("a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", invalid, fragments);
    check_is_refused("a.ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                     "element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n",
                     invalid, fragments);
}

BOOST_AUTO_TEST_CASE(a_decimal_comma_is_named) {
    check_is_refused("a.off", "OFF\n4 2 5\n" + replaced(off_body, "1 0 0", "1,0 0 0"), unreadable,
                     {"line 4", "'1,0'", "decimal point, not a comma"});
    check_is_refused("a.obj", "v 0,000000e+00 0 0\n", unreadable, {"line 1", "'0,000000e+00'", "not a comma"});
}

BOOST_AUTO_TEST_CASE(several_files_are_read_as_one_mesh) {
    const TemporaryFolder folder;
    const Mesh cube = make_shape("cube"), torus = make_shape("torus");
    const std::vector<std::string> paths{folder.file("cube.stl"), folder.file("torus.off"), folder.file("again.ply")};
    for (std::size_t i = 0; i < 3; ++i) write_mesh(i == 1 ? torus : cube, paths[i]);
    const Mesh all = read_meshes(paths);
    BOOST_TEST(all.triangles().size() == 2 * cube.triangles().size() + torus.triangles().size());
    std::size_t triangle = 0;
    std::uint32_t vertex = 0;
    for (const std::string& path : paths) {
        const Mesh part = read_mesh(path);
        for (const Triangle& t : part.triangles()) {
            const Triangle expected{t[0] + vertex, t[1] + vertex, t[2] + vertex};
            BOOST_REQUIRE((all.triangles()[triangle++] == expected));
        }
        for (const Vec3& position : part.vertices()) BOOST_REQUIRE((all.vertices()[vertex++] == position));
    }
    BOOST_TEST(read_meshes(std::span(paths).first(1)).hash() == read_mesh(paths[0]).hash());
    BOOST_TEST(all.name() == paths[0] + " + " + paths[1] + " + " + paths[2]);
    check_throws(ErrorCode::invalid_argument, {"no file"}, [] { read_meshes({}); });
    check_throws(unreadable, {"none.off"}, [&] { read_meshes(std::vector{paths[0], folder.file("none.off")}); });
}
