#pragma once

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>
#include <clsdf/mesh.hpp>

#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <vector>

/// Shared by the tests of mesh files: texts and bytes that are written, and the meshes that must be read from them.
namespace clsdf::test {

inline const std::vector<Triangle> two_triangles{{0, 1, 2}, {0, 2, 3}};
inline const std::vector<Vec3> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

/// Checks that the text is read as the unit square, split at the diagonal of its first corner.
inline void check_is_square(const std::string& name, const std::string& text) {
    BOOST_TEST_CONTEXT(name << ":\n" << text) {
        const TemporaryFolder folder;
        const std::string path = folder.file(name, text);
        try {
            const Mesh mesh = read_mesh(path);
            BOOST_TEST(mesh.name() == path);
            BOOST_CHECK(mesh.vertices() == square);
            BOOST_CHECK(mesh.triangles() == two_triangles);
        } catch (const Error& error) {
            BOOST_ERROR(error.what());
        }
    }
}

/// Checks that reading fails with the code, and that the message has the file's name and the fragments.
inline void check_is_refused(const std::string& name, const std::string& content, ErrorCode code,
                             std::vector<std::string> fragments) {
    BOOST_TEST_CONTEXT(name << ":\n" << content.substr(0, 1000)) {
        const TemporaryFolder folder;
        fragments.push_back(name);
        check_throws(code, fragments, [&] { read_mesh(folder.file(name, content)); });
    }
}

inline constexpr ErrorCode unreadable = ErrorCode::unreadable_input;
inline constexpr ErrorCode invalid = ErrorCode::invalid_mesh;

template <typename Number>
std::string bytes_of(Number number, std::endian order) {
    std::string bytes(sizeof(Number), '\0');
    std::memcpy(bytes.data(), &number, sizeof(Number));
    if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t place = text.find(from);
    BOOST_REQUIRE(place != std::string::npos);
    return text.replace(place, from.size(), to);
}

inline std::string with_line_ends(const std::string& text, const std::string& line_end) {
    std::string result;
    for (const char c : text) c == '\n' ? result += line_end : result += c;
    return result;
}

}  // namespace clsdf::test
