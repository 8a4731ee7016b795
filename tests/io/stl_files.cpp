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

std::string binary_stl(const std::string& header, const std::vector<std::array<float, 9>>& triangles) {
    std::string content = header;
    content.resize(80, ' ');
    content += bytes_of(static_cast<std::uint32_t>(triangles.size()), std::endian::little);
    for (const auto& triangle : triangles) {
        content += std::string(12, '\0');
        for (const float x : triangle) content += bytes_of(x, std::endian::little);
        content += std::string(2, '\0');
    }
    return content;
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
    refused("endfacet\n", "", unreadable, {"line 8", "'endfacet'", "'endsolid'"});
    refused("endsolid a\n", "", unreadable, {"'endsolid'", "file ends"});
    refused(facet1, "", invalid, {"no triangle"});
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
    while (long_name.size() < (3U << 20))
        long_name += "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ";
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
    check_is_refused("a.stl", good.substr(0, good.size() - 9), unreadable, {"'endsolid'", "file ends"});
}

BOOST_AUTO_TEST_CASE(binary_stl_is_told_by_its_size_even_where_its_header_says_solid) {
    const std::vector<std::array<float, 9>> triangles{{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, -0.0F, 1, 0}};
    check_is_square("a.stl", binary_stl("made by hand", triangles));
    check_is_square("a.stl", binary_stl("solid but binary", triangles));
    const std::string solid = binary_stl("solid but binary", triangles);
    check_is_refused("a.stl", solid.substr(0, solid.size() - 1), unreadable, {"2 triangles", "184", "183"});
    check_is_square("a.stl", solid + "\n");
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
