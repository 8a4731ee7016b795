#include "apps/process.hpp"

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

using clsdf::test::check_refused;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;

BOOST_AUTO_TEST_SUITE(info)

BOOST_AUTO_TEST_CASE(counts_the_saddles_and_gaps_of_the_papers_table_without_a_device) {
    const TemporaryFolder folder;
    const std::string torus = folder.file("torus.off");
    BOOST_TEST(run_command({"shape", "torus", "-o", torus}).status == 0);
    const Outcome outcome = run_command({"info", torus, "--json", "--self-intersections"}, no_devices);
    BOOST_TEST(outcome.status == 0);
    const nlohmann::json found = nlohmann::json::parse(outcome.out);
    BOOST_TEST(found["mesh"] == torus);
    BOOST_TEST(found["vertices"] == 3000);
    BOOST_TEST(found["saddle_vertices"] == 1788);
    BOOST_TEST(found["gaps"]["adjacent_pairs"] == 0);
    BOOST_TEST(found["gaps"]["all_pairs"] == 0);
    BOOST_TEST(found["defects"]["closed"] == true);
    BOOST_TEST(found["defects"]["components"] == 1);
    BOOST_TEST(found["defects"]["self_intersections"] == 0);
}

BOOST_AUTO_TEST_CASE(tells_defects_in_words) {
    const TemporaryFolder folder;
    const std::string open =
        folder.file("open.off", "OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n2 0 0\n9 9 9\n3 0 1 2\n3 0 1 3\n3 1 0 2\n");
    const Outcome outcome = run_command({"info", open}, no_devices);
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(outcome.out.empty());
    for (const char* fragment : {"open", "1 unused", "1 faces without area", "1 duplicate", "1 non-manifold,"})
        BOOST_TEST(outcome.error.find(fragment) != std::string::npos, "no '" << fragment << "' in " << outcome.error);
    check_refused(run_command({"info", folder.file("missing.off")}, no_devices), 3, {"missing.off"});
    const Outcome intersections = run_command({"info", open, "--self-intersections"}, no_devices);
    BOOST_TEST(intersections.status == 0);
    BOOST_TEST(intersections.error.find("2 pairs of triangles intersect") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(lists_the_groups_with_their_faces_areas_and_boxes) {
    const TemporaryFolder folder;
    const std::string vertices = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 5\n";
    const std::string mesh = folder.file("a.obj", vertices + "g floor\nf 1 2 3\ng wall\nf 1 2 4\nf 1 4 3\n");
    const Outcome outcome = run_command({"info", mesh, "--json"}, no_devices);
    BOOST_TEST(outcome.status == 0);
    const nlohmann::json groups = nlohmann::json::parse(outcome.out)["groups"];
    BOOST_REQUIRE(groups.size() == 2U);
    BOOST_TEST(
        groups[0] ==
        nlohmann::json(
            {{"name", "floor"}, {"faces", 1}, {"area", 2.0}, {"lower", {0.0, 0.0, 0.0}}, {"upper", {2.0, 2.0, 0.0}}}));
    BOOST_TEST(groups[1]["faces"] == 2);
    BOOST_TEST(groups[1]["area"] == 10.0);
    BOOST_TEST(groups[1]["upper"] == nlohmann::json({2.0, 2.0, 5.0}));
    BOOST_TEST(outcome.error.find("groups    1") == std::string::npos);
    for (const char* line : {"groups    0   'floor': 1 face, area 2, from (0, 0, 0) to (2, 2, 0)\n",
                             "          1   'wall': 2 faces, area 10, from (0, 0, 0) to (2, 2, 5)\n"})
        BOOST_TEST(outcome.error.find(line) != std::string::npos, outcome.error);
    const std::string none = folder.file("b.obj", vertices + "f 1 2 3\n");
    BOOST_TEST(nlohmann::json::parse(run_command({"info", none, "--json"}, no_devices).out)["groups"].empty());
    const std::string ply =
        folder.file("a.ply",
                    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                    "element face 1\nproperty int id\nproperty list uchar int vertex_indices\nend_header\n"
                    "0 0 0\n1 0 0\n0 1 0\n17 3 0 1 2\n");
    BOOST_TEST(nlohmann::json::parse(
                   run_command({"info", ply, "--group-by", "id", "--json"}, no_devices).out)["groups"][0]["name"] ==
               "17");
}

BOOST_AUTO_TEST_CASE(says_what_decides_the_sign) {
    const TemporaryFolder folder;
    const auto info = [&](const std::vector<std::string>& triangles) {
        std::string text = fmt::format("OFF\n5 {} 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n", triangles.size());
        for (const std::string& triangle : triangles) text += "3 " + triangle + "\n";
        const std::string path = folder.file("a.off", text);
        const Outcome shown = run_command({"info", path}, no_devices);
        return std::pair(nlohmann::json::parse(run_command({"info", path, "--json"}, no_devices).out), shown.error);
    };
    const auto has = [](const std::string& text, const std::string& part) {
        BOOST_TEST(text.find(part) != std::string::npos, "no '" << part << "' in " << text);
    };
    const std::vector<std::string> closed{"0 2 1", "0 1 3", "1 2 3", "0 3 2"};
    auto [doubled, text] = info({closed[0], closed[1], closed[2], closed[3], closed[2]});
    BOOST_TEST(doubled["defects"]["uncounted_faces"] == 1);
    BOOST_TEST(doubled["warnings"].size() == 1U);
    has(text, "1 doubled face not counted");
    has(text, "warning: for the sign, 1 face is there twice");
    has(info({closed[0], "0 3 1", closed[2], closed[3]}).second, "1 face turned around");
    const auto [open, of_open] = info({closed[0], closed[1], closed[2]});
    BOOST_TEST(open["defects"]["open_edges"] == 3);
    has(of_open, "open: 3 edges with one face\n");
    has(of_open, "warning: the mesh is not closed");
    // A wall of one face between two tetrahedra.
    const auto [walled, of_walled] = info({closed[0], closed[1], closed[2], closed[3], "1 2 4", "2 3 4", "3 1 4"});
    BOOST_TEST(walled["defects"]["boundary_edges"] == 0);
    BOOST_TEST(walled["defects"]["inner_wall_faces"] == 1);
    BOOST_TEST(walled["defects"]["sheet_faces"] == 1);
    has(of_walled, "1 face left out");
    has(of_walled, "warning: for the sign, 1 face of inner walls is left out");
}

BOOST_AUTO_TEST_SUITE_END()
