#include "field/formats.hpp"
#include "field/npy_header.hpp"
#include "field/npy_sidecar.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <filesystem>
#include <optional>

namespace clsdf {
namespace {

namespace fs = std::filesystem;

std::vector<std::int64_t> shape_of(const Grid& grid) {
    return {grid.size[2], grid.size[1], grid.size[0]};
}

void check_shape(const InputFile& file, const NpyHeader& header, const Grid& grid) {
    if (header.shape != shape_of(grid))
        file.fail(fmt::format("header field 'shape': ({}), but '{}' states sizes for the shape ({})",
                              fmt::join(header.shape, ", "), sidecar_path(file.path()),
                              fmt::join(shape_of(grid), ", ")));
}

std::vector<std::uint32_t> read_triangles(const std::string& path, const std::vector<std::int64_t>& shape) {
    InputFile file(path);
    const NpyHeader header = read_npy_header(file);
    if (header.values.type != ValueType::uint32) file.fail("header field 'descr': triangles are '<u4'");
    if (header.shape != shape)
        file.fail(fmt::format("header field 'shape': ({}), but the field's is ({}); compute both again",
                              fmt::join(header.shape, ", "), fmt::join(shape, ", ")));
    return read_indices(file, header.values, checked_count(file, header.values, header.shape));
}

}  // namespace

void write_npy(const Field& field, const std::string& path) {
    const std::vector<std::int64_t> shape = shape_of(field.grid);
    std::optional<AtomicFile> triangles;
    std::string triangle_file;
    if (!field.triangle.empty()) {
        const std::string beside = triangle_path(path);
        triangle_file = fs::path(beside).filename().string();
        triangles.emplace(beside);
        triangles->write(npy_header("<u4", shape));
        write_little_endian(*triangles, field.triangle);
    }
    AtomicFile sidecar(sidecar_path(path));
    sidecar.write(sidecar_text(field, triangle_file));
    AtomicFile distances(path);
    distances.write(npy_header("<f4", shape));
    write_little_endian(distances, field.distance);

    if (triangles) triangles->commit();
    sidecar.commit();
    distances.commit();
}

Field read_npy(const std::string& path) {
    InputFile file(path);
    const NpyHeader header = read_npy_header(file);
    if (header.values.type == ValueType::uint32)
        file.fail("header field 'descr': '<u4' is not a distance; save the array as float32 ('<f4')");
    const std::size_t count = checked_count(file, header.values, header.shape);

    const std::string description = sidecar_path(path);
    if (!fs::exists(description))
        file.fail(
            fmt::format("there is no '{}' beside it, which states where the samples lie: at least \"origin\", "
                        "\"spacing\" and \"size\", each with three numbers along x, y, z",
                        description));
    Sidecar sidecar = read_sidecar(description);
    Field field = std::move(sidecar.field);
    check_shape(file, header, field.grid);
    field.distance = read_floats(file, header.values, count);
    if (!sidecar.triangle_file.empty()) {
        const std::string beside = path_beside(path, sidecar.triangle_file);
        if (fs::exists(beside)) field.triangle = read_triangles(beside, header.shape);
    }
    return field;
}

}  // namespace clsdf
