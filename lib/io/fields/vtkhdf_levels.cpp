#include "core/files.hpp"
#include "io/fields/field_files.hpp"
#include "io/fields/hdf5_layout.hpp"
#include "io/fields/vtkhdf.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <vector>

namespace clsdf {
namespace {

using hdf5::NewArray;
using hdf5::NewAttribute;

[[noreturn]] void refuse(std::size_t box, const std::string& reason) {
    throw Error(ErrorCode::invalid_argument, fmt::format("box {} of a refined mesh: {}", box, reason));
}

/// The boxes of one spacing.
struct Level {
    Vec3 spacing{};
    std::vector<std::size_t> boxes{};
    std::vector<std::int32_t> extents{};  ///< of each box the first and the last cell along x, y, z
    std::uint64_t cells = 0;
};

Vec3 lower_corner(const Grid& grid) {
    Vec3 corner = grid.position(0, 0, 0);
    for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] -= 0.5 * grid.spacing[axis];
    return corner;
}

/// Coarsest first.
std::vector<Level> levels_of(std::span<const CellBox> boxes) {
    std::vector<Level> levels;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Vec3& spacing = boxes[i].grid.spacing;
        auto level = std::ranges::find(levels, spacing, &Level::spacing);
        if (level == levels.end()) level = levels.insert(levels.end(), Level{.spacing = spacing});
        level->boxes.push_back(i);
        level->cells += boxes[i].grid.sample_count();
    }
    std::ranges::sort(levels, [](const Level& a, const Level& b) { return a.spacing[0] > b.spacing[0]; });
    for (std::size_t l = 1; l < levels.size(); ++l)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double ratio = levels[l - 1].spacing[axis] / levels[l].spacing[axis];
            if (std::round(ratio) < 1 || std::abs(ratio - std::round(ratio)) > 1e-6)
                refuse(levels[l].boxes.front(), fmt::format("{:g} is no whole part of the spacing of the next coarser "
                                                            "level, {:g}",
                                                            levels[l].spacing[axis], levels[l - 1].spacing[axis]));
        }
    return levels;
}

/// The lower corner of the coarsest level; all boxes then have their places on the lattices of their levels.
Vec3 place(std::span<const CellBox> boxes, std::vector<Level>& levels) {
    Vec3 origin = lower_corner(boxes[levels.front().boxes.front()].grid);
    for (const std::size_t i : levels.front().boxes)
        for (std::size_t axis = 0; axis < 3; ++axis)
            origin[axis] = std::min(origin[axis], lower_corner(boxes[i].grid)[axis]);
    for (Level& level : levels)
        for (const std::size_t i : level.boxes)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const Grid& grid = boxes[i].grid;
                const double cell = (lower_corner(grid)[axis] - origin[axis]) / level.spacing[axis];
                const double first = std::round(cell), last = first + static_cast<double>(grid.size[axis]) - 1;
                if (std::abs(cell - first) > 1e-3)
                    refuse(i, fmt::format("its cells lie {:g} cells beside those of the coarsest level", cell - first));
                const double farthest = std::abs(first) > std::abs(last) ? first : last;
                if (std::abs(farthest) > std::numeric_limits<std::int32_t>::max())
                    refuse(i, fmt::format("VTK counts no cell {:.0f}", farthest));
                level.extents.push_back(static_cast<std::int32_t>(first));
                level.extents.push_back(static_cast<std::int32_t>(last));
            }
    return origin;
}

