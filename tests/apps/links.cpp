#include "apps/process.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A cube of half side 1, whose walls lie a quarter of a voxel beyond samples.
struct Inputs {
    TemporaryFolder folder;
    std::string mesh = folder.file("cube.off");
    std::vector<std::string> grid{"--size", "12", "--origin", "-2.25,-2.25,-2.25", "--spacing", "0.5"};

    Inputs() { write_mesh(cube(1), mesh); }

    nlohmann::json run(std::vector<std::string> arguments) const {
        arguments.insert(arguments.end(), grid.begin(), grid.end());
        arguments.emplace_back("--json");
        const Outcome outcome = run_command(arguments);
        BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.out << outcome.error);
        return nlohmann::json::parse(outcome.out);
    }
};

}  // namespace

BOOST_AUTO_TEST_CASE(links_are_written_in_each_format) {
    const Inputs inputs;
    const DistanceTransform transform(Device::strongest(), cube(1));
    const Links links =
        transform.links({{-2.25, -2.25, -2.25}, {0.5, 0.5, 0.5}, {12, 12, 12}, {}}, stencil("D3Q19", "OpenLB"));
    const std::string npy = inputs.folder.file("links.npy"), npz = inputs.folder.file("links.npz");
    const nlohmann::json report =
        inputs.run({"links", inputs.mesh, "-o", npy, "--directions", "D3Q19", "--order", "OpenLB"});
    BOOST_TEST(report["links"] == links.size());
    BOOST_TEST(report["directions"].size() == 19U);
    const std::string rows = content_of(npy);
    constexpr std::size_t row = 30;
    BOOST_REQUIRE(rows.size() > row * links.size());
    const char* at = rows.data() + rows.size() - row * links.size();
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < links.size(); ++n, at += row)
        wrong += std::memcmp(at, links.samples[n].data(), 12) != 0 || std::memcmp(at + 13, &links.q[n], 8) != 0 ||
                 std::memcmp(at + 21, &links.triangles[n], 4) != 0;
    BOOST_TEST(wrong == 0);
    inputs.run({"links", inputs.mesh, "-o", npz, "--directions", "D3Q19", "--order", "OpenLB"});
    const std::string archive = content_of(npz);
    BOOST_TEST(archive.substr(0, 4) == std::string("PK\x03\x04"));
    const std::string q(reinterpret_cast<const char*>(links.q.data()), 8 * links.size());
    BOOST_TEST((archive.find(q) != std::string::npos));
    // Samples and directions are whole numbers.
    const std::size_t samples = archive.find("samples.npy"), stencil = archive.find("stencil.npy");
    BOOST_TEST((archive.find("'<i4'", samples) < archive.find("directions.npy", samples)));
    BOOST_TEST((archive.find("'<i4'", stencil) < archive.find("inside.npy", stencil)));
    inputs.run({"links", inputs.mesh, "-o", inputs.folder.file("links.h5")});
    BOOST_TEST((content_of(inputs.folder.file("links.h5")).find("samples") != std::string::npos));
    const Outcome outcome = run_command({"links", inputs.mesh, "-o", inputs.folder.file("links.csv")});
    BOOST_TEST(outcome.status != 0);
    BOOST_TEST((outcome.error.find(".npz") != std::string::npos));
}

namespace {

/// A solid of an STL file in ASCII.
std::string solid(const std::string& name, const std::vector<std::array<Vec3, 3>>& triangles) {
    std::string text = "solid " + name + '\n';
    for (const auto& triangle : triangles) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const Vec3& v : triangle) text += fmt::format("vertex {} {} {}\n", v[0], v[1], v[2]);
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid " + name + '\n';
}

/// A square duct about z whose corners lie on the axes, as one file of three solids, and a block around it as another.
struct Duct {
    static constexpr double radius = 2, length = 50, spacing = 0.25;
    TemporaryFolder folder;
    std::string duct = folder.file("duct.stl"), block = folder.file("block.stl");
    std::vector<std::string> grid{"--size", "25,25,209", "--origin", "-3,-3,-1", "--spacing", "0.25"};

    Duct() {
        const auto corner = [](std::size_t i, double z) {
            const std::array<double, 5> along{radius, 0, -radius, 0, radius};
            return Vec3{along[i % 4], along[(i + 3) % 4], z};
        };
        std::vector<std::array<Vec3, 3>> wall;
        for (std::size_t i = 0; i < 4; ++i) {
            wall.push_back({corner(i, 0), corner(i + 1, 0), corner(i + 1, length)});
            wall.push_back({corner(i, 0), corner(i + 1, length), corner(i, length)});
        }
        const auto lid = [&](double z, std::size_t a, std::size_t b) {
            return std::vector<std::array<Vec3, 3>>{{corner(0, z), corner(a, z), corner(b, z)},
                                                    {corner(2, z), corner(b + 2, z), corner(a + 2, z)}};
        };
        folder.file("duct.stl",
                    solid("wall", wall) + solid("inlet", lid(0, 3, 1)) + solid("outlet", lid(length, 1, 3)));
        write_mesh(box({-4, -4, -5}, {4, 4, 60}), block);
    }
};

