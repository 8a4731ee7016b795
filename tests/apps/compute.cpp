#include "apps/process.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <string>

using clsdf::test::check_refused;
using clsdf::test::content_of;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;
using nlohmann::json;

namespace {

json dry_run(const std::string& mesh, std::vector<std::string> options) {
    options.insert(options.begin(), {"compute", mesh, "--dry-run", "--json"});
    const Outcome outcome = run_command(options, no_devices);
    BOOST_TEST_CONTEXT("message: " << outcome.error)
    BOOST_REQUIRE(outcome.status == 0);
    return json::parse(outcome.out);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_dry_run)

BOOST_AUTO_TEST_CASE(prints_the_grid_and_the_memory_needs_no_device_and_writes_nothing) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const Outcome outcome = run_command({"compute", mesh, "-o", folder.file("a.nrrd"), "--dry-run"}, no_devices);
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(outcome.out.empty());
    for (const char* fragment : {"4 vertices, 4 triangles", "256 x 256 x 256 samples", "nonzero", "67.1 MB"})
        BOOST_CHECK_MESSAGE(outcome.error.find(fragment) != std::string::npos, fragment << " in " << outcome.error);
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(refuses_what_the_computation_would_refuse) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::vector<std::vector<std::string>> refused{
        {"-o", folder.file("a.sdf"), "--spacing", "0.1,0.1,0.2"},
        {"-o", folder.file("a.nrrd"), "--band", "1e39", "--margin", "1"},
        {"-o", folder.file("a.nrrd"), "--scan", "brute-force", "--with", "gradient"},
        {"-o", folder.file("a.nrrd"), "--sign", "none", "--band", "0", "--margin", "1"}};
    const std::vector<std::string> fragments{"one spacing", "beyond the floats", "gradient", "signs alone"};
    for (std::size_t i = 0; i < refused.size(); ++i)
        for (const bool is_dry : {false, true}) {
            std::vector<std::string> arguments{"compute", mesh};
            arguments.insert(arguments.end(), refused[i].begin(), refused[i].end());
            if (is_dry) arguments.emplace_back("--dry-run");
            check_refused(run_command(arguments), 2, {fragments[i]});
        }
    check_refused(run_command({"compute", mesh, "--dry-run", "-o", folder.file(std::string(252, 'a') + ".npy")}), 5,
                  {"too long"});
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(refuses_a_band_without_end_whose_distances_exceed_a_float) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", "OFF\n4 1 0\n0 0 0\n1e39 0 0\n0 1e39 0\n0 0 1e39\n3 1 2 3\n");
    const auto compute = [&](const std::string& band) {
        return run_command({"compute", mesh, "-o", folder.file("a.nrrd"), "--resolution", "32", "--band", band});
    };
    check_refused(compute("full"), 2, {"diagonal", "beyond the floats"});
    BOOST_TEST(folder.file_count() == 1U);
    BOOST_TEST(compute("1%").status == 0);
}

BOOST_AUTO_TEST_CASE(lays_the_grid_out_as_the_options_say) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", "OFF\n3 1 0\n0 0 0\n4 0 0\n0 2 1\n3 0 1 2\n");
    const auto size = [](const json& result) { return result["grid"]["size"].dump(); };
    const auto spacing = [](const json& result) { return result["grid"]["spacing"][0].get<double>(); };
    const auto origin = [](const json& result) { return result["grid"]["origin"].dump(); };

    const json percent = dry_run(mesh, {"--resolution", "49"});
    BOOST_TEST(spacing(percent) == (4 + 2 * 0.4) / 48);
    BOOST_TEST(percent["band"]["inside"].get<double>() == 0.4);
    BOOST_TEST(percent["grid"]["size"][0].get<int>() == 49);

    const json leading_zero = dry_run(mesh, {"--resolution", "049"});
    BOOST_TEST(leading_zero["grid"]["size"][0].get<int>() == 49);

    const json voxels = dry_run(mesh, {"--resolution", "15", "--band", "3v"});
    BOOST_TEST(size(voxels) == "[15,11,9]");
    BOOST_TEST(voxels["band"]["outside"].get<double>() == 1.5);

    const json full = dry_run(mesh, {"--resolution", "45", "--band", "full"});
    BOOST_TEST(spacing(full) == (4 + 2 * 0.2) / 44);
    BOOST_TEST(full["band"]["outside"].is_null());

    const json sides = dry_run(mesh, {"--spacing", "0.5", "--band-inside", "0", "--band-outside", "2v", "--band", "1"});
    BOOST_TEST(size(sides) == "[13,9,7]");
    BOOST_TEST(sides["band"].dump() == R"({"inside":0.0,"outside":1.0})");

    BOOST_TEST(size(dry_run(mesh, {"--resolution", "15", "--band", "3v", "--cubic"})) == "[15,15,15]");
    BOOST_TEST(size(dry_run(mesh, {"--spacing", "1,1,0.5", "--margin", "0"})) == "[5,3,3]");
    BOOST_TEST(origin(dry_run(mesh, {"--spacing", "1", "--margin", "1", "--cell-centred"})) == "[-0.5,-0.5,-0.5]");

    const json slice = dry_run(mesh, {"--box", "-1,0,0.5,3,2,0.5", "--samples", "41,41,1"});
    BOOST_TEST(size(slice) == "[41,41,1]");
    BOOST_TEST(origin(slice) == "[-1.0,0.0,0.5]");
    check_refused(
        run_command({"compute", mesh, "--dry-run", "--box", "-1,0,0,3,2,1", "--samples", "41,41,1"}, no_devices), 2,
        {"1 sample along z", "same coordinate in both corners"});

    const json stated = dry_run(mesh, {"--size", "8,9,10", "--origin", "-1,-2,-3e-1", "--spacing", "0.5"});
    BOOST_TEST(size(stated) == "[8,9,10]");
    BOOST_TEST(origin(stated) == "[-1.0,-2.0,-0.3]");
}

