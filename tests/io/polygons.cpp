#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>

#include "written_files.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

using Corner = std::array<double, 2>;
using Outline = std::vector<Corner>;

/// An outline in the plane z = 0, and in a plane that is parallel to no axis: a rotation, so that areas stay.
Vec3 flat(const Corner& c) {
    return {c[0], c[1], 0};
}
Vec3 tilted(const Corner& c) {
    return {c[0] * 2 / 3 - c[1] / 3, c[0] / 3 - c[1] * 2 / 3, c[0] * 2 / 3 + c[1] * 2 / 3};
}

std::string obj_of(const Outline& outline, Vec3 (*place)(const Corner&)) {
    std::string text, face = "f";
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const auto [x, y, z] = place(outline[i]);
        text += fmt::format("v {} {} {}\n", x, y, z);
        face += fmt::format(" {}", i + 1);
    }
    return text + face + "\n";
}

double signed_area(const Outline& outline) {
    double twice = 0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Corner &a = outline[i], &b = outline[(i + 1) % outline.size()];
        twice += a[0] * b[1] - a[1] * b[0];
    }
    return twice / 2;
}

/// Rows of a lattice, all from left to right: an outline that crosses itself, with an ear at nearly every corner.
Outline rows(int corners) {
    Outline outline;
    for (int i = 0; i < corners; ++i) outline.push_back({1.0 * (i % 447), 1.0 * (i / 447)});
    return outline;
}

/// One facet, and a triangle before it.
std::string stl_of(const Outline& outline) {
    std::string text = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 9\nvertex 1 0 9\nvertex 0 1 9\nendloop\n";
    text += "endfacet\nfacet normal 0 0 1\nouter loop\n";
    for (const Corner& corner : outline) text += fmt::format("vertex {} {} 0\n", corner[0], corner[1]);
    return text + "endloop\nendfacet\nendsolid\n";
}

/// The areas of triangles, along one normal: negative for those that face the other way.
std::vector<double> areas_of(const Mesh& mesh, const Vec3& normal) {
    std::vector<double> areas;
    for (const Triangle& t : mesh.triangles()) {
        const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
        double area = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
            area += normal[i] * ((b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j])) / 2;
        }
        areas.push_back(area);
    }
    return areas;
}

void check_areas(const Mesh& mesh, const Outline& outline, const Vec3& normal, double tolerance = 1e-12) {
    const double area = signed_area(outline);
    double sum = 0;
    for (const double part : areas_of(mesh, normal)) {
        BOOST_TEST(part * area >= -1e-12);
        sum += part;
    }
    BOOST_TEST(mesh.triangles().size() == outline.size() - 2);
    BOOST_TEST(sum == area, boost::test_tools::tolerance(tolerance));
}

/// From every first corner, in both windings, in both planes: triangles of the outline's winding with its area. As
/// they all face one way, they overlap nowhere.
void check_is_covered_once(const char* name, Outline outline) {
    for (int winding = 0; winding < 2; ++winding) {
        for (std::size_t first = 0; first < outline.size(); ++first) {
            BOOST_TEST_CONTEXT(name << ", winding " << winding << ", corner " << first) {
                const TemporaryFolder folder;
                check_areas(read_mesh(folder.file("a.obj", obj_of(outline, flat))), outline, {0, 0, 1});
                check_areas(read_mesh(folder.file("b.obj", obj_of(outline, tilted))), outline,
                            {2.0 / 3, -2.0 / 3, -1.0 / 3});
            }
            std::rotate(outline.begin(), outline.begin() + 1, outline.end());
        }
        std::reverse(outline.begin(), outline.end());
    }
}

const Outline l_shape{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};