/// VTK shows one of two values of a cell, and counts it twice.
void refuse_overlaps(const Level& level) {
    const auto of = [&](std::size_t box, std::size_t n) { return level.extents[6 * box + n]; };
    std::vector<std::size_t> by_z(level.boxes.size());
    std::iota(by_z.begin(), by_z.end(), std::size_t{0});
    std::ranges::sort(by_z, {}, [&](std::size_t box) { return of(box, 4); });
    for (std::size_t n = 0; n < by_z.size(); ++n)
        for (std::size_t m = n + 1; m < by_z.size() && of(by_z[m], 4) <= of(by_z[n], 5); ++m) {
            const std::size_t a = by_z[n], b = by_z[m];
            if (of(a, 0) > of(b, 1) || of(b, 0) > of(a, 1) || of(a, 2) > of(b, 3) || of(b, 2) > of(a, 3)) continue;
            const auto [first, second] = std::minmax(level.boxes[a], level.boxes[b]);
            refuse(second, fmt::format("it overlaps box {} of the same spacing; leave ghost cells out", first));
        }
}

void check(std::span<const CellBox> boxes) {
    if (boxes.empty()) throw Error(ErrorCode::invalid_argument, "a refined mesh has one box at least");
    const OutputSet outputs = boxes.front().values.outputs();
    if (outputs.empty()) refuse(0, "it has no values");
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        boxes[i].grid.validate();
        if (boxes[i].values.outputs() != outputs) refuse(i, "it has other outputs than box 0");
        for (const OutputInfo& info : infos_of(outputs))
            if (boxes[i].values.bytes(info.output).size() != boxes[i].grid.sample_count() * info.sample_bytes())
                refuse(i, fmt::format("'{}' has {} bytes, not those of {} cells", info.name,
                                      boxes[i].values.bytes(info.output).size(), boxes[i].grid.sample_count()));
    }
}

hdf5::NewContent content(const std::vector<Level>& levels, const Vec3& origin, const std::vector<OutputInfo>& infos) {
    hdf5::NewContent content;
    content.groups = {{vtkhdf::root,
                       {{"Version", std::vector<std::int64_t>{1, 0}},
                        {"Type", NewAttribute::Ascii{"OverlappingAMR"}},
                        {"Origin", std::vector(origin.begin(), origin.end())},
                        {"GridDescription", NewAttribute::Ascii{"XYZ"}}}}};
    for (std::size_t l = 0; l < levels.size(); ++l) {
        const std::string group = fmt::format("{}/Level{}", vtkhdf::root, l);
        const Vec3& spacing = levels[l].spacing;
        content.groups.push_back({group, {{"Spacing", std::vector(spacing.begin(), spacing.end())}}});
        for (const char* part : {"CellData", "PointData", "FieldData"})
            content.groups.push_back({group + "/" + part, {}});
        content.arrays.push_back({group + "/AMRBox", ElementType::int32, {levels[l].boxes.size(), 6}, {}});
        for (const OutputInfo& info : infos) {
            std::vector<hsize_t> shape{levels[l].cells};
            if (info.components > 1) shape.push_back(info.components);
            content.arrays.push_back({fmt::format("{}/CellData/{}", group, info.name), info.type, shape, {}});
        }
    }
    return content;
}

}  // namespace

void write_overlapping_amr(std::span<const CellBox> boxes, const std::string& path) {
    if (format_of(path, ErrorCode::unsupported).writer != &vtkhdf_writer)
        throw Error(ErrorCode::unsupported, fmt::format("{}: boxes of a refined mesh are written as .vtkhdf", path));
    check(boxes);
    std::vector<Level> levels = levels_of(boxes);
    const Vec3 origin = place(boxes, levels);
    for (const Level& level : levels) refuse_overlaps(level);
    const std::vector<OutputInfo> infos = infos_of(boxes.front().values.outputs());

    AtomicFile file(path);
    const std::vector<std::uint64_t> offsets = hdf5::write_layout(file, path, content(levels, origin, infos));
    auto offset = offsets.begin();
    for (const Level& level : levels) {
        file.seek(*offset++);
        write_little_endian(file, std::as_bytes(std::span(level.extents)), sizeof(std::int32_t));
        for (const OutputInfo& info : infos) {
            file.seek(*offset++);
            for (const std::size_t i : level.boxes)
                write_little_endian(file, boxes[i].values.bytes(info.output), bytes_of(info.type));
        }
    }
    file.commit();
}

}  // namespace clsdf