template <typename Value>
Value value_at(const char* row, std::size_t at) {
    Value value;
    std::memcpy(&value, row + at, sizeof value);
    return value;
}

}  // namespace

BOOST_AUTO_TEST_CASE(links_in_a_duct_know_wall_inlet_and_outlet) {
    const Duct duct;
    const std::string npy = duct.folder.file("links.npy"), npz = duct.folder.file("links.npz");
    std::vector<std::string> arguments{"links",  duct.duct, duct.block, "-o",      npy,      "--sign",       "parity",
                                       "--with", "group",   "--json",   "--order", "OpenLB", "--directions", "D3Q27"};
    arguments.insert(arguments.end(), duct.grid.begin(), duct.grid.end());
    const Outcome outcome = run_command(arguments);
    BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
    const nlohmann::json report = nlohmann::json::parse(outcome.out);
    const auto names = report["groups"].get<std::vector<std::string>>();
    BOOST_TEST(names == (std::vector<std::string>{"duct/wall", "duct/inlet", "duct/outlet", "block"}),
               boost::test_tools::per_element());
    BOOST_TEST(outcome.error.find("groups  0 'duct/wall', 1 'duct/inlet'") != std::string::npos, outcome.error);
    const auto directions = report["directions"].get<std::vector<LinkDirection>>();
    const auto count = report["links"].get<std::size_t>();
    const std::string rows = content_of(npy);
    BOOST_TEST(rows.find("('triangle', '<u4'), ('group', '<u4'), ('count', '<u4')") != std::string::npos);
    constexpr std::size_t row = 34;
    BOOST_REQUIRE(rows.size() > row * count);
    const char* at = rows.data() + rows.size() - row * count;
    // The group is that of the part that the point of the wall lies on.
    std::array<std::size_t, 4> found{};
    std::size_t wrong = 0;
    std::string groups;
    for (std::size_t n = 0; n < count; ++n, at += row) {
        const LinkDirection& direction = directions.at(value_at<std::uint8_t>(at, 12));
        const auto q = value_at<double>(at, 13);
        const auto group = value_at<std::uint32_t>(at, 25);
        groups.append(at + 25, 4);
        Vec3 point;
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] =
                (axis == 2 ? -1 : -3) + Duct::spacing * (value_at<std::int32_t>(at, 4 * axis) + q * direction[axis]);
        const std::array<double, 3> distances{std::abs(std::abs(point[0]) + std::abs(point[1]) - Duct::radius),
                                              std::abs(point[2]), std::abs(point[2] - Duct::length)};
        if (group < 3) ++found[group];
        wrong += group >= 3 || distances[group] > 1e-9 || value_at<std::uint32_t>(at, 29) % 2 == 0 ? 1U : 0U;
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST(found[0] > 10000U);
    BOOST_TEST(found[1] > 500U);
    BOOST_TEST(found[2] > 500U);
    // The same column in an archive, and none unless it is asked for.
    arguments[4] = npz;
    BOOST_TEST(run_command(arguments).status == 0);
    const std::string archive = content_of(npz);
    BOOST_TEST(archive.find("groups.npy") != std::string::npos);
    BOOST_TEST((archive.find(groups) != std::string::npos));
    std::erase_if(arguments, [](const std::string& word) { return word == "--with" || word == "group"; });
    const nlohmann::json without = nlohmann::json::parse(run_command(arguments).out);
    BOOST_TEST(!without.contains("groups"));
    BOOST_TEST(content_of(npz).find("groups.npy") == std::string::npos);
}

BOOST_AUTO_TEST_CASE(crossings_and_links_have_the_groups_of_a_property) {
    const Inputs inputs;
    const std::string mesh = inputs.folder.file("cube.ply"), edges = inputs.folder.file("edges.npz");
    const Mesh solid = cube(1);
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
        "property double z\nelement face 12\nproperty list uchar int vertex_indices\nproperty int patch\n"
        "end_header\n";
    for (const Vec3& v : solid.vertices()) text += fmt::format("{} {} {}\n", v[0], v[1], v[2]);
    for (const Triangle& t : solid.triangles()) text += fmt::format("3 {} {} {} 7\n", t[0], t[1], t[2]);
    inputs.folder.file("cube.ply", text);
    const nlohmann::json report =
        inputs.run({"crossings", mesh, "-o", edges, "--group-by", "patch", "--with", "group"});
    BOOST_TEST(report["groups"] == std::vector<std::string>{"7"});
    const std::string archive = content_of(edges);
    for (const char* name : {"x_groups.npy", "y_groups.npy", "z_groups.npy"})
        BOOST_TEST(archive.find(name) != std::string::npos, name);
    BOOST_TEST(inputs.run({"links", mesh, "-o", edges, "--group-by", "patch", "--with", "group"})["groups"][0] == "7");
    check_refused(run_command({"links", inputs.mesh, "-o", edges, "--with", "group"}), 2,
                  {"--with group", "no groups"});
}

