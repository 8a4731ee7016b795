#include "apps/process.hpp"
#include "support/hostile_meshes.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

#include <nlohmann/json.hpp>

#include <sys/stat.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A cube of half side 1 as a file, and points around it.
struct Inputs {
    TemporaryFolder folder;
    std::string mesh = folder.file("cube.off");
    std::vector<Vec3> points{{0.5, 0, 0}, {3, 0.25, -0.5}, {1, 0.5, 0.25}, {-2, -3, 0}};
    std::string csv;

    Inputs() {
        write_mesh(cube(1), mesh);
        std::string text = "id, y, X, z\r\n";
        for (const auto& [x, y, z] : points)
            text += "7," + std::to_string(y) + "," + std::to_string(x) + ", " + std::to_string(z) + "\r\n";
        csv = folder.file("points.csv", text);
    }
};

std::vector<std::vector<std::string>> table_of(const std::string& path) {
    std::vector<std::vector<std::string>> rows;
    std::istringstream lines(content_of(path));
    for (std::string line, field; std::getline(lines, line);) {
        rows.emplace_back();
        std::istringstream fields(line);
        while (std::getline(fields, field, ',')) rows.back().push_back(field);
    }
    return rows;
}

std::string replaced_once(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
}

std::string npy(const std::string& type, const std::string& shape, const std::string& values) {
    std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }\n";
    return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header + values;
}

