#include "io/fields/field_files.hpp"
#include "io/fields/nvdb_layout.hpp"
#include "io/fields/sparse_files.hpp"
#include "io/fields/tree_bricks.hpp"
#include "io/meshes/raw_values.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace clsdf {
namespace {

using namespace nvdb;

template <class Value>
Value value_at(InputFile& file, std::uint64_t offset) {
    Value value;
    file.read(offset, std::as_writable_bytes(std::span(&value, 1)));
    return value;
}

std::string_view name_in(std::span<const char> room) {
    return {room.data(), static_cast<std::size_t>(std::ranges::find(room, '\0') - room.begin())};
}

/// One grid of floats in a file; it begins at byte `begin`.
struct StoredGrid {
    std::uint64_t begin = 0;
    std::uint64_t bytes = 0;
};

void check_header(InputFile& file, const FileHeader& header) {
    if (header.magic == magic_of_newer_grids)
        file.fail("a NanoVDB grid without the header of a file; write it by nanovdb::io::writeGrid");
    if (header.magic != magic && header.magic != magic_of_newer_files)
        file.fail("not a NanoVDB file: it does not begin with \"NanoVDB0\" or \"NanoVDB2\"");
    if (const std::uint32_t major = header.version >> 21; major != major_version)
        file.fail(fmt::format("version {} of NanoVDB's format; version {} is read", major, major_version));
    if (header.codec != codec_none)
        file.fail(
            "its grids are compressed; write them with the codec NONE (nanovdb_convert without --zip and --blosc)");
}

/// The grid `distance`, or the first one of floats.
StoredGrid find_grid(InputFile& file) {
    std::optional<StoredGrid> first;
    for (std::uint64_t position = 0; position < file.size();) {
        const auto header = value_at<FileHeader>(file, position);
        check_header(file, header);
        position += sizeof(FileHeader);
        std::vector<std::pair<FileMetaData, std::string>> grids;
        for (unsigned i = 0; i < header.grid_count; ++i) {
            const auto about = value_at<FileMetaData>(file, position);
            position += sizeof(FileMetaData);
            constexpr std::uint32_t longest_name = 1U << 16;
            if (about.name_bytes > longest_name)
                file.fail(fmt::format("the name of grid {} has {} bytes, which is no name", i, about.name_bytes));
            std::string name(about.name_bytes, '\0');
            file.read(position, std::as_writable_bytes(std::span(name)));
            position += about.name_bytes;
            grids.emplace_back(about, name_in(name));
        }
        for (const auto& [about, name] : grids) {
            if (about.file_bytes > file.size() - position || about.grid_bytes != about.file_bytes)
                file.fail(fmt::format("grid '{}' has {} bytes from byte {} on, but the file ends at {}", name,
                                      about.file_bytes, position, file.size()));
            if (about.type == type_float) {
                if (name == info_of(Output::distance).name) return {position, about.grid_bytes};
                if (!first) first = StoredGrid{position, about.grid_bytes};
            }
            position += about.file_bytes;
        }
        if (grids.empty()) break;
    }
    if (!first) file.fail("it has no grid of floats");
    return *first;
}

/// Reads the nodes that overlap a block of samples. Every offset is compared with the size of the grid. A node's place
/// follows from its parent's, so a damaged tree costs no more time than a whole one.
class TreeReader {
public:
    TreeReader(InputFile& file, const StoredGrid& stored) : file_(file), stored_(stored), grid_(at<GridData>(0)) {
        if (grid_.magic != magic && grid_.magic != magic_of_newer_grids)
            file.fail(fmt::format("no grid begins at byte {}: the file is damaged", stored.begin));
        if (grid_.type != type_float) file.fail("its grid is not one of floats");
        if (grid_.bytes != stored.bytes)
            file.fail(fmt::format("its grid has {} bytes, but the header states {}", grid_.bytes, stored.bytes));
        const auto tree = at<TreeData>(sizeof(GridData));
        active_count_ = tree.active_count;
        root_begin_ = sizeof(GridData) + tree.offsets[3];
        if (tree.offsets[3] > stored.bytes) fail_offset(tree.offsets[3]);
        root_ = at<RootData>(root_begin_);
        if (root_.tile_count > (stored.bytes - root_begin_) / sizeof(RootTile))
            file.fail(fmt::format("its root has {} tiles, more than the file has bytes for", root_.tile_count));
        tiles_.resize(root_.tile_count);
        read(root_begin_ + sizeof(RootData), std::as_writable_bytes(std::span(tiles_)));
        check_head();
    }

