#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>

#include "written_files.hpp"

#include <sys/stat.h>
#include <cmath>
#include <random>
#include <utility>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// The unit square in a binary PLY file with everything a reader has to step over.
std::string binary_ply(std::endian order) {
    std::string content = std::string("ply\nformat binary_") + (order == std::endian::big ? "big" : "little") +
                          "_endian 1.0\ncomment made by hand\nobj_info none\n"
                          "element camera 2\nproperty double view\nproperty list ushort short range\n"
                          "element vertex 4\nproperty uchar red\nproperty float x\nproperty double y\n"
                          "property list uchar float weights\nproperty short z\n"
                          "element face 1\nproperty int label\nproperty list uint uint vertex_indices\n"
                          "property list uchar double texture\nend_header\n";
    for (int camera = 0; camera < 2; ++camera) {
        content += bytes_of(0.5, order) + bytes_of(static_cast<std::uint16_t>(camera), order);
        for (int k = 0; k < camera; ++k) content += bytes_of(static_cast<std::int16_t>(-3), order);
    }
    for (const Vec3& vertex : square) {
        content += bytes_of(static_cast<std::uint8_t>(200), order) + bytes_of(static_cast<float>(vertex[0]), order) +
                   bytes_of(vertex[1], order) + bytes_of(static_cast<std::uint8_t>(1), order) + bytes_of(0.25F, order) +
                   bytes_of(static_cast<std::int16_t>(vertex[2]), order);
    }
    content += bytes_of(std::int32_t{-7}, order) + bytes_of(std::uint32_t{4}, order);
    for (std::uint32_t k = 0; k < 4; ++k) content += bytes_of(k, order);
    content += bytes_of(static_cast<std::uint8_t>(1), order) + bytes_of(1.5, order);
    return content;
}

const std::string ply_square =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

}  // namespace

BOOST_AUTO_TEST_CASE(what_is_written_is_read_back_to_the_last_bit) {
    const TemporaryFolder folder;
    Mesh noisy = make_shape("noisy");
    std::vector<Vec3> vertices = noisy.vertices();
    vertices[0] = {-0.0, 5e-324, 1.7976931348623157e308};
    vertices[1] = {0.1, -1e-310, 1.0 / 3};
    const Mesh mesh(vertices, noisy.triangles());
    for (const char* name : {"mesh.off", "mesh.obj", "mesh.ply", "MESH.OFF"}) {
        BOOST_TEST_CONTEXT(name) {
            write_mesh(mesh, folder.file(name));
            const Mesh read = read_mesh(folder.file(name));
            BOOST_CHECK(read.vertices() == mesh.vertices());
            BOOST_TEST(std::signbit(read.vertices()[0][0]));
            BOOST_CHECK(read.triangles() == mesh.triangles());
        }
    }
}

BOOST_AUTO_TEST_CASE(a_file_in_another_unit_is_scaled_and_moved_with_two_roundings) {
    const TemporaryFolder folder;
    constexpr unsigned seed = 11;
    BOOST_TEST_INFO("seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> any(-1000, 1000);
    Mesh mesh = make_shape("torus");
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& vertex : vertices)
        for (double& coordinate : vertex) coordinate = any(random);
    mesh.set_positions(vertices);
    for (const char* name : {"mesh.off", "mesh.obj", "mesh.ply"}) {
        write_mesh(mesh, folder.file(name));
        const Vec3 translate{0.1, -7, 1e6};
        const Mesh read = read_mesh(folder.file(name), {.scale = 0.001, .translate = translate});
        BOOST_CHECK(read.triangles() == mesh.triangles());
        for (std::size_t v = 0; v < vertices.size(); ++v)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const volatile double product = vertices[v][axis] * 0.001;
                BOOST_REQUIRE(read.vertices()[v][axis] == product + translate[axis]);
            }
        BOOST_CHECK(read_mesh(folder.file(name), {}).vertices() == mesh.vertices());
    }
    const std::string path = folder.file("mesh.off");
    for (const double scale : {0.0, -1.0, std::nan(""), 1.0 / 0.0})
        check_throws(ErrorCode::invalid_argument, {"scale", "above 0"}, [&] { read_mesh(path, {.scale = scale}); });
    check_throws(ErrorCode::invalid_argument, {"translate", "finite"}, [&] {
        read_mesh(path, {.translate = {0, std::nan(""), 0}});
    });
    check_throws(ErrorCode::invalid_argument, {"mesh.off", "vertex", "1e+308"},
                 [&] { read_mesh(path, {.scale = 1e308}); });
}

