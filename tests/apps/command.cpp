#include "apps/process.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>
#include <clsdf/version.hpp>

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <map>
#include <string>

using clsdf::test::check_refused;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;

BOOST_AUTO_TEST_SUITE(the_command)

BOOST_AUTO_TEST_CASE(has_help_with_examples_on_every_page) {
    std::vector<std::vector<std::string>> pages{{"--help"}};
    for (const std::string& name : clsdf::test::subcommands()) pages.push_back({name, "--help"});
    for (const std::vector<std::string>& arguments : pages) {
        const Outcome outcome = run_command(arguments);
        BOOST_TEST_CONTEXT("help of " << arguments.front()) {
            BOOST_TEST(outcome.status == 0);
            BOOST_TEST(outcome.error.empty());
            BOOST_TEST(outcome.out.find("Examples:\n  clsdf ") != std::string::npos);
            BOOST_TEST(outcome.out.find("Exit status: 0 done") != std::string::npos);
        }
    }
}

BOOST_AUTO_TEST_CASE(tells_its_version_and_what_it_was_built_with) {
    const Outcome outcome = run_command({"--version"});
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(outcome.out.starts_with("clsdf " + clsdf::version()));
    for (const char* part : {"CGAL ", "Eigen ", "cairo 1."})
        BOOST_TEST(outcome.out.find(part) != std::string::npos, "no " << part << " in " << outcome.out);
}

BOOST_AUTO_TEST_CASE(has_usage_lines_with_what_is_required_in_the_order_of_the_command_line) {
    for (const auto& [name, usage] : std::map<std::string, std::string>{{"compute", "MESH... -o FIELD"},
                                                                        {"query", "MESH... POINTS -o RESULT"},
                                                                        {"check", "MESH... FIELD"},
                                                                        {"slice", "FIELD -o PICTURE"},
                                                                        {"render", "FIELD -o PICTURE"},
                                                                        {"info", "MESH..."},
                                                                        {"polyhedra", "MESH... -o FILE"},
                                                                        {"close", "MESH... -o FILE --floor Z"},
                                                                        {"outer", "MESH... -o FILE"},
                                                                        {"shape", "SHAPE -o FILE"},
                                                                        {"devices", ""},
                                                                        {"bench", "BENCHMARK [MESHES...]"},
                                                                        {"help", "[SUBCOMMAND]"}}) {
        const std::string page = run_command({name, "--help"}).out;
        const std::string line = "\nUsage: clsdf " + name + " [OPTIONS]" + (usage.empty() ? "" : " ") + usage + '\n';
        BOOST_TEST(page.find(line) != std::string::npos, "no " << line << " in " << page.substr(0, 200));
    }
    BOOST_TEST(run_command({"--help"}).out.find("\nUsage: clsdf [OPTIONS] SUBCOMMAND\n") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(has_the_same_page_as_help_and_as_option) {
    BOOST_TEST(run_command({"help", "compute"}).out == run_command({"compute", "--help"}).out);
    BOOST_TEST(run_command({"help"}).out == run_command({"--help"}).out);
    // Without arguments it is a mistake, and answered with the same page.
    const Outcome outcome = run_command({});
    BOOST_TEST(outcome.status == 2);
    BOOST_TEST(outcome.out.empty());
    BOOST_TEST(outcome.error == run_command({"--help"}).out);
}

BOOST_AUTO_TEST_CASE(reads_and_writes_files_only) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    check_refused(run_command({"compute", mesh, "-o", "-"}), 2, {"--output", "standard input and output"});
    check_refused(run_command({"compute", "-", "-o", folder.file("a.nrrd")}), 2, {"MESH", "standard input and output"});
    check_refused(run_command({"check", mesh, "-"}), 2, {"FIELD", "standard input and output"});
    check_refused(run_command({"slice", "", "-o", "a.png"}), 2, {"FIELD", "missing"});
    check_refused(run_command({"compute", mesh, "-o", folder.file("")}), 2, {".nrrd"});
    std::filesystem::create_directory(folder.file("folder.nrrd"));
    check_refused(run_command({"compute", mesh, "-o", folder.file("folder.nrrd")}), 5, {"Is a directory"});
    check_refused(run_command({"compute", mesh, "-o", mesh}), 2, {"mesh.off", "is the mesh that is read"});
    check_refused(run_command({"compute", mesh, "-o", folder.file("other.off")}), 2, {"other.off", ".nrrd"});
}

BOOST_AUTO_TEST_CASE(takes_names_with_blanks_and_letters_of_any_language) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("ein Körper.off", tetrahedron);
    const std::string field = folder.file("поле 1.nrrd");
    const Outcome outcome = run_command({"compute", mesh, "-o", field, "--resolution", "9", "--json", "--quiet"});
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(nlohmann::json::parse(outcome.out)["output"] == field);
    BOOST_TEST(clsdf::read_field(field).mesh_name == "ein Körper.off");
}

