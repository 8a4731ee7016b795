#include "io/fields/field_files.hpp"

#include "core/files.hpp"
#include "core/refuse.hpp"
#include "core/unfinished_files.hpp"
#include "io/fields/sparse_files.hpp"
#include "io/meshes/mesh_files.hpp"
#include "tools/text.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <new>
#include <optional>
#include <utility>

namespace clsdf {
namespace {

namespace fs = std::filesystem;

constexpr std::array formats{
    Format{".nrrd", nrrd_writer, read_nrrd, true, nullptr, files_of_nrrd},
    Format{".npy", npy_writer, read_npy, true, check_npy, files_of_npy, sparse_npy_writer, read_sparse_npy},
    Format{.ending = ".vti", .writer = vti_writer, .read = read_vti, .has_groups = true},
    Format{.ending = ".vtkhdf", .writer = vtkhdf_writer, .read = read_vtkhdf, .has_groups = true},
    Format{".h5", h5_writer, read_h5, true, check_h5, nullptr, sparse_h5_writer, read_sparse_h5},
    Format{".vdb", vdb_writer, read_vdb, true, check_vdb, nullptr, sparse_vdb_writer, read_sparse_vdb, true},
    Format{".nvdb", nvdb_writer, read_nvdb, false, check_nvdb, nullptr, sparse_nvdb_writer, read_sparse_nvdb, true},
    Format{".sdf", sdf_writer, read_sdf, false},
};

std::string endings() {
    std::string text;
    for (std::size_t i = 0; i < formats.size(); ++i)
        text.append(i == 0 ? "" : i + 1 < formats.size() ? ", " : " or ").append(formats[i].ending);
    return text;
}

}  // namespace

const Format& format_of(const std::string& path, ErrorCode code) {
    const std::string ending = ending_of(path);
    for (const Format& format : formats)
        if (format.ending == ending) return format;
    throw Error(code, fmt::format("{}: no field format ends in \"{}\"; choose {}", path, ending, endings()));
}

void check_place_for(OutputSet outputs, const std::string& path, const Format& format) {
    if (format.check != nullptr) format.check(path, outputs);
    if (format.has_extras) return;
    for (const OutputInfo& info : extra_outputs())
        if (outputs.contains(info.output))
            refuse_unsupported("{}: {} cannot store the output {}; choose another format, or leave the output out",
                               path, format.ending, info.name);
}

Grid with_lattice(const Grid& stated, const Vec3& lattice_origin, const Index3& lattice_first) {
    const Grid part{lattice_origin, stated.spacing, stated.size, lattice_first};
    part.validate();
    return part.position(0, 0, 0) == stated.position(0, 0, 0) ? part : stated;
}

std::string extra_path(const std::string& path, const std::string& array) {
    const fs::path file(path);
    return (file.parent_path() / (file.stem().string() + "_" + array + file.extension().string())).string();
}

std::string file_name(const std::string& path) {
    return fs::path(path).filename().string();
}

std::string path_beside(const std::string& path, const std::string& name) {
    const fs::path file(name);
    if (name.empty() || file.filename() != file || name == "." || name == "..")
        throw Error(ErrorCode::unreadable_input,
                    fmt::format("{}: {} is not the name of a file in the same folder", path, quoted(name, 80)));
    return (fs::path(path).parent_path() / file).string();
}

bool is_there(const std::string& path) noexcept {
    return ::access(path.c_str(), F_OK) == 0;
}

namespace fs = std::filesystem;

void check_field_path(const std::string& path, OutputSet outputs) {
    check_place_for(outputs, path, format_of(path, ErrorCode::unsupported));
    check_writable(path);
}

void write_field(const Field& field, const std::string& path) {
    format_of(path, ErrorCode::unsupported);
    field.grid.validate();
    const std::size_t samples = field.grid.sample_count();
    const OutputSet outputs = field.outputs();
    const FieldSlab slab = field.slab();
    for (const OutputInfo& info : infos_of(outputs)) {
        const std::size_t values = slab.bytes(info.output).size() / info.sample_bytes();
        if (slab.bytes(info.output).size() != samples * info.sample_bytes())
            refuse("field: {} has {} values, but the grid {} samples", info.name, values, samples);
    }
    FieldWriter writer(path, field, outputs);
    writer.append(slab);
    writer.finish();
}

Field read_field(const std::string& path) {
    OutputSet all;
    for (const OutputInfo& info : extra_outputs()) all.insert(info.output);
    return read_field(path, all);
}

namespace {

/// Calls read(), which reads this file.
template <class Read>
auto with_errors_of(const std::string& path, const Read& read) {
    try {
        return read();
    } catch (const Error& error) {
        if (error.code() == ErrorCode::unreadable_input && fs::is_regular_file(path))
            refuse_other_content(FileContent(path, telling_bytes));
        // An invalid grid, band or sign rule of the file is an error of the file, not of the caller.
        if (error.code() != ErrorCode::invalid_argument) throw;
        throw Error(ErrorCode::unreadable_input, fmt::format("{}: {}", path, error.what()));
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, fmt::format("{}: the field does not fit the memory", path));
    }
}

}  // namespace

