#include "core/files.hpp"
#include "core/refuse.hpp"
#include "io/meshes/mesh_files.hpp"

#include <clsdf/mesh_files.hpp>

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>

namespace clsdf {

namespace {

/// Buffers text and writes it to the file in large pieces.
class TextWriter {
public:
    explicit TextWriter(AtomicFile& file) : file_(file) {}

    template <typename... Values>
    void write(fmt::format_string<const Values&...> format, const Values&... values) {
        fmt::format_to(std::back_inserter(buffer_), format, values...);
        if (buffer_.size() > piece_bytes) flush();
    }
    void flush() {
        file_.write(std::string_view(buffer_.data(), buffer_.size()));
        buffer_.clear();
    }

private:
    static constexpr std::size_t piece_bytes = std::size_t{1} << 16U;
    AtomicFile& file_;
    fmt::memory_buffer buffer_;
};

/// "{}" writes the shortest digits that are read back as the same number.
void write_off(const Mesh& mesh, AtomicFile& file) {
    TextWriter text(file);
    text.write("OFF\n{} {} 0\n", mesh.vertices().size(), mesh.triangles().size());
    for (const auto& [x, y, z] : mesh.vertices()) text.write("{} {} {}\n", x, y, z);
    for (const auto& [a, b, c] : mesh.triangles()) text.write("3 {} {} {}\n", a, b, c);
    text.flush();
}

void write_obj(const Mesh& mesh, AtomicFile& file) {
    TextWriter text(file);
    for (const auto& [x, y, z] : mesh.vertices()) text.write("v {} {} {}\n", x, y, z);
    for (const auto& [a, b, c] : mesh.triangles())
        text.write("f {} {} {}\n", std::uint64_t{a} + 1, std::uint64_t{b} + 1, std::uint64_t{c} + 1);
    text.flush();
}

float to_float(double coordinate, std::uint32_t vertex) {
    const auto rounded = static_cast<float>(coordinate);
    if (!std::isfinite(rounded))
        refuse_unsupported(
            "STL holds 32-bit numbers, which end before the coordinate {} of vertex {}; choose "
            "another format",
            coordinate, vertex);
    return rounded;
}

std::array<float, 3> unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 u{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const Vec3 v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const Vec3 n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::hypot(n[0], n[1], n[2]);
    // A zero normal tells readers to compute it from the vertices.
    if (!(length > 0) || !std::isfinite(length)) return {};
    return {static_cast<float>(n[0] / length), static_cast<float>(n[1] / length), static_cast<float>(n[2] / length)};
}

void write_stl(const Mesh& mesh, AtomicFile& file) {
    // Not "solid": readers would take the file for text.
    std::array<std::byte, 84> header{};
    constexpr std::string_view comment = "binary STL written by clsdf";
    for (std::size_t i = 0; i < comment.size(); ++i) header[i] = static_cast<std::byte>(comment[i]);
    store_little_endian(&header[80], static_cast<std::uint32_t>(mesh.triangles().size()));
    file.write(header);
    for (const Triangle& triangle : mesh.triangles()) {
        std::array<std::byte, 50> record{};
        std::byte* address = record.data();
        const auto& vertices = mesh.vertices();
        for (const float x : unit_normal(vertices[triangle[0]], vertices[triangle[1]], vertices[triangle[2]]))
            address = store_little_endian(address, x);
        for (const std::uint32_t index : triangle)
            for (const double x : vertices[index]) address = store_little_endian(address, to_float(x, index));
        file.write(record);
    }
}

void write_ply(const Mesh& mesh, AtomicFile& file, std::span<const FaceColour> colours,
               std::span<const std::uint32_t> given_faces) {
    // Some readers know no unsigned indices.
    const bool fits_int = mesh.vertices().size() <= std::size_t{std::numeric_limits<std::int32_t>::max()};
    file.write(
        fmt::format("ply\nformat binary_little_endian 1.0\ncomment written by clsdf\nelement vertex {}\n"
                    "property double x\nproperty double y\nproperty double z\nelement face {}\n"
                    "property list uchar {} vertex_indices\n{}{}end_header\n",
                    mesh.vertices().size(), mesh.triangles().size(), fits_int ? "int" : "uint",
                    colours.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n",
                    given_faces.empty() ? "" : "property uint given_face\n"));
    for (const Vec3& vertex : mesh.vertices()) {
        std::array<std::byte, 24> record{};
        std::byte* address = record.data();
        for (const double x : vertex) address = store_little_endian(address, x);
        file.write(record);
    }
    for (std::size_t face = 0; face < mesh.triangles().size(); ++face) {
        std::array<std::byte, 20> record{std::byte{3}};
        std::byte* address = record.data() + 1;
        for (const std::uint32_t index : mesh.triangles()[face]) address = store_little_endian(address, index);
        if (!colours.empty())
            for (const std::uint8_t part : colours[face]) address = store_little_endian(address, part);
        if (!given_faces.empty()) address = store_little_endian(address, given_faces[face]);
        file.write(std::span(record.data(), address));
    }
}

/// given_faces: a number for each triangle, or none; only .ply stores them.
void write(const Mesh& mesh, const std::string& path, std::span<const FaceColour> colours,
           std::span<const std::uint32_t> given_faces) {
    const MeshFormat format = format_of_ending(path);
    AtomicFile file(path);
    switch (format) {
        case MeshFormat::off:
            write_off(mesh, file);
            break;
        case MeshFormat::obj:
            write_obj(mesh, file);
            break;
        case MeshFormat::stl:
            write_stl(mesh, file);
            break;
        case MeshFormat::ply:
            write_ply(mesh, file, colours, given_faces);
            break;
    }
    file.commit();
}

}  // namespace

void write_mesh(const Mesh& mesh, const std::string& path, std::span<const FaceColour> colours) {
    if (!colours.empty() && colours.size() != mesh.triangles().size())
        refuse("{} colours for {} triangles; give one for each, or none", colours.size(), mesh.triangles().size());
    write(mesh, path, colours, {});
}

void write_mesh(const OuterSurface& surface, const std::string& path) {
    write(surface.mesh, path, {}, surface.faces);
}

void check_mesh_path(const std::string& path) {
    static_cast<void>(format_of_ending(path));
    check_writable(path);
}

}  // namespace clsdf
