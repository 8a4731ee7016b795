#include "core/files.hpp"
#include "io/fields/field_files.hpp"
#include "io/fields/hdf5_layout.hpp"
#include "io/fields/segment_files.hpp"
#include "io/fields/sparse_files.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>

namespace clsdf {
namespace {

using hdf5::NewArray;
using hdf5::NewAttribute;

/// The attributes of an array of samples.
std::vector<NewAttribute> lattice_attributes(const Vec3& origin, const Vec3& spacing) {
    return {{"origin", std::vector(origin.begin(), origin.end())},
            {"spacing", std::vector(spacing.begin(), spacing.end())}};
}

/// The content of a file with this description.
hdf5::NewContent described(const std::string& description, std::vector<NewArray> arrays) {
    return {.attributes = {{"clsdf", description}}, .groups = {}, .arrays = std::move(arrays)};
}

std::string escaped_for_xml(std::string_view text) {
    std::string result;
    for (const char letter : text) {
        if (letter == '&')
            result += "&amp;";
        else if (letter == '<')
            result += "&lt;";
        else if (letter == '>')
            result += "&gt;";
        else
            result += letter;
    }
    return result;
}

// The XDMF text, which gives ParaView and VisIt the positions of the samples. XDMF has the order of HDF5: z, y, x.
std::string xdmf_text(const std::string& path, const Grid& grid, const std::vector<OutputInfo>& infos) {
    const Vec3 origin = grid.position(0, 0, 0);
    const auto triple = [](const auto& values) { return fmt::format("{} {} {}", values[2], values[1], values[0]); };
    std::string attributes;
    for (const OutputInfo& info : infos)
        attributes += fmt::format(
            "      <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">\n"
            "        <DataItem Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\" Format=\"HDF\">{}:/{}</DataItem>\n"
            "      </Attribute>\n",
            info.name,
            info.components == 1   ? "Scalar"
            : info.components == 3 ? "Vector"
                                   : "Matrix",
            fmt::join(hdf5::shape_of(grid, info), " "),
            is_whole(info.type) ? (info.type == ElementType::uint8 ? "UChar" : "UInt") : "Float", bytes_of(info.type),
            escaped_for_xml(file_name(path)), info.name);
    return fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<Xdmf Version=\"3.0\">\n"
        "  <Domain>\n"
        "    <Grid Name=\"field\" GridType=\"Uniform\">\n"
        "      <Time Value=\"0\"/>\n"  // PyVista reads no file without one
        "      <Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"{}\"/>\n"
        "      <Geometry GeometryType=\"ORIGIN_DXDYDZ\">\n"
        "        <DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">{}</DataItem>\n"
        "        <DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">{}</DataItem>\n"
        "      </Geometry>\n"
        "{}"
        "    </Grid>\n"
        "  </Domain>\n"
        "</Xdmf>\n",
        triple(grid.size), triple(origin), triple(grid.spacing), attributes);
}

std::string xdmf_path(const std::string& path) {
    return std::filesystem::path(path).replace_extension(".xdmf").string();
}

class H5Writer : public FormatWriter {
public:
    H5Writer(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : infos_(infos_of(outputs)),
          slice_(static_cast<std::uint64_t>(field.grid.size[0]) * static_cast<std::uint64_t>(field.grid.size[1])),
          xdmf_(xdmf_path(path)),
          file_(path) {
        xdmf_.write(xdmf_text(path, field.grid, infos_));
        std::vector<NewArray> arrays;
        for (const OutputInfo& info : infos_)
            arrays.push_back({info.name, info.type, hdf5::shape_of(field.grid, info),
                              lattice_attributes(field.grid.position(0, 0, 0), field.grid.spacing)});
        offsets_ = hdf5::write_layout(file_, path, described(description_text(field), std::move(arrays)));
    }

    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        for (std::size_t i = 0; i < infos_.size(); ++i) {
            const OutputInfo& info = infos_[i];
            file_.seek(offsets_[i] + static_cast<std::uint64_t>(first_slice) * slice_ * info.sample_bytes());
            write_little_endian(file_, slab.bytes(info.output), bytes_of(info.type));
        }
    }