template <typename Number>
std::string bytes_of(const std::vector<Vec3>& points) {
    std::string bytes;
    for (const Vec3& p : points)
        for (const double x : p) {
            const auto number = static_cast<Number>(x);
            bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
        }
    return bytes;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(the_query_command)

BOOST_AUTO_TEST_CASE(reads_tables_as_numpy_and_paraview_write_them) {
    const Inputs inputs;
    const std::string rows = "0.5,0,0\n3,0.25,-0.5\n1,0.5,0.25\n-2,-3,0\n";
    const auto found = [&](const std::string& names) {
        const std::string result = inputs.folder.file("found.csv");
        const std::string table = inputs.folder.file("table.csv", names + "\n" + rows);
        BOOST_REQUIRE(run_command({"query", inputs.mesh, table, "-o", result}).status == 0);
        return content_of(result);
    };
    const std::string plain = found("x,y,z");
    for (const char* names : {"# x,y,z", "#x, y, z", "Points:0,Points:1,Points:2", "Points_0,Points_1,Points_2"})
        BOOST_TEST(found(names) == plain, names);
}

BOOST_AUTO_TEST_CASE(writes_its_result_into_a_pipe) {
    const Inputs inputs;
    const std::string pipe = inputs.folder.file("pipe.csv");
    BOOST_REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    Process process({"query", inputs.mesh, inputs.csv, "-o", pipe});
    const std::string written = content_of(pipe);
    BOOST_TEST(process.wait().status == 0);
    const std::string path = inputs.folder.file("file.csv");
    BOOST_REQUIRE(run_command({"query", inputs.mesh, inputs.csv, "-o", path}).status == 0);
    BOOST_TEST(written == content_of(path));
}

BOOST_AUTO_TEST_CASE(writes_winding_numbers_as_the_last_column) {
    const Inputs inputs;
    for (const std::string name : {"found.csv", "found.ply", "found.npy"}) {
        const std::string result = inputs.folder.file(name);
        const Outcome outcome = run_command(
            {"query", inputs.mesh, inputs.csv, "-o", result, "--winding", "--sign", "solid-angle", "--json"});
        BOOST_REQUIRE(outcome.status == 0);
        const nlohmann::json report = nlohmann::json::parse(outcome.out);
        BOOST_TEST(report["sign"] == "solid-angle");
        BOOST_TEST(report["winding"] == true);
        BOOST_TEST(content_of(result).find("winding") != std::string::npos);
    }
    const auto rows = table_of(inputs.folder.file("found.csv"));
    BOOST_REQUIRE(rows.size() == 5U);
    const std::vector<std::string> names{"x", "y", "z", "distance", "winding"};
    BOOST_TEST(rows[0] == names, boost::test_tools::per_element());
    BOOST_TEST(rows[1][4] == "1");
    BOOST_TEST(rows[2][4] == "0");
}

BOOST_AUTO_TEST_CASE(takes_what_lies_below_a_terrain_to_be_inside) {
    const Inputs inputs;
    write_mesh({{{0, 0, 2}, {4, 0, 2}, {4, 4, 2}, {0, 4, 2}}, {{0, 1, 2}, {0, 2, 3}}, "terrain"}, inputs.mesh);
    const std::string points = inputs.folder.file("below.csv", "x,y,z\n2,2,1\n2,2,3\n2,2,-2\n"),
                      result = inputs.folder.file("found.csv"), field = inputs.folder.file("field.nrrd");
    BOOST_REQUIRE(
        run_command({"query", inputs.mesh, points, "-o", result, "--sign", "below", "--floor", "-1"}).status == 0);
    const auto rows = table_of(result);
    BOOST_TEST(rows[1][3] == "-1");
    BOOST_TEST(rows[2][3] == "1");
    BOOST_TEST(rows[3][3] == "4");
    // The field knows its floor.
    const Outcome made = run_command({"compute", inputs.mesh, "-o", field, "--resolution", "16", "--margin", "50%",
                                      "--band", "full", "--sign", "below", "--floor", "-1", "--json"});
    BOOST_REQUIRE(made.status == 0);
    const nlohmann::json report = nlohmann::json::parse(made.out);
    BOOST_TEST(report["sign"] == "below");
    BOOST_TEST(report["floor"] == -1);
    BOOST_TEST(report["topology"]["rim_loops"] == 1);
    BOOST_TEST(run_command({"check", inputs.mesh, field, "--complete"}).status == 0);
    BOOST_TEST(read_field(field).floor.value_or(0) == -1);
    for (const std::vector<std::string>& wrong :
         {std::vector<std::string>{"--sign", "below"}, {"--floor", "-1"}, {"--sign", "below", "--floor", "2"}}) {
        std::vector<std::string> arguments{"query", inputs.mesh, points, "-o", result};
        arguments.insert(arguments.end(), wrong.begin(), wrong.end());
        const Outcome refused = run_command(arguments);
        BOOST_TEST(refused.status != 0);
        BOOST_TEST(refused.error.find("floor") != std::string::npos, refused.error);
    }
}

BOOST_AUTO_TEST_CASE(writes_a_table_with_a_row_for_each_point) {
    const Inputs inputs;
    const std::string result = inputs.folder.file("found.csv");
    const Outcome outcome =
        run_command({"query", inputs.mesh, inputs.csv, "-o", result, "--with", "closest,site", "--json"});
    BOOST_TEST(outcome.status == 0);
    const nlohmann::json report = nlohmann::json::parse(outcome.out);
    BOOST_TEST(report["count"] == 4);
    BOOST_TEST(report["inside"] == 1);
    BOOST_TEST(report["sign"] == "nonzero");
    BOOST_TEST(report["half_width"].is_null());
    const auto rows = table_of(result);
    BOOST_REQUIRE(rows.size() == 5U);
    const std::vector<std::string> names{"x", "y", "z", "distance", "site", "closest_x", "closest_y", "closest_z"};
    BOOST_TEST(rows[0] == names, boost::test_tools::per_element());
    BOOST_TEST(std::stod(rows[1][3]) == -0.5);
    BOOST_TEST(std::stod(rows[2][3]) == 2);
    BOOST_TEST(std::stod(rows[2][5]) == 1, boost::test_tools::tolerance(1e-12));
    BOOST_TEST(rows[3][3] == "0");
    BOOST_TEST(std::stod(rows[4][3]) == std::sqrt(5.0), boost::test_tools::tolerance(1e-7));
    BOOST_TEST(std::stoi(rows[4][4]) < 6);  // an edge or a vertex
    BOOST_TEST((read_points(result) == inputs.points));
}

BOOST_AUTO_TEST_CASE(reads_and_writes_every_format_alike) {
    const Inputs inputs;
    const std::string first = inputs.folder.file("a.csv");
    const std::vector<std::string> options{"--with", "triangle,barycentric", "--half-width", "1.5", "--quiet"};
    const auto run = [&](const std::string& points, const std::string& result) {
        std::vector<std::string> arguments{"query", inputs.mesh, points, "-o", result};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const Outcome outcome = run_command(arguments);
        BOOST_TEST(outcome.status == 0);
        BOOST_TEST(outcome.error.empty(), outcome.error);
    };
    run(inputs.csv, first);
    const std::string expected = content_of(first);
    BOOST_TEST(table_of(first)[2][3] == "1.5");         // beyond the limit
    BOOST_TEST(table_of(first)[2][4] == "4294967295");  // no triangle
    BOOST_TEST(table_of(first)[2][5] == "nan");         // no barycentric coordinates
    const std::string ply = inputs.folder.file("a.ply"), second = inputs.folder.file("b.csv");
    run(inputs.csv, ply);
    run(ply, second);
    BOOST_TEST((content_of(second) == expected));
    for (const std::string& points :
         {inputs.folder.file("f4.npy", npy("<f4", "4, 3", bytes_of<float>(inputs.points))),
          inputs.folder.file("f8.npy", npy("<f8", "4, 3", bytes_of<double>(inputs.points)))}) {
        run(points, second);
        BOOST_TEST((content_of(second) == expected));
    }
    const std::string array = inputs.folder.file("a.npy");
    run(inputs.csv, array);
    const std::string content = content_of(array);
    BOOST_TEST(content.find("{'descr': [('distance', '<f4'), ('triangle', '<u4'), ('barycentric', '<f4', (2,))], "
                            "'fortran_order': False, 'shape': (4,), }") != std::string::npos);
    BOOST_REQUIRE(content.size() % 64 == 4 * 16 % 64);
    float distance = 0;
    std::memcpy(&distance, content.data() + content.size() - 4 * 16, sizeof(distance));
    BOOST_TEST(distance == -0.5F);
}

BOOST_AUTO_TEST_CASE(writes_every_value_that_is_no_number_alike) {
    const TemporaryFolder folder;
    const std::string file = folder.file("found.csv");
    const float none = std::numeric_limits<float>::quiet_NaN();
    const double wide = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Vec3> points(1);
    const std::vector<double> closest{wide, -wide, std::copysign(wide, -1)};
    const std::vector<float> distance{std::copysign(none, -1.0F)};
    FieldSlab found;
    found.set(Output::distance, distance);
    found.set(Output::closest, closest);
    write_points(points, found, file);
    const std::vector<std::string> expected{"0", "0", "0", "nan", "nan", "nan", "nan"};
    BOOST_TEST(table_of(file)[1] == expected, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(reads_points_in_fortran_order_and_fields_in_quotes) {
    const Inputs inputs;
    std::string columns;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const Vec3& point : inputs.points) columns += bytes_of<double>({{point[axis], 0, 0}}).substr(0, 8);
    std::string content = npy("<f8", "4, 3", columns);
    content.replace(content.find("False"), 5, "True ");
    BOOST_TEST((read_points(inputs.folder.file("f.npy", content)) == inputs.points));
    const std::vector<Vec3> expected{{1, 2, 3}};
    const std::string table = inputs.folder.file("q.csv", "\"name, \"\"long\"\"\",\"x\",y,z\n\"a,b\",1,\"2\",3\n");
    BOOST_TEST((read_points(table) == expected));
    // Marks of inches, within fields that are not in quotes.
    for (const char* text : {"name,x,y,z\n12\" pipe,1,2,3\n", "size,x,y,z,note\n5\",1,2,3,6\"\n"})
        BOOST_TEST((read_points(inputs.folder.file("inches.csv", text)) == expected));
}

BOOST_AUTO_TEST_CASE(counts_points_that_are_not_finite_or_too_far) {
    const Inputs inputs;
    const std::string result = inputs.folder.file("found.csv");
    const std::string points = inputs.folder.file("marks.csv", "x,y,z\n0.5,0,0\nnan,nan,nan\n1e30,0,0\n0.25,0,0\n");
    const Outcome outcome = run_command(
        {"query", inputs.mesh, points, "-o", result, "--with", "triangle", "--half-width", "0.6", "--json"});
    BOOST_TEST(outcome.status == 0);
    const nlohmann::json report = nlohmann::json::parse(outcome.out);
    BOOST_TEST(report["unusable_points"] == 2);
    BOOST_REQUIRE(report["warnings"].size() == 1U);
    const auto warning = report["warnings"][0].get<std::string>();
    BOOST_TEST(warning.find("1 of 4 points has no triangle and the distance NaN") != std::string::npos, warning);
    BOOST_TEST(warning.find("1 of 4 points has no triangle and the distance the half width, 0.6") != std::string::npos);
    const auto rows = table_of(result);
    BOOST_TEST(std::stod(rows[1][3]) == -0.5);
    const std::vector<std::string> expected{"nan", "nan", "nan", "nan", "4294967295"};
    BOOST_TEST(rows[2] == expected, boost::test_tools::per_element());
    BOOST_TEST(rows[3][3] == "0.6");
    BOOST_TEST(rows[4][3] == "-0.6");
}

BOOST_AUTO_TEST_CASE(takes_an_empty_field_and_marks_of_missing_values_for_nan) {
    const Inputs inputs;
    const std::vector<std::string> marks{"",       " ",     "\"\"",    "NA",      "N/A",     "n/a",
                                         "null",   "NULL",  "None",    "#N/A",    "<NA>",    "#N/A N/A",
                                         "#NA",    "nan",   "-NaN",    "-1.#IND", "1.#QNAN", "-1.#QNAN",
                                         "1.#IND", "#NUM!", "#DIV/0!", "#VALUE!", "\\N"};
    std::string text = "x,y,z,note\n0.5D+00,0,0,\n,,,\n\n  \n";
    for (const std::string& mark : marks) text += "0.5," + mark + ",0,a\n";
    const std::vector<Vec3> points = read_points(inputs.folder.file("missing.csv", text + "0.25,0,0,NA\n"));
    BOOST_TEST_REQUIRE(points.size() == marks.size() + 3);
    BOOST_TEST((points[0] == Vec3{0.5, 0, 0} && points.back() == Vec3{0.25, 0, 0}));
    for (const double x : points[1]) BOOST_TEST(std::isnan(x));
    for (std::size_t i = 0; i < marks.size(); ++i)
        BOOST_TEST((std::isnan(points[i + 2][1]) && points[i + 2][0] == 0.5 && points[i + 2][2] == 0), marks[i]);
    const std::string result = inputs.folder.file("found.csv");
    const Outcome outcome =
        run_command({"query", inputs.mesh, inputs.folder.file("missing.csv"), "-o", result, "--json"});
    BOOST_TEST_REQUIRE(outcome.status == 0, outcome.error);
    BOOST_TEST(nlohmann::json::parse(outcome.out)["unusable_points"] == marks.size() + 1);
    const auto rows = table_of(result);
    BOOST_TEST(rows[1][3] == "-0.5");
    BOOST_TEST(rows[2][3] == "nan");
    BOOST_TEST(rows.back()[3] == "-0.75");
    for (const char* other : {"missing", "N-A", "#", "--", "nul"})
        check_refused(
            run_command({"query", inputs.mesh,
                         inputs.folder.file("h.csv", std::string("x,y,z\n1,2,3\n1,") + other + ",3\n"), "-o", result}),
            3, {"h.csv: line 3: ", other});
}

BOOST_AUTO_TEST_CASE(counts_points_inside_only_if_there_is_an_inside) {
    const Inputs inputs;
    const std::string result = inputs.folder.file("found.csv");
    const std::string sheet = inputs.folder.file("sheet.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    BOOST_TEST(run_command({"query", inputs.mesh, inputs.csv, "-o", result}).error.find("1 of them inside") !=
               std::string::npos);
    const std::string report = run_command({"query", sheet, inputs.csv, "-o", result}).error;
    BOOST_TEST(report.find("without a sign") != std::string::npos, report);
    BOOST_TEST(report.find("of them inside") == std::string::npos, report);
}

BOOST_AUTO_TEST_CASE(takes_several_files_as_one_body) {
    const Inputs inputs;
    const std::string second = inputs.folder.file("second.stl"), result = inputs.folder.file("found.csv");
    write_mesh(box({2, -1, -1}, {4, 1, 1}), second);
    BOOST_TEST(run_command({"query", inputs.mesh, second, inputs.csv, "-o", result, "--quiet"}).status == 0);
    BOOST_TEST(std::stod(table_of(result)[2][3]) == -0.5);  // (3, 0.25, -0.5)
    BOOST_TEST(std::stod(table_of(result)[1][3]) == -0.5);
    const std::string field = inputs.folder.file("two.nrrd");
    const Outcome computed =
        run_command({"compute", inputs.mesh, second, "-o", field, "--resolution", "24", "--band", "full", "--json"});
    BOOST_TEST(computed.status == 0);
    BOOST_TEST(nlohmann::json::parse(computed.out)["mesh"]["name"] == "cube.off + second.stl");
    BOOST_TEST(nlohmann::json::parse(computed.out)["mesh"]["triangles"] == 24);
    BOOST_TEST(run_command({"check", inputs.mesh, second, field}).status == 0);
    BOOST_TEST(run_command({"check", inputs.mesh, field}).status == 1);
    const Outcome info = run_command({"info", inputs.mesh, second, "--json"});
    BOOST_TEST(nlohmann::json::parse(info.out)["triangles"] == 24);
    check_refused(run_command({"compute", inputs.mesh, second, "-o", second}), 2, {"second.stl"});
}

BOOST_AUTO_TEST_CASE(results_of_any_program_are_judged_at_their_points) {
    const Inputs inputs;
    const std::string found = inputs.folder.file("found.csv");
    BOOST_REQUIRE(
        run_command({"query", inputs.mesh, inputs.csv, "-o", found, "--with", "closest,gradient,triangle"}).status ==
        0);
    const std::vector<std::string> asked{"check", inputs.mesh, "--points",    inputs.csv, "--distances",
                                         found,   "--closest", found,         "--json",   "--gradients",
                                         found,   "--quiet",   "--triangles", found};
    const Outcome passed = run_command(asked);
    BOOST_TEST(passed.status == 0, passed.error);
    BOOST_TEST(nlohmann::json::parse(passed.out)["points"] == 4);

    // The structures that it writes itself, too.
    const std::string structures = inputs.folder.file("found.npy");
    BOOST_REQUIRE(run_command({"query", inputs.mesh, inputs.csv, "-o", structures, "--with", "closest"}).status == 0);
    BOOST_TEST(run_command({"check", inputs.mesh, "--points", inputs.csv, "--distances", structures, "--closest",
                            structures, "--quiet"})
                   .status == 0);
    check_refused(run_command({"check", inputs.mesh, "--points", inputs.csv, "--distances", structures, "--gradients",
                               structures}),
                  3, {"no member 'gradient' of 3 numbers, but 'distance' of 1, 'closest' of 3"});

    const std::string wrong = inputs.folder.file("wrong.csv", "distance\n0.5\n2.00001\n0\nnan\n");
    const Outcome failed = run_command({"check", inputs.mesh, "--points", inputs.csv, "--distances", wrong, "--json"});
    BOOST_TEST(failed.status == 1);
    const nlohmann::json report = nlohmann::json::parse(failed.out);
    BOOST_TEST(report["wrong_distances"] == 2);
    BOOST_TEST(report["wrong_signs"] == 1);
    BOOST_TEST(report["max_error"].is_null());
    BOOST_TEST(report["findings"].size() == 3U);
    BOOST_TEST(failed.error.find("| cube.off | 4 | inf | 2 | 1 | 0 | 0 | 0 |") != std::string::npos, failed.error);
    const std::string near = inputs.folder.file("near.csv", "distance\n-0.5\n2.00001\n0\n2.2360680\n");
    BOOST_TEST(run_command({"check", inputs.mesh, "--points", inputs.csv, "--distances", near, "--tolerance", "2e-5"})
                   .status == 0);
    BOOST_TEST(run_command({"check", inputs.mesh, "--points", inputs.csv, "--distances", near}).status == 1);

    // Two cubes that overlap: the distance in the overlap is that to the union if it is asked for.
    const std::string two = inputs.folder.file("two.off"), point = inputs.folder.file("point.csv", "x,y,z\n0.5,0,0\n"),
                      of_union = inputs.folder.file("union.csv", "distance\n-1\n");
    write_mesh(together({cube(1), shifted(cube(1), {1, 0, 0})}, "two"), two);
    const auto judged = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"check", two, "--points", point, "--distances", of_union};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run_command(arguments);
    };
    BOOST_TEST(judged({}).status == 1);
    BOOST_TEST(judged({"--surface", "outer"}).status == 0);
    check_refused(judged({"--surface", "outer", "--triangles", found}), 2, {"--triangles"});
    const std::string field = inputs.folder.file("union.nrrd");
    BOOST_TEST(
        run_command({"compute", two, "-o", field, "--surface", "outer", "--resolution", "16", "--quiet"}).status == 0);
    const Outcome without = run_command({"check", two, field});
    BOOST_TEST(without.status == 1);
    BOOST_TEST(without.error.find("check it with --surface outer") != std::string::npos, without.error);
    for (const char* option : {"--samples", "--seed", "--tolerance-voxels"})
        check_refused(judged({option, "7"}), 2, {option, "--points"});
    check_refused(judged({"--complete"}), 2, {"--complete", "--points"});

    check_refused(run_command({"check", inputs.mesh, "--points", inputs.csv}), 2, {"--distances"});
    check_refused(run_command({"check", inputs.mesh, "--distances", found}), 2, {"--points"});
    const std::string few = inputs.folder.file("few.csv", "distance\n1\n");
    check_refused(run_command({"check", inputs.mesh, "--points", inputs.csv, "--distances", few}), 3,
                  {"few.csv", "1 rows", "4 points"});
    check_refused(run_command({"check", inputs.mesh, "--points", inputs.csv, "--distances", inputs.csv}), 3,
                  {"no column 'distance'"});
}

