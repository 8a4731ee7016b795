#include "apps/process.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/papers.hpp>

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

using clsdf::test::check_refused;
using clsdf::test::content_of;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;

BOOST_AUTO_TEST_SUITE(polyhedra)

BOOST_AUTO_TEST_CASE(are_written_for_the_triangles_around_the_first_gap_without_a_device) {
    const TemporaryFolder folder;
    const std::string knot = folder.file("knot.off");
    BOOST_TEST(run_command({"shape", "knot", "-o", knot}).status == 0);
    const clsdf::Mesh mesh = clsdf::read_mesh(knot);
    const std::uint32_t vertex = examine_saddles(mesh).gaps.front();
    for (const std::string ending : {".ply", ".off"}) {
        const std::string output = folder.file("polyhedra" + ending);
        const Outcome outcome =
            run_command({"polyhedra", knot, "-o", output, "--json", "--polyhedra", "peikert-sigg"}, no_devices);
        BOOST_TEST(outcome.status == 0);
        const nlohmann::json found = nlohmann::json::parse(outcome.out);
        BOOST_TEST(found["vertex"] == vertex);
        BOOST_TEST(std::abs(found["half_width"].get<double>() - 0.1 * mesh.box().longest_side()) < 1e-12);
        const std::vector<std::uint32_t> triangles = triangles_at(mesh, vertex);
        BOOST_TEST(found["polyhedra"].size() == triangles.size());
        std::size_t faces = 0;
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            BOOST_TEST(found["polyhedra"][i]["triangle"] == triangles[i]);
            BOOST_TEST(found["polyhedra"][i]["volume"].get<double>() > 0);
            faces += found["polyhedra"][i]["faces"].get<std::size_t>();
        }
        const clsdf::Mesh written = clsdf::read_mesh(output);
        BOOST_TEST(written.triangles().size() == faces);
        BOOST_TEST(describe_topology(written).balanced);
        const std::string head = content_of(output).substr(0, 400);
        BOOST_TEST((head.find("property uchar red") != std::string::npos) == (ending == ".ply"));
    }
}

BOOST_AUTO_TEST_CASE(are_those_asked_for) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("tetrahedron.off", tetrahedron);
    const std::string output = folder.file("polyhedra.ply");
    const auto written = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"polyhedra", mesh, "-o", output, "--json", "--quiet"});
        const Outcome outcome = run_command(arguments, no_devices);
        BOOST_TEST(outcome.status == 0);
        BOOST_TEST(outcome.error.empty());
        return nlohmann::json::parse(outcome.out)["polyhedra"];
    };
    const nlohmann::json two = written({"--triangles", "3,1", "--half-width", "0.25"});
    BOOST_REQUIRE(two.size() == 4U);
    BOOST_TEST(two[0]["triangle"] == 3);
    BOOST_TEST(two[0]["part"] == "front");
    BOOST_TEST(two[1]["part"] == "back");
    BOOST_TEST(two[2]["triangle"] == 1);
    // The outer polyhedron of triangle 1 has its area times the half width and more, because the solid is convex.
    BOOST_TEST(two[2]["volume"].get<double>() > 0.5 * 0.25);
    BOOST_TEST(written({"--around", "0"}).size() == 6U);
    const Outcome outcome = run_command({"polyhedra", "-o", output, "--triangles", "3,1", mesh}, no_devices);
    BOOST_TEST(outcome.status == 0, outcome.error);
    BOOST_TEST(written({"--around", "0", "--polyhedra", "peikert-sigg"}).size() == 3U);
}

BOOST_AUTO_TEST_CASE(that_cannot_be_had_are_refused_with_the_remedy) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("tetrahedron.off",
                                         "OFF\n5 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n9 9 9\n3 0 2 1\n"
                                         "3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    const std::string output = folder.file("polyhedra.ply");
    const auto refused = [&](std::vector<std::string> arguments, int status,
                             const std::vector<std::string>& fragments) {
        arguments.insert(arguments.begin(), {"polyhedra", mesh, "-o", output});
        check_refused(run_command(arguments, no_devices), status, fragments);
        BOOST_TEST(!std::filesystem::exists(output));
    };
    refused({"--around", "5"}, 2, {"no vertex 5", "0 to 4"});
    refused({"--around", "010"}, 2, {"no vertex 10"});
    refused({"--around", "4"}, 2, {"vertex 4", "no triangle", "choose another"});
    refused({"--triangles", "0,4"}, 2, {"no triangle 4", "0 to 3"});
    refused({"--triangles", "0", "--around", "0"}, 2, {"--around", "--triangles"});
    refused({"--no-closing"}, 2, {"--no-closing", "--polyhedra peikert-sigg"});
    refused({"--polyhedra", "mauch"}, 2, {"mauch", "leaned", "peikert-sigg"});
    refused({"--half-width", "3v"}, 2, {"--half-width", "no voxels", "percent"});
    refused({"--half-width", "full"}, 2, {"--half-width", "percent"});
    refused({"--half-width", "0"}, 2, {"--half-width", "positive"});
    for (const char* width : {"1e308", "1e300", "1e-320"}) refused({"--half-width", width}, 2, {"--half-width", width});
    refused({"--half-width", "wide"}, 2, {"--half-width", "wide"});
    for (const std::string number : {"0x1", "-1", "1.5", "4294967296", "1 "}) {
        refused({"--around", number}, 2, {"--around", "'" + number + "'", "a whole number from 0 to 4294967295"});
        refused({"--triangles", number}, 2, {"--triangles", "'" + number + "'", "a whole number from 0 to 4294967295"});
    }
    refused({"--aruond", "0"}, 2, {"did you mean --around?"});
    check_refused(run_command({"polyhedra", mesh, "-o", folder.file("a.xyz")}, no_devices), 2, {"a.xyz"});
    check_refused(run_command({"polyhedra", mesh, "-o", mesh}, no_devices), 2, {mesh, "the mesh that is read"});
    check_refused(run_command({"polyhedra", folder.file("none.off"), "-o", output}, no_devices), 3, {"none.off"});
    // Several files are one body.
    check_refused(run_command({"polyhedra", folder.file("none.off"), mesh, "-o", mesh}, no_devices), 2,
                  {mesh, "the mesh that is read"});
    const Outcome both = run_command({"polyhedra", mesh, mesh, "-o", output, "--triangles", "5", "--json"}, no_devices);
    BOOST_TEST(both.status == 0, both.error);
    BOOST_TEST(nlohmann::json::parse(both.out)["mesh"] == mesh + " + " + mesh);
}

BOOST_AUTO_TEST_CASE(need_a_value_after_the_sign_of_equality) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("tetrahedron.off", tetrahedron);
    const std::string output = folder.file("polyhedra.ply");
    check_refused(run_command({"polyhedra", mesh, "-o", output, "--around=", "0"}, no_devices), 2,
                  {"--around: the value is missing"});
    check_refused(run_command({"polyhedra", mesh, "--output=", output}, no_devices), 2, {"--output: the value is"});
    BOOST_TEST(!std::filesystem::exists(output));
    const Outcome outcome = run_command({"polyhedra", mesh, "--output=" + output, "--around=0"}, no_devices);
    BOOST_TEST(outcome.status == 0, outcome.error);
}

BOOST_AUTO_TEST_SUITE_END()
