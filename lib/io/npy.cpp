#include "io/field_files.hpp"
#include "io/npy_header.hpp"
#include "io/raw_values.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace clsdf {
namespace {

std::string sidecar_path(const std::string& path) {
    return path + ".json";
}

std::vector<std::int64_t> shape_of(const Grid& grid) {
    return {grid.size[2], grid.size[1], grid.size[0]};
}

// The components of a sample come last.
std::vector<std::int64_t> shape_of(const Grid& grid, const OutputInfo& info) {
    std::vector<std::int64_t> shape = shape_of(grid);
    if (info.components > 1) shape.push_back(static_cast<std::int64_t>(info.components));
    return shape;
}

NpyHeader read_field_header(InputFile& file) {
    NpyHeader header = read_npy_header(file);
    if (header.fortran_order)
        file.fail("header field 'fortran_order': True is not read; save numpy.ascontiguousarray(field)");
    return header;
}

void check_shape(const InputFile& file, const NpyHeader& header, const Grid& grid) {
    if (header.shape != shape_of(grid))
        file.fail(fmt::format("header field 'shape': ({}), but '{}' states sizes for the shape ({})",
                              fmt::join(header.shape, ", "), sidecar_path(file.path()),
                              fmt::join(shape_of(grid), ", ")));
}

void read_extra(const std::string& path, const OutputInfo& info, Field& field) {
    InputFile file(path);
    const NpyHeader header = read_field_header(file);
    if (!reads_as(header.values.type, info.type))
        file.fail(fmt::format("header field 'descr': {} is '{}'", info.description, npy_name_of(info.type)));
    const std::vector<std::int64_t> shape = shape_of(field.grid, info);
    if (header.shape != shape)
        file.fail(fmt::format("header field 'shape': ({}), but the field's is ({}); compute both again",
                              fmt::join(header.shape, ", "), fmt::join(shape, ", ")));
    checked_count(file, header.values, header.shape);
    read_output(file, header.values, info, field);
}

class NpyWriter : public FormatWriter {
public:
    NpyWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : infos_(infos_of(outputs)), sidecar_(sidecar_path(path)) {
        std::map<std::string, std::string> names;
        for (const OutputInfo& info : infos_) {
            const bool is_distance = info.output == Output::distance;
            const std::string file = is_distance ? path : extra_path(path, info);
            if (!is_distance) names.emplace(info.name, file_name(file));
            files_.emplace_back(file);
            files_.back().write(npy_header(fmt::format("'{}'", npy_name_of(info.type)), shape_of(field.grid, info)));
        }
        sidecar_.write(description_text(field, names));
    }

    void append(const FieldSlab& slab, std::int64_t) override {
        for (std::size_t i = 0; i < infos_.size(); ++i)
            write_little_endian(files_[i], slab.bytes(infos_[i].output), bytes_of(infos_[i].type));
    }

    void finish() override {
        std::vector<AtomicFile*> files;
        for (std::size_t i = 1; i < files_.size(); ++i) files.push_back(&files_[i]);
        files.push_back(&sidecar_);
        files.push_back(&files_.front());
        AtomicFile::commit_all(files);
    }

private:
    std::vector<OutputInfo> infos_;
    AtomicFile sidecar_;
    std::deque<AtomicFile> files_;  // the distances' first
};

}  // namespace

std::unique_ptr<FormatWriter> npy_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    return std::make_unique<NpyWriter>(path, field, outputs);
}

void check_npy(const std::string& path, OutputSet outputs) {
    if (infos_of(outputs).size() > 1) check_utf8(path, "the description, which names the files of the other outputs,");
}

std::map<std::string, std::string> files_of_npy(const std::string& path) {
    return read_description(sidecar_path(path)).files;
}

Field read_npy(const std::string& path, OutputSet wanted) {
    InputFile file(path);
    const NpyHeader header = read_field_header(file);
    if (is_whole(header.values.type))
        file.fail(fmt::format("header field 'descr': '{}' is not a distance; save the array as float32 ('<f4')",
                              npy_name_of(header.values.type)));
    if (header.shape.size() != 3)
        file.fail(fmt::format("header field 'shape': ({}) has {} dimensions; a distance field has three, (nz, ny, nx)",
                              fmt::join(header.shape, ", "), header.shape.size()));
    checked_count(file, header.values, header.shape);

    const std::string sidecar = sidecar_path(path);
    if (!is_there(sidecar))
        file.fail(
            fmt::format("there is no '{}' beside it, which states where the samples lie: at least \"origin\", "
                        "\"spacing\" and \"size\", each with three numbers along x, y, z",
                        sidecar));
    Description description = read_description(sidecar);
    Field field = std::move(description.field);
    check_shape(file, header, field.grid);
    read_output(file, header.values, info_of(Output::distance), field);
    for (const OutputInfo& info : extra_outputs()) {
        const auto name = description.files.find(info.name);
        if (name == description.files.end() || !wanted.contains(info.output)) continue;
        const std::string beside = path_beside(path, name->second);
        if (is_there(beside)) read_extra(beside, info, field);
    }
    return field;
}

}  // namespace clsdf