Outline star(int points) {
    Outline outline;
    for (int i = 0; i < 2 * points; ++i) {
        const double angle = std::numbers::pi * i / points, radius = i % 2 == 0 ? 3 : 1;
        outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    return outline;
}

/// Its back has a corner behind each tooth and each gap.
Outline comb(int teeth) {
    Outline outline;
    for (int i = 0; i <= 2 * teeth; ++i) outline.push_back({1.0 * i, 0});
    for (int i = teeth; i-- > 0;) {
        const double x = 2 * i;
        for (const Corner& corner : {Corner{x + 2, 1}, Corner{x + 1, 1}, Corner{x + 1, 5}, Corner{x, 5}})
            outline.push_back(corner);
    }
    return outline;
}

/// step: the angle between corners.
Outline spiral(int corners, double step = 0.7) {
    Outline outline;
    const auto add = [&](double radius, double angle) {
        outline.push_back({(radius + angle * 2 / 7) * std::cos(angle), (radius + angle * 2 / 7) * std::sin(angle)});
    };
    for (int i = 0; i < corners; ++i) add(1, step * i);
    for (int i = corners; i-- > 0;) add(0.6, step * i);
    return outline;
}

std::vector<Triangle> triangles_of(const std::string& name, const std::string& content) {
    const TemporaryFolder folder;
    return read_mesh(folder.file(name, content)).triangles();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_polygon_is_covered_once_by_triangles_of_its_winding) {
    check_is_covered_once("l", l_shape);
    check_is_covered_once("dart", {{0, 0}, {2, 3}, {0, 1}, {-2, 3}});
    check_is_covered_once("star", star(7));
    check_is_covered_once("comb", comb(6));
    check_is_covered_once("spiral", spiral(30));
    // A hole, joined to the outline by an edge in both directions.
    check_is_covered_once("frame", {{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}});
    // Equal corners, in a row and apart; an edge there and back.
    check_is_covered_once("repeated", {{0, 0}, {2, 0}, {2, 1}, {2, 1}, {1, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 2}});
    check_is_covered_once("spike", {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {1, 3}, {1, 2}, {0, 2}});
}

BOOST_AUTO_TEST_CASE(a_polygon_stays_a_fan_if_the_fan_is_right_or_if_nothing_is) {
    const auto fan = [](std::uint32_t corners) {
        std::vector<Triangle> triangles;
        for (std::uint32_t k = 2; k < corners; ++k) triangles.push_back({0, k - 1, k});
        return triangles;
    };
    const auto is_fan = [&](const Outline& outline) {
        return triangles_of("a.obj", obj_of(outline, flat)) == fan(static_cast<std::uint32_t>(outline.size()));
    };
    Outline round;
    for (int i = 0; i < 20; ++i) round.push_back({std::cos(0.3 * i), std::sin(0.3 * i)});
    BOOST_TEST(is_fan(round));
    BOOST_TEST(is_fan({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 2}, {0, 2}}));
    BOOST_TEST(is_fan({{1, 1}, {1, 2}, {0, 2}, {0, 0}, {2, 0}, {2, 1}}));
    // It crosses itself, without area and with some; it has no area; its coordinates are not finite or overflow.
    BOOST_TEST(is_fan({{0, 0}, {1, 1}, {1, 0}, {0, 1}}));
    BOOST_TEST(is_fan({{0, 0}, {2, 2}, {2, 0}, {0, 1}}));
    BOOST_TEST(is_fan({{0, 0}, {1, 0}, {3, 0}, {2, 0}, {1, 0}}));
    BOOST_TEST(is_fan({{1, 1}, {1, 1}, {1, 1}, {1, 1}}));
    BOOST_TEST(is_fan({{1e308, 0}, {-1e308, 0}, {-1e308, -1e308}, {0, -1e307}}));
    const TemporaryFolder folder;
    check_throws(invalid, {"nan"},
                 [&] { read_mesh(folder.file("a.obj", "v 0 0 0\nv 1 nan 0\nv 1 1 inf\nv 0 1 0\nf 1 2 3 4\n")); });
}

BOOST_AUTO_TEST_CASE(polygons_of_all_formats_are_triangulated_alike_from_the_smallest_to_the_largest) {
    const Outline from_behind{{2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 0}};
    for (const double size : {1e-300, 1e-30, 1.0, 1e30, 1e300}) {
        BOOST_TEST_CONTEXT("size " << size) {
            std::string off = "OFF\n6 1 0\n", obj = "f 1 2 3 4 5 6\n",
                        ply =
                            "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
                            "element vertex 6\nproperty double x\nproperty double y\nproperty double z\nend_header\n"
                            "6 0 1 2 3 4 5\n",
                        stl = "solid a\nfacet normal 0 0 1\nouter loop\n";
            for (const Corner& corner : from_behind) {
                const std::string line = fmt::format("{} {} 0\n", size * corner[0], size * corner[1]);
                off += line;
                obj += "v " + line;
                ply += line;
                stl += "vertex " + line;
            }
            const std::vector<Triangle> expected = triangles_of("a.obj", obj);
            BOOST_TEST(
                std::ranges::count_if(expected, [](const Triangle& t) { return std::ranges::count(t, 2U) > 0; }) == 4);
            BOOST_CHECK(triangles_of("a.off", off + "6 0 1 2 3 4 5\n") == expected);
            BOOST_CHECK(triangles_of("a.ply", ply) == expected);
            BOOST_CHECK(triangles_of("a.stl", stl + "endloop\nendfacet\nendsolid a\n") == expected);
        }
    }
}

BOOST_AUTO_TEST_CASE(outlines_of_thousands_of_corners_are_covered_once) {
    const TemporaryFolder folder;
    for (const Outline& outline : {star(10000), comb(2500), spiral(10000, 0.01)})
        for (const auto& [place, normal] : {std::pair(&flat, Vec3{0, 0, 1}), {&tilted, {2.0 / 3, -2.0 / 3, -1.0 / 3}}})
            check_areas(read_mesh(folder.file("a.obj", obj_of(outline, place))), outline, normal, 1e-11);
}

BOOST_AUTO_TEST_CASE(an_outline_whose_ears_take_too_many_steps_becomes_a_fan_with_a_warning) {
    const TemporaryFolder folder;
    const Outline outline = rows(20000);
    const std::string triangle = "v 0 0 9\nv 1 0 9\nv 0 1 9\nf -3 -2 -1\n";
    for (const std::string& path : {folder.file("a.obj", obj_of(outline, flat) + triangle + "f -3 -1 -2\n"),
                                    folder.file("a.stl", stl_of(outline))}) {
        std::vector<std::string> messages;
        const Mesh mesh = read_mesh(path, {.log = [&](const std::string& message) { messages.push_back(message); }});
        const std::size_t first = path.ends_with(".stl") ? 1 : 0;
        BOOST_TEST_REQUIRE(messages.size() == 1U);
        BOOST_TEST(messages[0] ==
                   fmt::format("{}: 1 polygon becomes a fan, whose triangles may overlap, because ears were not found "
                               "within a limit of steps; divide it into triangles beforehand (it is that of triangle "
                               "{}, with 20000 corners)",
                               path, first));
        BOOST_TEST((mesh.triangles()[first + 10][0] == mesh.triangles()[first][0]));
    }
}
