#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>

#include "written_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

using Names = std::vector<std::string>;
using Numbers = std::vector<std::uint32_t>;

void check_groups(const Mesh& mesh, const Names& names, const Numbers& numbers) {
    BOOST_TEST(mesh.groups().names == names, boost::test_tools::per_element());
    BOOST_TEST(mesh.groups().numbers == numbers, boost::test_tools::per_element());
}

void check_groups_of_file(const std::string& name, const std::string& text, const Names& names, const Numbers& numbers,
                          const ReadOptions& options = {}) {
    BOOST_TEST_CONTEXT(name << ":\n" << text.substr(0, 1000)) {
        const TemporaryFolder folder;
        check_groups(read_mesh(folder.file(name, text), options), names, numbers);
    }
}

std::string facet(double x) {
    return fmt::format(
        "facet normal 0 0 1\nouter loop\nvertex {0} 0 0\nvertex {1} 0 0\nvertex {0} 1 0\nendloop\nendfacet\n", x,
        x + 1);
}

std::string solid(const std::string& name, int facets) {
    std::string text = "solid " + name + "\n";
    for (int t = 0; t < facets; ++t) text += facet(t);
    return text + "endsolid " + name + "\n";
}

const std::string ply =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 3\nproperty int label\nproperty list uchar int vertex_indices\nproperty float weight\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n7 4 0 1 2 3 1\n-2 3 0 1 2 1\n7 3 0 2 3 1\n";

}  // namespace

BOOST_AUTO_TEST_CASE(solids_of_an_stl_file_are_groups_and_equal_names_are_one) {
    check_groups_of_file("a.stl", solid("inlet", 2) + solid("wall of brick", 1) + solid("none", 0) + solid("inlet", 1),
                         {"inlet", "wall of brick"}, {0, 0, 1, 0});
    check_groups_of_file("a.stl", solid("  one \t body  ", 2), {"one body"}, {0, 0});
    check_groups_of_file("a.stl", solid("", 1) + solid("b", 1), {"", "b"}, {0, 1});
    check_groups_of_file("a.stl", solid("", 1) + solid("", 1), {}, {});
    // A polygon of four corners is two triangles.
    check_groups_of_file("a.stl", replaced(solid("a", 2), "vertex 0 1 0", "vertex 1 1 0\nvertex 0 1 0") + solid("b", 1),
                         {"a", "b"}, {0, 0, 0, 1});
    // However they begin and end.
    check_groups_of_file("a.stl", "solid a\n" + facet(0) + "solid b\n" + facet(1) + "endsolidb\nsolidc\n" + facet(2),
                         {"a", "b", "c"}, {0, 1, 2});
    check_groups_of_file(
        "a.stl", with_line_ends(solid("a facet", 2) + solid("", 1) + solid("b # 1", 1) + solid("solid", 1), " "),
        {"a facet", "", "b # 1", "solid"}, {0, 0, 1, 2, 3});
    // Parts of a large text are read on all cores.
    const int many = 20000;
    Numbers numbers(many, 0);
    numbers.insert(numbers.end(), many, 1);
    numbers.push_back(2);
    check_groups_of_file("a.stl", solid("first", many) + solid("second", many) + solid("third", 1),
                         {"first", "second", "third"}, numbers);
    const TemporaryFolder folder;
    write_mesh(make_shape("cube"), folder.file("binary.stl"));
    check_groups(read_mesh(folder.file("binary.stl")), {}, {});
}

BOOST_AUTO_TEST_CASE(groups_and_objects_of_an_obj_file_are_groups) {
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", face = "f 1 2 3\n";
    const auto check = [&](const std::string& text, const Names& names, const Numbers& numbers) {
        check_groups_of_file("a.obj", vertices + text, names, numbers);
    };
    check(face, {}, {});
    check("g inlet # a comment\n" + face + "g wall left\nf 1 2 3 4\ng inlet\n" + face, {"inlet", "wall left"},
          {0, 1, 1, 0});
    check("o hull\n" + face + "o deck\n" + face, {"hull", "deck"}, {0, 1});
    check(face + "g last\n" + face, {"", "last"}, {0, 1});
    // A group stays when an object begins, as in the specification, and equal names are not repeated.
    check("o hull\ng left\n" + face + "o deck\n" + face + "g\n" + face + "g deck\n" + face,
          {"hull/left", "deck/left", "deck"}, {0, 1, 2, 2});
    check("g\no\n" + face, {}, {});
}