    const GridData& grid() const { return grid_; }
    const RootData& root() const { return root_; }
    std::uint64_t active_count() const { return active_count_; }

    /// The text that clsdf adds to the grid, or nothing.
    std::optional<std::string> description() {
        constexpr std::uint64_t longest = 1U << 20;
        for (std::uint32_t i = 0; i < grid_.blind_count; ++i) {
            const std::uint64_t begin = static_cast<std::uint64_t>(grid_.blind_offset) + i * sizeof(BlindMetaData);
            const auto blind = at<BlindMetaData>(begin);
            if (name_in(blind.name) != description_name) continue;
            if (blind.value_count > longest)
                file_.fail("blind data 'clsdf' are too long for the description of a field");
            std::string text(static_cast<std::size_t>(blind.value_count), '\0');
            read(begin + static_cast<std::uint64_t>(blind.data_offset), std::as_writable_bytes(std::span(text)));
            if (!remove_checksum(text))
                file_.fail("the checksum of its blind data 'clsdf' is wrong: the file is damaged");
            return text;
        }
        return std::nullopt;
    }

    /// Samples of the block, whose indices are those of the tree, x fastest.
    void copy(const Grid& block, std::span<float> room) {
        block_ = &block;
        room_ = room;
        std::ranges::fill(room, root_.background);
        for (const RootTile& tile : tiles_) {
            const Int3 origin = origin_of(tile.key);
            if (!overlaps(origin, Upper::log_side)) continue;
            if (tile.child == 0)
                fill(origin, Upper::log_side, tile.value);
            else
                copy_node<Upper>(offset(root_begin_, tile.child), origin);
        }
    }

    /// Leaves by their offsets, and tiles, in the field's bricks.
    void collect(const FieldDescription& field, TreeBricks<std::uint64_t>& bricks) {
        const Grid whole = in_whole_bricks(field.grid);
        block_ = &whole;
        for (const RootTile& tile : tiles_) {
            const Int3 origin = origin_of(tile.key);
            if (!overlaps(origin, Upper::log_side)) continue;
            if (tile.child == 0)
                bricks.add_tile(index_of(origin), std::int64_t{1} << Upper::log_side, tile.value);
            else
                collect_node<Upper>(offset(root_begin_, tile.child), origin, bricks);
        }
        block_ = nullptr;
    }

    /// The values of a leaf, x fastest.
    void read_leaf(std::uint64_t begin, std::span<float> room) {
        const auto leaf = at<Leaf>(begin);
        for (std::size_t n = 0; n < Leaf::sample_count; ++n) room[n] = leaf.values[place_in_leaf(n)];
    }

private:
    static Index3 index_of(const Int3& sample) { return {sample[0], sample[1], sample[2]}; }

    void read(std::uint64_t begin, std::span<std::byte> bytes) {
        if (begin > stored_.bytes || bytes.size() > stored_.bytes - begin) fail_offset(begin);
        file_.read(stored_.begin + begin, bytes);
    }
    template <class Value>
    Value at(std::uint64_t begin) {
        Value value;
        read(begin, std::as_writable_bytes(std::span(&value, 1)));
        return value;
    }
    [[noreturn]] void fail_offset(std::uint64_t offset) const {
        file_.fail(fmt::format("an offset in its grid, {}, leads beyond the grid's {} bytes: the file is damaged",
                               offset, stored_.bytes));
    }
    /// Wraps around if it is damaged, and is then refused.
    static std::uint64_t offset(std::uint64_t from, std::int64_t step) {
        return from + static_cast<std::uint64_t>(step);
    }