BOOST_AUTO_TEST_CASE(warns_that_an_open_mesh_has_no_inside_and_refuses_a_sign_asked_for) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", "OFF\n3 1 0\n0 0 0\n4 0 0\n0 2 1\n3 0 1 2\n");
    const Outcome outcome = run_command({"compute", mesh, "--dry-run", "--json"}, no_devices);
    BOOST_TEST(outcome.error.find("warning: ") != std::string::npos);
    BOOST_TEST(json::parse(outcome.out)["sign"].get<std::string>() == "none");
    BOOST_TEST(json::parse(outcome.out)["warnings"].size() == 1U);
    check_refused(run_command({"compute", mesh, "--dry-run", "--sign", "parity"}, no_devices), 3, {"3", "edge"});
}

BOOST_AUTO_TEST_CASE(says_what_the_mesh_is_like_and_counts_bytes_in_whole_numbers) {
    const TemporaryFolder folder;
    const json result = dry_run(folder.file("mesh.off", "OFF\n3 1 0\n0 0 0\n4 0 0\n0 2 1\n3 0 1 2\n"), {});
    BOOST_TEST(result["memory"]["field_bytes"].is_number_integer());
    BOOST_TEST(result["memory"]["working_bytes"].is_number_integer());
    BOOST_TEST(result["memory"]["slab_bytes"] == result["memory"]["field_bytes"]);
    const json& topology = result["topology"];
    BOOST_TEST(topology["closed"] == false);
    BOOST_TEST(topology["balanced"] == false);
    BOOST_TEST(topology["inside_out"] == false);
    BOOST_TEST(topology["open_edges"] == 3);
    BOOST_TEST(topology["unbalanced_edges"] == 3);
    for (const char* count : {"non_manifold_edges", "coincident_vertices", "unused_vertices", "repeated_vertex_faces"})
        BOOST_TEST(topology[count] == 0);
}

// A cube of facets with vertices of their own that differ by noise, with a face twice.
BOOST_AUTO_TEST_CASE(says_what_decides_the_sign_and_joins_what_is_to_be_welded) {
    const auto cube = [](double noise) {
        const std::array<std::array<int, 3>, 12> corners{{{0, 2, 1},
                                                          {1, 2, 3},
                                                          {4, 5, 6},
                                                          {5, 7, 6},
                                                          {0, 1, 4},
                                                          {1, 5, 4},
                                                          {2, 6, 3},
                                                          {3, 6, 7},
                                                          {0, 4, 2},
                                                          {2, 4, 6},
                                                          {1, 3, 5},
                                                          {3, 7, 5}}};
        std::string vertices, triangles;
        int count = 0;
        const auto add = [&](const std::array<int, 3>& face) {
            triangles += fmt::format("3 {} {} {}\n", count, count + 1, count + 2);
            for (const int corner : face) {
                vertices += fmt::format("{} {} {}\n", (corner & 1) + noise * (count % 3),
                                        (corner >> 1 & 1) + noise * (count % 2), (corner >> 2) - noise * (count % 5));
                ++count;
            }
        };
        for (const std::array<int, 3>& face : corners) add(face);
        add(corners[7]);
        return fmt::format("OFF\n{} 13 0\n{}{}", count, vertices, triangles);
    };
    const TemporaryFolder folder;
    const json topology = dry_run(folder.file("noise.off", cube(1e-15)), {})["topology"];
    BOOST_TEST(topology["balanced"] == true);
    BOOST_TEST(topology["duplicate_faces"] == 1);
    BOOST_TEST(topology["uncounted_faces"] == 1);
    BOOST_TEST(topology["reoriented_faces"] == 0);
    BOOST_TEST(topology["parts"] == 1);
    BOOST_TEST(topology["joined_vertices"].get<int>() > 8);
    const std::string coarse = folder.file("coarse.off", cube(1e-7));
    BOOST_TEST(dry_run(coarse, {})["sign"] == "none");
    BOOST_TEST(dry_run(coarse, {})["topology"]["tested_points"].get<int>() > 512);
    BOOST_TEST(dry_run(coarse, {"--weld", "1e-6"})["sign"] == "nonzero");
    BOOST_TEST(dry_run(coarse, {"--weld", "0.0001%"})["sign"] == "nonzero");
    check_refused(run_command({"compute", coarse, "--dry-run", "--weld", "3v"}, no_devices), 2, {"--weld", "3v"});
    check_refused(run_command({"compute", coarse, "--dry-run", "--weld", "-1"}, no_devices), 2, {"-1"});
    check_refused(run_command({"compute", coarse, "--dry-run", "--weld", "200%"}, no_devices), 2,
                  {"--weld: '200%'", "no face", "give a length below that of the edges"});
}

