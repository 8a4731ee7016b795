#include "apps/process.hpp"
#include "support/doubtful_meshes.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"

#include <clsdf/mesh_files.hpp>

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;
using nlohmann::json;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

/// Runs the command, which gives one warning. Checks that it takes at most two lines of 100 letters with the fragments,
/// and that JSON and --verbose have all of it. Returns the text of JSON.
std::string check_two_lines(std::vector<std::string> arguments, const std::vector<std::string>& fragments) {
    arguments.insert(arguments.end(), {"--quiet", "--json"});
    const Outcome brief = run_command(arguments, no_devices);
    arguments.emplace_back("--verbose");
    const Outcome verbose = run_command(arguments, no_devices);
    BOOST_TEST_CONTEXT(brief.error) {
        BOOST_REQUIRE(brief.status == 0);
        const json warnings = json::parse(brief.out)["warnings"];
        BOOST_REQUIRE(warnings.size() == 1U);
        BOOST_TEST(json::parse(verbose.out)["warnings"] == warnings);
        const auto whole = warnings[0].get<std::string>();
        BOOST_TEST(verbose.error == "warning: " + whole + "\n");
        const std::vector<std::string> lines = lines_of(brief.error);
        BOOST_TEST(lines.size() <= 2U);
        std::string text;
        for (const std::string& line : lines) {
            BOOST_TEST(line.size() <= 100U, line.size());
            text += text.empty() ? line : ' ' + line.substr(std::min(line.find_first_not_of(' '), line.size()));
        }
        BOOST_TEST(text.starts_with("warning: "));
        for (const std::string& fragment : fragments)
            BOOST_TEST(text.find(fragment) != std::string::npos, "no '" << fragment << "'");
        // What is left out is said to be there.
        const bool is_cut = text.ends_with("; --verbose tells more") || text.ends_with(" ...");
        if (whole.find(" to (") != std::string::npos) BOOST_TEST(is_cut);
        if (!is_cut) BOOST_TEST(text.ends_with(whole.substr(whole.size() - 8)));
        BOOST_TEST(text.find(" to (") == std::string::npos);
        return whole;
    }
    return {};
}

struct MeshFile {
    explicit MeshFile(const Mesh& mesh) { write_mesh(mesh, path); }
    TemporaryFolder folder;
    std::string path = folder.file("mesh.off");
};