BOOST_AUTO_TEST_CASE(takes_a_scene_of_many_bodies) {
    const Inputs inputs;
    const std::string result = inputs.folder.file("found.csv"), array = inputs.folder.file("found.npy");
    const std::string head = R"({"bodies": [{"name": "base", "mesh": "cube.off"})";
    const auto scene = [&](const std::string& more) { return inputs.folder.file("scene.json", head + more + "]}"); };
    const std::string points = inputs.folder.file("row.csv", "x,y,z\n0,0,3\n10,0,3\n0,0,0.5\n10,0,90\n");
    const std::string rows = "[[0, -1, 0, 10], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";
    const std::string numbers = "[0, -1, 0, 10, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]";
    for (const std::string& pose : {rows, numbers}) {
        const std::string path = scene(R"(, {"name": "arm", "instance": "base", "pose": )" + pose + "}");
        const Outcome outcome = run_command(
            {"query", path, points, "-o", result, "--with", "closest", "--half-width", "9", "--winding", "--json"});
        BOOST_TEST_REQUIRE(outcome.status == 0, outcome.error);
        const auto table = table_of(result);
        BOOST_TEST((table[0] == std::vector<std::string>{"x", "y", "z", "distance", "closest_x", "closest_y",
                                                         "closest_z", "body", "winding"}));
        BOOST_TEST((table[1][3] == "2" && table[1][7] == "0" && table[1][8] == "0"));
        BOOST_TEST((table[2][3] == "2" && table[2][7] == "1" && std::stod(table[2][4]) == 10));
        BOOST_TEST((table[3][3] == "-0.5" && table[3][7] == "0" && table[3][8] == "1"));
        BOOST_TEST((table[4][3] == "9" && table[4][7] == "4294967295"));
        const auto json = nlohmann::json::parse(outcome.out);
        BOOST_TEST(json["inside"] == 1);
        BOOST_TEST(json["bodies"].size() == 2U);
        BOOST_TEST(json["bodies"][1]["name"] == "arm");
        BOOST_TEST(json["bodies"][1]["triangles"] == 12);
        BOOST_TEST(json["bodies"][1]["sign"] == "nonzero");
        BOOST_TEST(outcome.error.find("2 bodies") != std::string::npos, outcome.error);
    }
    BOOST_TEST(run_command({"query", scene(""), points, "-o", array, "--quiet"}).status == 0);
    BOOST_TEST(content_of(array).find("('body', '<u4')]") != std::string::npos);
    BOOST_TEST(
        run_command({"query", scene(R"(, {"mesh": ["cube.off"], "sign": "none"})"), points, "-o", result}).status == 0);

    // 0.3 and 0.2 deep in two cubes, and 1 in their union.
    const std::string together =
        scene(R"(, {"instance": "base", "pose": [1, 0, 0, 1.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]})");
    const std::string deep = inputs.folder.file("deep.csv", "x,y,z\n0.7,0,0\n");
    BOOST_TEST(run_command({"query", together, deep, "-o", result, "--surface", "outer", "--quiet"}).status == 0);
    BOOST_TEST(table_of(result)[1][3] == "-1");
    const std::string field = inputs.folder.file("together.nrrd");
    const Outcome made = run_command({"compute", together, "-o", field, "--surface", "outer", "--resolution", "16",
                                      "--band", "full", "--with", "body", "--quiet"});
    BOOST_TEST(made.status == 0, made.error);
    BOOST_TEST(std::ranges::min(read_field(field).distance()) < -0.8F);
    BOOST_TEST(run_command({"check", together, field, "--surface", "outer", "--complete", "--quiet"}).status == 0);
    const Outcome of_given = run_command({"check", together, field, "--complete"});
    BOOST_TEST(of_given.status == 1);
    BOOST_TEST(of_given.error.find("check it with --surface outer") != std::string::npos, of_given.error);
    check_refused(run_command({"compute", together, "--dry-run", "--surface", "outer", "--with", "site"}), 2,
                  {"site", "--surface outer"});
    const std::string merged = inputs.folder.file("merged.off"), cells = inputs.folder.file("cells.npz");
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"outer", together, "-o", merged, "--json"},
          std::vector<std::string>{"fractions", together, "-o", cells, "--resolution", "9", "--json"}}) {
        const Outcome of_union = run_command(command);
        BOOST_TEST_REQUIRE(of_union.status == 0, of_union.error);
        const auto json = nlohmann::json::parse(of_union.out);
        BOOST_TEST(std::abs(json["volume"].get<double>() - 14) < 1e-12);
        BOOST_TEST(std::abs(json["area"].get<double>() - 36) < 1e-12);
    }
    check_refused(run_command({"outer", together, "-o", merged, "--sign", "parity"}), 2, {"--sign", "scene.json"});
    check_refused(run_command({"fractions", together, "-o", cells, "--resolution", "200000"}), 4,
                  {"of memory", "--resolution"});

    for (const auto& [more, message] : std::vector<std::pair<std::string, std::string>>{
             {", {}", "body 1, counted from 0: it needs either 'mesh'"},
             {R"(, {"mesh": "cube.off", "instance": "base"})", "either 'mesh'"},
             {R"(, {"instance": "arm"})", "no body before it has the name 'arm'"},
             {R"(, {"instance": "base", "sign": "none"})", "leave 'sign' out"},
             {R"(, {"instance": "base", "name": "base"})", "has the name 'base', too"},
             {R"(, {"instance": "base", "place": 1})", "no member 'place'"},
             {R"(, {"instance": "base", "pose": 1, "pose": 2})", "has the member 'pose' twice"},
             {R"(, {"name": "lid", "mesh": "none.off"})", "body 1, 'lid'"},
             {R"(, {"instance": "base", "pose": [1, 2]})", "no 4 x 4 matrix"},
             {R"(, {"instance": "base", "pose": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, "a"]})", "no number"},
             {R"(, {"instance": "base", "pose": [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]})", "no rotation"},
             {R"(, {"instance": "base", "pose": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2]})", "last row"},
             {R"(, {"mesh": "cube.off", "sign": "below"})", "sign rule 'below' is not one of"},
             // Texts end there for the system, and so would the message.
             {R"(, {"name": "li\u0000d", "mesh": "none.off"})", R"("li\u0000d" has the character U+0000)"},
             {R"(, {"mesh": "cube.off\u0000d"})", R"("cube.off\u0000d" has the character U+0000)"},
             {R"(, {"instance": "base", "pl\u0000ace": 1})", R"("pl\u0000ace" has the character U+0000)"},
             {", 7", "no object"},
             {",", "scene.json"}})
        check_refused(run_command({"query", scene(more), points, "-o", result}), 3, {"scene.json", message});
    check_refused(run_command({"query", inputs.folder.file("none.json", "{\"bodies\": []}"), points, "-o", result}), 3,
                  {"none.json", "empty list"});
    const std::string path = scene("");
    check_refused(run_command({"query", path, points, "-o", result, "--sign", "none"}), 2, {"--sign", "scene.json"});
    check_refused(run_command({"query", path, points, "-o", result, "--with", "group"}), 2, {"--with group"});
    check_refused(run_command({"query", path, points, "-o", result, "--half-width", "10%"}), 2,
                  {"--half-width", "10%"});
    check_refused(run_command({"query", path, inputs.mesh, points, "-o", result}), 2, {"several files"});
    const Outcome info = run_command({"info", path});
    BOOST_TEST(info.status != 0);
    BOOST_TEST(info.error.find("scene of many bodies") != std::string::npos, info.error);
}

