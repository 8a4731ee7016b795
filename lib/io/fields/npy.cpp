#include "io/fields/field_files.hpp"
#include "io/fields/sparse_files.hpp"
#include "io/meshes/npy_header.hpp"
#include "io/meshes/raw_values.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
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
            const std::string file = is_distance ? path : extra_path(path, info.name);
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

/// Values first, headers last: the number of bricks is known at the end. All headers have the same length.
class SparseNpyWriter : public SparseFormatWriter {
public:
    SparseNpyWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : infos_(infos_of(outputs)),
          sidecar_(sidecar_path(path)),
          bricks_file_(extra_path(path, bricks_name)),
          runs_file_(extra_path(path, runs_name)) {
        std::map<std::string, std::string> names{{bricks_name, file_name(extra_path(path, bricks_name))},
                                                 {runs_name, file_name(extra_path(path, runs_name))}};
        for (const OutputInfo& info : infos_) {
            const bool is_distance = info.output == Output::distance;
            const std::string file = is_distance ? path : extra_path(path, info.name);
            if (!is_distance) names.emplace(info.name, file_name(file));
            files_.emplace_back(file).write(header_of(info));
        }
        sidecar_.write(description_text(field, names));
    }

    void append(const SparseSlab& slab) override {
        for (std::size_t i = 0; i < infos_.size(); ++i)
            write_little_endian(files_[i], slab.values.bytes(infos_[i].output), bytes_of(infos_[i].type));
        bricks_.insert(bricks_.end(), slab.bricks.begin(), slab.bricks.end());
        runs_.insert(runs_.end(), slab.inside.begin(), slab.inside.end());
    }

    void finish() override {
        const auto write_numbers = [](AtomicFile& file, std::span<const std::byte> bytes, std::int64_t columns) {
            const auto rows = static_cast<std::int64_t>(bytes.size() / sizeof(std::int64_t)) / columns;
            file.write(npy_header(fmt::format("'{}'", npy_name_of(ElementType::int64)), {rows, columns}));
            write_little_endian(file, bytes, sizeof(std::int64_t));
        };
        write_numbers(bricks_file_, std::as_bytes(std::span(bricks_)), 3);
        write_numbers(runs_file_, std::as_bytes(std::span(runs_)), 4);
        std::vector<AtomicFile*> files{&bricks_file_, &runs_file_};
        for (std::size_t i = 0; i < files_.size(); ++i) {
            files_[i].seek(0);
            files_[i].write(header_of(infos_[i]));
            if (i > 0) files.push_back(&files_[i]);
        }
        files.push_back(&sidecar_);
        files.push_back(&files_.front());
        AtomicFile::commit_all(files);
    }

private:
    std::string header_of(const OutputInfo& info) const {
        return npy_header(fmt::format("'{}'", npy_name_of(info.type)), sparse_shape(bricks_.size(), info));
    }

    std::vector<OutputInfo> infos_;
    AtomicFile sidecar_;
    AtomicFile bricks_file_;
    AtomicFile runs_file_;
    std::deque<AtomicFile> files_;  // the distances' first
    std::vector<Index3> bricks_;
    std::vector<BrickRun> runs_;
};

/// Reads the array of a file beside the field, whose first axis has any length if it is negative.
template <class Allocate>
void read_sparse_array(const std::string& path, ElementType type, std::vector<std::int64_t> shape,
                       const Allocate& allocate) {
    InputFile file(path);
    const NpyHeader header = read_field_header(file);
    if (!reads_as(header.values.type, type))
        file.fail(fmt::format("header field 'descr': '{}' is not '{}'; compute the field again",
                              npy_name_of(header.values.type), npy_name_of(type)));
    if (shape[0] < 0 && !header.shape.empty()) shape[0] = header.shape[0];
    if (header.shape != shape || shape[0] < 0)
        file.fail(fmt::format("header field 'shape': ({}), but that of these bricks is ({}); compute the field again",
                              fmt::join(header.shape, ", "), fmt::join(shape, ", ")));
    if (shape[0] > 0) checked_count(file, header.values, shape);
    const std::span<std::byte> room = allocate(static_cast<std::size_t>(shape[0]));
    if (!room.empty()) read_values(file, header.values, type, room);
}

