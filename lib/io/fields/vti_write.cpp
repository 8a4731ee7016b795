#include "io/fields/field_files.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <limits>

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

void check_extent(const std::string& path, const Grid& grid) {
    for (const std::int64_t size : grid.size)
        if (size > std::numeric_limits<std::int32_t>::max())
            throw Error(ErrorCode::unsupported,
                        fmt::format("{}: VTK counts the samples of an axis in 32 bits, and {} are too many; choose "
                                    ".nrrd, .npy or .h5",
                                    path, size));
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
          slice_(static_cast<std::uint64_t>(field.grid.size[0]) * static_cast<std::uint64_t>(field.grid.size[1])),
          samples_(field.grid.sample_count()),
          file_(path) {
        const std::string text = document(field);
        file_.write(text);
        begin_ = text.size();
    }

    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        std::uint64_t array = begin_;
        for (const OutputInfo& info : infos_) {
            const std::uint64_t bytes = samples_ * info.sample_bytes();
            if (first_slice == 0) {
                file_.seek(array);
                write_number(bytes);
            }
            file_.seek(array + header_width + static_cast<std::uint64_t>(first_slice) * slice_ * info.sample_bytes());
            write_little_endian(file_, slab.bytes(info.output), bytes_of(info.type));
            array += header_width + bytes;
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
        for (const OutputInfo& info : infos_) {
            arrays += fmt::format(
                "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
                "offset=\"{}\"/>\n",
                vti_name_of(info.type), info.name, info.components, offset);
            offset += header_width + samples_ * info.sample_bytes();
        }
        return fmt::format(
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
            "  <ImageData WholeExtent=\"{}\" Origin=\"{}\" Spacing=\"{}\">\n"
            "    <FieldData>\n"
            "      <DataArray type=\"String\" Name=\"clsdf\" NumberOfTuples=\"1\" format=\"ascii\">\n"
            "        {}\n"
            "      </DataArray>\n"
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
            numbers_of_letters(description_text(field)), extent, info_of(Output::distance).name, arrays);
    }

    void write_number(std::uint64_t number) {
        write_little_endian(file_, std::as_bytes(std::span(&number, 1)), sizeof(number));
    }

    std::vector<OutputInfo> infos_;
    std::uint64_t slice_;
    std::uint64_t samples_;
    std::uint64_t begin_ = 0;  // of the values
    std::uint64_t end_ = 0;
    AtomicFile file_;
};

}  // namespace

std::unique_ptr<FormatWriter> vti_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    check_extent(path, field.grid);
    return std::make_unique<VtiWriter>(path, field, outputs);
}

}  // namespace clsdf