std::string check_mesh(const Mesh& mesh, const std::vector<std::string>& fragments,
                       const std::vector<std::string>& options = {}) {
    const MeshFile file(mesh);
    std::vector<std::string> arguments{"compute", file.path, "--dry-run"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return check_two_lines(arguments, fragments);
}

Mesh without(const Mesh& mesh, std::size_t count) {
    std::vector<Triangle> triangles = mesh.triangles();
    triangles.resize(triangles.size() - count);
    return Mesh(mesh.vertices(), triangles);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(warnings)

BOOST_AUTO_TEST_CASE(of_the_sign_take_two_lines_and_have_the_remedy) {
    const Mesh sphere = make_shape("sphere3"), solid = tilted(cube(1.0 / 3));
    // Meshes that are nearly balanced.
    check_mesh(seamed_torus(), {"vertices differ from another one by rounding and count as it"});
    check_mesh(with_faces(sphere, {sphere.triangles()[40]}, ""), {"1 face is there twice and counts once"});
    check_mesh(with_turned(sphere, {3, 200, 201}, ""), {"3 faces look the wrong way and are turned around"});
    check_mesh(reversed(solid), {"inside out", "is inside all the same"});
    // Open ones.
    check_mesh(without(sphere, 1),
               {"3 open edges", "follows from the winding number", "--sign none gives the distance alone"});
    const std::string turned =
        check_mesh(with_turned(without(sphere, 1), {7}, ""), {"3 open edges", "--sign none gives"});
    BOOST_TEST(turned.find("1 face looks the wrong way and is turned around") != std::string::npos, turned);
    const std::string half = check_mesh(without(solid, 6), {"no sign", "close the surface, for example by walls"});
    BOOST_TEST(half.find("its winding number is in doubt") != std::string::npos, half);
    BOOST_TEST(half.find("--weld LENGTH") != std::string::npos, half);
    check_mesh(without(solid, 10), {"no sign", "close the surface, for example by walls"});
    check_mesh(Mesh({{0, 0, 2}, {4, 0, 2}, {4, 4, 2}, {0, 4, 3}}, {{0, 1, 2}, {0, 2, 3}}),
               {"no sign", "close the surface, for example by walls", "--sign below --floor Z"});
    check_mesh(without(solid, 11), {"--sign none gives"}, {"--sign", "solid-angle"});
    // A Klein bottle.
    check_mesh(parametric(28, 20, 2 * std::numbers::pi, "",
                          [](double u, double v) {
                              const double radius =
                                  2 + std::cos(u / 2) * std::sin(v) - std::sin(u / 2) * std::sin(2 * v);
                              return Vec3{radius * std::cos(u), radius * std::sin(u),
                                          std::sin(u / 2) * std::sin(v) + std::cos(u / 2) * std::sin(2 * v)};
                          }),
               {"the sign follows from parity", "unbalanced edges"});
    check_mesh(boxes_with_membrane(), {"2 faces of inner walls are left out"});
    // Meshes that are left as they are.
    check_mesh(together({cube(1), reversed(shifted(cube(1), {1, 1, 1}))}, ""),
               {"1 of 2 parts looks inwards", "turn the faces of this part around", "triangle 12"});
    check_mesh(together({cube(1), tilted(cube(0.4))}, ""), {"--sign parity makes cavities", "triangle 12"});
    // All at once: remedies come first.
    check_mesh(
        with_faces(together({seamed_torus(), shifted(cube(1), {9, 0, 0}), shifted(tilted(cube(0.4)), {9, 0, 0})}, ""),
                   {seamed_torus().triangles()[5]}, ""),
        {"--sign parity makes cavities"});
}

BOOST_AUTO_TEST_CASE(of_details_are_there_once_and_json_counts_them) {
    // A lamp on a body, open towards it, above a gap.
    const Mesh mesh = together({box({0, 0, 0}, {8, 8, 4}), open_box({1, 1, 4.1}, {2, 2, 6.1}, 4)}, "");
    const std::string text = check_mesh(mesh, {"follows from the winding number", "1 small open part is a detail",
                                               "close it, or --sign none gives the distance alone"});
    BOOST_TEST(text.find("the detail has 10 faces (the first is triangle 12)") != std::string::npos, text);
    BOOST_TEST(text.find("it has 4 open edges") != std::string::npos, text);
    const MeshFile file(mesh);
    const Outcome info = run_command({"info", file.path, "--json"}, no_devices);
    const json defects = json::parse(info.out)["defects"];
    BOOST_TEST(defects["detail_parts"] == 1);
    BOOST_TEST(defects["detail_faces"] == 10);
    BOOST_TEST(info.error.find("sign      1 small open part of 10 faces counts as a detail of the body\n") !=
               std::string::npos);
    const Outcome computed =
        run_command({"compute", file.path, "--resolution", "9", "-o", file.folder.file("a.npy"), "--json"});
    const json topology = json::parse(computed.out)["topology"];
    BOOST_TEST(topology["detail_parts"] == 1);
    BOOST_TEST(topology["detail_faces"] == 10);
}

BOOST_AUTO_TEST_CASE(of_parts_that_overlap_nothing_say_so_of_an_overlap_only_if_there_is_one) {
    const std::string apart =
        check_mesh(together({cube(1), reversed(shifted(cube(0.5), {9, 0, 0}))}, ""), {"turn the faces"});
    BOOST_TEST(apart.find("an overlap with another part, if there is one, is outside") != std::string::npos, apart);
}

BOOST_AUTO_TEST_CASE(of_turned_faces_do_not_contradict_that_the_mesh_is_inside_out) {
    const std::string text = check_mesh(reversed(with_turned(make_shape("torus"), {1, 2}, "")), {"inside out"});
    BOOST_TEST(text.find("2 faces look another way than their neighbours and are turned around") != std::string::npos,
               text);
    BOOST_TEST(text.find("the wrong way") == std::string::npos, text);
}

BOOST_AUTO_TEST_CASE(of_a_weld_that_flattens_a_wall_name_the_length) {
    // Beside a body that stays: that nothing is inside would be another warning.
    const MeshFile file(together({plate(0.001), box({3, 0, 0}, {4, 1, 1})}, "a plate and a box"));
    const std::string text =
        check_two_lines({"compute", file.path, "--dry-run", "--weld", "0.002"},
                        {"--weld 0.002: ", "lose their area", "1.004 to 1; ", "give a smaller one"});
    BOOST_TEST(text.find("volume changes from ") != std::string::npos, text);
    check_two_lines({"info", file.path, "--weld", "0.002"}, {"--weld 0.002: ", "give a smaller one"});
    const Outcome thick = run_command({"info", file.path, "--weld", "0.0005", "--quiet"}, no_devices);
    BOOST_TEST(thick.error.empty(), thick.error);
}

BOOST_AUTO_TEST_CASE(of_a_narrow_band_name_a_wider_one) {
    check_mesh(cube(1), {"0.1 voxels wide", "choose --band 2v or more"}, {"--band", "0.1v"});
}

BOOST_AUTO_TEST_CASE(of_a_mesh_between_samples_say_that_none_is_inside) {
    const MeshFile file(plate(0.001));
    const auto with_box = [&](const char* corners) {
        return std::vector<std::string>{"compute", file.path, "--dry-run", "--cells",
                                        "12,12,3", corners,   "--band",    "1"};
    };
    check_two_lines(with_box("--box=-1.5,-1.5,-0.3,1.5,1.5,0.45"),
                    {"0.004 spacings wide along z", "between two samples", "choose a finer grid"});
    std::vector<std::string> meets = with_box("--box=-1.5,-1.5,-0.25,1.5,1.5,0.5");
    meets.emplace_back("--quiet");
    const Outcome one_inside = run_command(meets, no_devices);
    BOOST_TEST(one_inside.error.empty(), one_inside.error);
}

BOOST_AUTO_TEST_CASE(of_bad_facets_count_them_and_errors_name_the_option) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("a.obj",
                                         "v 0 0 0\nv 1.0D+00 0 0\nv 0 1 0\nv 0 0 1\nv 0.12345678901234567 nan 2\n"
                                         "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\nf 1 2 5\nf 1 2 9\n");
    check_refused(run_command({"info", mesh}, no_devices), 3, {"--skip-bad-facets"});
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"info", mesh},
                                                      {"compute", mesh, "--dry-run"},
                                                      {"polyhedra", mesh, "-o", folder.file("b.ply")}}) {
        std::vector<std::string> with_option = arguments;
        with_option.emplace_back("--skip-bad-facets");
        check_two_lines(with_option, {"2 faces with a vertex", "left out", "line 10 (a vertex is (0.123457, nan, 2))"});
    }
}

BOOST_AUTO_TEST_SUITE_END()
