#include "mesh/mesh_readers.hpp"
#include "mesh/text_scanner.hpp"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <optional>

namespace clsdf {

namespace {

/// Reads the corners of faces. A face may come before its vertices, so that the upper limit of the indices is known
/// only at the end of the file; the greatest index and its line are kept until then.
class ObjFaces {
public:
    /// The vertex index of "v", "v/vt", "v//vn" or "v/vt/vn", counted from 0.
    std::uint32_t read_corner(const TextScanner& scanner, std::string_view word, std::size_t vertex_count) {
        const std::string_view number = word.substr(0, word.find('/'));
        std::int64_t index = 0;
        const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), index);
        if (error != std::errc() || end != number.data() + number.size()) scanner.fail_word("a vertex index", word);
        const auto count = static_cast<std::int64_t>(vertex_count);
        if (index == 0 || index < -count || index >= std::numeric_limits<std::uint32_t>::max())
            fail(scanner, index, vertex_count);
        const auto corner = static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
        if (corner > greatest_) {
            greatest_ = corner;
            where_greatest_ = scanner;
        }
        return corner;
    }

    void check(std::size_t vertex_count) const {
        if (greatest_ >= vertex_count && where_greatest_)
            fail(*where_greatest_, std::int64_t{greatest_} + 1, vertex_count);
    }

private:
    [[noreturn]] static void fail(const TextScanner& scanner, std::int64_t index, std::size_t vertex_count) {
        scanner.fail(ErrorCode::invalid_mesh,
                     fmt::format("the vertex index {} is out of range: there are {} vertices, counted from 1 or back "
                                 "from -1",
                                 index, vertex_count));
    }

    std::uint32_t greatest_ = 0;
    std::optional<TextScanner> where_greatest_;
};

}  // namespace

MeshArrays read_obj(const FileContent& file) {
    TextScanner scanner(file.text(), file.path(), {.hash_comments = true, .line_continuation = true});
    MeshArrays mesh;
    ObjFaces faces;
    std::vector<std::uint32_t> corners;
    while (scanner.next_line()) {
        const std::string_view keyword = scanner.word();
        if (keyword == "v") {
            // A weight or a colour may follow on the line.
            const double x = scanner.real("a coordinate");
            const double y = scanner.real("a coordinate");
            const double z = scanner.real("a coordinate");
            mesh.vertices.push_back({x, y, z});
        } else if (keyword == "f") {
            corners.clear();
            while (!scanner.at_end_of_line())
                corners.push_back(faces.read_corner(scanner, scanner.word(), mesh.vertices.size()));
            if (corners.size() < 3)
                scanner.fail(fmt::format("a face needs three corners or more, not {}", corners.size()));
            mesh.add_polygon(corners);
        }
    }
    faces.check(mesh.vertices.size());
    return mesh;
}

}  // namespace clsdf
