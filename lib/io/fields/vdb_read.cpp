#include "core/parallel.hpp"
#include "io/fields/field_files.hpp"
#include "io/fields/sparse_files.hpp"
#include "io/fields/tree_bricks.hpp"
#include "io/fields/vdb.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace clsdf {

namespace {

// OpenVDB's header: magic number (8 bytes), versions (12), a flag, the UUID as text.
constexpr std::string_view magic(" BDV\0\0\0\0", 8);
constexpr std::size_t uuid_begin = 21;
constexpr std::size_t uuid_length = 36;
constexpr std::size_t header_length = uuid_begin + uuid_length;
constexpr std::string_view uuid_of_ours = "c15df000-0000-8000-";  // then the checksum, as xxxx-xxxxxxxxxxxx
constexpr std::size_t chunk = std::size_t{1} << 16;

// A checksum over words of eight bytes, for speed. Each step is one-to-one, so no change within one word goes
// unnoticed. The rotation moves the upper bits, which do not affect lower bits of a product, to the lower end.
class Checksum {
public:
    void add(std::string_view bytes) {
        constexpr std::size_t width = sizeof(std::uint64_t);
        for (; bytes.size() >= width; bytes.remove_prefix(width)) add(word_of(bytes.data(), width));
        if (!bytes.empty()) add(word_of(bytes.data(), bytes.size()));
    }
    void add(std::uint64_t word) { sum_ = std::rotl((sum_ ^ word) * 0x9E3779B97F4A7C15U, 32); }
    std::string uuid() const {
        return fmt::format("{}{:04x}-{:012x}", uuid_of_ours, sum_ >> 48, sum_ & 0xFFFFFFFFFFFFU);
    }

private:
    /// The lowest byte comes first; bytes that are missing are zero.
    static std::uint64_t word_of(const char* bytes, std::size_t count) {
        std::uint64_t word = 0;
        for (std::size_t i = count; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes[i]);
        return word;
    }

    std::uint64_t sum_ = 0;
};

// The checksum of the whole file without the UUID, and of its length, because an incomplete last word is padded with
// zeros.
std::string expected_uuid(InputFile& file) {
    Checksum checksum;
    std::string bytes = file.beginning(header_length);
    checksum.add(std::string_view(bytes).substr(0, uuid_begin));
    for (std::uint64_t begin = header_length; begin < file.size(); begin += chunk) {
        bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(chunk, file.size() - begin)));
        file.read(begin, std::as_writable_bytes(std::span(bytes)));
        checksum.add(bytes);
    }
    checksum.add(file.size());
    return checksum.uuid();
}

}  // namespace

void seal_vdb(const std::string& path) {
    InputFile written(path);
    const std::string uuid = expected_uuid(written);
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.exceptions(std::ios::failbit | std::ios::badbit);
    file.seekp(uuid_begin);
    file.write(uuid.data(), static_cast<std::streamsize>(uuid.size()));
    file.close();
}

bool check_vdb_seal(InputFile& file) {
    const std::string beginning = file.beginning(chunk);
    if (!beginning.starts_with(magic)) file.fail("not a VDB file: it does not begin with \" BDV\"");
    if (beginning.size() < header_length) file.fail("the file is truncated in its header");
    const std::string_view uuid = std::string_view(beginning).substr(uuid_begin, uuid_length);
    // If the first mark, the UUID, is damaged, the description is the second. OpenVDB keeps it if it saves the file
    // again, and writes a random UUID, whose version is not ours.
    constexpr std::size_t version = 14;
    const bool is_ours =
        uuid.starts_with(uuid_of_ours) ||
        (uuid[version] == uuid_of_ours[version] && beginning.find(R"("program": "clsdf )") != std::string::npos);
    if (is_ours && uuid != expected_uuid(file)) file.fail("its checksum is wrong: the file is damaged or truncated");
    return is_ours;
}

}  // namespace clsdf

#pragma GCC visibility push(default)
#include <openvdb/tools/Dense.h>
#pragma GCC visibility pop

#include <optional>

namespace clsdf {
namespace {

using namespace vdb;
using openvdb::Coord;

/// Grids as OpenVDB reads them.
class VdbReader {
public:
    VdbReader(InputFile& file, bool is_ours) : input_(file), is_ours_(is_ours), file_(file.path()) {
        file_.open(false);
    }