BOOST_AUTO_TEST_CASE(says_how_much_of_the_field_is_in_memory_at_once) {
    const TemporaryFolder folder;
    const json memory = dry_run(folder.file("mesh.off", tetrahedron), {"--resolution", "1024"})["memory"];
    BOOST_TEST(memory["field_bytes"] == std::size_t{1} << 32);
    BOOST_TEST(memory["slabs"] == 32U);
    BOOST_TEST(memory["slab_bytes"] == std::size_t{1} << 28);
}

BOOST_AUTO_TEST_CASE(warns_that_a_computation_exceeds_the_memory_of_the_machine) {
    const TemporaryFolder folder;
    const json result = dry_run(folder.file("mesh.off", tetrahedron), {"--resolution", "100000"});
    BOOST_TEST(result["memory"]["field_bytes"] == 4'000'000'000'000'000);
    BOOST_REQUIRE(result["warnings"].size() == 1U);
    BOOST_TEST(result["warnings"][0].get<std::string>().find("--resolution") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(refuses_a_grid_beyond_the_address_space) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    check_refused(run_command({"compute", mesh, "--dry-run", "--resolution", "3000000"}), 4,
                  {"samples", "choose a lower --resolution"});
    check_refused(run_command({"compute", mesh, "--dry-run", "--spacing", "1e-7"}), 4,
                  {"samples", "choose a larger --spacing"});
    check_refused(run_command({"compute", mesh, "--dry-run", "--spacing", "1e300"}), 2,
                  {"--spacing: 1e+300", "choose a smaller spacing"});
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(computing)

BOOST_AUTO_TEST_CASE(writes_a_field_that_passes_the_check) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    for (const std::string name : {"field.nrrd", "field.npy"}) {
        const std::string field = folder.file(name);
        const Outcome computed =
            run_command({"compute", mesh, "-o", field, "--resolution", "24", "--with", "triangle"});
        BOOST_TEST_CONTEXT(computed.error) {
            BOOST_TEST(computed.status == 0);
            BOOST_TEST(computed.out.empty());
            BOOST_TEST(computed.error.find("within the band's limits") != std::string::npos);
            BOOST_TEST(computed.error.find('\r') == std::string::npos);
        }
        const Outcome checked = run_command({"check", mesh, field, "--complete", "--json"});
        BOOST_TEST_CONTEXT(checked.error) {
            BOOST_REQUIRE(checked.status == 0);
            const json report = json::parse(checked.out);
            BOOST_TEST(report["passed"].get<bool>());
            BOOST_TEST(report["samples"].get<int>() == 24 * 24 * 24);
            BOOST_TEST(report["max_error_voxels"].get<double>() <= 1e-5);
        }
    }
}

BOOST_AUTO_TEST_CASE(reports_what_it_did_as_json_and_nothing_when_quiet) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const Outcome outcome =
        run_command({"compute", mesh, "-o", folder.file("a.nrrd"), "--resolution", "24", "--json", "--quiet"});
    BOOST_REQUIRE(outcome.status == 0);
    BOOST_TEST(outcome.error.empty());
    const json result = json::parse(outcome.out);
    BOOST_TEST(result["sign"].get<std::string>() == "nonzero");
    BOOST_TEST(result["grid"]["size"].dump() == "[24,24,24]");
    BOOST_TEST(!result["device"]["name"].get<std::string>().empty());
    BOOST_TEST(result["seconds"]["compute"].get<double>() > 0);
    const json& statistics = result["statistics"];
    BOOST_TEST(statistics["triangles"].get<int>() == 4);
    BOOST_TEST(statistics["band_samples"].get<int>() > 0);
    BOOST_TEST(!statistics.contains("lanes_evaluated"));  // counting takes other kernels
}

BOOST_AUTO_TEST_CASE(counts_the_same_samples_in_text_and_json) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off",
                                         "OFF\n8 4 0\n0 0 0\n8 0 0\n0 8 0\n8 8 0\n0 0 4\n8 0 4\n0 8 4\n"
                                         "8 8 4\n3 0 1 2\n3 1 3 2\n3 4 5 6\n3 5 7 6\n");
    // The planes of samples are z = -2 ... 6: 0 and 4 lie on the mesh; -1, 1, 3 and 5 are exactly at the limit.
    const Outcome outcome = run_command({"compute", mesh, "-o", folder.file("a.nrrd"), "--size", "9,9,9", "--origin",
                                         "0,0,-2", "--spacing", "1", "--band", "1", "--json"});
    BOOST_REQUIRE(outcome.status == 0);
    BOOST_TEST(json::parse(outcome.out)["statistics"]["band_samples"] == 2 * 81);
    BOOST_CHECK_MESSAGE(outcome.error.find("729 samples, 162 of them within") != std::string::npos, outcome.error);
}