BOOST_AUTO_TEST_CASE(a_property_of_faces_of_a_ply_file_makes_groups_if_it_is_named) {
    check_groups_of_file("a.ply", ply, {}, {});
    check_groups_of_file("a.ply", ply, {"7", "-2"}, {0, 0, 1, 0}, {.group_by = "label"});
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& file, const std::string& property, const std::string& fragment) {
        check_throws(ErrorCode::invalid_argument, {file, "'" + property + "'", fragment},
                     [&] { read_mesh(folder.file(file), {.group_by = property}); });
    };
    folder.file("a.ply", ply);
    refused("a.ply", "patch", "label, vertex_indices, weight");
    refused("a.ply", "vertex_indices", "a list");
    refused("a.ply", "weight", "no integer");
    write_mesh(make_shape("cube"), folder.file("a.off"));
    refused("a.off", "label", ".ply");
}

BOOST_AUTO_TEST_CASE(each_of_several_files_is_a_group_or_a_prefix) {
    const TemporaryFolder folder, other;
    const std::string plain = folder.file("plain.stl", solid("exported", 2)),
                      two = folder.file("two.parts.stl", solid("inlet", 1) + solid("", 1) + solid("wall", 1)),
                      same = other.file("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    check_groups(read_meshes(Names{plain, two, same}),
                 {"plain", "two.parts/inlet", "two.parts", "two.parts/wall", "plain_2"}, {0, 0, 1, 2, 3, 4});
    check_groups(read_meshes(Names{plain}), {"exported"}, {0, 0});
}

BOOST_AUTO_TEST_CASE(groups_stay_when_a_mesh_is_copied_welded_or_moved) {
    const TemporaryFolder folder;
    Mesh mesh =
        read_mesh(folder.file("a.stl", solid("a", 2) + solid("b", 1)), {.scale = 2, .up = "y", .rotate = {1, 2, 3}});
    std::vector<Vec3> positions = mesh.vertices();
    mesh.set_positions(positions);
    const Mesh copy = mesh, welded = weld(copy), joined = weld(copy, 0.1);
    for (const Mesh* one : {&copy, &welded, &joined}) check_groups(*one, {"a", "b"}, {0, 0, 1});
    mesh.set_groups({});
    check_groups(mesh, {}, {});
    check_groups(copy, {"a", "b"}, {0, 0, 1});
    BOOST_TEST(copy.groups().of(2) == 1);
    BOOST_TEST(copy.groups().of(no_triangle) == no_group);
    BOOST_TEST(mesh.groups().of(0) == no_group);
    BOOST_TEST(mesh.hash() == copy.hash());
}

BOOST_AUTO_TEST_CASE(groups_that_do_not_fit_a_mesh_are_refused) {
    Mesh mesh(square, two_triangles);
    mesh.set_groups({{"a", "unused", "b"}, {2, 0}});
    const auto refused = [&](FaceGroups groups, const std::vector<std::string>& fragments) {
        check_throws(ErrorCode::invalid_argument, fragments, [&] { mesh.set_groups(std::move(groups)); });
        check_groups(mesh, {"a", "unused", "b"}, {2, 0});
    };
    refused({{"a"}, {0}}, {"2 triangles", "numbers for 1"});
    refused({{"a"}, {0, 1}}, {"triangle 1", "the group 1", "1 names"});
    refused({{}, {0, 0}}, {"triangle 0", "0 names"});
    refused({{"a", "b", "a"}, {0, 1}}, {"two groups", "'a'"});
}