BOOST_AUTO_TEST_CASE(a_scene_has_a_field_that_the_reference_confirms) {
    const Inputs inputs;
    const std::string path = inputs.folder.file("scene.json", R"({"bodies": [{"name": "base", "mesh": "cube.off"},
        {"instance": "base", "pose": [0, -1, 0, 1.25, 1, 0, 0, 0.125, 0, 0, 1, 0.25, 0, 0, 0, 1]}]})");
    for (const char* const ending : {"nrrd", "npy", "vti", "h5"}) {
        const std::string file = inputs.folder.file(std::string("field.") + ending);
        const Outcome made = run_command({"compute", path, "-o", file, "--resolution", "24", "--band", "3v", "--with",
                                          "body,triangle,gradient", "--json"});
        BOOST_TEST(made.status == 0, made.error);
        const auto json = nlohmann::json::parse(made.out);
        BOOST_TEST(json["bodies"].size() == 2U);
        BOOST_TEST(json["sign"] == "nonzero");
        Field field = read_field(file);
        for (const std::uint32_t body : {0U, 1U, no_body})
            BOOST_TEST((std::ranges::find(field.body(), body) != field.body().end()));
        const Outcome checked = run_command({"check", path, file, "--complete"});
        BOOST_TEST(checked.status == 0, checked.out + checked.error);
        std::ranges::replace(field.body(), 1U, 0U);
        write_field(field, file);
        const Outcome failed = run_command({"check", path, file, "--complete", "--json"});
        BOOST_TEST(failed.status == 1);
        BOOST_TEST(nlohmann::json::parse(failed.out)["wrong_outputs"]["body"] > 0);
    }
    const std::string file = inputs.folder.file("field.nrrd");
    check_refused(run_command({"compute", path, "-o", file, "--sign", "none"}), 2, {"--sign", "scene.json"});
    check_refused(run_command({"compute", path, inputs.mesh, "-o", file}), 2, {"several files"});
    BOOST_TEST(run_command({"compute", path, "-o", inputs.folder.file("field.vdb")}).status != 0);
    BOOST_TEST(run_command({"compute", path, "--dry-run"}).status == 0);
    check_refused(run_command({"check", path, file, "--floor", "-3"}), 2, {"--floor", "scene.json"});
    const std::string capitals = inputs.folder.file("ARM.JSON", R"({"bodies": [{"mesh": "cube.off"}]})");
    BOOST_TEST(run_command({"compute", capitals, "--dry-run"}).status == 0);
}