Field read_field(const std::string& path, OutputSet wanted) {
    const Format& format = format_of(path, ErrorCode::unsupported);
    return with_errors_of(path, [&] { return format.read(path, wanted); });
}

std::optional<SparseField> read_sparse_field(const std::string& path, OutputSet wanted) {
    const Format& format = format_of(path, ErrorCode::unsupported);
    if (format.read_sparse == nullptr) return std::nullopt;
    return with_errors_of(path, [&] { return format.read_sparse(path, wanted); });
}

std::vector<std::string> missing_field_files(const std::string& path) {
    const Format& format = format_of(path, ErrorCode::unsupported);
    std::vector<std::string> missing;
    if (format.files == nullptr) return missing;
    for (const auto& [output, name] : format.files(path))
        if (const std::string beside = path_beside(path, name); !is_there(beside)) missing.push_back(beside);
    return missing;
}

namespace {

Error misuse(const std::string& what) {
    return {ErrorCode::invalid_argument, "field writer: " + what};
}

// The number of slices in a slab. Every announced output must have the same number, and no other output any.
std::int64_t slices_in(const FieldSlab& slab, const Grid& grid, OutputSet outputs) {
    const auto slice = static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]);
    const std::size_t samples = slab.distance().size();
    if (samples == 0 || samples % slice != 0)
        throw misuse(fmt::format("{} samples are no whole slices of {} x {}", samples, grid.size[0], grid.size[1]));
    for (const OutputInfo& info : extra_outputs()) {
        const std::size_t bytes = slab.bytes(info.output).size();
        const std::size_t expected = outputs.contains(info.output) ? samples * info.sample_bytes() : 0;
        if (bytes != expected)
            throw misuse(fmt::format("{} has {} bytes in a slab of {} samples, and {} were announced", info.name, bytes,
                                     samples, expected));
    }
    return static_cast<std::int64_t>(samples / slice);
}

}  // namespace

namespace {

void check_floor(const std::string& path, const FieldDescription& field) {
    if (!field.floor) return;
    if (field.sign != SignRule::below)
        refuse(
            "{}: a floor, at z = {}, is for the sign rule below, and the field's rule is {}; leave "
            "it out",
            path, *field.floor, name_of(field.sign));
    if (!std::isfinite(*field.floor))
        refuse("{}: the floor of the sign rule below, {}, is not finite", path, *field.floor);
}

}  // namespace

FieldWriter::FieldWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
    : field_(field), outputs_(outputs) {
    const Format& format = format_of(path, ErrorCode::unsupported);
    field.grid.validate();
    field.band.validate();
    check_floor(path, field);
    if (field.positive_inside && (field.band.has_signs_only || field.sign == SignRule::none))
        refuse(
            "{}: {} cannot be positive inside; write the field without that", path,
            field.band.has_signs_only ? "a field of signs alone, which are those of zeros," : "a field without a sign");
    check_place_for(outputs, path, format);
    format_ = format.writer(path, field, outputs);
}

FieldWriter::FieldWriter(FieldWriter&&) noexcept = default;
FieldWriter& FieldWriter::operator=(FieldWriter&&) noexcept = default;
FieldWriter::~FieldWriter() = default;

void FieldWriter::append(const FieldSlab& slab) {
    // Taken out first: if an error is thrown, this writer cannot finish the incomplete files.
    std::unique_ptr<FormatWriter> format = std::exchange(format_, nullptr);
    if (!format) throw misuse("nothing can be appended after a failure or after finish()");
    const std::int64_t slices = slices_in(slab, field_.grid, outputs_);
    if (slices > field_.grid.size[2] - slices_)
        throw misuse(
            fmt::format("{} slices after {} are more than the {} of the grid", slices, slices_, field_.grid.size[2]));
    format->append(slab, slices_);
    slices_ += slices;
    format_ = std::move(format);
}

void FieldWriter::finish() {
    const std::unique_ptr<FormatWriter> format = std::exchange(format_, nullptr);
    if (!format) throw misuse("nothing is left to finish after a failure or after finish()");
    if (slices_ != field_.grid.size[2])
        throw misuse(fmt::format("{} of {} slices were appended", slices_, field_.grid.size[2]));
    format->finish();
}