BOOST_AUTO_TEST_CASE(a_mesh_that_cannot_be_written_leaves_nothing) {
    const TemporaryFolder folder;
    const Mesh cube = make_shape("cube");
    check_throws(ErrorCode::unsupported, {"cube.vtk", ".off", ".obj", ".stl", ".ply"},
                 [&] { write_mesh(cube, folder.file("cube.vtk")); });
    check_throws(ErrorCode::output_failure, {"none/cube.off"}, [&] { write_mesh(cube, folder.file("none/cube.off")); });
    const Mesh vast({{0, 0, 0}, {1e39, 0, 0}, {0, 1e39, 0}}, {{0, 1, 2}});
    check_throws(ErrorCode::unsupported, {"1e+39", "vertex 1"}, [&] { write_mesh(vast, folder.file("vast.stl")); });
    BOOST_TEST(folder.file_count() == 0U);
}

BOOST_AUTO_TEST_CASE(off_comes_in_many_forms) {
    const std::string body = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    check_is_square("a.off", "OFF\n4 2 5\n" + body);
    check_is_square("a.off", "OFF 4 2 5\n" + body);
    check_is_square("a.off", "OFF4 2 5\n" + body);
    check_is_square("a.off", "OFF\n4 2\n" + body);
    check_is_square("a.off", "OFF\n4\n2\n5\n" + body);
    check_is_square("a.off", "OFF\n4\n2\n" + body);
    check_is_square("a.off", "4 2 5\n" + body);
    check_is_square("a.off", "\xEF\xBB\xBFOFF\n4 2 5\n" + body);
    check_is_square("a.off",
                    "# first\n\nOFF # second\n# third\n\n4 2 5 # fourth\n\n" + replaced(body, "\n", "# v\n\n \n"));
    check_is_square("a.off", with_line_ends("OFF\n4 2 5\n" + body, "\r\n"));
    check_is_square("a.off", with_line_ends("OFF\n4 2 5\n" + body, "\r"));
    check_is_square("a.off", "OFF\n4 2 5\n" + body.substr(0, body.size() - 1));
    check_is_square("a.off", "OFF\n4 1 5\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 255 128 0 255\n");
    check_is_square("a.off",
                    "COFF\n4 1 5\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n1 1 0 0 0 0 0\n0 1 0 9 9 9 9\n4 0 1 2 3 7\n");
    check_is_square("a.off", "NOFF\n4 1 5\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n4 0 1 2 3\n");
    check_is_square("a.off", "STCNOFF\n4 1 5\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n4 0 1 2 3\n");
    const std::string tiny = "0." + std::string(400, '0') + "1e+2";
    check_is_square("a.off", "OFF\n4 2 5\n" + replaced(body, "0 0 0", tiny + " -" + tiny + " 1e-99999999999999999999"));
    check_is_square("a.off", "STOFF\n4 1 5\n\t+0 0.0 -0e9  .5 .5\n1. 0 0\n1e0 10e-1 1e-999\n0 1 0\n  4\t0 1 2 +3  \n");
}

