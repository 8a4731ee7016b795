#include "apps/process.hpp"

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

BOOST_AUTO_TEST_SUITE_END()