namespace {

Error sparse_misuse(const std::string& what) {
    return {ErrorCode::invalid_argument, "sparse field writer: " + what};
}

/// The samples of all bricks that have a sample of the grid, along one axis.
std::int64_t bricks_begin(const Grid& grid, std::size_t axis) {
    return grid.first[axis] & ~(brick_side - 1);
}
std::int64_t bricks_end(const Grid& grid, std::size_t axis) {
    return (grid.first[axis] + grid.size[axis] + brick_side - 1) & ~(brick_side - 1);
}

void check_layers(const SparseSlab& slab, const Grid& grid, OutputSet outputs, std::int64_t next) {
    for (std::size_t axis = 0; axis < 2; ++axis)
        if (slab.part.first[axis] != bricks_begin(grid, axis) ||
            slab.part.size[axis] != bricks_end(grid, axis) - bricks_begin(grid, axis))
            throw sparse_misuse("a part has not the grid's whole layers of bricks");
    if (slab.part.first[2] != next || slab.part.size[2] < 1 || slab.part.size[2] % brick_side != 0 ||
        slab.part.size[2] > bricks_end(grid, 2) - next)
        throw sparse_misuse(fmt::format("layers {} to {} do not follow the layers before, which end at {}",
                                        slab.part.first[2], slab.part.first[2] + slab.part.size[2] - 1, next));
    for (const OutputInfo& info : infos_of(outputs))
        if (const std::size_t bytes = slab.values.bytes(info.output).size();
            bytes != slab.bricks.size() * brick_samples * info.sample_bytes())
            throw sparse_misuse(
                fmt::format("{} has {} bytes in a part of {} bricks", info.name, bytes, slab.bricks.size()));
    if (const std::string fault = fault_in(slab); !fault.empty()) throw sparse_misuse(fault);
}

}  // namespace

SparseFieldWriter::SparseFieldWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
    : field_(field), outputs_(outputs), next_(bricks_begin(field.grid, 2)) {
    const Format& format = format_of(path, ErrorCode::unsupported);
    if (format.sparse_writer == nullptr)
        refuse_unsupported("{}: {} stores no sparse fields; choose .nvdb, .vdb, .npy or .h5, or write a dense field",
                           path, format.ending);
    field.grid.validate();
    field.band.validate();
    check_floor(path, field);
    const double widest = field.sign == SignRule::none ? field.band.outside : field.band.widest();
    if (!std::isfinite(widest) || field.band.has_signs_only)
        throw sparse_misuse("a sparse field has a band of finite half widths");
    check_place_for(outputs, path, format);
    format_ = format.sparse_writer(path, field, outputs);
}

SparseFieldWriter::SparseFieldWriter(SparseFieldWriter&&) noexcept = default;
SparseFieldWriter& SparseFieldWriter::operator=(SparseFieldWriter&&) noexcept = default;
SparseFieldWriter::~SparseFieldWriter() = default;

void SparseFieldWriter::append(const SparseSlab& slab) {
    // Taken out first, as by FieldWriter.
    std::unique_ptr<SparseFormatWriter> format = std::exchange(format_, nullptr);
    if (!format) throw sparse_misuse("nothing can be appended after a failure or after finish()");
    check_layers(slab, field_.grid, outputs_, next_);
    format->append(slab);
    next_ += slab.part.size[2];
    format_ = std::move(format);
}

void SparseFieldWriter::finish() {
    const std::unique_ptr<SparseFormatWriter> format = std::exchange(format_, nullptr);
    if (!format) throw sparse_misuse("nothing is left to finish after a failure or after finish()");
    if (const std::int64_t end = bricks_end(field_.grid, 2); next_ != end)
        throw sparse_misuse(fmt::format("layers {} to {} are missing", next_, end - 1));
    format->finish();
}

bool stores_sparse_fields(const std::string& path) {
    return format_of(path, ErrorCode::unsupported).sparse_writer != nullptr;
}

bool stores_sparse_fields_only(const std::string& path) {
    return format_of(path, ErrorCode::unsupported).is_always_sparse;
}

bool stores_groups(const std::string& path) {
    return format_of(path, ErrorCode::unsupported).has_groups;
}

void write_field(const SparseField& field, const std::string& path) {
    OutputSet extras = field.outputs();
    extras.erase(Output::distance);
    SparseFieldWriter writer(path, field, extras);
    writer.append(field.slab());
    writer.finish();
}

void abandon_unfinished_files() noexcept {
    UnfinishedFiles::of_process().abandon();
}

}  // namespace clsdf