BOOST_AUTO_TEST_CASE(warns_where_no_sample_is_within_the_limits_and_names_both_boxes) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const Outcome outcome = run_command({"compute", mesh, "-o", folder.file("a.nrrd"), "--size", "8", "--origin",
                                         "100,0,0", "--spacing", "0.5", "--band", "1", "--json", "--quiet"});
    BOOST_REQUIRE(outcome.status == 0);
    const json result = json::parse(outcome.out);
    BOOST_REQUIRE(result["warnings"].size() == 1U);
    const auto warning = result["warnings"][0].get<std::string>();
    for (const char* fragment : {"no sample", "(100, 0, 0) to (103.5, 3.5, 3.5)", "(0, 0, 0) to (1, 1, 1)"})
        BOOST_CHECK_MESSAGE(warning.find(fragment) != std::string::npos, fragment << " in " << warning);
    BOOST_TEST(outcome.error.starts_with("warning: no sample"));
}

BOOST_AUTO_TEST_CASE(warns_that_a_format_cannot_carry_the_band) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    for (const std::string name : {"a.sdf", "A.SDF"})
        for (const std::string band : {"2v", "full"}) {
            const Outcome outcome = run_command(
                {"compute", mesh, "-o", folder.file(name), "--resolution", "12", "--band", band, "--json", "--quiet"});
            BOOST_REQUIRE(outcome.status == 0);
            BOOST_TEST(json::parse(outcome.out)["warnings"].size() == (band == "full" ? 0U : 1U));
        }
}

BOOST_AUTO_TEST_CASE(warns_that_a_field_without_sign_has_no_band_inside) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    for (const std::string sign : {"none", "nonzero"}) {
        const Outcome outcome =
            run_command({"compute", mesh, "--sign", sign, "--band-inside", "1", "--dry-run", "--quiet"});
        BOOST_REQUIRE(outcome.status == 0);
        BOOST_TEST(outcome.error.starts_with("warning: --band-inside has no effect") == (sign == "none"),
                   outcome.error);
    }
}

BOOST_AUTO_TEST_CASE(warns_that_triangles_of_an_earlier_field_lie_beside_the_new_one) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::vector<std::string> plain{"compute", mesh, "-o",     folder.file("a.npy"), "--resolution", "9",
                                         "--band",  "2v", "--quiet"};
    std::vector<std::string> with_triangles = plain;
    with_triangles.insert(with_triangles.end(), {"--with", "triangle"});
    BOOST_TEST(run_command(plain).error.empty());
    BOOST_TEST(run_command(with_triangles).error.empty());
    const Outcome outcome = run_command(plain);
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(outcome.error.find("warning: " + folder.file("a_triangle.npy")) == 0U);
    // A file of that name beside a format that has all outputs in one file is another field.
    const auto in_vti = [&](const std::string& name) {
        return run_command({"compute", mesh, "-o", folder.file(name), "--resolution", "9", "--band", "2v", "--quiet"});
    };
    BOOST_REQUIRE(in_vti("a_triangle.vti").status == 0);
    const Outcome in_one_file = in_vti("a.vti");
    BOOST_TEST(in_one_file.status == 0);
    BOOST_TEST(in_one_file.error.empty(), in_one_file.error);
}

BOOST_AUTO_TEST_CASE(keeps_the_name_of_the_mesh_without_its_folder) {
    const TemporaryFolder folder;
    const std::string field = folder.file("a.nrrd");
    BOOST_TEST(
        run_command({"compute", folder.file("mesh.off", tetrahedron), "-o", field, "--resolution", "9"}).status == 0);
    BOOST_TEST(clsdf::read_field(field).mesh_name == "mesh.off");
}

BOOST_AUTO_TEST_CASE(says_when_its_output_cannot_be_written) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::string field = folder.file("field.nrrd");
    check_refused(run_command({"compute", mesh, "--dry-run", "--json"}, {}, "/dev/full"), 5, {"standard output"});
    std::filesystem::create_symlink("/dev/full", field);
    check_refused(run_command({"compute", mesh, "-o", field, "--resolution", "24"}), 5, {"field.nrrd"});
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(checking)

BOOST_AUTO_TEST_CASE(finds_what_is_wrong_with_a_field_and_says_where) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::string path = folder.file("field.nrrd");
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", path, "--resolution", "24"}).status == 0);
    clsdf::Field field = clsdf::read_field(path);
    field.distance()[field.grid.offset(6, 6, 6)] *= -1;
    field.distance()[field.grid.offset(0, 12, 5)] = 0;
    write_field(field, path);
    const Outcome outcome = run_command({"check", mesh, path, "--complete", "--json"});
    BOOST_TEST(outcome.status == 1);
    BOOST_TEST(outcome.error.find("(6, 6, 6)") != std::string::npos);
    const json report = json::parse(outcome.out);
    BOOST_TEST(!report["passed"].get<bool>());
    BOOST_TEST(report["findings"].size() == 2U);
    BOOST_TEST(outcome.error.find("ulp (beyond one voxel from the surface)") != std::string::npos);
    BOOST_TEST(!report.contains("note"));
}

