#include <clsdf/eigen.hpp>
#include <clsdf/mesh.hpp>

#include "support/throws.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

namespace clsdf {

using test::check_throws;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
const std::vector<Triangle> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

void check_is_the_tetrahedron(const MeshView& view) {
    const Mesh mesh(view);
    BOOST_CHECK(mesh.vertices() == corners);
    BOOST_CHECK(mesh.triangles() == faces);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_view_reads_the_callers_arrays_whatever_their_type) {
    std::vector<double> doubles;
    std::vector<float> floats;
    std::vector<std::uint32_t> indices;
    for (const Vec3& corner : corners)
        for (const double x : corner) {
            doubles.push_back(x);
            floats.push_back(static_cast<float>(x));
        }
    for (const Triangle& face : faces) indices.insert(indices.end(), face.begin(), face.end());
    check_is_the_tetrahedron(MeshView(doubles, indices));
    check_is_the_tetrahedron(MeshView(floats, indices));
    check_is_the_tetrahedron(MeshView(corners, faces));

    // Four numbers a vertex, and all first corners before all second ones.
    std::vector<float> fours;
    for (const Vec3& corner : corners) {
        for (const double x : corner) fours.push_back(static_cast<float>(x));
        fours.push_back(7);
    }
    std::vector<std::uint32_t> planes;
    for (std::size_t k = 0; k < 3; ++k)
        for (const Triangle& face : faces) planes.push_back(face[k]);
    constexpr std::ptrdiff_t width = 4;
    check_is_the_tetrahedron(MeshView({fours.data(), 4, 4 * width}, {planes.data(), 4, width, 4 * width}));

    // 64 bits an index, the last triangle first; an offset into an array of numbers.
    std::vector<std::int64_t> backwards{7, 7};
    for (std::size_t f = faces.size(); f-- > 0;) backwards.insert(backwards.end(), faces[f].begin(), faces[f].end());
    InputArray triangles(backwards);
    triangles.offset = (2 + 3 * 3) * sizeof(std::int64_t);
    triangles.strides[0] = -static_cast<std::ptrdiff_t>(3 * sizeof(std::int64_t));
    triangles.count = 4;
    check_is_the_tetrahedron(MeshView(corners, triangles));
    const std::vector<std::array<float, 3>> float_corners{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
    check_is_the_tetrahedron(MeshView(float_corners, faces));
}

BOOST_AUTO_TEST_CASE(new_positions_come_from_the_callers_array) {
    Mesh mesh(corners, faces);
    const std::vector<float> from_the_last{0, 0, 6, 9, 0, 4, 0, 9, 2, 0, 0, 9, 0, 0, 0, 9};
    mesh.set_positions({from_the_last.data() + 12, 4, -16});
    BOOST_CHECK((mesh.vertices() == std::vector<Vec3>{{0, 0, 0}, {2, 0, 0}, {0, 4, 0}, {0, 0, 6}}));
    BOOST_CHECK((mesh.box().upper == Vec3{2, 4, 6}));
    check_throws(ErrorCode::invalid_argument, {"4 vertices", "3 positions"}, [&] {
        mesh.set_positions({from_the_last.data(), 3, 16});
    });
    check_throws(ErrorCode::invalid_argument, {"positions", "uint32"}, [&] { mesh.set_positions(InputArray(faces)); });
    mesh.set_positions(corners);
    BOOST_CHECK(mesh.vertices() == corners);
}

// Whichever core finds it first.
BOOST_AUTO_TEST_CASE(the_first_index_that_is_out_of_range_is_named) {
    const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    std::vector<std::array<std::uint64_t, 3>> wide(300'000, {0, 1, 2});
    for (const std::size_t triangle : {299'999U, 180'007U, 70'001U, 180'008U})
        wide[triangle][triangle % 3] = 0xFFFFFFFFU;
    for (int run = 0; run < 10; ++run)
        check_throws(ErrorCode::invalid_mesh, {"triangle 70001", "4294967295"},
                     [&] { Mesh(MeshView(vertices, wide), "wide"); });
    wide[70'001] = wide[180'007] = wide[180'008] = wide[299'999] = {2, 0, 1};
    const Mesh mesh(MeshView(vertices, wide));
    BOOST_TEST((mesh.triangles()[180'007] == Triangle{2, 0, 1}));
}

BOOST_AUTO_TEST_CASE(indices_of_64_bits_are_named_as_they_are) {
    std::vector<std::array<std::int64_t, 3>> wide{{0, 2, 1}, {0, 1, 5'000'000'000}};
    check_throws(ErrorCode::invalid_mesh,
                 {"mesh: triangle 1", "index 5000000000", "triangles and indices count from 0"},
                 [&] { Mesh{MeshView(corners, wide)}; });
    wide[1][2] = -1;
    check_throws(ErrorCode::invalid_mesh, {"mesh: triangle 1", "index -1"}, [&] { Mesh{MeshView(corners, wide)}; });
    wide[1][2] = 4;
    check_throws(ErrorCode::invalid_mesh, {"mesh: triangle 1", "index 4", "4 vertices"},
                 [&] { Mesh{MeshView(corners, wide)}; });
}

BOOST_AUTO_TEST_CASE(arrays_that_cannot_be_triples_are_refused) {
    InputArray vertices(corners);
    const auto refused = [&](const std::vector<std::string>& words) {
        check_throws(ErrorCode::invalid_mesh, words, [&] { MeshView(vertices, faces); });
    };
    vertices.count = 5;
    refused({"5 vertices", "byte 0 to 120", "holds 96"});
    vertices.count = 2;
    vertices.strides[0] = -24;
    refused({"vertices", "byte -24 to 24"});
    vertices.strides[0] = 28;
    refused({"vertices", "28", "8 bytes"});
    vertices.strides[0] = 24;
    vertices.offset = 4;
    refused({"vertices", "offset 4"});
    vertices = corners;
    vertices.strides[1] = 24;
    refused({"vertices", "strides along y and z", "24"});
    vertices = {};
    vertices.count = 1;
    refused({"vertices", "automatic", "floats or doubles"});
    vertices.type = ElementType::float64;
    refused({"1 vertices", "no memory"});
    check_throws(ErrorCode::invalid_mesh, {"vertices", "uint32", "floats or doubles"}, [&] { MeshView(faces, faces); });
    check_throws(ErrorCode::invalid_mesh, {"triangles", "double", "integers"}, [&] { MeshView(corners, corners); });
}

BOOST_AUTO_TEST_CASE(matrices_of_either_order_are_meshes) {
    std::vector<double> doubles;
    std::vector<std::uint32_t> indices;
    for (const Vec3& corner : corners) doubles.insert(doubles.end(), corner.begin(), corner.end());
    for (const Triangle& face : faces) indices.insert(indices.end(), face.begin(), face.end());
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const Eigen::Map<const RowMajor> map(doubles.data(), 4, 3);
    const Eigen::Map<const Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 3, Eigen::RowMajor>> index_map(indices.data(),
                                                                                                       4, 3);
    check_is_the_tetrahedron(mesh_view(map, index_map));
    const RowMajor rows = map;
    const Eigen::Ref<const RowMajor> reference = rows;
    const Eigen::Matrix<float, 3, Eigen::Dynamic> columns = map.transpose().cast<float>();
    const Eigen::Matrix<int, 3, Eigen::Dynamic> index_columns = index_map.transpose().cast<int>();
    check_is_the_tetrahedron(mesh_view(reference, index_columns));
    check_is_the_tetrahedron(mesh_view(columns, index_map));

    // libigl's: a row for each, column by column in memory.
    const Eigen::MatrixXd V = map;
    const Eigen::MatrixXi F = index_map.cast<int>();
    check_is_the_tetrahedron(mesh_view(V, F));
    const Eigen::MatrixXf transposed = map.transpose().cast<float>();
    check_is_the_tetrahedron(mesh_view(transposed, F));

    // Parts of larger matrices.
    Eigen::MatrixXd homogeneous = Eigen::MatrixXd::Ones(4, 4);
    homogeneous.leftCols<3>() = map;
    check_is_the_tetrahedron(mesh_view(homogeneous.leftCols<3>(), F));
    const Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> rows_of_four = homogeneous;
    check_is_the_tetrahedron(mesh_view(rows_of_four.leftCols(3), F));

    check_throws(ErrorCode::invalid_argument, {"vertices", "4 x 4", "n x 3"}, [&] { mesh_view(homogeneous, F); });
}

BOOST_AUTO_TEST_CASE(an_array_that_is_cut_off_is_refused) {
    const std::vector<double> ten(10);
    const std::vector<std::uint32_t> three(3);
    const std::vector<std::uint32_t> four(4);
    check_throws(ErrorCode::invalid_mesh, {"vertices", "10"}, [&] { MeshView(ten, three); });
    check_throws(ErrorCode::invalid_mesh, {"triangles", "4"}, [&] { MeshView(std::span(ten).first(9), four); });
}

BOOST_AUTO_TEST_CASE(a_mesh_names_what_is_wrong_with_it) {
    check_throws(ErrorCode::invalid_mesh, {"part 7", "no triangle"}, [] { Mesh(corners, {}, "part 7"); });
    check_throws(ErrorCode::invalid_mesh, {"no triangle"}, [] { Mesh({}, {}); });
    check_throws(ErrorCode::invalid_mesh, {"mesh: triangle 1", "index 4", "4 vertices", "triangles and indices"}, [] {
        Mesh(corners, {{0, 1, 2}, {0, 1, 4}});
    });
    for (const double bad : {nan, infinity, -infinity}) {
        std::vector<Vec3> vertices = corners;
        vertices[3][1] = bad;
        check_throws(ErrorCode::invalid_mesh, {"vertex 3", "triangle 1", std::to_string(bad), "count from 0"},
                     [&] { Mesh(vertices, faces); });
    }
}

BOOST_AUTO_TEST_CASE(what_no_triangle_uses_does_not_matter) {
    std::vector<Vec3> vertices = corners;
    vertices.push_back({nan, infinity, 7});
    vertices.push_back({1e9, 1e9, 1e9});
    const Mesh mesh(vertices, faces);
    BOOST_CHECK((mesh.box().lower == Vec3{0, 0, 0}));
    BOOST_CHECK((mesh.box().upper == Vec3{1, 2, 3}));
    BOOST_TEST(weld(mesh).vertices().size() == 6U);
}

BOOST_AUTO_TEST_CASE(welding_makes_equal_coordinates_one_vertex_and_keeps_the_triangles) {
    // A soup of the tetrahedron; the origin is written with different zeros.
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (const Triangle& face : faces) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        triangles.push_back({first, first + 1, first + 2});
        for (const std::uint32_t index : face) vertices.push_back(corners[index]);
    }
    vertices[0] = {-0.0, 0.0, -0.0};
    const Mesh welded = weld(Mesh(vertices, triangles, "soup"));
    BOOST_TEST(welded.name() == "soup");
    BOOST_TEST(welded.vertices().size() == 4U);
    BOOST_REQUIRE(welded.triangles().size() == 4U);
    for (std::size_t t = 0; t < 4; ++t)
        for (std::size_t k = 0; k < 3; ++k)
            BOOST_CHECK(welded.vertices()[welded.triangles()[t][k]] == corners[faces[t][k]]);
}

BOOST_AUTO_TEST_CASE(meshes_that_differ_in_one_number_have_different_hashes) {
    const std::uint64_t hash = Mesh(corners, faces, "one").hash();
    BOOST_TEST(Mesh(corners, faces, "other").hash() == hash);
    BOOST_TEST(hash == 7316670834777255572U);  // on every machine
    std::set<std::uint64_t> hashes{hash};
    std::size_t meshes = 1;
    const auto add = [&](const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
        hashes.insert(Mesh(vertices, triangles).hash());
        ++meshes;
    };
    for (std::size_t v = 0; v < corners.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k)
            for (const double x : {std::nextafter(corners[v][k], -1.0), std::nextafter(corners[v][k], 9.0), -7.0}) {
                std::vector<Vec3> vertices = corners;
                vertices[v][k] = x;
                add(vertices, faces);
            }
    for (std::size_t t = 0; t < faces.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            for (std::uint32_t index = 0; index < 4; ++index)
                if (index != faces[t][k]) {
                    std::vector<Triangle> triangles = faces;
                    triangles[t][k] = index;
                    add(corners, triangles);
                }
    // Another order, a vertex that no triangle uses, a triangle less.
    add({corners[1], corners[0], corners[2], corners[3]}, faces);
    add(corners, {faces[1], faces[0], faces[2], faces[3]});
    add({corners[0], corners[1], corners[2], corners[3], {0, 0, 0}}, faces);
    add(corners, {faces[0], faces[1], faces[2]});
    BOOST_TEST(hashes.size() == meshes);
}

BOOST_AUTO_TEST_CASE(coordinates_one_ulp_apart_stay_apart) {
    const double next = std::nextafter(1.0, 2.0);
    const Mesh mesh({{0, 0, 0}, {1, 0, 0}, {next, 0, 0}, {0, 1, 0}}, {{0, 1, 3}, {0, 2, 3}});
    BOOST_TEST(weld(mesh).vertices().size() == 4U);
}

}  // namespace clsdf