BOOST_AUTO_TEST_CASE(answers_a_mistyped_word_with_the_nearest_one) {
    check_refused(run_command({"compte", "a.off", "-o", "a.nrrd"}), 2, {"compte", "did you mean compute?"});
    check_refused(run_command({"compute", "a.off", "-o", "a.nrrd", "--resoluton", "9"}), 2,
                  {"--resoluton", "did you mean --resolution?"});
    check_refused(run_command({"device"}), 2, {"did you mean devices?"});
    check_refused(run_command({"polyhedron", "a.off"}), 2, {"did you mean polyhedra?"});
    check_refused(run_command({"compute", "a.off", "--ouptut=a.nrrd"}), 2, {"--ouptut", "did you mean --output?"});
    check_refused(run_command({"check", "a.off", "a.nrrd", "--compl"}), 2, {"did you mean --complete?"});
    check_refused(run_command({"--versoin"}), 2, {"did you mean --version?"});
    check_refused(run_command({"help", "shap"}), 2, {"did you mean shape?"});
    check_refused(run_command({"compute", "a.off", "--dry-run", "--sign", "nonzer"}), 2,
                  {"--sign", "auto, nonzero", "did you mean nonzero?"});
    check_refused(run_command({"shape", "kont", "-o", "a.off"}), 2, {"kont", "knot"});
    const Outcome axis = run_command({"slice", "a.nrrd", "-o", "a.png", "--axis", "w"});
    check_refused(axis, 2, {"--axis: one of x, y, z, not 'w'"});
    BOOST_TEST(axis.error.find("did you mean") == std::string::npos);
    const Outcome nothing_near = run_command({"compute", "a.off", "-o", "a.nrrd", "--xyzzy-plugh-frotz"});
    check_refused(nothing_near, 2, {"--xyzzy-plugh-frotz", "clsdf compute --help"});
    BOOST_TEST(nothing_near.error.find("did you mean") == std::string::npos);
}

BOOST_AUTO_TEST_CASE(needs_a_subcommand_and_its_arguments) {
    check_refused(run_command({}), 2, {"subcommand", "--help"});
    check_refused(run_command({"compute"}), 2, {"MESH is required (the mesh: .off"});
    check_refused(run_command({"slice", "a.nrrd"}), 2, {"--output is required (the picture: .png"});
    check_refused(run_command({"check", "a.off"}), 2, {"FIELD"});
    check_refused(run_command({"shape"}), 2, {"name", "--list"});
    check_refused(run_command({"shape", "knot", "--list"}), 2, {"--list", "SHAPE"});
    check_refused(run_command({"shape", "-o", "knot.off", "--list"}), 2, {"--list", "--output"});
}