BOOST_AUTO_TEST_CASE(writes_the_group_of_the_nearest_triangle) {
    const Inputs inputs;
    const std::string second = inputs.folder.file("second.stl"), result = inputs.folder.file("found.csv"),
                      array = inputs.folder.file("found.npy");
    write_mesh(box({2, -1, -1}, {4, 1, 1}), second);
    const Outcome outcome =
        run_command({"query", inputs.mesh, second, inputs.csv, "-o", result, "--with", "group", "--json"});
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(nlohmann::json::parse(outcome.out)["groups"] == nlohmann::json({"cube", "second"}));
    BOOST_TEST(outcome.error.find("groups  0 'cube', 1 'second'") != std::string::npos, outcome.error);
    const auto table = table_of(result);
    BOOST_TEST((table[0] == std::vector<std::string>{"x", "y", "z", "distance", "triangle", "group"}));
    for (std::size_t row = 1; row < table.size(); ++row)
        BOOST_TEST((table[row][5] == "1") == (std::stoi(table[row][4]) >= 12));
    BOOST_TEST(table[1][5] == "0");
    BOOST_TEST(table[2][5] == "1");  // (3, 0.25, -0.5)
    BOOST_TEST(run_command({"query", inputs.mesh, second, inputs.csv, "-o", array, "--with", "group"}).status == 0);
    BOOST_TEST(content_of(array).find("('triangle', '<u4'), ('group', '<u4')]") != std::string::npos);
    check_refused(run_command({"query", inputs.mesh, inputs.csv, "-o", result, "--with", "group"}), 2,
                  {"--with group", "cube.off has no groups", "--group-by"});
    check_refused(run_command({"query", inputs.mesh, inputs.csv, "-o", result, "--group-by", "label"}), 2,
                  {"cube.off", "'label'", ".ply"});
}