    // Nodes have a checksum of their own, whose definition differs between versions and compilers.
    void check_head() {
        const std::uint32_t stated = grid_.checksums[0];
        if (stated == no_checksum) return;
        const std::uint64_t end = grid_.version >= version_of_short_head
                                      ? sizeof(GridData) + sizeof(TreeData)
                                      : root_begin_ + sizeof(RootData) + tiles_.size() * sizeof(RootTile);
        std::vector<std::byte> head(static_cast<std::size_t>(end) - offsetof(GridData, version));
        read(offsetof(GridData, version), head);
        if (checksum_of(head) != stated) file_.fail("the checksum of its grid's head is wrong: the file is damaged");
    }

    bool overlaps(const Int3& origin, unsigned log_side) const {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (origin[axis] >= block_->first[axis] + block_->size[axis] ||
                origin[axis] + (std::int64_t{1} << log_side) <= block_->first[axis])
                return false;
        return true;
    }

    /// Calls f(row, x, y, z, count) for rows of samples that lie in the block; (x, y, z) counts from the origin.
    template <class Function>
    void for_each_row(const Int3& origin, unsigned log_side, const Function& f) {
        std::array<std::int64_t, 3> begin{}, end{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            begin[axis] = std::max<std::int64_t>(origin[axis], block_->first[axis]);
            end[axis] =
                std::min(origin[axis] + (std::int64_t{1} << log_side), block_->first[axis] + block_->size[axis]);
        }
        for (std::int64_t z = begin[2]; z < end[2]; ++z)
            for (std::int64_t y = begin[1]; y < end[1]; ++y) {
                const std::size_t sample =
                    block_->offset(begin[0] - block_->first[0], y - block_->first[1], z - block_->first[2]);
                f(room_.data() + sample, static_cast<std::size_t>(begin[0] - origin[0]),
                  static_cast<std::size_t>(y - origin[1]), static_cast<std::size_t>(z - origin[2]),
                  static_cast<std::size_t>(end[0] - begin[0]));
            }
    }

    void fill(const Int3& origin, unsigned log_side, float value) {
        for_each_row(origin, log_side, [&](float* row, std::size_t, std::size_t, std::size_t, std::size_t count) {
            std::fill_n(row, count, value);
        });
    }

    template <class Node>
    using ChildOf = std::conditional_t<std::is_same_v<Node, Upper>, Lower, Leaf>;

    /// Calls on_child(offset, origin) and on_tile(origin, value) for what overlaps the block.
    template <class Node, class OnChild, class OnTile>
    void for_each_entry(std::uint64_t begin, const Int3& origin, const OnChild& on_child, const OnTile& on_tile) {
        const auto node = std::make_unique<Node>(at<Node>(begin));
        for (std::size_t entry = 0; entry < Node::child_count; ++entry) {
            Int3 child = origin;
            for (std::size_t axis = 3, rest = entry; axis-- > 0; rest >>= Node::log)
                child[axis] += static_cast<std::int32_t>((rest & ((1U << Node::log) - 1)) << Node::log_child_side);
            if (!overlaps(child, Node::log_child_side)) continue;
            if ((node->children[entry / 64] >> entry % 64 & 1U) != 0)
                on_child(offset(begin, static_cast<std::int64_t>(node->table[entry])), child);
            else
                on_tile(child, std::bit_cast<float>(static_cast<std::uint32_t>(node->table[entry])));
        }
    }

    template <class Node>
    void copy_node(std::uint64_t begin, const Int3& origin) {
        if constexpr (std::is_same_v<Node, Leaf>) {
            const auto leaf = at<Leaf>(begin);
            for_each_row(origin, Leaf::log_side,
                         [&](float* row, std::size_t x, std::size_t y, std::size_t z, std::size_t count) {
                             for (std::size_t i = 0; i < count; ++i) row[i] = leaf.values[64 * (x + i) + 8 * y + z];
                         });
        } else {
            for_each_entry<Node>(
                begin, origin, [&](std::uint64_t child, const Int3& first) { copy_node<ChildOf<Node>>(child, first); },
                [&](const Int3& first, float value) { fill(first, Node::log_child_side, value); });
        }
    }