    openvdb::FloatGrid::Ptr distance() {
        for (auto name = file_.beginName(); name != file_.endName(); ++name)
            if (*name == info_of(Output::distance).name) return read<openvdb::FloatGrid>(*name);
        for (auto name = file_.beginName(); name != file_.endName(); ++name)
            if (file_.readGridMetadata(*name)->isType<openvdb::FloatGrid>()) return read<openvdb::FloatGrid>(*name);
        input_.fail("it has no grid of floats");
    }

    bool has(const std::string& name) const { return file_.hasGrid(name); }

    template <class GridType>
    typename GridType::Ptr read(const std::string& name) {
        auto grid = openvdb::gridPtrCast<GridType>(file_.readGrid(name));
        if (!grid) input_.fail(fmt::format("grid '{}' is of another type", name));
        return grid;
    }

    Grid lattice(const openvdb::GridBase& grid) const {
        if (!grid.transform().isLinear()) input_.fail("its grid is not linear; resample it");
        const openvdb::Mat4d matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
        Grid result;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                if (row != column && matrix(row, column) != 0)
                    input_.fail("its grid is not parallel to the axes; resample it");
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int i = static_cast<int>(axis);
            result.spacing[axis] = matrix(i, i);
            result.origin[axis] = matrix(3, i);
        }
        return result;
    }

    // The block of samples: as stated, or the box around all active voxels.
    void set_block(Grid& grid, const openvdb::FloatGrid& distance, const std::optional<Grid>& stated) const {
        const openvdb::CoordBBox active = distance.evalActiveVoxelBoundingBox();
        if (stated && (active.empty() || fits(active, *stated))) {
            grid.first = stated->first;
            grid.size = stated->size;
            return;
        }
        if (active.empty()) input_.fail("no voxel of its grid is active");
        double volume = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            grid.first[axis] = active.min()[axis];
            grid.size[axis] = std::int64_t{active.max()[axis]} - active.min()[axis] + 1;
            volume *= static_cast<double>(grid.size[axis]);
        }
        constexpr double sparsest = 1e5;
        if (!is_ours_ && volume > sparsest * static_cast<double>(distance.activeVoxelCount()))
            input_.fail(
                fmt::format("its active voxels are strewn over {} samples; crop it", fmt::join(grid.size, " x ")));
    }

    template <class GridType>
    void copy(const GridType& source, const Grid& grid, std::span<std::byte> room) const {
        using Dense = openvdb::tools::Dense<typename GridType::ValueType, openvdb::tools::LayoutXYZ>;
        const Coord first = coordinates(grid.first);
        const openvdb::CoordBBox box(first, first + coordinates(grid.size) - Coord(1));
        Dense dense(box, reinterpret_cast<typename GridType::ValueType*>(room.data()));
        openvdb::tools::copyToDense(source, dense);
    }

private:
    static bool fits(const openvdb::CoordBBox& box, const Grid& block) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (box.min()[axis] < block.first[axis] || box.max()[axis] >= block.first[axis] + block.size[axis])
                return false;
        return true;
    }

    InputFile& input_;
    bool is_ours_;
    openvdb::io::File file_;
};

/// Grid, band and sign, as the file states them.
FieldDescription describe(const InputFile& file, const VdbReader& reader, const openvdb::FloatGrid& distance) {
    const auto description = distance.getMetadata<openvdb::StringMetadata>(description_key);
    const std::string source = file.path() + ": metadata 'clsdf'";

    FieldDescription field;
    Grid block = reader.lattice(distance);
    reader.set_block(block, distance, description ? described_block(source, description->value()) : std::nullopt);
    block.validate();
    if (description) {
        field = parse_description(source, description->value(), block).field;
    } else {
        const auto background = static_cast<double>(distance.background());
        const bool has_band = distance.getGridClass() == openvdb::GRID_LEVEL_SET && background > 0;
        field.band = has_band ? Band::symmetric(background) : Band::full();
        field.sign = SignRule::automatic;
    }
    field.grid = block;
    return field;
}