BOOST_AUTO_TEST_CASE(a_file_with_another_axis_up_is_rotated_exactly) {
    const TemporaryFolder folder;
    constexpr unsigned seed = 12;
    BOOST_TEST_INFO("seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> any(-1000, 1000);
    Mesh mesh = make_shape("torus");
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& vertex : vertices)
        for (double& coordinate : vertex) coordinate = any(random);
    vertices[0] = {0, 0, 0};
    mesh.set_positions(vertices);
    const std::string path = folder.file("mesh.ply");
    write_mesh(mesh, path);
    const auto check = [&](const ReadOptions& options, const auto& expected) {
        const Mesh read = read_mesh(path, options);
        for (std::size_t v = 0; v < vertices.size(); ++v) {
            const auto [x, y, z] = vertices[v];
            BOOST_REQUIRE((read.vertices()[v] == expected(x, y, z)));
            for (const double coordinate : read.vertices()[0]) BOOST_REQUIRE(!std::signbit(coordinate));
        }
    };
    check({.up = "z"}, [](double x, double y, double z) { return Vec3{x, y, z}; });
    check({.up = "-z"}, [](double x, double y, double z) { return Vec3{x, -y, -z}; });
    check({.up = "y"}, [](double x, double y, double z) { return Vec3{x, -z, y}; });
    check({.up = "-y"}, [](double x, double y, double z) { return Vec3{x, z, -y}; });
    check({.up = "x"}, [](double x, double y, double z) { return Vec3{-z, y, x}; });
    check({.up = "-x"}, [](double x, double y, double z) { return Vec3{z, y, -x}; });
    // The scale, up, about x, y and z, the translation.
    check({.rotate = {90, 0, 0}}, [](double x, double y, double z) { return Vec3{x, -z, y}; });
    check({.rotate = {0, -270, 0}}, [](double x, double y, double z) { return Vec3{z, y, -x}; });
    check({.rotate = {0, 0, 450}}, [](double x, double y, double z) { return Vec3{-y, x, z}; });
    check({.rotate = {90, 0, 90}}, [](double x, double y, double z) { return Vec3{z, x, y}; });
    check({.scale = 0.5, .translate = {1, 2, 3}, .up = "y", .rotate = {0, 0, 180}}, [](double x, double y, double z) {
        return Vec3{-0.5 * x + 1, 0.5 * z + 2, 0.5 * y + 3};
    });
}

BOOST_AUTO_TEST_CASE(a_rotation_by_any_angles_keeps_lengths_and_is_that_of_the_fixed_axes) {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.off", "OFF\n3 1 0\n1 0 0\n0 2 0\n0 0 3\n3 0 1 2\n");
    const double degree = std::acos(-1) / 180;
    const auto near = [](const Vec3& a, const Vec3& b) {
        for (std::size_t axis = 0; axis < 3; ++axis) BOOST_TEST(std::abs(a[axis] - b[axis]) < 1e-14);
    };
    const Mesh about_z = read_mesh(path, {.rotate = {0, 0, 30}});
    near(about_z.vertices()[0], {std::cos(30 * degree), 0.5, 0});
    near(about_z.vertices()[1], {-1, 2 * std::cos(30 * degree), 0});
    const Mesh about_both = read_mesh(path, {.rotate = {60, 0, 30}});  // first about x
    near(about_both.vertices()[0], about_z.vertices()[0]);
    near(about_both.vertices()[1], {-0.5, std::cos(30 * degree), 2 * std::sin(60 * degree)});
    const Mesh all = read_mesh(path, {.rotate = {10, -20, 1000}});
    for (std::size_t v = 0; v < 3; ++v) {
        const auto& [x, y, z] = all.vertices()[v];
        BOOST_TEST(std::abs(std::hypot(x, y, z) - (1.0 + static_cast<double>(v))) < 1e-14);
    }
    check_throws(ErrorCode::invalid_argument, {"up", "'w'", "-z"}, [&] { read_mesh(path, {.up = "w"}); });
    check_throws(ErrorCode::invalid_argument, {"rotate", "degrees"}, [&] {
        read_mesh(path, {.rotate = {0, std::nan(""), 0}});
    });
}

