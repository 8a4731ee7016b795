#include "apps/process.hpp"
#include "support/hostile_meshes.hpp"

#include <clsdf/mesh_files.hpp>

#include <boost/test/unit_test.hpp>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A cube of half side 1 as a file, and rays: through it, from its middle, past it, along a side, and one without a
/// direction.
struct Inputs {
    TemporaryFolder folder;
    std::string mesh = folder.file("cube.off");
    std::vector<std::array<double, 6>> rays{
        {-4, 0.25, 0.5, 2, 0, 0}, {0, 0, 0, 0, 0, -4}, {0, 0, 5, 1, 0, 0}, {-4, 1, 0, 1, 0, 0}, {0, 0, 0, 0, 0, 0}};
    std::string csv, npy;

    Inputs() {
        write_mesh(cube(1), mesh);
        std::string text = "dx,dy,dz,name,X,Y,Z\n", bytes;
        for (const auto& ray : rays) {
            for (const std::size_t k : {3U, 4U, 5U}) text += std::to_string(ray[k]) + ',';
            text += "a ray";
            for (const std::size_t k : {0U, 1U, 2U}) text += ',' + std::to_string(ray[k]);
            text += '\n';
            bytes.append(reinterpret_cast<const char*>(ray.data()), sizeof ray);
        }
        csv = folder.file("rays.csv", text);
        npy = folder.file("rays.npy", npy_of("5, 6", bytes));
    }

    static std::string npy_of(const std::string& shape, const std::string& bytes) {
        const std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + shape + "), }\n";
        return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header + bytes;
    }
};

}  // namespace

BOOST_AUTO_TEST_CASE(rays_of_a_file_get_a_row_each) {
    const Inputs inputs;
    const std::string output = inputs.folder.file("hits.csv");
    for (const std::string& rays : {inputs.csv, inputs.npy}) {
        const Outcome outcome = run_command({"rays", inputs.mesh, rays, "-o", output, "--json"});
        BOOST_TEST_INFO(outcome.error);
        BOOST_TEST(outcome.status == 0);
        BOOST_TEST(content_of(output) ==
                   "x,y,z,dx,dy,dz,t,triangle\n"
                   "-4,0.25,0.5,2,0,0,1.5,8\n"
                   "0,0,0,0,0,-4,0.25,0\n"
                   "0,0,5,1,0,0,inf,4294967295\n"
                   "-4,1,0,1,0,0,inf,4294967295\n"
                   "0,0,0,0,0,0,nan,4294967295\n");
        const nlohmann::json result = nlohmann::json::parse(outcome.out);
        BOOST_TEST(result["count"] == 5);
        BOOST_TEST(result["hit"] == 2);
        BOOST_TEST(result["unusable_rays"] == 1);
        BOOST_TEST(result["hits"] == "walls");
        BOOST_TEST(result["sign"] == "nonzero");
        BOOST_TEST(!result.contains("limit"));
        BOOST_TEST(outcome.error.find("1 of 5 rays") != std::string::npos, outcome.error);
    }
    const Outcome faces = run_command({"rays", inputs.mesh, inputs.npy, "-o", output, "--hits", "faces", "--limit", "3",
                                       "--most", "2", "--count", "--quiet"});
    BOOST_TEST(faces.status == 0, faces.error);
    BOOST_TEST(content_of(output) ==
               "x,y,z,dx,dy,dz,t_1,triangle_1,t_2,triangle_2,count\n"
               "-4,0.25,0.5,2,0,0,1.5,8,2.5,11,2\n"
               "0,0,0,0,0,-4,0.25,0,inf,4294967295,1\n"
               "0,0,5,1,0,0,inf,4294967295,inf,4294967295,0\n"
               "-4,1,0,1,0,0,3,9,inf,4294967295,1\n"
               "0,0,0,0,0,0,nan,4294967295,nan,4294967295,0\n");
}

BOOST_AUTO_TEST_CASE(rays_are_written_as_a_structured_array) {
    const Inputs inputs;
    const std::string output = inputs.folder.file("hits.npy");
    BOOST_TEST(run_command({"rays", inputs.mesh, inputs.csv, "-o", output, "--most", "2", "--count"}).status == 0);
    const std::string content = content_of(output);
    BOOST_TEST(content.find("[('t', '<f8', (2,)), ('triangle', '<u4', (2,)), ('count', '<u4')]") != std::string::npos);
    constexpr std::size_t row = 2 * 8 + 2 * 4 + 4;
    const std::string rows = content.substr(content.size() - 5 * row);
    double t[2];
    std::uint32_t numbers[3];
    std::memcpy(t, rows.data(), sizeof t);
    std::memcpy(numbers, rows.data() + sizeof t, sizeof numbers);
    BOOST_TEST(t[0] == 1.5);
    BOOST_TEST(t[1] == 2.5);
    BOOST_TEST(numbers[0] == 8U);
    BOOST_TEST(numbers[1] == 11U);
    BOOST_TEST(numbers[2] == 2U);
}

