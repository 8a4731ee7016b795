#include "apps/process.hpp"
#include "support/temporary_folder.hpp"

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>

using clsdf::test::check_refused;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using nlohmann::json;

namespace {

json result_of(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "bench");
    arguments.insert(arguments.end(), {"--quick", "--json", "--quiet"});
    const Outcome outcome = run_command(arguments);
    BOOST_TEST_CONTEXT("message: " << outcome.error) BOOST_REQUIRE(outcome.status == 0);
    return json::parse(outcome.out);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(bench_command)

BOOST_AUTO_TEST_CASE(peers_have_their_error_beside_their_time) {
    const json result = result_of({"peers", "--commit", "0123abc"});
    BOOST_TEST(result["commit"] == "0123abc");
    BOOST_TEST(result["machine"]["threads"].get<int>() > 0);
    BOOST_TEST(!result["device"]["name"].get<std::string>().empty());
    std::set<std::string> methods, workloads;
    for (const json& row : result["rows"]) {
        methods.insert(row["method"]);
        workloads.insert(row["workload"]);
        const json& wall = row["wall_seconds"];
        BOOST_TEST(wall["least"].get<double>() > 0);
        BOOST_TEST(wall["least"].get<double>() <= wall["median"].get<double>());
        BOOST_TEST(wall["median"].get<double>() <= wall["most"].get<double>());
        BOOST_TEST(row["processor_seconds"]["median"].get<double>() > 0);
        BOOST_TEST(row["judgement"]["samples"].get<int>() > 0);
        if (row["method"] != "OpenVDB") BOOST_TEST(row["judgement"]["exact"].get<bool>());
    }
    BOOST_TEST(methods.contains("clsdf"));
    BOOST_TEST(methods.contains("CGAL"));
    BOOST_TEST((workloads == std::set<std::string>{"W1", "W2", "W3", "W4"}));
    for (const json& method : result["methods"])
        BOOST_TEST(method["there"].get<bool>() == method["remedy"].get<std::string>().empty());
}

BOOST_AUTO_TEST_CASE(scaling_has_four_series) {
    std::set<std::string> series;
    const json result = result_of({"scaling"});
    for (const json& row : result["rows"]) {
        series.insert(row["series"]);
        BOOST_TEST(row["judgement"]["exact"].get<bool>());
    }
    BOOST_TEST((series == std::set<std::string>{"N", "d", "triangles", "threads"}));
}

BOOST_AUTO_TEST_CASE(floors_are_above_every_result_and_the_stages_add_up) {
    const json result = result_of({"floors", "--workload", "W1"});
    for (const char* floor : {"store_bytes_per_second", "fma_operations_per_second", "launch_seconds"})
        BOOST_TEST(result["floors"][floor].get<double>() > 0, floor);
    for (const json& row : result["rows"]) {
        BOOST_TEST(row["part_of_floor"].get<double>() > 0);
        BOOST_TEST(row["part_of_floor"].get<double>() < 1);
        BOOST_TEST(row["lanes_evaluated_per_band_sample"].get<double>() >= 1);
        BOOST_TEST(row["stages_seconds"]["bricks"].get<double>() > 0);
        double sum = 0;
        for (const json& stage : row["stages_seconds"]) sum += stage.get<double>();
        BOOST_TEST(sum < 1.5 * row["wall_seconds"]["most"].get<double>());
    }
}

BOOST_AUTO_TEST_CASE(papers_have_their_polyhedra_distances_and_errors_beside_their_time) {
    const json result = result_of({"papers", "sphere6", "knot"});
    BOOST_REQUIRE(result["table_1"].size() == 2U);
    BOOST_TEST(result["table_1"][0]["mesh"] == "sphere6");
    BOOST_TEST(result["table_1"][0]["vertices"] == 16386);
    BOOST_TEST(result["table_1"][0]["gaps"] == 0);
    BOOST_REQUIRE(result["rows"].size() == 20U);  // brute force for the small ones only
    for (const json& row : result["rows"]) {
        BOOST_TEST(row["workload"] == std::to_string(row["grid"]["size"][0].get<int>()) + ", 10%");
        BOOST_TEST(row["wall_seconds"]["median"].get<double>() > 0);
        BOOST_TEST(row["distances_per_band_sample"].get<double>() > 0.9);
        const std::string method = row["method"];
        if (method == "leaned, bricks" || method == "leaned, slices" || method == "mauch, slices" ||
            method == "brute force") {
            BOOST_TEST(row["judgement"]["exact"].get<bool>(), method);
            BOOST_TEST(row["wrong_percent"].get<double>() == 0);
        }
        if (row["mesh"] == "sphere6")
            BOOST_TEST(row["polyhedra"].get<int>() == (method.starts_with("mauch") ? 98306 : 32768), method);
    }
}

BOOST_AUTO_TEST_CASE(the_far_field_is_exact_by_clsdf_and_its_continued_bands_are_not) {
    const json rows = result_of({"papers", "knot", "--series", "far-field"})["far_field"];
    BOOST_TEST_REQUIRE(rows.size() == 4U);
    BOOST_TEST(rows[0]["method"] == "clsdf");
    BOOST_TEST(rows[0]["judgement"]["exact"].get<bool>());
    BOOST_TEST(rows[0]["judgement"]["mean_error_voxels"].get<double>() < 1e-6);
    std::set<std::string> bands;
    for (std::size_t i = 1; i < rows.size(); ++i) {
        const json& row = rows[i];
        const std::string method = row["method"];
        BOOST_TEST_INFO_SCOPE(method);
        bands.insert(method.substr(0, method.find(',')));
        BOOST_TEST(row["band_samples"] == rows[0]["band_samples"]);
        if (row.contains("remedy")) {
            BOOST_TEST(!row["remedy"].get<std::string>().empty());
            continue;
        }
        BOOST_TEST(row["wall_seconds"]["median"].get<double>() > 0);
        // Of first order: never exact, but it follows the surface, and its signs are those of the band.
        const json& judgement = row["judgement"];
        BOOST_TEST(judgement["wrong_signs"] == 0);
        BOOST_TEST(judgement["missed"] == 0);
        BOOST_TEST(judgement["wrong_values"].get<int>() > 0);
        BOOST_TEST(judgement["mean_error_voxels"].get<double>() > 1e-3);
        BOOST_TEST(judgement["max_error_voxels"].get<double>() < 2);
    }
    BOOST_TEST((bands == std::set<std::string>{"band of 2%", "band of 5%", "band of 10%"}));
}

BOOST_AUTO_TEST_CASE(under_sampled_grids_are_computed_in_three_ways_which_have_a_crossover_or_none) {
    const json whole = result_of({"papers", "sphere6", "--series", "under-sampled"});
    BOOST_TEST(!whole.contains("far_field"));
    BOOST_TEST(!whole.contains("rows"));
    const json& result = whole["under_sampled"];
    std::set<std::string> methods;
    double least = INFINITY, most = 0;
    for (const json& row : result["rows"]) {
        const std::string method = row["method"];
        BOOST_TEST_INFO_SCOPE(method << " on " << row["mesh"]);
        methods.insert(method.substr(0, method.find(':')));
        if (row.contains("remedy")) continue;
        const double area = row["mean_area_voxels"];
        least = std::min(least, 1 / area);
        most = std::max(most, 1 / area);
        // The unit sphere of so many triangles.
        const double side = row["grid"]["spacing"][0];
        BOOST_TEST(area * row["triangles"].get<double>() * side * side == 4 * 3.14159265,
                   boost::test_tools::tolerance(0.06));
        BOOST_TEST(row["wall_seconds"]["median"].get<double>() > 0);
        BOOST_TEST(row["judgement"]["samples"].get<int>() > 0);
        if (method != "Embree") BOOST_TEST(row["judgement"]["exact"].get<bool>());
    }
    for (const char* way : {"bricks", "bricks, again", "tree of points", "tree of points, again"})
        BOOST_TEST(methods.contains(way), way);
    BOOST_TEST((methods.contains("Embree") || methods.contains("embree")));
    BOOST_TEST(least < 0.2);
    BOOST_TEST(most > 50);  // the quick grids have at least nine samples on a side
    BOOST_TEST(result["crossovers"].size() == 4U);
    for (const json& crossover : result["crossovers"]) {
        BOOST_TEST(crossover["text"].get<std::string>().find("crossover") != std::string::npos);
        for (const json& value : crossover["triangles_per_voxel"]) {
            BOOST_TEST(value.get<double>() >= least);
            BOOST_TEST(value.get<double>() <= most);
        }
    }
}

BOOST_AUTO_TEST_CASE(calls_have_ratios_limits_and_errors) {
    const json result = result_of({"calls", "sphere5"});
    std::vector<std::string> names;
    for (const json& row : result["rows"]) {
        names.push_back(row["name"]);
        BOOST_TEST_INFO_SCOPE(names.back());
        BOOST_TEST(row["ratio"].get<double>() > 0);
        BOOST_TEST(row["wrong"] == 0);
        BOOST_TEST(row["samples_judged"].get<int>() > 0);
        BOOST_TEST(row["max_error_voxels"].get<double>() < 1e-5);
        BOOST_TEST((row["limit"].is_null() || row["limit"].get<double>() > 0));
    }
    const std::vector<std::string> expected = {
        "again",       "outputs",         "outputs_again", "one_sample", "one_point",   "one_point_all_outputs",
        "patches",     "patches_at_once", "band_boxes",    "moved",      "moved_128",   "moved_points",
        "plan_update", "device_first",    "device_step",   "classify",   "small_meshes"};
    BOOST_TEST(names == expected, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(points_have_speeds_and_no_errors) {
    const json result = result_of({"points", "knot"});
    std::vector<std::string> names;
    for (const json& row : result["rows"]) {
        BOOST_TEST_INFO_SCOPE(row["name"] << " by " << row["method"]);
        BOOST_TEST(row["points_per_second"].get<double>() > 0);
        BOOST_TEST(row["judged"].get<int>() > 0);
        if (row["method"] != "clsdf") continue;  // a peer's errors are its own
        names.push_back(row["name"]);
        BOOST_TEST(row["wrong"] == 0);
        BOOST_TEST(row["wrong_signs"] == 0);
        BOOST_TEST(row["max_error_voxels"].get<double>() < 1e-4);  // 2 ulp of 256 voxels
    }
    const std::vector<std::string> expected = {"uniform",        "near",        "rays",         "calls",    "first",
                                               "uniform device", "near device", "uniform plan", "near plan"};
    BOOST_TEST(names == expected, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(rays_have_speeds_and_no_errors) {
    const json result = result_of({"rays", "knot"});
    BOOST_TEST(result["rows"].size() >= 6U);
    for (const json& row : result["rows"]) {
        BOOST_TEST(row["rays_per_second"].get<double>() > 0);
        if (row["method"] == "clsdf") BOOST_TEST(row["wrong"] == 0, row.dump());
        const bool is_judged = row["rays"] == "random" || row["rays"] == "parallel" || row["rays"] == "edges";
        BOOST_TEST((row["judged"].get<int>() > 0) == is_judged);
    }
}

BOOST_AUTO_TEST_CASE(links_have_speeds_and_no_errors) {
    const json result = result_of({"links", "sphere4"});
    std::vector<std::string> names;
    for (const json& row : result["rows"]) {
        BOOST_TEST_INFO_SCOPE(row.dump());
        names.push_back(row["links"]);
        BOOST_TEST(row["links_per_second"].get<double>() > 0);
        BOOST_TEST(row["wrong"] == 0);
        BOOST_TEST((row["judged"].get<int>() > 0) == (row["links"] != "faces"));
        BOOST_TEST(row["max_error_voxels"].get<double>() < 1e-12);
    }
    const std::vector<std::string> expected = {"first",
                                               "again",
                                               "count",
                                               "faces",
                                               "ball, first",
                                               "ball, again",
                                               "cube on planes, first",
                                               "cube on planes, again"};
    BOOST_TEST(names == expected, boost::test_tools::per_element());
    // As many links, within a tenth.
    const double ratio = result["rows"][7]["count"].get<double>() / result["rows"][5]["count"].get<double>();
    BOOST_TEST(std::abs(ratio - 1) < 0.1);
}

BOOST_AUTO_TEST_CASE(cut_cells_have_times_beside_the_errors_of_their_sums) {
    const json result = result_of({"fractions", "sphere4"});
    std::vector<std::string> names;
    for (const json& row : result["rows"]) {
        BOOST_TEST_INFO_SCOPE(row.dump());
        names.push_back(row["name"]);
        BOOST_TEST(row["seconds"]["median"].get<double>() > 0);
        BOOST_TEST((row["cut_cells"] > 0) == (row["name"] != "outer"));
        BOOST_TEST(row["volume_error"].get<double>() < 1e-12);
        BOOST_TEST(row["area_error"].get<double>() < 1e-12);
    }
    const std::vector<std::string> expected = {"outer", "16", "16, again", "32", "32, again"};
    BOOST_TEST(names == expected, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(points_of_a_file_are_measured_alone) {
    const TemporaryFolder folder;
    const std::string file = folder.file("points.csv", "x,y,z\n0,0,0\n9,9,9\n0.5,1,0.25\n");
    const json result = result_of({"points", "knot", "--points", file});
    for (const json& row : result["rows"]) {
        BOOST_TEST(row["name"] == "file");
        BOOST_TEST(row["points"] == 3);
        BOOST_TEST(row["judged"] == 3);
        BOOST_TEST(row["seconds"]["median"].get<double>() > 0);
        if (row["method"] == "clsdf") BOOST_TEST(row["wrong"] == 0);
    }
    check_refused(run_command({"bench", "points", "knot", "--points", "/nonexistent.npy"}), 3, {"/nonexistent.npy"});
    check_refused(run_command({"bench", "points", "knot", "--points", folder.file("none.csv", "x,y,z\n")}), 2,
                  {"none.csv has no points"});
}

BOOST_AUTO_TEST_CASE(a_part_of_the_domain_has_a_share_of_the_memory_and_the_bytes_of_the_whole) {
    // With fewer samples a band of three voxels would hold half of the mesh.
    const Outcome outcome = run_command({"bench", "memory", "sphere7", "--json", "--quiet"});
    BOOST_TEST_REQUIRE(outcome.status == 0);
    const json result = json::parse(outcome.out);
    BOOST_TEST_REQUIRE(result["rows"].size() == 1);
    const json& row = result["rows"][0];
    BOOST_TEST(row["triangles"] == 131072);
    BOOST_TEST(row["samples"].get<int>() > 0);
    BOOST_TEST(row["different"] == 0);
    BOOST_TEST(row["whole_bytes"].get<double>() > row["without_mesh_bytes"].get<double>());
    // The share of a small mesh is blurred by free memory that malloc keeps.
    BOOST_TEST(row["kept_share"].get<double>() > 0);
    BOOST_TEST(row["kept_share"].get<double>() < 0.5);
}

BOOST_AUTO_TEST_CASE(what_cannot_be_measured_is_refused_with_the_remedy) {
    check_refused(run_command({"bench", "peers", "bunny00", "--meshes", "/nonexistent"}), 3,
                  {"bunny00.off", "scripts/fetch-meshes"});
    check_refused(run_command({"bench", "peers", "/nonexistent.off"}), 3, {"/nonexistent.off"});
    check_refused(run_command({"bench", "peers"}, no_devices), 4, {"pocl-opencl-icd"});
    check_refused(run_command({"bench", "peers", "--repetition", "3"}), 2,
                  {"--repetition", "--repetitions", "bench --help"});
    check_refused(run_command({"bench", "pears"}), 2, {"pears", "peers"});
    check_refused(run_command({"bench", "papers", "armadillo"}), 2, {"armadillo", "bunny00"});
    check_refused(run_command({"bench", "papers", "bunny"}), 2, {"did you mean bunny00?"});
    check_refused(run_command({"bench", "peers", "nomesh"}), 2, {"nomesh", "noisy_sphere", "refined_elephant", "knot"});
    check_refused(run_command({"bench", "peers", std::string(300, 'a')}), 2, {"there is no mesh 'aaa"});
    check_refused(run_command({"bench", "floors", "seashel"}), 2, {"did you mean seashell?"});
    check_refused(run_command({"bench", "scaling", "knot", "torus"}), 2, {"one mesh", "torus"});
    for (const char* benchmark : {"peers", "scaling", "floors", "papers", "calls", "points", "memory"})
        check_refused(run_command({"bench", benchmark, "--quick", "--device", "xyzzy"}), 4, {"--device xyzzy"});
    check_refused(run_command({"bench", "peers", "--workload", "W9"}), 2, {"W9"});
}

BOOST_AUTO_TEST_CASE(an_option_that_would_be_ignored_is_refused) {
    const auto refused = [](const std::string& benchmark, const std::string& option, const std::string& value,
                            const std::string& takes) {
        check_refused(run_command({"bench", benchmark, option, value, "--quick"}), 2,
                      {option, "bench " + benchmark, takes});
    };
    refused("peers", "--series", "N", "--workload, --method, --seconds-per-call");
    refused("scaling", "--workload", "W1", "--method, --series");
    refused("floors", "--method", "embree", "takes --workload");
    refused("floors", "--series", "N", "takes --workload");
    refused("floors", "--seconds-per-call", "1", "takes --workload");
    refused("papers", "--workload", "W2", "takes --series");
    refused("papers", "--method", "clsdf", "takes --series");
    refused("calls", "--points", "points.npy", "takes only those of all");
    refused("papers", "--series", "d", "which has table-1, scans, far-field, under-sampled");
    refused("scaling", "--series", "scans", "which has threads, N, d, triangles");
}

BOOST_AUTO_TEST_CASE(nothing_is_measured_before_all_meshes_are_loaded) {
    for (const char* benchmark : {"peers", "floors"}) {
        const Outcome outcome = run_command({"bench", benchmark, "sphere2", "/nonexistent.off", "--quick"});
        check_refused(outcome, 3, {"/nonexistent.off"});
        BOOST_TEST(outcome.error.find("sphere2") == std::string::npos);
        BOOST_TEST(outcome.error.find("launch") == std::string::npos);
    }
}

BOOST_AUTO_TEST_SUITE_END()
