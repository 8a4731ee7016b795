#include "core/files.hpp"
#include "io/fields/field_files.hpp"
#include "io/fields/hdf5_layout.hpp"
#include "io/fields/vtkhdf.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {
namespace {

using hdf5::NewArray;
using hdf5::NewAttribute;

std::string in_group(const char* group, const std::string& array) {
    return std::string(group) + "/" + array;
}

/// VTK's ImageData in HDF5: the arrays of .h5 in the group PointData. The grid's own first sample is the extent's 0.
/// The description is an attribute of the file, as in .h5.
class VtkHdfWriter : public FormatWriter {
public:
    VtkHdfWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : infos_(infos_of(outputs)),
          groups_(outputs.contains(Output::triangle) ? field.groups : nullptr),
          slice_(static_cast<std::uint64_t>(field.grid.size[0]) * static_cast<std::uint64_t>(field.grid.size[1])),
          file_(path),
          offsets_(hdf5::write_layout(file_, path, content(field))) {}

    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        for (std::size_t i = 0; i < infos_.size(); ++i) write(i, infos_[i], slab.bytes(infos_[i].output), first_slice);
        if (!groups_) return;
        const std::span<const std::uint32_t> triangles = slab.triangle();
        numbers_.resize(triangles.size());
        std::ranges::transform(triangles, numbers_.begin(), [&](std::uint32_t t) { return groups_->of(t); });
        write(infos_.size(), group_info, std::as_bytes(std::span(numbers_)), first_slice);
    }

    void finish() override { file_.commit(); }

private:
    hdf5::NewContent content(const FieldDescription& field) const {
        const Grid& grid = field.grid;
        const Vec3 origin = grid.position(0, 0, 0);
        hdf5::NewContent content;
        content.attributes = {{"clsdf", description_text(field)}};
        content.groups = {
            {vtkhdf::root,
             {{"Version", std::vector<std::int64_t>{1, 0}},
              {"Type", NewAttribute::Ascii{"ImageData"}},
              {"WholeExtent", std::vector<std::int64_t>{0, grid.size[0] - 1, 0, grid.size[1] - 1, 0, grid.size[2] - 1}},
              {"Origin", std::vector(origin.begin(), origin.end())},
              {"Spacing", std::vector(grid.spacing.begin(), grid.spacing.end())},
              {"Direction", std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1}}}},
            {vtkhdf::point_data, {{"Scalars", NewAttribute::Ascii{info_of(Output::distance).name}}}},
            {vtkhdf::cell_data, {}},
            {vtkhdf::field_data, {}}};
        for (const OutputInfo& info : infos_) content.arrays.push_back(array_of(grid, info));
        if (groups_) {
            // VTK 9.1 refuses a file with texts in FieldData.
            content.arrays.push_back(array_of(grid, group_info));
            if (!groups_->names.empty()) content.arrays.back().attributes = {{"names", groups_->names}};
        }
        return content;
    }

    static NewArray array_of(const Grid& grid, const OutputInfo& info) {
        return {in_group(vtkhdf::point_data, info.name), info.type, hdf5::shape_of(grid, info), {}};
    }

    void write(std::size_t array, const OutputInfo& info, std::span<const std::byte> values, std::int64_t first_slice) {
        file_.seek(offsets_[array] + static_cast<std::uint64_t>(first_slice) * slice_ * info.sample_bytes());
        write_little_endian(file_, values, bytes_of(info.type));
    }

    static constexpr OutputInfo group_info{.name = "group", .type = ElementType::uint32};

    std::vector<OutputInfo> infos_;
    std::shared_ptr<const FaceGroups> groups_;  // null unless they are written
    std::vector<std::uint32_t> numbers_;
    std::uint64_t slice_;
    AtomicFile file_;
    std::vector<std::uint64_t> offsets_;
};

}  // namespace

std::unique_ptr<FormatWriter> vtkhdf_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    check_vtk_extent(path, field.grid);
    return std::make_unique<VtkHdfWriter>(path, field, outputs);
}

}  // namespace clsdf