BOOST_AUTO_TEST_CASE(says_what_was_skipped_in_the_mesh) {
    const Inputs inputs;
    const std::string mesh =
        inputs.folder.file("edge.off", replaced_once(content_of(inputs.mesh), " 12 0", " 13 0") + "2 0 1\n");
    const Outcome outcome = run_command({"query", mesh, inputs.csv, "-o", inputs.folder.file("a.csv"), "--json"});
    BOOST_TEST(outcome.status == 0);
    const auto warnings = nlohmann::json::parse(outcome.out)["warnings"];
    BOOST_REQUIRE(warnings.size() == 1U);
    BOOST_TEST(warnings[0].get<std::string>().find("1 face of fewer than three corners is skipped") !=
               std::string::npos);
}

BOOST_AUTO_TEST_CASE(keeps_the_columns_of_the_outputs_without_points) {
    const Inputs inputs;
    const std::string result = inputs.folder.file("none.csv"), array = inputs.folder.file("none.npy");
    for (const std::string& points :
         {inputs.folder.file("a.csv", "x,y,z\n"), inputs.folder.file("a.npy", npy("<f8", "0, 3", {}))}) {
        for (const std::string& output : {result, array}) {
            std::filesystem::remove(output);
            BOOST_TEST(run_command({"query", inputs.mesh, points, "-o", output, "--with", "closest,site"}).status == 0);
        }
        BOOST_TEST(content_of(result) == "x,y,z,distance,site,closest_x,closest_y,closest_z\n");
        BOOST_TEST(content_of(array).find("[('distance', '<f4'), ('site', '|u1'), ('closest', '<f8', (3,))]") !=
                   std::string::npos);
    }
}