BOOST_AUTO_TEST_CASE(needs_the_files_of_all_outputs) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    for (const std::string ending : {".npy", ".nrrd"}) {
        const std::string path = folder.file("field" + ending), output = folder.file("field_site" + ending);
        BOOST_REQUIRE(run_command({"compute", mesh, "-o", path, "--resolution", "12", "--with", "site"}).status == 0);
        BOOST_TEST(run_command({"check", mesh, path}).status == 0);
        BOOST_REQUIRE(std::filesystem::remove(output));
        check_refused(run_command({"check", mesh, path}), 3, {path, output, "cannot be found"});
    }
}

BOOST_AUTO_TEST_CASE(names_no_distances_if_another_output_is_wrong) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::string path = folder.file("field.vti");
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", path, "--resolution", "12", "--with", "triangle"}).status == 0);
    clsdf::Field field = clsdf::read_field(path);
    field.triangle()[field.grid.offset(1, 6, 5)] ^= 1;
    write_field(field, path);
    const Outcome outcome = run_command({"check", mesh, path, "--complete"});
    BOOST_TEST(outcome.status == 1);
    BOOST_TEST(outcome.error.find("(1, 6, 5)") != std::string::npos);
    BOOST_TEST(outcome.error.find("instead of") == std::string::npos, outcome.error);
    const Outcome described = run_command({"check", mesh, path, "--complete", "--json"});
    BOOST_TEST(described.out.find("\"position\"") != std::string::npos, described.out);
    BOOST_TEST(described.out.find("\"expected\"") == std::string::npos, described.out);
}

BOOST_AUTO_TEST_CASE(notes_that_a_field_which_fails_names_another_mesh_and_is_quiet_where_it_passes) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::string other = folder.file("other.off",
                                          "OFF\n4 4 0\n0 0 0\n2 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n"
                                          "3 0 3 2\n3 1 2 3\n");
    const std::string field = folder.file("field.nrrd");
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", field, "--resolution", "16"}).status == 0);
    const Outcome passed = run_command({"check", mesh, field, "--quiet"});
    BOOST_TEST(passed.status == 0);
    BOOST_TEST(passed.error.empty());
    const Outcome failed = run_command({"check", other, field, "--quiet"});
    BOOST_TEST(failed.status == 1);
    BOOST_TEST(failed.error.find("FAILED") != std::string::npos);
    BOOST_TEST(failed.error.find("made from 'mesh.off'") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(notes_that_a_field_is_positive_inside) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    for (const char* band : {"full", "3v"}) {
        const std::string path = folder.file("field.nrrd");
        BOOST_REQUIRE(run_command({"compute", mesh, "-o", path, "--resolution", "16", "--band", band}).status == 0);
        const Outcome mistaken = run_command({"check", mesh, path, "--positive-inside"});
        BOOST_TEST(mistaken.status == 1);
        BOOST_TEST(mistaken.error.find("leave out --positive-inside") != std::string::npos, mistaken.error);
        const auto note_with = [&](std::size_t kept) {
            clsdf::Field field = clsdf::read_field(path);
            for (std::size_t i = kept; i < field.distance().size(); ++i) field.distance()[i] *= -1;
            const std::string other = folder.file("other.nrrd");
            write_field(field, other);
            const Outcome outcome = run_command({"check", mesh, other, "--complete", "--json"});
            BOOST_TEST(outcome.status == 1);
            return json::parse(outcome.out).value("note", "");
        };
        BOOST_TEST(note_with(0).starts_with("all signs are opposite: positive inside?"), note_with(0));
        BOOST_TEST(note_with(100).empty(), note_with(100));
    }
}

BOOST_AUTO_TEST_CASE(warns_that_a_band_is_narrower_than_a_voxel) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const auto warnings = [&](const std::vector<std::string>& options) {
        std::vector<std::string> arguments{"compute", mesh, "--dry-run", "--json", "--resolution", "64"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        return json::parse(run_command(arguments).out)["warnings"];
    };
    for (const std::vector<std::string>& narrow :
         {std::vector<std::string>{"--band", "0.25%"}, {"--band", "0.9v"}, {"--band", "3v", "--band-inside", "0.5v"}}) {
        BOOST_REQUIRE(warnings(narrow).size() == 1U);
        BOOST_TEST(warnings(narrow)[0].get<std::string>().find("voxels wide") != std::string::npos);
    }
    for (const std::vector<std::string>& wide : {std::vector<std::string>{},
                                                 {"--band", "1v"},
                                                 {"--band", "0"},
                                                 {"--band", "3v", "--band-inside", "0"},
                                                 {"--band", "full"}})
        BOOST_TEST(warnings(wide).empty());
}

BOOST_AUTO_TEST_CASE(notes_that_wrong_values_look_like_the_limits_of_a_band_that_is_not_stated) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::string path = folder.file("field.sdf");
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", path, "--resolution", "16"}).status == 0);
    const Outcome failed = run_command({"check", mesh, path, "--complete"});
    BOOST_TEST(failed.status == 1);
    BOOST_TEST(failed.error.find("note: the first wrong samples have the field's smallest or largest value") !=
                   std::string::npos,
               failed.error);
    clsdf::Field field = clsdf::read_field(path);
    field.distance()[field.grid.offset(8, 8, 8)] *= -1;
    write_field(field, path);
    const Outcome sign = run_command({"check", mesh, path, "--complete"});
    BOOST_TEST(sign.status == 1);
    BOOST_TEST(sign.error.find("note") == std::string::npos, sign.error);
    BOOST_REQUIRE(run_command({"compute", mesh, "-o", path, "--resolution", "16", "--band", "full"}).status == 0);
    field = clsdf::read_field(path);
    field.distance()[field.grid.offset(8, 8, 8)] += 0.01F;
    write_field(field, path);
    const Outcome other = run_command({"check", mesh, path, "--complete"});
    BOOST_TEST(other.status == 1);
    BOOST_TEST(other.error.find("note") == std::string::npos, other.error);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(options_of_a_place_a_unit_and_a_convention)