Field read_dense(InputFile& file, bool is_ours, OutputSet wanted) {
    initialise();
    VdbReader reader(file, is_ours);
    const openvdb::FloatGrid::Ptr distance = reader.distance();
    Field field;
    static_cast<FieldDescription&>(field) = describe(file, reader, *distance);
    const Grid& in_file = field.grid;
    const std::size_t samples = field.grid.sample_count();
    reader.copy(*distance, in_file, field.resize(Output::distance, samples));
    for (const OutputInfo& info : extra_outputs()) {
        if (!wanted.contains(info.output) || !reader.has(info.name)) continue;
        if (!fits_grid(info)) continue;
        std::vector<std::byte> wide(samples * sample_bytes_in_grid(info));
        if (is_whole(info.type))
            reader.copy(*reader.read<openvdb::Int32Grid>(info.name), in_file, wide);
        else if (info.type == ElementType::float64)
            reader.copy(*reader.read<openvdb::Vec3DGrid>(info.name), in_file, wide);
        else
            reader.copy(*reader.read<openvdb::Vec3SGrid>(info.name), in_file, wide);
        narrow(info, wide, allocate_output(info, field));
    }
    return field;
}

/// The samples of a brick in a tree, x fastest; those of tiles and of the background, too.
template <class GridType>
void copy_brick(const GridType& grid, const Index3& brick, std::span<std::byte> room) {
    using Value = typename GridType::ValueType;
    const Coord first = coordinates(brick);
    const auto* const leaf = grid.tree().probeConstLeaf(first);
    const Value tile = leaf == nullptr ? grid.tree().getValue(first) : Value{};
    for (std::size_t n = 0; n < brick_samples; ++n) {
        const auto place = static_cast<openvdb::Index>(place_in_leaf(n));
        const Value value = leaf == nullptr ? tile : leaf->getValue(place);
        std::memcpy(room.data() + n * sizeof(Value), &value, sizeof(Value));
    }
}

/// Leaves and tiles in the field's bricks.
void collect(const openvdb::FloatGrid& distance, TreeBricks<bool>& bricks) {
    const auto index_of = [](const Coord& first) { return Index3{first[0], first[1], first[2]}; };
    for (auto leaf = distance.tree().cbeginLeaf(); leaf; ++leaf) bricks.add_leaf(index_of(leaf->origin()), true);
    auto tile = distance.tree().cbeginValueAll();
    tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        const openvdb::CoordBBox box = tile.getBoundingBox();
        bricks.add_tile(index_of(box.min()), std::int64_t{box.max()[0]} - box.min()[0] + 1, *tile);
    }
}

SparseField read_sparse(InputFile& file, bool is_ours, OutputSet wanted) {
    initialise();
    VdbReader reader(file, is_ours);
    const openvdb::FloatGrid::Ptr distance = reader.distance();
    SparseField field;
    static_cast<FieldDescription&>(field) = describe(file, reader, *distance);
    check_sparse(file, field);
    TreeBricks<bool> bricks(field);
    collect(*distance, bricks);
    bricks.sort_into(field);
    const auto copy = [&](const auto& grid, std::size_t width, std::span<std::byte> room) {
        for_each_index(
            field.bricks.size(),
            [&](std::size_t n) {
                copy_brick(grid, field.bricks[n], room.subspan(n * brick_samples * width, brick_samples * width));
            },
            64);
    };
    copy(*distance, sizeof(float), field.resize(Output::distance, field.bricks.size()));
    for (const OutputInfo& info : extra_outputs()) {
        if (!wanted.contains(info.output) || !reader.has(info.name) || !fits_grid(info)) continue;
        const std::size_t width = sample_bytes_in_grid(info);
        std::vector<std::byte> wide(field.bricks.size() * brick_samples * width);
        if (is_whole(info.type))
            copy(*reader.read<openvdb::Int32Grid>(info.name), width, wide);
        else if (info.type == ElementType::float64)
            copy(*reader.read<openvdb::Vec3DGrid>(info.name), width, wide);
        else
            copy(*reader.read<openvdb::Vec3SGrid>(info.name), width, wide);
        narrow(info, wide, field.resize(info.output, field.bricks.size()));
    }
    return field;
}

/// Calls read(file, is_ours), and makes OpenVDB's errors those of the file.
template <class Read>
auto with_errors_of(const std::string& path, const Read& read) {
    InputFile file(path);
    const bool is_ours = check_vdb_seal(file);
    try {
        return read(file, is_ours);
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        file.fail(fmt::format("OpenVDB: {}", error.what()));
    }
}

}  // namespace

Field read_vdb(const std::string& path, OutputSet wanted) {
    return with_errors_of(path, [&](InputFile& file, bool is_ours) { return read_dense(file, is_ours, wanted); });
}

std::optional<SparseField> read_sparse_vdb(const std::string& path, OutputSet wanted) {
    return with_errors_of(path, [&](InputFile& file, bool is_ours) { return read_sparse(file, is_ours, wanted); });
}

}  // namespace clsdf
