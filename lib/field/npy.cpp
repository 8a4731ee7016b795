#include "field/description.hpp"
#include "field/formats.hpp"
#include "field/npy_header.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <deque>
#include <filesystem>

namespace clsdf {
namespace {

namespace fs = std::filesystem;

std::string sidecar_path(const std::string& path) {
    return path + ".json";
}

std::vector<std::int64_t> shape_of(const Grid& grid) {
    return {grid.size[2], grid.size[1], grid.size[0]};
}

// The components of a sample come last.
std::vector<std::int64_t> shape_of(const Grid& grid, const OutputKind& kind) {
    std::vector<std::int64_t> shape = shape_of(grid);
    if (kind.components > 1) shape.push_back(kind.components);
    return shape;
}

const char* name_of(ValueType type) {
    return type == ValueType::uint32 ? "<u4" : "<f4";
}

void check_shape(const InputFile& file, const NpyHeader& header, const Grid& grid) {
    if (header.shape != shape_of(grid))
        file.fail(fmt::format("header field 'shape': ({}), but '{}' states sizes for the shape ({})",
                              fmt::join(header.shape, ", "), sidecar_path(file.path()),
                              fmt::join(shape_of(grid), ", ")));
}

void read_extra(const std::string& path, const OutputKind& kind, Field& field) {
    InputFile file(path);
    const NpyHeader header = read_npy_header(file);
    if (!reads_as(header.values.type, kind.type))
        file.fail(fmt::format("header field 'descr': {} is '{}'", kind.content, name_of(kind.type)));
    const std::vector<std::int64_t> shape = shape_of(field.grid, kind);
    if (header.shape != shape)
        file.fail(fmt::format("header field 'shape': ({}), but the field's is ({}); compute both again",
                              fmt::join(header.shape, ", "), fmt::join(shape, ", ")));
    checked_count(file, header.values, header.shape);
    read_output(file, header.values, kind, field);
}

class NpyWriter : public FormatWriter {
public:
    NpyWriter(const std::string& path, const FieldDescription& field, const Outputs& outputs)
        : kinds_(kinds_of(outputs)), sidecar_(sidecar_path(path)) {
        std::map<std::string, std::string> names;
        for (const OutputKind& kind : kinds_) {
            const bool is_distance = &kind == kinds_.data();
            const std::string file = is_distance ? path : extra_path(path, kind);
            if (!is_distance) names.emplace(kind.name, file_name(file));
            files_.emplace_back(file);
            files_.back().write(npy_header(name_of(kind.type), shape_of(field.grid, kind)));
        }
        sidecar_.write(description_text(field, names));
    }

    void append(const FieldSlab& slab, std::int64_t) override {
        for (std::size_t i = 0; i < kinds_.size(); ++i)
            write_little_endian(files_[i], kinds_[i].bytes(slab), width_of(kinds_[i].type));
    }

    void finish() override {
        for (std::size_t i = 1; i < files_.size(); ++i) files_[i].commit();
        sidecar_.commit();
        files_.front().commit();
    }

private:
    std::vector<OutputKind> kinds_;
    AtomicFile sidecar_;
    std::deque<AtomicFile> files_;  // the distances' first
};

}  // namespace

std::unique_ptr<FormatWriter> npy_writer(const std::string& path, const FieldDescription& field,
                                         const Outputs& outputs) {
    return std::make_unique<NpyWriter>(path, field, outputs);
}

Field read_npy(const std::string& path) {
    InputFile file(path);
    const NpyHeader header = read_npy_header(file);
    if (header.values.type == ValueType::uint32)
        file.fail("header field 'descr': '<u4' is not a distance; save the array as float32 ('<f4')");
    if (header.shape.size() != 3)
        file.fail(fmt::format("header field 'shape': ({}) has {} dimensions; a distance field has three, (nz, ny, nx)",
                              fmt::join(header.shape, ", "), header.shape.size()));
    checked_count(file, header.values, header.shape);

    const std::string sidecar = sidecar_path(path);
    if (!fs::exists(sidecar))
        file.fail(
            fmt::format("there is no '{}' beside it, which states where the samples lie: at least \"origin\", "
                        "\"spacing\" and \"size\", each with three numbers along x, y, z",
                        sidecar));
    Description description = read_description(sidecar);
    Field field = std::move(description.field);
    check_shape(file, header, field.grid);
    read_output(file, header.values, distance_kind(), field);
    for (const OutputKind& kind : extra_kinds()) {
        const auto name = description.files.find(kind.name);
        if (name == description.files.end()) continue;
        const std::string beside = path_beside(path, name->second);
        if (fs::exists(beside)) read_extra(beside, kind, field);
    }
    return field;
}

}  // namespace clsdf