namespace {

void run_well(const std::vector<std::string>& arguments) {
    const Outcome outcome = run_command(arguments);
    BOOST_TEST_CONTEXT(outcome.error) BOOST_REQUIRE(outcome.status == 0);
}

}  // namespace

BOOST_AUTO_TEST_CASE(put_the_mesh_into_another_unit_and_place) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron), field = folder.file("field.nrrd");
    const std::vector<std::string> options{"--scale", "0.001", "--translate", "1,-2,3"};
    const auto with = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), options.begin(), options.end());
        return arguments;
    };
    run_well(with({"compute", mesh, "-o", field, "--resolution", "16", "--margin", "0"}));
    BOOST_TEST((clsdf::read_field(field).grid.origin == clsdf::Vec3{1, -2, 3}));
    run_well(with({"check", mesh, field}));
    BOOST_TEST(run_command({"check", mesh, field}).status == 1);
    const std::string points = folder.file("points.csv", "x,y,z\n1,-2,2.999\n"), found = folder.file("found.csv");
    run_well(with({"query", mesh, points, "-o", found}));
    BOOST_TEST(content_of(found).find("0.001") != std::string::npos);
    check_refused(run_command({"compute", mesh, "-o", field, "--scale", "0"}), 2, {"--scale: ", "above 0, not '0'"});
    check_refused(run_command({"compute", mesh, "-o", field, "--scale", "-1"}), 2, {"--scale: ", "above 0, not '-1'"});
    check_refused(run_command({"compute", mesh, "-o", field, "--translate", "1,2"}), 2, {"--translate", "three"});
}

BOOST_AUTO_TEST_CASE(put_the_mesh_upright) {
    const TemporaryFolder folder;
    const std::string mesh =
        folder.file("mesh.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 2 0\n0 0 3\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
    const std::string field = folder.file("field.nrrd");
    const auto lower = [&](std::vector<std::string> options) {
        options.insert(options.begin(), {"compute", mesh, "--dry-run", "--json"});
        return json::parse(run_command(options).out)["mesh"]["lower"].get<clsdf::Vec3>();
    };
    // (x, -z, y); about z by a quarter turn: (z, x, y); and by half a turn about x: (x, -y, -z).
    BOOST_TEST((lower({"--up", "y"}) == clsdf::Vec3{0, -3, 0}));
    BOOST_TEST((lower({"--up", "-y"}) == clsdf::Vec3{0, 0, -2}));
    BOOST_TEST((lower({"--up", "y", "--rotate", "0,0,90", "--translate", "0.5,0,0"}) == clsdf::Vec3{0.5, 0, 0}));
    BOOST_TEST((lower({"--rotate", "180,0,0"}) == clsdf::Vec3{0, -2, -3}));
    run_well({"compute", mesh, "-o", field, "--resolution", "16", "--rotate", "180,0,0"});
    run_well({"check", mesh, field, "--rotate", "180,0,0"});
    BOOST_TEST(run_command({"check", mesh, field}).status == 1);
    check_refused(run_command({"compute", mesh, "-o", field, "--up", "w"}), 2, {"--up: ", "-z"});
    check_refused(run_command({"compute", mesh, "-o", field, "--rotate", "90"}), 2, {"--rotate", "three angles"});
}

BOOST_AUTO_TEST_CASE(write_the_group_of_each_sample) {
    const TemporaryFolder folder;
    const std::string first = folder.file("first.off", tetrahedron), second = folder.file("second.off", tetrahedron);
    const std::string field = folder.file("field.vti");
    const Outcome outcome = run_command(
        {"compute", first, second, "-o", field, "--resolution", "16", "--with", "group", "--json", "--sign", "none"});
    BOOST_TEST_CONTEXT(outcome.error) BOOST_REQUIRE(outcome.status == 0);
    BOOST_TEST(nlohmann::json::parse(outcome.out)["groups"] == nlohmann::json({"first", "second"}));
    BOOST_TEST(content_of(field).find("Name=\"group\"") != std::string::npos);
    BOOST_TEST(clsdf::read_field(field).outputs().contains(clsdf::Output::triangle));
    run_well({"compute", first, second, "-o", field, "--resolution", "16", "--with", "triangle", "--sign", "none"});
    BOOST_TEST(content_of(field).find("Name=\"group\"") == std::string::npos);
    check_refused(run_command({"compute", first, second, "-o", folder.file("a.npy"), "--with", "group"}), 2,
                  {"a.npy", "group", ".vti"});
    check_refused(run_command({"compute", first, "-o", field, "--with", "group"}), 2, {"no groups"});
}

BOOST_AUTO_TEST_CASE(state_a_grid_by_its_box) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::vector<std::string> box{"--box", "-1,-1,-1,1,1,1", "--cells", "64,64,32"};
    BOOST_TEST(dry_run(mesh, box)["grid"]["size"] == json({65, 65, 33}));
    BOOST_TEST(dry_run(mesh, {"--box", "-1,-1,-1,1,1,1", "--samples", "65"})["grid"]["spacing"] ==
               json({0.03125, 0.03125, 0.03125}));
    const json centred = dry_run(mesh, {"--box", "-1,-1,-1,1,1,1", "--cells", "64", "--cell-centred"})["grid"];
    BOOST_TEST(centred["size"] == json({64, 64, 64}));
    BOOST_TEST(centred["origin"] == json({-0.984375, -0.984375, -0.984375}));
    const auto refuses = [&](std::vector<std::string> options, const std::string& word) {
        options.insert(options.begin(), {"compute", mesh, "--dry-run"});
        check_refused(run_command(options), 2, {word});
    };
    refuses({"--box", "0,0,0,1,1,1"}, "--samples or by --cells");
    refuses({"--box", "0,0,0,1,1", "--cells", "4"}, "two corners");
    refuses({"--box", "0,0,0,1,1,1", "--cells", "4", "--spacing", "1"}, "--spacing");
    refuses({"--box", "0,0,0,1,1,1", "--samples", "4", "--cell-centred"}, "needs --cells");
    refuses({"--box", "0,0,0,1,1,0", "--cells", "4"}, "along z");
    refuses({"--cells", "4"}, "--box");
}

