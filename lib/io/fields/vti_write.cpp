#include "core/refuse.hpp"
#include "io/fields/field_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace clsdf {
namespace {

constexpr std::size_t header_width = sizeof(std::uint64_t);

const char* vti_name_of(ElementType type) {
    switch (type) {
        case ElementType::float64:
            return "Float64";
        case ElementType::uint32:
            return "UInt32";
        case ElementType::uint8:
            return "UInt8";
        default:
            return "Float32";
    }
}

// Texts in VTK's ASCII are the numbers of their letters, with a zero at the end.
std::string numbers_of_letters(const std::string& text) {
    std::string numbers;
    for (const char letter : text) numbers += fmt::format("{} ", static_cast<unsigned char>(letter));
    return numbers + "0";
}

/// VTK's ImageData in one piece with raw appended values: an XML document whose arrays name the offsets of their values
/// behind the underscore, each led by its number of bytes. The grid's own first sample is the extent's 0.
class VtiWriter : public FormatWriter {
public:
    VtiWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : infos_(infos_of(outputs)),
          groups_(outputs.contains(Output::triangle) ? field.groups : nullptr),
          slice_(static_cast<std::uint64_t>(field.grid.size[0]) * static_cast<std::uint64_t>(field.grid.size[1])),
          samples_(field.grid.sample_count()),
          file_(path) {
        const std::string text = document(field);
        file_.write(text);
        begin_ = text.size();
    }

    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        std::uint64_t array = begin_;
        const auto write = [&](const OutputInfo& info, std::span<const std::byte> values) {
            const std::uint64_t bytes = samples_ * info.sample_bytes();
            if (first_slice == 0) {
                file_.seek(array);
                write_number(bytes);
            }
            file_.seek(array + header_width + static_cast<std::uint64_t>(first_slice) * slice_ * info.sample_bytes());
            write_little_endian(file_, values, bytes_of(info.type));
            array += header_width + bytes;
        };
        for (const OutputInfo& info : infos_) write(info, slab.bytes(info.output));
        if (groups_) {
            const std::span<const std::uint32_t> triangles = slab.triangle();
            numbers_.resize(triangles.size());
            std::ranges::transform(triangles, numbers_.begin(), [&](std::uint32_t t) { return groups_->of(t); });
            write(group_info, std::as_bytes(std::span(numbers_)));
        }
        end_ = array;
    }

    void finish() override {
        file_.seek(end_);
        file_.write("\n  </AppendedData>\n</VTKFile>\n");
        file_.commit();
    }

private:
    std::string document(const FieldDescription& field) const {
        const Grid& grid = field.grid;
        const std::string extent = fmt::format("0 {} 0 {} 0 {}", grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
        std::string arrays;
        std::uint64_t offset = 0;
        const auto add = [&](const OutputInfo& info) {
            arrays += fmt::format(
                "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
                "offset=\"{}\"/>\n",
                vti_name_of(info.type), info.name, info.components, offset);
            offset += header_width + samples_ * info.sample_bytes();
        };
        for (const OutputInfo& info : infos_) add(info);
        if (groups_) add(group_info);
        return fmt::format(
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
            "  <ImageData WholeExtent=\"{}\" Origin=\"{}\" Spacing=\"{}\">\n"
            "    <FieldData>\n"
            "      <DataArray type=\"String\" Name=\"clsdf\" NumberOfTuples=\"1\" format=\"ascii\">\n"
            "        {}\n"
            "      </DataArray>\n"
            "{}"
            "    </FieldData>\n"
            "    <Piece Extent=\"{}\">\n"
            "      <PointData Scalars=\"{}\">\n"
            "{}"
            "      </PointData>\n"
            "      <CellData/>\n"
            "    </Piece>\n"
            "  </ImageData>\n"
            "  <AppendedData encoding=\"raw\">\n"
            "   _",
            extent, fmt::join(grid.position(0, 0, 0), " "), fmt::join(grid.spacing, " "),
            numbers_of_letters(description_text(field)), names_of_groups(), extent, info_of(Output::distance).name,
            arrays);
    }

    std::string names_of_groups() const {
        if (!groups_) return {};
        std::string names;
        for (const std::string& name : groups_->names) names += numbers_of_letters(name) + " ";
        return fmt::format(
            "      <DataArray type=\"String\" Name=\"groups\" NumberOfTuples=\"{}\" format=\"ascii\">\n"
            "        {}\n"
            "      </DataArray>\n",
            groups_->names.size(), names);
    }

    void write_number(std::uint64_t number) {
        write_little_endian(file_, std::as_bytes(std::span(&number, 1)), sizeof(number));
    }

    static constexpr OutputInfo group_info{.name = "group", .type = ElementType::uint32};

    std::vector<OutputInfo> infos_;
    std::shared_ptr<const FaceGroups> groups_;  // null unless they are written
    std::vector<std::uint32_t> numbers_;
    std::uint64_t slice_;
    std::uint64_t samples_;
    std::uint64_t begin_ = 0;  // of the values
    std::uint64_t end_ = 0;
    AtomicFile file_;
};

}  // namespace

void check_vtk_extent(const std::string& path, const Grid& grid) {
    for (const std::int64_t size : grid.size)
        if (size > std::numeric_limits<std::int32_t>::max())
            refuse_unsupported(
                "{}: VTK counts the samples of an axis in 32 bits, and {} are too many; choose "
                ".nrrd, .npy or .h5",
                path, size);
}

std::unique_ptr<FormatWriter> vti_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    check_vtk_extent(path, field.grid);
    return std::make_unique<VtiWriter>(path, field, outputs);
}

}  // namespace clsdf