BOOST_AUTO_TEST_CASE(damaged_off_files_are_refused_with_the_line) {
    const std::string good = "OFF\n4 2 5\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n# the end\n";
    const auto refused = [&](const std::string& from, const std::string& to, ErrorCode code,
                             std::vector<std::string> fragments) {
        check_is_refused("a.off", replaced(good, from, to), code, std::move(fragments));
    };
    refused("OFF", "OOF", unreadable, {"line 1", "OFF", "'OOF'"});
    refused("OFF", "4OFF", ErrorCode::unsupported, {"line 1", "4OFF"});
    refused("OFF", "OFF BINARY", ErrorCode::unsupported, {"binary"});
    refused("4 2 5", "x 2 5", unreadable, {"line 2", "vertices", "'x'"});
    refused("4 2 5", "4 -2 5", unreadable, {"line 2", "-2"});
    refused("4 2 5", "4 2.5 5", unreadable, {"line 2", "'2.5'"});
    refused("4 2 5", "1000000000 2 5", unreadable, {"line 2", "1000000000 vertices"});
    refused("4 2 5", "4 1000000000 5", unreadable, {"line 2", "1000000000 faces"});
    refused("4 2 5", "9223372036854775807 9223372036854775807 5", unreadable, {"line 2"});
    refused("4 2 5", "3074457345618258603 2 5", unreadable, {"line 2", "3074457345618258603 vertices"});
    refused("4 2 5", "99999999999999999999 2 5", unreadable, {"line 2", "99999999999999999999"});
    refused("4 2 5", "5 2 5", unreadable, {"after 1 of 2 faces"});
    refused("1 0 0", "1 0", unreadable, {"line 4", "coordinate", "line ends"});
    refused("1 0 0", "1 0,5 0", unreadable, {"line 4", "'0,5'"});
    refused("1 0 0", "1 nan 0", invalid, {"vertex 1", "triangle 0", "nan"});
    refused("1 0 0", "1 1e999 0", invalid, {"vertex 1", "inf"});
    refused("1 0 0", "1 -1" + std::string(400, '0') + " 0", invalid, {"vertex 1", "-inf"});
    refused("3 0 2 3", "3 0 2 4", invalid, {"line 8", "index 4", "4 vertices"});
    refused("3 0 2 3", "3 0 2 -1", invalid, {"line 8", "index -1"});
    refused("3 0 2 3", "3 0 2", unreadable, {"line 8", "index", "line ends"});
    refused("3 0 2 3", "3 0 2 3.5", unreadable, {"line 8", "'3.5'"});
    refused("3 0 2 3", "0 0 2 3", unreadable, {"line 8", "three corners", "not 0"});
    refused("3 0 2 3", "-3 0 2 3", unreadable, {"line 8", "three corners"});
    refused("3 0 2 3", "3000000000 0 2 3", unreadable, {"line 8", "line ends"});
    refused("3 0 2 3\n", "", unreadable, {"after 1 of 2 faces"});
    check_is_refused("a.off", with_line_ends(replaced(good, "3 0 2 3", "3 0 2 4"), "\r\n"), invalid, {"line 8"});
    refused("# the end", "3 1 2 3", unreadable, {"line 9", "4 vertices and 2 faces"});
    refused("4 2 5", "4 1 5", unreadable, {"line 8", "1 faces"});
    check_is_refused("a.off", "OFF", unreadable, {"number of vertices", "file ends"});
    check_is_refused("a.off", "OFF\n0 0 0\n", invalid, {"no triangle"});
}