BOOST_AUTO_TEST_CASE(what_needs_a_sign_names_the_mesh_and_options_that_help) {
    const Inputs inputs;
    const std::string terrain = inputs.folder.file("terrain.off"), bowl = inputs.folder.file("bowl.off"),
                      rays = inputs.folder.file("rays.csv", "x,y,z,dx,dy,dz\n0,0,9,0,0,-1\n"),
                      out = inputs.folder.file("out.npz");
    write_mesh(Mesh({{0, 0, 2}, {4, 0, 2}, {4, 4, 2}, {0, 4, 2}}, {{0, 1, 2}, {0, 2, 3}}, ""), terrain);
    write_mesh(open_box({0, 0, 0}, {4, 4, 2}, 5), bowl);
    const auto check = [&](const std::vector<std::string>& arguments, const std::vector<std::string>& fragments) {
        for (const auto& [mesh, remedy] :
             {std::pair(terrain, "close the terrain by --sign below --floor Z"), {bowl, "close its surface"}})
            for (const std::string sign : {"auto", "none"}) {
                std::vector<std::string> all{arguments[0], mesh};
                all.insert(all.end(), arguments.begin() + 1, arguments.end());
                all.insert(all.end(), {"--sign", sign, "--quiet"});
                std::vector<std::string> texts = fragments;
                texts.insert(texts.end(), {mesh + ": the mesh has no sign with --sign " + sign,
                                           sign == "none" ? "choose another --sign" : remedy});
                const Outcome outcome = run_command(all);
                check_refused(outcome, 2, texts);
                for (const char* word : {"transform", "exact signs", "sign rule none would"})
                    BOOST_TEST(outcome.error.find(word) == std::string::npos, outcome.error);
            }
    };
    check({"links", "-o", out, "--resolution", "9"}, {"--hits walls needs one", "choose --hits faces"});
    check({"crossings", "-o", out, "--resolution", "9"}, {"crossings need one"});
    check({"rays", rays, "-o", inputs.folder.file("hits.csv")}, {"--hits walls needs one", "choose --hits faces"});
    const std::string field = inputs.folder.file("field.npy");
    check({"compute", "-o", field, "--resolution", "9", "--exact-signs"},
          {"--exact-signs needs one", "leave that out"});
    check({"compute", "-o", field, "--resolution", "9", "--band", "0", "--margin", "1"},
          {"--band 0, the signs alone, needs one", "give the band a width"});
    check({"query", inputs.folder.file("points.csv", "x,y,z\n0,0,0\n"), "-o", inputs.folder.file("d.csv"),
           "--positive-inside"},
          {"--positive-inside needs one"});
}

BOOST_AUTO_TEST_CASE(crossings_are_written_and_counted) {
    const Inputs inputs;
    const nlohmann::json report =
        inputs.run({"crossings", inputs.mesh, "-o", inputs.folder.file("edges.npz"), "--counts"});
    // 4 x 4 rows on each axis have samples inside, and two walls.
    BOOST_TEST(report["crossed"][0] == 32);
    BOOST_TEST(report["crossed"][2] == 32);
    BOOST_TEST((content_of(inputs.folder.file("edges.npz")).find("x_counts.npy") != std::string::npos));
}

BOOST_AUTO_TEST_CASE(links_of_faces_are_found_without_a_sign) {
    const Inputs inputs;
    const std::string npy = inputs.folder.file("links.npy");
    const auto count = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments{"links", inputs.mesh, "-o", npy};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return inputs.run(arguments)["links"].get<std::size_t>();
    };
    // From both ends; and 4 diagonal links touch each of 12 edges, where some of the eight looks meet a face.
    BOOST_TEST(count({"--sign", "none", "--hits", "faces"}) == 2 * (count({"--hits", "walls"}) + 12 * 4));
}

BOOST_AUTO_TEST_CASE(options_of_links_that_would_have_no_effect_are_refused) {
    const Inputs inputs;
    const auto refused = [&](std::vector<std::string> more, const std::vector<std::string>& texts) {
        std::vector<std::string> arguments{"links", inputs.mesh, "-o", inputs.folder.file("links.npy")};
        arguments.insert(arguments.end(), more.begin(), more.end());
        check_refused(run_command(arguments), 2, texts);
    };
    refused({"--between", "--hits", "faces"}, {"--between", "--hits faces", "leave out"});
    refused({"--order", "OpenLB", "--directions", "1,0,0,-1,0,0"}, {"--order OpenLB", "1,0,0,-1,0,0", "leave it out"});
    refused({"--hits", "corners"}, {"--hits", "walls", "faces"});
    refused({"--faces"}, {"--faces"});
}

BOOST_AUTO_TEST_CASE(the_margin_of_links_and_crossings_is_that_of_no_band) {
    for (const char* const subcommand : {"links", "crossings"}) {
        const std::string help = run_command({subcommand, "--help"}).out;
        const std::string line = help.substr(std::min(help.size(), help.find("--margin")), 200);
        BOOST_TEST(line.find("[5%]") != std::string::npos, line);
        BOOST_TEST(help.find("band") == std::string::npos, help);
    }
}