BOOST_AUTO_TEST_CASE(says_which_mesh_cannot_be_read_within_a_second_of_processor_time_and_writes_nothing) {
    const TemporaryFolder folder;
    const std::string output = folder.file("field.nrrd");
    const auto refused = [&](const std::string& name, const std::string& content) {
        BOOST_TEST_CONTEXT("mesh " << name) {
            const std::string mesh = folder.file(name, content);
            const Outcome outcome = run_command({"compute", mesh, "-o", output}, no_devices);
            check_refused(outcome, 3, {name});
            BOOST_TEST(outcome.cpu_seconds < 1);
            BOOST_TEST(!std::filesystem::exists(output));
        }
    };
    std::string random_bytes;
    for (unsigned i = 0, state = 1; i < 10000; ++i, state = state * 1664525 + 1013904223)
        random_bytes += static_cast<char>(state >> 24);

    for (const std::string ending : {".off", ".obj", ".stl", ".ply"}) {
        refused("empty" + ending, "");
        refused("random" + ending, random_bytes);
    }
    refused("truncated.off", tetrahedron.substr(0, 60));
    refused("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
    refused("nan.off", "OFF\n3 1 0\n0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n");
    refused("billion.off", "OFF\n1000000000 1000000000 0\n0 0 0\n");
    refused("none.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n");
    refused("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    refused("billion.stl", std::string(80, ' ') + "\xff\xff\xff\x3f" + std::string(50, ' '));
    refused("billion.ply",
            "ply\nformat ascii 1.0\nelement vertex 1000000000\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1000000000\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n");
    check_refused(run_command({"compute", folder.file("missing.off"), "-o", output}), 3, {"missing.off"});
}

BOOST_AUTO_TEST_CASE(says_which_field_cannot_be_read) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    check_refused(run_command({"check", mesh, folder.file("field.nrrd", "NRRD0005\ntype: float\n")}), 3,
                  {"field.nrrd"});
    check_refused(run_command({"check", mesh, folder.file("missing.npy")}), 3, {"missing.npy"});
}

BOOST_AUTO_TEST_CASE(refuses_options_that_make_no_sense) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::string output = folder.file("field.nrrd");
    const auto refused = [&](const std::vector<std::string>& options, const std::vector<std::string>& fragments) {
        std::vector<std::string> arguments{"compute", mesh, "-o", output};
        arguments.insert(arguments.end(), options.begin(), options.end());
        BOOST_TEST_CONTEXT("option " << options.front() << " " << (options.size() > 1 ? options[1] : ""))
        check_refused(run_command(arguments, no_devices), 2, fragments);
    };
    for (const char* number : {"many", "1", "1e3", "-3", "", "99999999999999999999"})
        refused({"--resolution", number},
                {"--resolution: a whole number from 2 to 1073741824, not '" + std::string(number) + "'"});
    refused({"--resolution", "7", "--band", "3v"}, {"3 voxels", "7"});
    refused({"--resolution", "64", "--spacing", "0.1"}, {"--resolution", "--spacing"});
    refused({"--spacing", "0.1,0.2"}, {"--spacing", "0.1,0.2"});
    for (const char* option : {"--spacing", "--size", "--origin", "--margin", "--band", "--band-inside"})
        refused({option, ""}, {option, "missing"});
    refused({"--spacing", "0"}, {"spacing", "0"});
    refused({"--spacing", "nan"}, {"spacing", "nan"});
    refused({"--spacing", "1e-300"}, {"larger spacing"});
    refused({"--band", "3x"}, {"--band", "3x", "10%"});
    refused({"--band-inside", "-1"}, {"--band-inside", "-1"});
    refused({"--band", "garbage", "--band-inside", "1", "--band-outside", "1"}, {"--band", "garbage"});
    refused({"--margin", "full"}, {"margin"});
    refused({"--size", "8,8,8"}, {"--origin", "--spacing"});
    refused({"--origin", "0,0,0", "--spacing", "1"}, {"--size"});
    refused({"--size", "8,8,8", "--origin", "0,0", "--spacing", "1"}, {"--origin", "0,0"});
    refused({"--size", "8,0,8", "--origin", "0,0,0", "--spacing", "1"}, {"0 samples along y"});
    refused({"--size", "8,8,8", "--margin", "1"}, {"--size", "--margin"});
    refused({"--sign", "sometimes"}, {"sometimes", "nonzero"});
    refused({"--with", "colour"}, {"--with", "colour", "triangle"});
    refused({"--with", "trianlge"}, {"--with", "trianlge", "did you mean triangle?"});
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(refuses_numbers_of_a_check_that_make_no_sense) {
    const auto refused = [](const std::string& option, const std::string& value, const std::string& expected) {
        BOOST_TEST_CONTEXT(option << " " << value)
        check_refused(run_command({"check", "a.off", "a.nrrd", option, value}), 2,
                      {option, expected, "'" + value + "'"});
    };
    for (const char* value : {"0", "-1", "1e3", "99999999999999999999"})
        refused("--samples", value, "a whole number from 1");
    for (const char* value : {"-1", "x", "18446744073709551616"}) refused("--seed", value, "a whole number from 0");
    for (const char* value : {"nan", "inf", "-1", "1e999", "x"})
        refused("--tolerance-voxels", value, "a finite number, 0 or more");
}

BOOST_AUTO_TEST_CASE(looks_at_the_output_before_anything_else) {
    const TemporaryFolder folder;
    const std::string missing = folder.file("missing.off");
    check_refused(run_command({"compute", missing, "-o", folder.file("field.vtk")}), 2, {"field.vtk", ".nrrd"});
    check_refused(run_command({"compute", missing, "-o", folder.file("no/field.nrrd")}), 5, {"no/field.nrrd"});
    check_refused(run_command({"compute", missing}), 2, {"-o"});
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(says_what_to_install_where_there_is_no_device_and_writes_nothing) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    check_refused(run_command({"compute", mesh, "-o", folder.file("field.nrrd")}, no_devices), 4,
                  {"OpenCL", "pocl-opencl-icd"});
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(writes_the_outer_surface_of_several_files) {
    const TemporaryFolder folder;
    const std::string cube = folder.file("cube.off"), again = folder.file("again.off"),
                      output = folder.file("outer.ply");
    write_mesh(clsdf::make_shape("cube"), cube);
    write_mesh(clsdf::make_shape("cube"), again);
    const clsdf::Vec3 side = clsdf::read_mesh(cube).box().extent();
    // Twice the same, and a third one, moved by half its side.
    const std::string moved = folder.file("moved.off");
    const clsdf::Mesh given = clsdf::read_mesh(cube);
    std::vector<clsdf::Vec3> vertices = given.vertices();
    for (clsdf::Vec3& vertex : vertices) vertex[0] += side[0] / 2;
    write_mesh(clsdf::Mesh(vertices, given.triangles()), moved);
    const Outcome outcome = run_command({"outer", cube, again, moved, "-o", output, "--json"}, no_devices);
    BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
    const nlohmann::json report = nlohmann::json::parse(outcome.out);
    BOOST_TEST(report["volume"] == 1.5 * side[0] * side[1] * side[2]);
    BOOST_TEST(report["hidden_faces"] >= given.triangles().size());
    const clsdf::Mesh surface = clsdf::read_meshes(std::array{output}, {.group_by = "given_face"});
    BOOST_TEST(surface.triangles().size() == report["triangles"]);
    BOOST_TEST(describe_topology(surface).balanced);
    BOOST_TEST(surface.groups().names.size() ==
               report["whole_faces"].get<std::size_t>() + report["partial_faces"].get<std::size_t>());
    const nlohmann::json info =
        nlohmann::json::parse(run_command({"info", output, "--outer", "--json"}, no_devices).out);
    BOOST_TEST(info["outer"]["volume"] == report["volume"]);
    BOOST_TEST(info["outer"]["hidden_faces"] == 0);
    check_refused(run_command({"outer", cube, "-o", cube}, no_devices), 2, {"is the mesh that is read"});
    check_refused(run_command({"outer", cube, "-o", folder.file("outer.txt")}, no_devices), 2, {".ply"});
    check_refused(
        run_command({"outer", folder.file("sheet.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "-o", output},
                    no_devices),
        2, {"sheet.off", "closed mesh"});
}

BOOST_AUTO_TEST_CASE(closes_a_terrain_by_walls_and_a_floor) {
    const TemporaryFolder folder;
    const std::string terrain =
        folder.file("terrain.off", "OFF\n4 2 0\n0 0 2\n4 0 2\n4 4 2\n0 4 2\n3 0 1 2\n3 0 2 3\n");
    for (const std::string ending : {".off", ".obj", ".stl", ".ply"}) {
        const std::string closed = folder.file("closed" + ending);
        const Outcome outcome = run_command({"close", terrain, "-o", closed, "--floor", "-1.5", "--json"}, no_devices);
        BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
        const nlohmann::json report = nlohmann::json::parse(outcome.out);
        BOOST_TEST(report["triangles"] == 12);  // 2, as many on the floor, and 8 of walls
        BOOST_TEST(report["floor"] == -1.5);
        const clsdf::Mesh mesh = clsdf::read_mesh(closed);
        BOOST_TEST(mesh.triangles().size() == 12U);
        BOOST_TEST(describe_topology(mesh).balanced);
        BOOST_TEST(mesh.box().lower[2] == -1.5);
        BOOST_TEST(mesh.box().upper[2] == 2.0);
    }
    const std::string closed = folder.file("closed.off");
    // Lengths are those after --scale.
    BOOST_TEST(run_command({"close", terrain, "-o", closed, "--floor", "1", "--scale", "3"}, no_devices).status == 0);
    BOOST_TEST(clsdf::read_mesh(closed).box().upper[2] == 6.0);
    const auto refused = [&](const std::vector<std::string>& arguments, int status,
                             const std::vector<std::string>& texts) {
        check_refused(run_command(arguments, no_devices), status, texts);
    };
    refused({"close", terrain, "-o", closed}, 2, {"--floor is required"});
    refused({"close", terrain, "-o", closed, "--floor", "2"}, 2, {terrain, "--floor 2", "lowest vertex"});
    refused({"close", terrain, "-o", terrain, "--floor", "0"}, 2, {"is the mesh that is read"});
    refused({"close", folder.file("solid.off", tetrahedron), "-o", closed, "--floor", "-9"}, 3,
            {"solid.off", "needs a terrain"});
}

BOOST_AUTO_TEST_CASE(makes_shapes_and_lists_them) {
    const TemporaryFolder folder;
    const Outcome list = run_command({"shape", "--list"});
    BOOST_TEST(list.status == 0);
    BOOST_TEST(list.out.find("torus") != std::string::npos);

    for (const std::string ending : {".off", ".obj", ".stl", ".ply"}) {
        const std::string mesh = folder.file("torus" + ending);
        const Outcome made = run_command({"shape", "torus", "-o", mesh, "--quiet"});
        BOOST_TEST(made.status == 0);
        BOOST_TEST(made.error.empty());
        BOOST_TEST(run_command({"compute", mesh, "--dry-run"}, no_devices).status == 0);
    }
    check_refused(run_command({"shape", "torsu", "-o", folder.file("a.off")}), 2, {"torsu", "torus"});
    check_refused(run_command({"shape", "torus", "-o", folder.file("a.xyz")}), 2, {"a.xyz", ".off"});
    check_refused(run_command({"shape", "torus", "-o", folder.file("no/a.off")}), 5, {"no/a.off"});
    BOOST_TEST(folder.file_count() == 4U);
}

BOOST_AUTO_TEST_SUITE_END()