BOOST_AUTO_TEST_CASE(have_exact_signs_and_files_say_so) {
    const TemporaryFolder folder;
    // The cube from 0 to 1, with samples on its faces.
    const std::string shape = folder.file("shape.off");
    run_well({"shape", "cube", "-o", shape});
    for (const std::string ending : {".nrrd", ".npy", ".vti", ".h5"}) BOOST_TEST_CONTEXT(ending) {
            const std::string path = folder.file("field" + ending);
            const Outcome computed = run_command({"compute", shape, "-o", path, "--box", "-2,-2,-2,2,2,2", "--cells",
                                                  "16", "--band", "0", "--exact-signs", "--json"});
            BOOST_TEST(computed.status == 0, computed.error);
            BOOST_TEST(json::parse(computed.out)["band"]["exact_signs"] == true);
            const clsdf::Field field = clsdf::read_field(path);
            BOOST_TEST(field.band.has_exact_signs);
            BOOST_TEST(std::ranges::count_if(field.distance(), [](float value) { return value < 0; }) == 27);
            BOOST_TEST(run_command({"check", shape, path, "--complete"}).status == 0);
        }
    const std::string path = folder.file("a.nrrd");
    check_refused(run_command({"compute", shape, "-o", path, "--sign", "none", "--exact-signs"}), 2,
                  {"--exact-signs", "no sign"});
    check_refused(run_command({"compute", shape, "-o", path, "--scan", "slices", "--exact-signs"}), 2,
                  {"--exact-signs", "slices"});
}