BOOST_AUTO_TEST_CASE(rays_have_the_groups_of_the_triangles_that_they_meet) {
    const Inputs inputs;
    // Two parts, each a file and a group.
    const std::string other = inputs.folder.file("other.off"), output = inputs.folder.file("hits.csv");
    write_mesh(box({3, -1, -1}, {4, 1, 1}), other);
    const std::string rays =
        inputs.folder.file("two.csv", "x,y,z,dx,dy,dz\n-4,0.25,0.5,1,0,0\n2,0.25,0.5,1,0,0\n0,0,5,1,0,0\n");
    const auto run = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"rays", inputs.mesh, other, rays, "-o", output, "--with", "group", "--json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run_command(arguments);
        BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
        return nlohmann::json::parse(outcome.out);
    };
    BOOST_TEST(run({})["groups"] == (std::vector<std::string>{"cube", "other"}));
    const std::string one = content_of(output);
    BOOST_TEST(one.starts_with("x,y,z,dx,dy,dz,t,triangle,group\n-4,0.25,0.5,1,0,0,3,8,0\n2,0.25,0.5,1,0,0,1,"), one);
    BOOST_TEST(one.find(",1\n0,0,5,1,0,0,inf,4294967295,4294967295\n") != std::string::npos, one);
    run({"--most", "3", "--count"});
    const std::string three = content_of(output);
    BOOST_TEST(three.starts_with("x,y,z,dx,dy,dz,t_1,triangle_1,group_1,t_2,triangle_2,group_2,t_3,triangle_3,group_3,"
                                 "count\n-4,0.25,0.5,1,0,0,3,8,0,5,11,0,7,"),
               three);
    const std::string npy = inputs.folder.file("hits.npy");
    BOOST_TEST(run_command({"rays", inputs.mesh, other, rays, "-o", npy, "--with", "group"}).status == 0);
    BOOST_TEST(content_of(npy).find("[('t', '<f8'), ('triangle', '<u4'), ('group', '<u4')]") != std::string::npos);
    check_refused(run_command({"rays", inputs.mesh, rays, "-o", output, "--with", "group"}), 2, {"cube", "no groups"});
}

BOOST_AUTO_TEST_CASE(a_limit_may_be_infinite) {
    const Inputs inputs;
    const std::string whole = inputs.folder.file("whole.csv"), limited = inputs.folder.file("limited.csv");
    BOOST_TEST(run_command({"rays", inputs.mesh, inputs.csv, "-o", whole}).status == 0);
    const Outcome outcome = run_command({"rays", inputs.mesh, inputs.csv, "-o", limited, "--limit", "inf"});
    BOOST_TEST(outcome.status == 0, outcome.error);
    BOOST_TEST(content_of(limited) == content_of(whole));
}

BOOST_AUTO_TEST_CASE(rays_that_cannot_be_are_refused) {
    const Inputs inputs;
    const std::string output = inputs.folder.file("hits.csv");
    const auto refused = [&](const std::vector<std::string>& more, int status, const std::vector<std::string>& texts,
                             const std::string& rays) {
        std::vector<std::string> arguments{"rays", inputs.mesh, rays, "-o", output};
        arguments.insert(arguments.end(), more.begin(), more.end());
        check_refused(run_command(arguments), status, texts);
    };
    const std::string points = inputs.folder.file("points.csv", "x,y,z\n0,0,0\n");
    const std::string three = inputs.folder.file("three.npy", Inputs::npy_of("0, 3", ""));
    refused({}, 3, {"points.csv", "no column 'dx'", "x,y,z,dx,dy,dz"}, points);
    refused({}, 3, {"three.npy", "(0, 3)", "(n, 6)"}, three);
    refused({"--refuse-unusable-rays"}, 3, {"ray 4", "its direction is 0"}, inputs.csv);
    refused({"--limit", "-1"}, 2, {"--limit", "0 to inf"}, inputs.csv);
    refused({"--limit", "nan"}, 2, {"--limit", "0 to inf"}, inputs.csv);
    refused({"--hits", "wall"}, 2, {"walls"}, inputs.csv);
    refused({"--sign", "none"}, 2, {"no sign", "faces"}, inputs.csv);
    check_refused(run_command({"rays", inputs.mesh, inputs.csv, "-o", inputs.folder.file("hits.ply")}), 2,
                  {"hits.ply", ".npy and .csv"});
}