BOOST_AUTO_TEST_CASE(a_vti_file_has_the_group_of_each_sample) {
    const TemporaryFolder folder;
    FieldDescription description;
    description.grid = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
    description.band = Band::symmetric(1);
    Field field(description, Output::distance | Output::triangle);
    const std::array<std::uint32_t, 8> triangles{0, 1, 2, 1, 0, no_triangle, 2, 2};
    std::ranges::copy(triangles, field.triangle().begin());
    std::ranges::fill(field.distance(), 0.5F);
    const std::string plain = folder.file("plain.vti"), path = folder.file("groups.vti");
    write_field(field, plain);
    BOOST_TEST(content_of(plain).find("group") == std::string::npos);
    field.groups = std::make_shared<const FaceGroups>(FaceGroups{{"in", "out"}, {1, 0, 1}});
    write_field(field, path);
    const std::string text = content_of(path);
    BOOST_TEST(text.find("Name=\"groups\" NumberOfTuples=\"2\"") != std::string::npos);
    BOOST_TEST(text.find("105 110 0 111 117 116 0") != std::string::npos);
    BOOST_TEST(text.find("<DataArray type=\"UInt32\" Name=\"group\" NumberOfComponents=\"1\"") != std::string::npos);
    std::string numbers;
    for (const std::uint32_t number : {1U, 0U, 1U, 0U, 1U, no_group, 1U, 1U})
        numbers += bytes_of(number, std::endian::little);
    BOOST_TEST(text.find(numbers) != std::string::npos);
    // Readers of fields step over it.
    const Field read = read_field(path);
    BOOST_TEST(read.triangle() == triangles, boost::test_tools::per_element());
    // In slices the bytes are the same.
    FieldWriter writer(folder.file("slices.vti"), field, field.outputs());
    for (std::size_t slice = 0; slice < 2; ++slice) {
        FieldSlab slab;
        slab.set(Output::distance, field.distance().subspan(4 * slice, 4));
        slab.set(Output::triangle, field.triangle().subspan(4 * slice, 4));
        writer.append(slab);
    }
    writer.finish();
    BOOST_TEST((content_of(folder.file("slices.vti")) == text));
    BOOST_TEST(stores_groups("a.vti"));
    BOOST_TEST(!stores_groups("a.nrrd"));
}

BOOST_AUTO_TEST_CASE(a_vtkhdf_file_has_the_group_of_each_sample_and_the_same_bytes_in_slices) {
    const TemporaryFolder folder;
    FieldDescription description;
    description.grid = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
    description.band = Band::symmetric(1);
    Field field(description, Output::distance | Output::triangle);
    const std::array<std::uint32_t, 8> triangles{0, 1, 2, 1, 0, no_triangle, 2, 2};
    std::ranges::copy(triangles, field.triangle().begin());
    field.groups = std::make_shared<const FaceGroups>(FaceGroups{{"in", "outside"}, {1, 0, 1}});
    const std::string path = folder.file("groups.vtkhdf");
    write_field(field, path);
    const std::string content = content_of(path);
    std::string numbers;
    for (const std::uint32_t number : {1U, 0U, 1U, 0U, 1U, no_group, 1U, 1U})
        numbers += bytes_of(number, std::endian::little);
    BOOST_TEST(content.find(numbers) != std::string::npos);
    BOOST_TEST(content.find(std::string("in\0\0\0\0\0\0outside\0", 16)) != std::string::npos);
    BOOST_TEST(read_field(path).triangle() == triangles, boost::test_tools::per_element());
    FieldWriter writer(folder.file("slices.vtkhdf"), field, field.outputs());
    for (std::size_t slice = 0; slice < 2; ++slice) {
        FieldSlab slab;
        slab.set(Output::distance, std::as_const(field).distance().subspan(4 * slice, 4));
        slab.set(Output::triangle, std::as_const(field).triangle().subspan(4 * slice, 4));
        writer.append(slab);
    }
    writer.finish();
    BOOST_TEST((content_of(folder.file("slices.vtkhdf")) == content));
    BOOST_TEST(stores_groups("a.VTKHDF"));
}

BOOST_AUTO_TEST_CASE(a_table_of_points_has_the_groups_of_their_triangles) {
    const TemporaryFolder folder;
    const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}};
    const std::array<float, 2> distance{1, 2};
    const std::array<std::uint32_t, 2> triangles{2, no_triangle};
    const FaceGroups groups{{"in", "out"}, {0, 0, 1}};
    FieldSlab results;
    results.set(Output::distance, distance);
    const std::string path = folder.file("a.csv");
    check_throws(ErrorCode::invalid_argument, {"triangle"},
                 [&] { write_points(points, results, path, {}, {}, &groups); });
    results.set(Output::triangle, triangles);
    write_points(points, results, path, {}, distance, &groups);
    BOOST_TEST(content_of(path) ==
               "x,y,z,distance,triangle,group,winding\n0,0,0,1,2,1,1\n1,0,0,2,4294967295,4294967295,2\n");
}