BOOST_AUTO_TEST_CASE(make_the_inside_positive_and_files_say_so) {
    const TemporaryFolder folder;
    // The cube from 0 to 1, with samples on its faces.
    const std::string shape = folder.file("shape.off"),
                      points = folder.file("points.csv", "x,y,z\n0.5,0.5,0.5\n0,0,0\n9,0,0\n");
    run_well({"shape", "cube", "-o", shape});
    const std::vector<std::string> options{"--box",  "-2,-2,-2,2,2,2", "--cells", "16",
                                           "--band", "0.75",           "--with",  "gradient,site"};
    const auto compute = [&](const std::string& field, bool positive_inside) {
        std::vector<std::string> arguments{"compute", shape, "-o", field};
        arguments.insert(arguments.end(), options.begin(), options.end());
        if (positive_inside) arguments.emplace_back("--positive-inside");
        run_well(arguments);
    };
    for (const std::string ending : {".nrrd", ".npy", ".vti", ".h5"}) {
        BOOST_TEST_CONTEXT(ending) {
            const std::string usual = folder.file("usual" + ending), turned = folder.file("turned" + ending);
            compute(usual, false);
            compute(turned, true);
            const clsdf::Field expected = clsdf::read_field(usual);
            clsdf::Field found = clsdf::read_field(turned);
            BOOST_TEST((found.positive_inside && !expected.positive_inside));
            std::size_t zeros = 0, wrong = 0;
            for (std::size_t i = 0; i < expected.distance().size(); ++i) {
                zeros += expected.distance()[i] == 0 ? 1U : 0U;
                wrong += std::signbit(found.distance()[i]) == std::signbit(expected.distance()[i]) ? 1U : 0U;
            }
            BOOST_TEST(zeros == 98U);
            BOOST_TEST(wrong == 0U);
            found.negate();
            for (const clsdf::OutputInfo& info : clsdf::output_table())
                BOOST_TEST(std::ranges::equal(found.bytes(info.output), expected.slab().bytes(info.output)), info.name);
            const Outcome checked = run_command({"check", shape, turned, "--complete", "--json"});
            BOOST_TEST(checked.status == 0);
            BOOST_TEST(json::parse(checked.out)["positive_inside"] == true);
            run_well({"slice", usual, "-o", folder.file("usual.png"), "--pixels", "200"});
            run_well({"slice", turned, "-o", folder.file("turned.png"), "--pixels", "200"});
            BOOST_TEST(content_of(folder.file("usual.png")).size() == content_of(folder.file("turned.png")).size());
        }
    }
    // A file that does not say so.
    const std::string plain = folder.file("plain.sdf");
    const Outcome warned =
        run_command({"compute", shape, "-o", plain, "--resolution", "9", "--band", "full", "--positive-inside"});
    BOOST_TEST(warned.error.find("does not state that it is positive inside") != std::string::npos);
    run_well({"check", shape, plain, "--positive-inside", "--tolerance-voxels", "1e-4"});
    const std::string negative = folder.file("negative.sdf"), picture = folder.file("plain.png");
    run_well({"compute", shape, "-o", negative, "--resolution", "9", "--band", "full"});
    for (const std::vector<std::string>& drawing :
         {std::vector<std::string>{"slice", "--pixels", "200"}, {"render", "--size", "100"}}) {
        std::vector<std::string> of_plain{drawing[0],         plain, "-o", picture, drawing[1], drawing[2],
                                          "--positive-inside"};
        run_well(of_plain);
        const std::string drawn = content_of(picture);
        run_well({drawing[0], negative, "-o", picture, drawing[1], drawing[2]});
        BOOST_TEST((content_of(picture) == drawn), drawing[0]);
    }
    check_refused(run_command({"compute", shape, "-o", folder.file("a.nrrd"), "--band", "0", "--margin", "1",
                               "--positive-inside"}),
                  2, {"--band 0", "zeros"});
    check_refused(run_command({"compute", shape, "-o", folder.file("a.nrrd"), "--sign", "none", "--positive-inside"}),
                  2, {"no sign"});
    // Points.
    const std::string found = folder.file("found.csv");
    run_well({"query", shape, points, "-o", found, "--half-width", "2", "--positive-inside", "--quiet"});
    const std::string rows = content_of(found);
    BOOST_TEST(rows == "x,y,z,distance\n0.5,0.5,0.5,0.5\n0,0,0,-0\n9,0,0,-2\n");
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(a_sparse_field)

BOOST_AUTO_TEST_CASE(is_computed_described_checked_sliced_and_drawn) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::vector<std::string> band{"--resolution", "60", "--band", "2v"};
    const auto run = [&](std::vector<std::string> arguments, const std::vector<std::string>& more = {}) {
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run_command(arguments);
        BOOST_TEST_CONTEXT("message: " << outcome.error)
        BOOST_TEST(outcome.status == 0);
        return outcome;
    };
    run({"compute", mesh, "-o", folder.file("dense.nrrd")}, band);
    const clsdf::Field dense = clsdf::read_field(folder.file("dense.nrrd"));
    for (const std::string name : {"field.npy", "field.h5", "field.nvdb"}) {
        const std::string field = folder.file(name);
        const json computed = json::parse(run({"compute", mesh, "-o", field, "--sparse", "--json"}, band).out);
        BOOST_TEST(computed["sparse"] == true);
        const std::optional<clsdf::SparseField> sparse = clsdf::read_sparse_field(field);
        BOOST_REQUIRE(sparse.has_value());
        BOOST_CHECK(std::ranges::equal(to_dense(*sparse).distance(), dense.distance()));
        const json about = json::parse(run({"info", field, "--json"}).out);
        BOOST_TEST(about["sparse"] == true);
        BOOST_TEST(about["bricks"]["values"] == sparse->bricks.size());
        BOOST_TEST(about["bricks"]["all"] == 8 * 8 * 8);
        BOOST_TEST(about["band_samples"] == computed["statistics"]["band_samples"]);
        run({"check", mesh, field, "--samples", "2000"});
        run({"slice", field, "-o", folder.file("slice.png"), "--pixels", "100"});
        run({"render", field, "-o", folder.file("render.png"), "--size", "32"});
    }
    const json about = json::parse(run({"info", folder.file("dense.nrrd"), "--json"}).out);
    BOOST_TEST(about["sparse"] == false);
    BOOST_TEST(about["outputs"] == json::array({"distance"}));
}

BOOST_AUTO_TEST_CASE(is_refused_where_there_is_none) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const auto refused = [&](const std::string& name, const std::vector<std::string>& options,
                             const std::vector<std::string>& parts) {
        std::vector<std::string> arguments{"compute", mesh, "-o", folder.file(name), "--sparse"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        check_refused(run_command(arguments, no_devices), 2, parts);
    };
    refused("a.nrrd", {}, {"a.nrrd", "stores no sparse fields", ".h5"});
    refused("a.npy", {"--band", "full", "--dry-run"}, {"--sparse", "no end", "--band"});
    refused("a.npy", {"--band", "0", "--margin", "1", "--dry-run"}, {"--sparse", "signs alone"});
    refused("a.npy", {"--scan", "brute-force", "--dry-run"}, {"--sparse", "--scan"});
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_SUITE_END()