    void finish() override {
        const std::array<AtomicFile*, 2> files{&xdmf_, &file_};
        AtomicFile::commit_all(files);
    }

private:
    std::vector<OutputInfo> infos_;
    std::uint64_t slice_;
    std::vector<std::uint64_t> offsets_;
    AtomicFile xdmf_;
    AtomicFile file_;
};

/// HDF5 must know the number of bricks before it lays out the file, so values wait in unfinished files.
class SparseH5Writer : public SparseFormatWriter {
public:
    SparseH5Writer(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : path_(path), field_(field), infos_(infos_of(outputs)), file_(path) {
        for (std::size_t i = 0; i < infos_.size(); ++i) spills_.emplace_back(path);
    }

    void append(const SparseSlab& slab) override {
        for (std::size_t i = 0; i < infos_.size(); ++i) spills_[i].append(slab.values.bytes(infos_[i].output));
        bricks_.insert(bricks_.end(), slab.bricks.begin(), slab.bricks.end());
        runs_.insert(runs_.end(), slab.inside.begin(), slab.inside.end());
    }

    void finish() override {
        std::vector<NewArray> arrays{{bricks_name,
                                      ElementType::int64,
                                      {bricks_.size(), 3},
                                      lattice_attributes(field_.grid.origin, field_.grid.spacing)},
                                     {runs_name, ElementType::int64, {runs_.size(), 4}, {}}};
        for (const OutputInfo& info : infos_) {
            const std::vector<std::int64_t> shape = sparse_shape(bricks_.size(), info);
            arrays.push_back({info.name, info.type, {shape.begin(), shape.end()}, {}});
        }
        const std::vector<std::uint64_t> offsets =
            hdf5::write_layout(file_, path_, described(description_text(field_), std::move(arrays)));
        write(offsets[0], std::as_bytes(std::span(bricks_)), sizeof(std::int64_t));
        write(offsets[1], std::as_bytes(std::span(runs_)), sizeof(std::int64_t));
        std::vector<std::byte> part;
        for (std::size_t i = 0; i < infos_.size(); ++i) {
            constexpr std::uint64_t most = std::uint64_t{1} << 22;
            for (std::uint64_t begin = 0; begin < spills_[i].size(); begin += most) {
                part.resize(static_cast<std::size_t>(std::min(most, spills_[i].size() - begin)));
                spills_[i].read(begin, part);
                write(offsets[2 + i] + begin, part, bytes_of(infos_[i].type));
            }
        }
        file_.commit();
        remove_xdmf();
    }

private:
    /// A dense field that was in the file has left a file that describes its arrays.
    void remove_xdmf() const {
        std::error_code error;
        std::filesystem::remove(xdmf_path(path_), error);
        if (error)
            throw Error(ErrorCode::output_failure,
                        fmt::format("cannot remove '{}', which describes the former content of '{}': {}",
                                    xdmf_path(path_), path_, error.message()));
    }

    void write(std::uint64_t offset, std::span<const std::byte> values, std::size_t width) {
        if (values.empty()) return;
        file_.seek(offset);
        write_little_endian(file_, values, width);
    }

    std::string path_;
    FieldDescription field_;
    std::vector<OutputInfo> infos_;
    AtomicFile file_;
    std::deque<SpillFile> spills_;  // of each output
    std::vector<Index3> bricks_;
    std::vector<BrickRun> runs_;
};

}  // namespace

std::unique_ptr<FormatWriter> h5_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    return std::make_unique<H5Writer>(path, field, outputs);
}

std::unique_ptr<SparseFormatWriter> sparse_h5_writer(const std::string& path, const FieldDescription& field,
                                                     OutputSet outputs) {
    return std::make_unique<SparseH5Writer>(path, field, outputs);
}

void write_h5_arrays(const std::string& path, const std::string& description, std::span<const FileArray> arrays) {
    AtomicFile file(path);
    std::vector<NewArray> layout;
    for (const FileArray& array : arrays)
        layout.push_back({array.name, array.type, {array.shape.begin(), array.shape.end()}, {}});
    const std::vector<std::uint64_t> offsets =
        hdf5::write_layout(file, path, described(description, std::move(layout)));
    for (std::size_t n = 0; n < arrays.size(); ++n) {
        if (arrays[n].bytes.empty()) continue;
        file.seek(offsets[n]);
        write_little_endian(file, arrays[n].bytes, bytes_of(arrays[n].type));
    }
    file.commit();
}

void check_h5(const std::string& path, OutputSet) {
    check_utf8(path, "the .xdmf file, which names the .h5 file,");
}

}  // namespace clsdf
