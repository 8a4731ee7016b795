#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>

#include "written_files.hpp"

#include <string>
#include <utility>
#include <vector>

/// Files that are not what their ending says: the message tells what they are and what to do.
using namespace clsdf;
using namespace clsdf::test;

namespace {

const std::vector<std::string> endings{".off", ".obj", ".stl", ".ply"};

void check_is_refused_as_any(const std::string& content, const std::vector<std::string>& fragments) {
    for (const std::string& ending : endings) check_is_refused("a" + ending, content, unreadable, fragments);
}

std::string utf16(const std::string& text, bool is_big, bool has_mark) {
    std::string wide = !has_mark ? "" : is_big ? "\xFE\xFF" : "\xFF\xFE";
    for (const char c : text) wide += is_big ? std::string{'\0', c} : std::string{c, '\0'};
    return wide;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_pointer_of_git_lfs_is_named) {
    const std::string pointer =
        "version https://git-lfs.github.com/spec/v1\n"
        "oid sha256:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\nsize 12345\n";
    check_is_refused_as_any(pointer, {"Git LFS", "12345 bytes", "'git lfs pull'", "'version https://git-lfs"});
    check_is_refused_as_any(with_line_ends(pointer, "\r\n"), {"Git LFS", "'git lfs pull'"});
    check_is_refused_as_any(pointer.substr(0, 50), {"Git LFS", "'git lfs pull'"});
    const TemporaryFolder folder;
    for (const char* name : {"points.csv", "points.ply", "points.npy"})
        check_throws(unreadable, {name, "Git LFS", "'git lfs pull'"}, [&] { read_points(folder.file(name, pointer)); });
}

BOOST_AUTO_TEST_CASE(a_web_page_is_named) {
    for (const char* page : {"<!DOCTYPE html>\n<html><head><title>404</title>", "\n\n  <HTML>\n<body>Not found</body>",
                             "\xEF\xBB\xBF<!doctype HTML PUBLIC>\n"})
        check_is_refused_as_any(page, {"HTML page", "download"});
}

BOOST_AUTO_TEST_CASE(text_in_utf_16_is_named) {
    const std::string mesh = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
    for (const bool is_big : {false, true})
        for (const bool has_mark : {false, true})
            check_is_refused_as_any(utf16(mesh, is_big, has_mark), {"UTF-16", "save it as UTF-8"});
    const TemporaryFolder folder;
    check_throws(unreadable, {"UTF-16"},
                 [&] { read_points(folder.file("p.csv", utf16("x,y,z\n1,2,3\n", false, true))); });
    // In UTF-8 a mark is skipped.
    for (const auto& name : std::vector<std::string>{"a.obj", "a.off", "a.stl", "a.ply"}) {
        write_mesh(make_shape("cube"), folder.file(name));
        if (name != "a.stl" && name != "a.ply")
            BOOST_TEST(read_mesh(folder.file("b" + name, "\xEF\xBB\xBF" + content_of(folder.file(name)))).hash() ==
                       read_mesh(folder.file(name)).hash());
    }
}

BOOST_AUTO_TEST_CASE(a_compressed_file_is_named) {
    check_is_refused_as_any(std::string("\x1F\x8B\x08").append(50, 'x'), {"compressed by gzip", "unpack it"});
    check_is_refused_as_any(std::string("PK\x03\x04").append(50, '\0'), {"compressed by zip", "unpack it"});
    check_is_refused_as_any(std::string("PK\x03\x04").append(50, '\0') + "3D/3dmodel.model",
                            {"compressed by zip", "package", ".3mf", "export the mesh as .stl or .ply"});
    check_is_refused_as_any(std::string("\x1F\x8B\x08").append(50, 'x'), {"gunzip"});
    for (const auto& [name, program] : {std::pair("a.stl.gz", "gunzip a.stl.gz"),
                                        {"b.OFF.GZ", "gunzip b.OFF.GZ"},
                                        {"c.ply.bz2", "bunzip2 c.ply.bz2"},
                                        {"d.zip", "unzip d.zip"}})
        check_throws(ErrorCode::unsupported, {name, "compressed", program, ".off, .obj, .stl or .ply"},
                     [&] { read_mesh(name); });
    check_is_refused_as_any(std::string("\x28\xB5\x2F\xFD").append(50, '\7'), {"compressed by zstd", "unpack it"});
}

BOOST_AUTO_TEST_CASE(a_mesh_of_another_format_is_named_with_its_ending) {
    const TemporaryFolder folder;
    const Mesh cube = make_shape("cube");
    for (const std::string& format : endings) {
        write_mesh(cube, folder.file("cube" + format));
        const std::string content = content_of(folder.file("cube" + format));
        for (const std::string& ending : endings)
            if (ending != format) check_is_refused("a" + ending, content, unreadable, {"give it the ending " + format});
    }
    const std::string text_stl =
        "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n";
    for (const char* ending : {".off", ".obj", ".ply"})
        check_is_refused(std::string("a") + ending, text_stl, unreadable, {"'solid a b'", "give it the ending .stl"});
    for (const char* ending : {".off", ".stl", ".ply"})
        check_is_refused(std::string("a") + ending, "# Blender\nmtllib a.mtl\no a\nv 0 0 0\nv 1 0 0\n", unreadable,
                         {"'# Blender'", "give it the ending .obj"});
    check_is_refused("a.ply", "# a comment\nCOFF\n4 2 5\n", unreadable, {"give it the ending .off"});
    check_is_refused_as_any("glTF\2\0\0\0", {"binary glTF", "convert it"});
    check_is_refused_as_any("ISO-10303-21;\nHEADER;\n", {"STEP", "convert it"});
}

BOOST_AUTO_TEST_CASE(other_text_is_quoted) {
    std::string text = "# exported by a program\nbody part\n facet normal 0 0 1\n";
    text.append(200, ' ');
    check_is_refused("a.stl", text, unreadable, {"'# exported by a program'", "begins with 'solid'"});
    check_is_refused("a.stl", "hello", unreadable, {"'hello'", "begins with 'solid'"});
    check_is_refused("a.off", "hello\n", unreadable, {"line 1", "OFF", "'hello'"});
    check_is_refused("a.ply", "hello\n", unreadable, {"line 1", "ply", "'hello'"});
    check_is_refused("a.obj", "hello\n", invalid, {"no triangle", "line 1, 'hello'"});
}

BOOST_AUTO_TEST_CASE(the_header_of_a_binary_stl_may_say_anything) {
    const TemporaryFolder folder;
    write_mesh(make_shape("cube"), folder.file("a.stl"));
    const std::string content = content_of(folder.file("a.stl"));
    for (std::string header : {"<html>", "ply", "OFF", "PK\x03\x04", "version https://git-lfs.github.com/spec/v1"}) {
        header.resize(80, ' ');
        BOOST_TEST(read_mesh(folder.file("b.stl", header + content.substr(80))).hash() ==
                   read_mesh(folder.file("a.stl")).hash());
    }
}