BOOST_AUTO_TEST_CASE(obj_comes_in_many_forms) {
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    check_is_square("a.obj", vertices + "f 1 2 3\nf 1 3 4\n");
    check_is_square("a.obj", vertices + "f 1 2 3 4\n");
    check_is_square("a.obj", vertices + "f -4 -3 -2 -1\n");
    check_is_square("a.obj", vertices + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3//1 4/1\n");
    check_is_square("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf 1 -2 -1\n");
    check_is_square("a.obj", "f 1 2 3 4\n" + vertices);
    check_is_square("a.obj", "# text\nmtllib a.mtl\no part\ng\ns off\nusemtl x\n" + vertices +
                                 "l 1 2\np 1\nf 1 2 3 4 # four\nvp 0.3\nsomething new\n");
}

BOOST_AUTO_TEST_CASE(obj_lines_may_be_continued_coloured_and_end_in_any_way) {
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    check_is_square("a.obj", vertices + "f 1 2 \\\n3\\\n 4\n");
    check_is_square("a.obj", with_line_ends(vertices + "f 1 2 \\\n3\\\n 4\n", "\r\n"));
    check_is_square("a.obj", "v 0 0 0 1.0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0 1 1 1 1\nv 0 1 0\nf 1 2 3 4");
}

BOOST_AUTO_TEST_CASE(damaged_obj_files_are_refused_with_the_line) {
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    const auto refused = [&](const std::string& rest, ErrorCode code, std::vector<std::string> fragments) {
        check_is_refused("a.obj", vertices + rest, code, std::move(fragments));
    };
    refused("f 1 2 0\n", invalid, {"line 5", "index 0"});
    refused("f 1 2 -5\n", invalid, {"line 5", "index -5", "4 vertices"});
    refused("f 1 2 5\nf 1 2 3\n", invalid, {"line 5", "index 5", "4 vertices"});
    refused("f 1 2 5000000000\n", invalid, {"line 5", "5000000000"});
    refused("f 1 2 99999999999999999999\n", unreadable, {"line 5", "99999999999999999999"});
    refused("f 1 2 x/3\n", unreadable, {"line 5", "'x/3'"});
    refused("f 1 2 /3\n", unreadable, {"line 5", "'/3'"});
    refused("f\n", unreadable, {"line 5", "three corners"});
    refused("v 1 2\nf 1 2 3\n", unreadable, {"line 5", "coordinate"});
    refused("v 1 2 z\nf 1 2 3\n", unreadable, {"line 5", "'z'"});
    refused("v 1 2 -inf\nf 1 2 5\n", invalid, {"vertex 4", "-inf"});
    refused("", invalid, {"no triangle"});
    refused("# f 1 2 3\n", invalid, {"no triangle"});
}

BOOST_AUTO_TEST_CASE(ply_comes_in_many_forms) {
    check_is_square("a.ply", ply_square);
    check_is_square("a.ply", with_line_ends(ply_square, "\r\n"));
    check_is_square("a.ply", replaced(ply_square, "vertex_indices", "vertex_index"));
    check_is_square("a.ply", binary_ply(std::endian::little));
    check_is_square("a.ply", binary_ply(std::endian::big));
    // The faces before the vertices; an element without properties.
    check_is_square("a.ply",
                    "ply\nformat ascii 1.0\nelement nothing 1000000000\nelement face 1\n"
                    "property list uchar int vertex_indices\nelement vertex 4\nproperty double z\n"
                    "property double y\nproperty double x\nproperty uchar red\nend_header\n"
                    "4 0 1 2 3\n0 0 0 9\n0 0 1 9\n0 1 1 9\n0 1 0 9\n");
    // The bytes after the header may look like the end of a line.
    std::string tail = "ply\r\nformat binary_little_endian 1.0\r\nelement pad 1\r\nproperty uchar a\r\n" +
                       binary_ply(std::endian::little).substr(std::strlen("ply\nformat binary_little_endian 1.0\n"));
    tail = replaced(tail, "end_header\n", "end_header\r\n\n");
    check_is_square("a.ply", tail);
}

BOOST_AUTO_TEST_CASE(damaged_ply_files_are_refused_with_the_line_or_the_row) {
    const auto refused = [&](const std::string& from, const std::string& to, ErrorCode code,
                             std::vector<std::string> fragments) {
        check_is_refused("a.ply", replaced(ply_square, from, to), code, std::move(fragments));
    };
    refused("ply", "plx", unreadable, {"line 1", "'plx'"});
    refused("format ascii", "format asci", unreadable, {"line 2", "'asci'"});
    refused("format ascii 1.0\n", "", unreadable, {"no format"});
    refused("element vertex 4", "element vertex", unreadable, {"line 3", "count"});
    refused("element vertex 4", "element vertex -4", unreadable, {"line 3", "-4"});
    refused("element vertex 4", "element vertex 1000000000", unreadable, {"1000000000", "'vertex'"});
    refused("element face 1", "element face 9223372036854775807", unreadable, {"9223372036854775807", "'face'"});
    refused("element face 1", "element vertex 1", unreadable, {"line 7", "second"});
    refused("element vertex 4\n", "", unreadable, {"line 3", "before the first element"});
    refused("property float x", "property flaot x", unreadable, {"line 4", "'flaot'"});
    refused("property float x", "property float", unreadable, {"line 4", "name"});
    refused("property float x", "property float u", unreadable, {"'x'"});
    refused("property float x", "property list uchar float x", unreadable, {"'x'"});
    refused("list uchar int", "list float int", unreadable, {"line 8", "integer"});
    refused("list uchar int", "list uchar float", unreadable, {"vertex_indices"});
    refused("list uchar int", "int", unreadable, {"vertex_indices"});
    refused("vertex_indices", "indices", unreadable, {"vertex_indices"});
    refused("end_header\n", "", unreadable, {"line 9", "'0'"});
    refused("1 0 0\n", "1 0\n", unreadable, {"line 11", "line ends"});
    refused("1 0 0\n", "1 0 0 0\n", unreadable, {"line 11", "more values"});
    refused("1 0 0\n", "1 0 x\n", unreadable, {"line 11", "'x'"});
    refused("1 0 0\n", "1 0 nan\n", invalid, {"vertex 1", "nan"});
    refused("4 0 1 2 3", "4 0 1 2 4", invalid, {"line 14", "index 4", "4 vertices"});
    refused("4 0 1 2 3", "4 0 1 2 -1", invalid, {"line 14", "index -1"});
    refused("4 0 1 2 3", "0", unreadable, {"line 14", "three corners"});
    refused("4 0 1 2 3", "-1 0 1", unreadable, {"line 14", "-1"});
    refused("4 0 1 2 3", "1000000000 0 1", unreadable, {"line 14"});
    refused("4 0 1 2 3\n", "", unreadable, {"'face'"});
    refused("element face 1\nproperty list uchar int vertex_indices\n", "", invalid,
            {"'face'", "4 vertices are a cloud of points", "reconstruct a surface", "POINTS of clsdf query"});
    refused("4 0 1 2 3\n", "4 0 1 2 3\n\n3 1 2 3\n", unreadable, {"line 16", "1 rows of 'face'"});
    check_is_square("a.ply", ply_square + " \n\n");
    check_is_refused("a.ply", "ply\nformat ascii 1.0\n", unreadable, {"header"});

    const std::string binary = binary_ply(std::endian::little);
    for (std::size_t cut = 1; cut < 30; ++cut)
        check_is_refused("a.ply", binary.substr(0, binary.size() - cut), unreadable, {});
    check_is_square("a.ply", binary + " \r\n");
    const std::size_t corner = binary.size() - 9 - 4;
    std::string far = binary;
    far[corner] = 'A';
    check_is_refused("a.ply", far, invalid, {"row 0", "'face'", "index 65"});
    std::string huge = binary;
    huge.replace(corner - 16, 4, "\xFF\xFF\xFF\xFF");
    check_is_refused("a.ply", huge, invalid, {"row 0", "'face'"});
}

BOOST_AUTO_TEST_CASE(vertices_that_no_face_uses_may_be_anything) {
    const TemporaryFolder folder;
    BOOST_TEST(read_mesh(folder.file("a.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\nnan inf -nan\n3 0 1 2\n"))
                   .triangles()
                   .size() == 1U);
    BOOST_TEST(read_mesh(folder.file("a.obj", "v 0 0 0\nv nan nan nan\nv 1 0 0\nv 1 1 0\nf 1 3 4\n")).box().upper[0] ==
               1);
    BOOST_TEST(read_mesh(folder.file("a.ply", replaced(ply_square, "4 0 1 2 3", "3 1 2 3"))).triangles().size() == 1U);
    BOOST_TEST(
        read_mesh(folder.file("a.ply", replaced(replaced(ply_square, "4 0 1 2 3", "3 1 2 3"), "\n0 0 0", "\nnan 0 0")))
            .box()
            .lower[0] == 0);
}

BOOST_AUTO_TEST_CASE(what_is_no_file_or_no_mesh_is_refused_at_once) {
    const TemporaryFolder folder;
    for (const std::string ending : {".off", ".obj", ".stl", ".ply"}) {
        BOOST_TEST_CONTEXT(ending) {
            check_throws(unreadable, {"none" + ending, "No such file"},
                         [&] { read_mesh(folder.file("none" + ending)); });
            const std::string directory = folder.file("folder" + ending);
            std::filesystem::create_directory(directory);
            check_throws(unreadable, {directory, "directory"}, [&] { read_mesh(directory); });
            const std::string pipe = folder.file("pipe" + ending);
            BOOST_REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
            check_throws(unreadable, {pipe, "pipe"}, [&] { read_mesh(pipe); });
            const std::string device = folder.file("device" + ending);
            std::filesystem::create_symlink("/dev/zero", device);
            check_throws(unreadable, {device, "device"}, [&] { read_mesh(device); });
            for (const std::string& content : {std::string(), std::string(1000, '\0'), std::string("\n\n\r\n  \n")}) {
                const std::string path = folder.file("bad" + ending, content);
                try {
                    read_mesh(path);
                    BOOST_ERROR("nothing was thrown");
                } catch (const Error& error) {
                    BOOST_TEST(std::string(error.what()).find(path) != std::string::npos);
                    BOOST_CHECK(error.code() == unreadable || (ending == ".obj" && error.code() == invalid));
                }
            }
        }
    }
    check_throws(ErrorCode::unsupported, {"mesh.vtk", ".off", ".obj", ".stl", ".ply"}, [] { read_mesh("mesh.vtk"); });
    check_throws(ErrorCode::unsupported, {"'mesh'"}, [] { read_mesh("mesh"); });
    check_throws(ErrorCode::unsupported, {"''"}, [] { read_mesh(""); });
}
