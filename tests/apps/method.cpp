#include "apps/process.hpp"

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

using clsdf::test::check_refused;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;
using nlohmann::json;

namespace {

/// The counterexample b2 (docs/method.md): its obtuse corners make the paper's polyhedra wrong.
const std::string obtuse_tetrahedron =
    "OFF\n4 4 0\n0 0 0\n-4 -4 -3\n1 1 3\n-2 -1 -2\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

std::pair<std::string, std::string> method_of(const json& result) {
    return {result["polyhedra"].get<std::string>(), result["scan"].get<std::string>()};
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_scan_follows_the_polyhedra_unless_it_is_stated) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const auto dry_run = [&](std::vector<std::string> options) {
        options.insert(options.begin(), {"compute", mesh, "--dry-run", "--json"});
        const Outcome outcome = run_command(options, no_devices);
        BOOST_REQUIRE(outcome.status == 0);
        BOOST_TEST(outcome.error.find("method") != std::string::npos);
        return json::parse(outcome.out);
    };
    BOOST_TEST((method_of(dry_run({})) == std::pair<std::string, std::string>("leaned", "bricks")));
    BOOST_TEST((method_of(dry_run({"--scan", "slices"})) == std::pair<std::string, std::string>("leaned", "slices")));
    BOOST_TEST((method_of(dry_run({"--scan", "brute-force"})) ==
                std::pair<std::string, std::string>("leaned", "brute-force")));
    const json paper = dry_run({"--polyhedra", "peikert-sigg"});
    BOOST_TEST((method_of(paper) == std::pair<std::string, std::string>("peikert-sigg", "slices")));
    BOOST_REQUIRE(paper["warnings"].size() == 1U);
    BOOST_TEST(paper["warnings"][0].get<std::string>().find("not exact") != std::string::npos);
    BOOST_TEST(dry_run({})["warnings"].empty());
    const json mauch = dry_run({"--polyhedra", "mauch"});
    BOOST_TEST((method_of(mauch) == std::pair<std::string, std::string>("mauch", "slices")));
    BOOST_TEST(mauch["warnings"].empty());
}

BOOST_AUTO_TEST_CASE(what_does_not_go_together_or_is_not_there_is_refused_with_a_remedy) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const auto refused = [&](const std::vector<std::string>& options, const std::vector<std::string>& fragments) {
        std::vector<std::string> all{"compute", mesh, "--dry-run"};
        all.insert(all.end(), options.begin(), options.end());
        check_refused(run_command(all, no_devices), 2, fragments);
    };
    refused({"--polyhedra", "peikert-sigg", "--scan", "bricks"}, {"bricks", "peikert-sigg", "use the scan \"slices\""});
    refused({"--polyhedra", "mauch", "--scan", "brute-force"}, {"brute-force", "mauch", "leave them out"});
    refused({"--polyhedra", "peikert-sig"}, {"--polyhedra", "peikert-sig", "did you mean peikert-sigg?"});
    refused({"--scan", "slice"}, {"--scan", "bricks", "did you mean slices?"});
    refused({"--scan", ""}, {"--scan"});
}

BOOST_AUTO_TEST_CASE(slices_pass_the_check_and_the_papers_polyhedra_do_not) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", obtuse_tetrahedron);
    const std::string field = folder.file("field.nrrd");
    const auto compute = [&](const std::vector<std::string>& options) {
        std::vector<std::string> all{"compute", mesh, "-o",     field,     "--resolution", "40",
                                     "--band",  "1",  "--json", "--quiet", "--with",       "triangle"};
        all.insert(all.end(), options.begin(), options.end());
        const Outcome outcome = run_command(all);
        BOOST_TEST_CONTEXT(outcome.error) BOOST_REQUIRE(outcome.status == 0);
        const json statistics = json::parse(outcome.out)["statistics"];
        BOOST_TEST(statistics["active_pieces"].get<int>() > 0);
        BOOST_TEST(statistics["slice_intersections"] == statistics["active_pieces"]);
        BOOST_TEST(statistics["empty_intersections"] == 0);
    };
    compute({"--scan", "slices"});
    BOOST_TEST(run_command({"check", mesh, field, "--complete", "--quiet"}).status == 0);
    compute({"--polyhedra", "peikert-sigg"});
    BOOST_TEST(run_command({"check", mesh, field, "--complete", "--quiet"}).status == 1);
}
