#include "core/files.hpp"
#include "core/refuse.hpp"
#include "io/fields/hdf5_layout.hpp"
#include "io/fields/sparse_files.hpp"

#include <clsdf/error.hpp>
#include <clsdf/part_files.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

namespace clsdf {

namespace {

/// Of the attribute that such a file has.
constexpr const char* description = "parts of transforms";

std::string dataset_of(std::size_t part) {
    return fmt::format("part_{}", part);
}

hdf5::WantedArray wanted_part(std::size_t part) {
    return {dataset_of(part), "byte", ElementType::uint8, {"byte"}};
}

void require_parts(InputFile& file, const hdf5::Source& source) {
    const std::optional<std::string> text = source.text("", "clsdf");
    if (!text || *text != description)
        file.fail(fmt::format("its attribute 'clsdf' is not '{}', so it has none", description));
}

std::size_t parts_in(const hdf5::Source& source) {
    std::size_t count = 0;
    while (source.has(dataset_of(count))) ++count;
    return count;
}

}  // namespace

/// HDF5 must know the lengths before it lays out the file, so the bytes wait in an unfinished file.
class PartFile {
public:
    explicit PartFile(const std::string& path) : path_(path), file_(path), spill_(path) {}

    void append(std::span<const std::byte> bytes) {
        spill_.append(bytes);
        sizes_.push_back(bytes.size());
    }

    void finish() {
        hdf5::NewContent content{.attributes = {{"clsdf", std::string(description)}}, .groups = {}, .arrays = {}};
        for (std::size_t part = 0; part < sizes_.size(); ++part)
            content.arrays.push_back({dataset_of(part), ElementType::uint8, {sizes_[part]}, {}});
        const std::vector<std::uint64_t> offsets = hdf5::write_layout(file_, path_, content);
        std::vector<std::byte> some;
        std::uint64_t from = 0;
        for (std::size_t part = 0; part < sizes_.size(); ++part) {
            file_.seek(offsets[part]);
            for (const std::uint64_t end = from + sizes_[part]; from < end; from += some.size()) {
                constexpr std::uint64_t most = std::uint64_t{1} << 22;
                some.resize(static_cast<std::size_t>(std::min(most, end - from)));
                spill_.read(from, some);
                write_little_endian(file_, some, 1);
            }
        }
        file_.commit();
    }

    bool is_empty() const { return sizes_.empty(); }
    const std::string& path() const { return path_; }

private:
    std::string path_;
    AtomicFile file_;
    SpillFile spill_;
    std::vector<std::uint64_t> sizes_;
};

namespace {

constexpr const char* no_file =
    "the file of parts has been finished, or a part could not be written; begin again with a new writer";

}  // namespace

PartWriter::PartWriter(const std::string& path) {
    if (ending_of(path) != ".h5") refuse_unsupported("{}: parts are written as .h5", path);
    file_ = std::make_unique<PartFile>(path);
}
PartWriter::PartWriter(PartWriter&&) noexcept = default;
PartWriter& PartWriter::operator=(PartWriter&&) noexcept = default;
PartWriter::~PartWriter() = default;

void PartWriter::append(std::span<const std::byte> bytes) {
    if (!file_) throw Error(ErrorCode::invalid_argument, no_file);
    if (bytes.empty()) refuse("{}: a part has no bytes", file_->path());
    // After a failure some of the part's bytes may be there: the next part would begin behind them.
    std::unique_ptr<PartFile> file = std::move(file_);
    file->append(bytes);
    file_ = std::move(file);
}

void PartWriter::finish() {
    if (!file_) throw Error(ErrorCode::invalid_argument, no_file);
    if (file_->is_empty()) refuse("{}: there is no part", file_->path());
    std::exchange(file_, nullptr)->finish();
}

std::size_t count_parts(const std::string& path) {
    std::size_t count = 0;
    hdf5::with_source(path, [&](InputFile& file, const hdf5::Source& source) {
        require_parts(file, source);
        count = parts_in(source);
    });
    return count;
}

std::vector<std::byte> read_part(const std::string& path, std::size_t part) {
    std::vector<std::byte> bytes;
    hdf5::with_source(path, [&](InputFile& file, const hdf5::Source& source) {
        require_parts(file, source);
        if (!source.has(dataset_of(part)))
            refuse("{}: there is no part {}: parts are numbered from 0, and it has {}", path, part, parts_in(source));
        const hdf5::StoredArray array = source.array(wanted_part(part));
        if (!array.chunks.empty())
            file.fail(fmt::format("dataset '/{}': its values are in chunks; save it contiguous (h5repack -l CONTI)",
                                  dataset_of(part)));
        bytes.resize(checked_count(file, array.values, array.shape));
        read_values(file, array.values, ElementType::uint8, bytes);
    });
    return bytes;
}

}  // namespace clsdf