SparseField read_sparse(const std::string& path, const Description& description, OutputSet wanted) {
    SparseField field;
    static_cast<FieldDescription&>(field) = description.field;
    const auto beside = [&](const char* array) {
        const auto name = description.files.find(array);
        if (name == description.files.end())
            throw Error(ErrorCode::unreadable_input,
                        fmt::format("{}: member '{}' is missing; it names the file of that array of a sparse field",
                                    sidecar_path(path), array));
        return path_beside(path, name->second);
    };
    read_sparse_array(beside(bricks_name), ElementType::int64, {-1, 3}, [&](std::size_t count) {
        field.bricks.resize(count);
        return std::as_writable_bytes(std::span(field.bricks));
    });
    read_sparse_array(beside(runs_name), ElementType::int64, {-1, 4}, [&](std::size_t count) {
        field.inside.resize(count);
        return std::as_writable_bytes(std::span(field.inside));
    });
    for (const OutputInfo& info : output_table()) {
        const bool is_distance = info.output == Output::distance;
        if (!is_distance && (!wanted.contains(info.output) || !description.files.contains(info.name))) continue;
        const std::string array = is_distance ? path : beside(info.name);
        if (!is_distance && !is_there(array)) continue;
        read_sparse_array(array, info.type, sparse_shape(field.bricks.size(), info),
                          [&](std::size_t count) { return field.resize(info.output, count); });
    }
    check_sparse(InputFile(path), field);
    return field;
}

/// A file of a sparse field that was copied without those beside it has the shape of bricks.
void check_has_no_bricks(InputFile& file, const std::string& path) {
    if (is_there(sidecar_path(path))) return;
    const NpyHeader header = read_field_header(file);
    if (header.shape.size() != 4 ||
        header.shape != sparse_shape(static_cast<std::size_t>(header.shape[0]), info_of(Output::distance)))
        return;
    file.fail(
        fmt::format("it has the bricks of a sparse field, and there is no '{}' beside it, which states where they lie; "
                    "copy that file into its folder, with '{}' and '{}'",
                    sidecar_path(path), extra_path(path, bricks_name), extra_path(path, runs_name)));
}

/// The description of a sparse field; nothing if the file has a dense one, or no description.
std::optional<Description> sparse_description(const std::string& path) {
    const std::string sidecar = sidecar_path(path);
    if (!is_there(sidecar)) return std::nullopt;
    Description description = read_description(sidecar);
    if (!description.files.contains(bricks_name)) return std::nullopt;
    return description;
}

}  // namespace

std::unique_ptr<FormatWriter> npy_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    return std::make_unique<NpyWriter>(path, field, outputs);
}

std::unique_ptr<SparseFormatWriter> sparse_npy_writer(const std::string& path, const FieldDescription& field,
                                                      OutputSet outputs) {
    check_utf8(path, "the description, which names the files of the bricks,");
    return std::make_unique<SparseNpyWriter>(path, field, outputs);
}

void check_npy(const std::string& path, OutputSet outputs) {
    if (infos_of(outputs).size() > 1) check_utf8(path, "the description, which names the files of the other outputs,");
}

std::map<std::string, std::string> files_of_npy(const std::string& path) {
    return read_description(sidecar_path(path)).files;
}

std::optional<SparseField> read_sparse_npy(const std::string& path, OutputSet wanted) {
    InputFile file(path);  // a file that is missing has no dense field
    const std::optional<Description> description = sparse_description(path);
    if (!description) {
        check_has_no_bricks(file, path);
        return std::nullopt;
    }
    return read_sparse(path, *description, wanted);
}

Field read_npy(const std::string& path, OutputSet wanted) {
    InputFile file(path);
    if (const std::optional<SparseField> sparse = read_sparse_npy(path, wanted)) return to_dense(*sparse);
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