BOOST_AUTO_TEST_CASE(errors_name_the_file_the_row_and_the_remedy) {
    const Inputs inputs;
    const std::string result = inputs.folder.file("found.csv");
    const auto query = [&](const std::string& points) {
        return run_command({"query", inputs.mesh, points, "-o", result});
    };
    check_refused(query(inputs.folder.file("a.csv", "x,y\n1,2\n")), 3, {"a.csv: line 1: ", "'z'"});
    check_refused(query(inputs.folder.file("b.csv", "x,y,z\n1,2,3\n4,five,6\n")), 3, {"b.csv", "3", "five"});
    check_refused(query(inputs.folder.file("n.csv", "1,2,3\n")), 3,
                  {"n.csv: line 1: ", "'1,2,3', has no column 'x'", "as in x,y,z"});
    check_refused(query(inputs.folder.file("c.csv", "x,y,z\n1,2\n")), 3, {"c.csv: line 2: ", "2 fields", "3 columns"});
    check_refused(run_command({"query", inputs.mesh, inputs.folder.file("d.csv", "x,y,z\n1,2,3\n1,nan,3\n"), "-o",
                               result, "--refuse-unusable-points"}),
                  3, {"d.csv", "point 1", "not finite"});
    check_refused(query(inputs.folder.file("e.npy", npy("<f4", "2, 2", std::string(16, '\0')))), 3,
                  {"e.npy", "(2, 2)", "(n, 3)"});
    check_refused(query(inputs.folder.file("i.npy", npy("<i8", "2, 3", std::string(48, '\0')))), 3,
                  {"i.npy", "float64"});
    check_refused(query(inputs.folder.file("j.csv", "x,y,z\n1,\"2,3\n")), 3, {"j.csv: line 2: ", "quotation mark"});
    check_refused(query(inputs.folder.file("g.npy", npy("<f4", "2, 3", std::string(16, '\0')))), 3, {"g.npy"});
    check_refused(query(inputs.folder.file("none.csv")), 3, {"none.csv"});
    for (const char* name : {"blank.csv", "blank.ply"})
        check_refused(query(inputs.folder.file(name, "\n\n\n")), 3, {std::string(name) + ": the file has no text"});
    check_refused(query(inputs.folder.file("k.npy", npy("<f8", "-1, 3", {}))), 3, {"k.npy", "(-1, 3)", "n >= 0"});
    check_refused(query(inputs.folder.file("l.csv", "# hi\n1\n")), 3, {"l.csv: line 1: ", "the first row, '# hi'"});
    check_refused(query(inputs.folder.file("m.csv", "x,y,X,z\n1,2,3,4\n")), 3,
                  {"m.csv: line 1: columns 1 and 3 both", "'x' and 'X'"});
    check_refused(query("points.xyz"), 2, {"points.xyz", ".npy, .csv and .ply"});
    check_refused(run_command({"query", inputs.mesh, inputs.csv, "-o", "found.xyz"}), 2, {"found.xyz", ".npy"});
    check_refused(run_command({"query", inputs.mesh, inputs.csv, "-o", result, "--half-width", "-1"}), 2,
                  {"--half-width"});
    const std::string points = content_of(inputs.csv);
    const std::string link = inputs.folder.file("link.csv");
    std::filesystem::create_symlink(inputs.csv, link);
    for (const std::string& output : {inputs.csv, link})
        check_refused(run_command({"query", inputs.mesh, inputs.csv, "-o", output}), 2, {output, "points", "another"});
    BOOST_TEST((content_of(inputs.csv) == points));
    check_refused(run_command({"query", inputs.mesh, inputs.csv}), 2, {"--output"});
}

BOOST_AUTO_TEST_SUITE_END()