    template <class Node>
    void collect_node(std::uint64_t begin, const Int3& origin, TreeBricks<std::uint64_t>& bricks) {
        if constexpr (std::is_same_v<Node, Leaf>) {
            bricks.add_leaf(index_of(origin), begin);
        } else {
            for_each_entry<Node>(
                begin, origin,
                [&](std::uint64_t child, const Int3& first) { collect_node<ChildOf<Node>>(child, first, bricks); },
                [&](const Int3& first, float value) {
                    bricks.add_tile(index_of(first), std::int64_t{1} << Node::log_child_side, value);
                });
        }
    }

    InputFile& file_;
    StoredGrid stored_;
    GridData grid_;
    std::uint64_t active_count_ = 0;
    std::uint64_t root_begin_ = 0;
    RootData root_{};
    std::vector<RootTile> tiles_;
    const Grid* block_ = nullptr;
    std::span<float> room_;
};

/// The lattice of a grid's map.
Grid lattice_of(const InputFile& file, const GridData& grid) {
    Grid lattice;
    for (std::size_t entry = 0; entry < grid.map.matrix.size(); ++entry)
        if (entry % 4 != 0 && grid.map.matrix[entry] != 0)
            file.fail("its grid is not parallel to the axes; resample it");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lattice.spacing[axis] = grid.map.matrix[4 * axis];
        lattice.origin[axis] = grid.map.vector[axis];
    }
    return lattice;
}

/// The block around all active samples.
Grid active_block(const InputFile& file, const RootData& root, std::uint64_t active_count, const Grid& lattice) {
    Index3 first{}, size{};
    double volume = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t lower = root.box.lower[axis], upper = root.box.upper[axis];
        if (lower > upper) file.fail("no sample of its grid is active");
        first[axis] = lower;
        size[axis] = upper - lower + 1;
        volume *= static_cast<double>(size[axis]);
    }
    constexpr double sparsest = 1e5;
    if (volume > sparsest * static_cast<double>(active_count))
        file.fail(fmt::format("its active samples are strewn over {} samples; crop it", fmt::join(size, " x ")));
    return lattice.block(first, size);
}

/// Grid, band and sign, as the file states them.
FieldDescription describe(const std::string& path, InputFile& file, TreeReader& tree) {
    const Grid lattice = lattice_of(file, tree.grid());
    FieldDescription field;
    if (const std::optional<std::string> description = tree.description()) {
        field = parse_description(path + ": blind data 'clsdf'", *description).field;
        field.grid = lattice.block(field.grid.first, field.grid.size);
    } else {
        const auto background = static_cast<double>(tree.root().background);
        const bool has_band = tree.grid().grid_class == GridClass::level_set && background > 0;
        field.grid = active_block(file, tree.root(), tree.active_count(), lattice);
        field.band = has_band ? Band::symmetric(background) : Band::full();
        field.sign = SignRule::automatic;
    }
    field.grid.validate();
    return field;
}

}  // namespace

Field read_nvdb(const std::string& path, OutputSet) {
    check_nvdb(path, {});
    InputFile file(path);
    const StoredGrid stored = find_grid(file);
    TreeReader tree(file, stored);
    Field field;
    static_cast<FieldDescription&>(field) = describe(path, file, tree);
    field.resize(Output::distance, field.grid.sample_count());
    tree.copy(field.grid, field.distance());
    return field;
}

std::optional<SparseField> read_sparse_nvdb(const std::string& path, OutputSet) {
    check_nvdb(path, {});
    InputFile file(path);
    const StoredGrid stored = find_grid(file);
    TreeReader tree(file, stored);
    SparseField field;
    static_cast<FieldDescription&>(field) = describe(path, file, tree);
    check_sparse(file, field);
    TreeBricks<std::uint64_t> bricks(field);
    tree.collect(field, bricks);
    const auto& sorted = bricks.sort_into(field);
    field.resize(Output::distance, sorted.size());
    for (std::size_t n = 0; n < sorted.size(); ++n) {
        const std::span<float> room = field.distance().subspan(n * brick_samples, brick_samples);
        if (sorted[n].is_tile)
            std::ranges::fill(room, sorted[n].tile);
        else
            tree.read_leaf(sorted[n].leaf, room);
    }
    return field;
}

}  // namespace clsdf
