#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "written_files.hpp"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <utility>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// attributes: the bytes behind each triangle, whose number stands in the two bytes before them.
std::string binary_stl(const std::string& header, const std::vector<std::array<float, 9>>& triangles,
                       const std::vector<std::string>& attributes = {}) {
    std::string content = header;
    content.resize(80, ' ');
    content += bytes_of(static_cast<std::uint32_t>(triangles.size()), std::endian::little);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        content += std::string(12, '\0');
        for (const float x : triangles[t]) content += bytes_of(x, std::endian::little);
        const std::string behind = t < attributes.size() ? attributes[t] : "";
        content += bytes_of(static_cast<std::uint16_t>(behind.size()), std::endian::little) + behind;
    }
    return content;
}

std::vector<std::array<float, 9>> corners_of(const Mesh& mesh) {
    std::vector<std::array<float, 9>> triangles;
    for (const Triangle& triangle : mesh.triangles()) {
        auto x = triangles.emplace_back().begin();
        for (const std::uint32_t corner : triangle)
            for (const double coordinate : mesh.vertices()[corner]) *x++ = static_cast<float>(coordinate);
    }
    return triangles;
}

}  // namespace

BOOST_AUTO_TEST_CASE(stl_is_written_in_single_precision_and_welded_when_it_is_read) {
    const TemporaryFolder folder;
    const Mesh mesh = make_shape("knot");
    write_mesh(mesh, folder.file("mesh.stl"));
    BOOST_TEST(content_of(folder.file("mesh.stl")).size() == 84 + 50 * mesh.triangles().size());
    const Mesh read = read_mesh(folder.file("mesh.stl"));
    BOOST_TEST(read.vertices().size() == mesh.vertices().size());
    BOOST_TEST(describe_topology(read).balanced);
    BOOST_REQUIRE(read.triangles().size() == mesh.triangles().size());
    for (std::size_t t = 0; t < read.triangles().size(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis)
                if (read.vertices()[read.triangles()[t][k]][axis] !=
                    static_cast<double>(static_cast<float>(mesh.vertices()[mesh.triangles()[t][k]][axis])))
                    BOOST_ERROR("a corner of triangle " << t << " has moved");
}

BOOST_AUTO_TEST_CASE(text_stl_is_read_and_welded) {
    const std::string facet1 =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n";
    const std::string facet2 =
        "  FACET NORMAL nan nan nan\n\tOUTER LOOP\n VERTEX 0 0 0\n VERTEX 1.0 1e0 0\n VERTEX -0 1 0\n ENDLOOP\n "
        "ENDFACET\n";
    check_is_square("a.stl", "solid\n" + facet1 + facet2 + "endsolid\n");
    check_is_square("a.stl", "solid facet of a name\n" + facet1 + facet2 + "endsolid facet of a name");
    check_is_square("a.stl", "solid a\n" + facet1 + "endsolid a\n\nsolid b\n" + facet2 + "endsolid b\n");
    check_is_square("a.stl", with_line_ends("solid a\n" + facet1 + facet2 + "endsolid a\n", "\r\n"));

    const std::string good = "solid a\n" + facet1 + "endsolid a\n";
    const auto refused = [&](const std::string& from, const std::string& to, ErrorCode code,
                             std::vector<std::string> fragments) {
        check_is_refused("a.stl", replaced(good, from, to), code, std::move(fragments));
    };
    refused("facet normal", "face normal", unreadable, {"line 2", "'face'"});
    refused("normal 0 0 1", "normal 0 0", unreadable, {"line 3"});
    refused("vertex 1 0 0", "vertex 1 0", unreadable, {"line 5", "line ends"});
    refused("vertex 1 0 0", "vertex 1 0 inf", invalid, {"line 5", "inf"});
    refused("vertex 1 0 0\n", "", unreadable, {"three vertices"});
    refused("endloop\n", "", unreadable, {"line 7", "'endloop'", "'endfacet'"});
    refused("endfacet\nendsolid a\n", "end", unreadable, {"line 8", "'endfacet'", "'end'"});
    refused(facet1, "", invalid, {"no triangle"});
    refused("endsolid a\n",
            "endsolid a facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n",
            unreadable, {"'solid'", "'facet'"});
    check_is_refused("a.stl", "solid", unreadable, {"file ends"});
}

BOOST_AUTO_TEST_CASE(text_stl_of_many_megabytes_is_read_as_it_is_one_facet_after_the_other) {
    constexpr int count = 20000;
    const auto text_of = [](int solid_facets, const std::string& name) {
        std::string text = "solid " + name + "\n";
        for (int t = 0; t < count; ++t) {
            if (t > 0 && t % solid_facets == 0) text += "endsolid\nsolid " + name + "\n";
            text += fmt::format(
                "facet normal 0 0 1\n outer loop\n  vertex {0} 0 0\n  vertex {1} 0 0\n  vertex {0} {0} 1\n endloop\n"
                "endfacet\n",
                t, t + 1);
        }
        return text + "endsolid\n";
    };
    const TemporaryFolder folder;
    std::string long_name;
    while (long_name.size() < (3U << 20)) long_name += "facet normal 0 0 1 outer vertex 0 0 0 endfacet ";
    for (const auto& [solid_facets, name] : {std::pair(count, std::string("one")), std::pair(3000, std::string("many")),
                                             std::pair(3, std::string("endfacet")), std::pair(15000, long_name)}) {
        const std::string text = text_of(solid_facets, name);
        BOOST_TEST(text.size() > (2U << 20));
        const Mesh mesh = read_mesh(folder.file("a.stl", text));
        BOOST_TEST_REQUIRE(mesh.triangles().size() == std::size_t{count});
        bool is_same = true;
        for (int t = 0; t < count; ++t) {
            const std::array<Vec3, 3> expected{Vec3{1.0 * t, 0, 0}, Vec3{t + 1.0, 0, 0}, Vec3{1.0 * t, 1.0 * t, 1}};
            for (std::size_t k = 0; k < 3; ++k)
                is_same = is_same && mesh.vertices()[mesh.triangles()[static_cast<std::size_t>(t)][k]] == expected[k];
        }
        BOOST_TEST(is_same);
    }
    const std::string good = text_of(count, "one");
    check_is_refused("a.stl", replaced(good, "vertex 19000 0 0", "vertx 19000 0 0"), unreadable,
                     {"line 132998", "'vertx'"});
    // What is irregular has its line.
    std::vector<std::string> warnings;
    const auto log = [&](const std::string& warning) { warnings.push_back(warning); };
    std::string irregular =
        replaced(good.substr(0, good.size() - 9), "vertex 19000 0 0\n", "vertex 19000 0 0\n# text\n");
    irregular.append(1000, '\0');
    BOOST_TEST(read_mesh(folder.file("a.stl", irregular), {.log = log}).triangles().size() == std::size_t{count});
    BOOST_TEST_REQUIRE(warnings.size() == 3U);
    BOOST_TEST(warnings[0].ends_with("the text ends without 'endsolid' and may be cut off, at line 140002"));
    BOOST_TEST(warnings[1].ends_with("1 comment is skipped, at line 132999"));
    BOOST_TEST(warnings[2].ends_with("1000 bytes of zeros or Ctrl-Z after the text are skipped"));
}

BOOST_AUTO_TEST_CASE(binary_stl_is_told_by_its_size_even_where_its_header_says_solid) {
    const std::vector<std::array<float, 9>> triangles{{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, -0.0F, 1, 0}};
    check_is_square("a.stl", binary_stl("made by hand", triangles));
    check_is_square("a.stl", binary_stl("solid but binary", triangles));
    const std::string solid = binary_stl("solid but binary", triangles);
    check_is_refused("a.stl", solid.substr(0, solid.size() - 1), unreadable, {"2 triangles", "184", "183"});
    check_is_refused("a.stl", solid + std::string(50, 'x'), unreadable, {"2 triangles", "184", "234"});
    check_is_refused("a.stl", solid.substr(0, 100), unreadable, {"2 triangles"});
    check_is_refused("a.stl", solid.substr(0, 83), unreadable, {"83"});
    check_is_refused("a.stl", binary_stl("", {}), invalid, {"no triangle"});
    std::string vast = binary_stl("vast", {});
    vast.replace(80, 4, "\xFF\xFF\xFF\xFF");
    check_is_refused("a.stl", vast, unreadable, {"4294967295"});
    const float nan = std::numeric_limits<float>::quiet_NaN();
    check_is_refused("a.stl", binary_stl("", {{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, nan, 1, 0, 0, 1, 0}}), invalid,
                     {"triangle 1", "nan"});
}

BOOST_AUTO_TEST_CASE(bytes_after_the_last_triangle_of_a_binary_stl_are_skipped_if_the_triangles_are_those_of_a_mesh) {
    const TemporaryFolder folder;
    std::string warning;
    const auto read = [&](const std::string& content, bool skip_bad_facets = false) {
        warning.clear();
        const auto log = [&](const std::string& text) { warning += text; };
        return read_mesh(folder.file("a.stl", content), {.log = log, .skip_bad_facets = skip_bad_facets});
    };
    const std::vector<std::array<float, 9>> cube = corners_of(make_shape("cube"));
    const std::string whole = binary_stl("cube", cube);
    const std::uint64_t hash = read(whole).hash();
    BOOST_TEST(warning == "");
    for (const std::string& after : {std::string("\n"), std::string(3, '\0'), std::string(49, 'x')}) {
        BOOST_TEST(read(whole + after).hash() == hash);
        BOOST_TEST(warning.ends_with(after.size() == 1
                                         ? "1 byte after the last triangle is skipped"
                                         : fmt::format("{} bytes after the last triangle are skipped", after.size())));
    }
    // Colours stand where the number of attribute bytes stands.
    std::string coloured = whole;
    for (std::size_t t = 0; t < cube.size(); ++t) coloured.replace(84 + 50 * t + 48, 2, "\xFF\x7F");
    BOOST_TEST(read(coloured).hash() == hash);
    BOOST_TEST(read(coloured + "\n").hash() == hash);

    // The bytes are attributes, which stand behind each triangle or at the end.
    const auto refused = [&](const std::string& content, const std::vector<std::string>& fragments) {
        for (const bool skip_bad_facets : {false, true})
            check_throws(unreadable, fragments, [&] { read(content, skip_bad_facets); });
    };
    const std::vector<std::string> four_each(cube.size(), "abcd"), one_has_them{"", "", "", "123"};
    refused(binary_stl("cube", cube, four_each),
            {"12 triangles", "684", "732", "attributes of 48 bytes", "without attributes"});
    refused(binary_stl("cube", cube, one_has_them), {"684", "687", "attributes of 3 bytes"});
    refused(binary_stl("cube", cube, std::vector<std::string>(cube.size(), "12345678")), {"attributes of 96 bytes"});
    std::string at_the_end = whole + "12345";
    at_the_end.replace(84 + 48, 2, std::string("\3\0\0", 2)).replace(84 + 98, 2, std::string("\2\0", 2));
    refused(at_the_end, {"684", "689", "attributes of 5 bytes"});

    // Bytes that are added or lost move all coordinates after them.
    auto with = [&](float x) {
        std::vector<std::array<float, 9>> triangles = cube;
        triangles[7][4] = x;
        return binary_stl("cube", triangles);
    };
    BOOST_TEST(read(with(9e5F) + "\n").triangles().size() == 12U);
    refused(with(3e6F) + "\n", {"684", "685", "3e+06", "median edge", "sent as text"});
    BOOST_TEST(read(with(3e6F)).triangles().size() == 12U);
    for (const float x : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()})
        refused(with(x) + "\n", {"684", "685", "not finite", "sent as text"});
    // Far from the origin a mesh is as good as there.
    std::vector<std::array<float, 9>> far = cube;
    for (auto& triangle : far)
        for (float& x : triangle) x += 4e6F;
    BOOST_TEST(read(binary_stl("far", far) + "\n").triangles().size() == 12U);
    std::string slipped = whole;
    slipped.insert(300, "\r");
    refused(slipped, {"684", "685", "sent as text"});
}
