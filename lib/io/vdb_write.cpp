#include "core/parallel.hpp"
#include "io/field_files.hpp"
#include "io/level_set.hpp"
#include "io/vdb.hpp"

#include <clsdf/error.hpp>
#include <clsdf/version.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>
#pragma GCC visibility push(default)
#include <openvdb/tools/Prune.h>
#pragma GCC visibility pop
#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace clsdf::vdb {
namespace {

inline constexpr std::int64_t leaf_side = openvdb::FloatTree::LeafNodeType::DIM;

constexpr Index3 whole_leaf{leaf_side, leaf_side, leaf_side};

/// The samples of a leaf that lie in the grid, in rows along x.
struct Block {
    Index3 first{};          ///< of the grid's samples
    Index3 size{};           ///< cut off at the grid's end
    std::size_t begin = 0;   ///< its first sample in the array of values
    std::int64_t row = 0;    ///< samples from a row to the next one along y
    std::int64_t slice = 0;  ///< and along z

    bool is_whole() const { return size == whole_leaf; }

    /// Whether a predicate holds for all rows; its arguments are j, k and the row's first sample in the array.
    template <class Predicate>
    bool all_rows(const Predicate& predicate) const {
        for (std::int64_t k = 0; k < size[2]; ++k)
            for (std::int64_t j = 0; j < size[1]; ++j)
                if (!predicate(j, k, begin + static_cast<std::size_t>(j * row + k * slice))) return false;
        return true;
    }
};

/// The block of this first sample, without its place in an array.
Block block_at(const Index3& first, const Index3& grid_size) {
    Block block{first};
    for (std::size_t axis = 0; axis < 3; ++axis) block.size[axis] = std::min(leaf_side, grid_size[axis] - first[axis]);
    return block;
}

/// Blocks whose values are in one array.
class Blocks {
public:
    Blocks() = default;
    Blocks(const Blocks&) = delete;
    Blocks& operator=(const Blocks&) = delete;
    virtual ~Blocks() = default;

    virtual std::size_t count() const = 0;
    virtual Block operator[](std::size_t number) const = 0;
};

/// Up to eight slices of a dense field.
class LayerBlocks final : public Blocks {
public:
    LayerBlocks(const Index3& grid_size, std::int64_t first_slice, std::int64_t slices)
        : grid_size_(grid_size), first_slice_(first_slice), slices_(slices) {}

    std::size_t count() const override {
        return static_cast<std::size_t>(leaves(grid_size_[0])) * static_cast<std::size_t>(leaves(grid_size_[1]));
    }
    Block operator[](std::size_t block) const override {
        const auto number = static_cast<std::int64_t>(block);
        Block result = block_at(
            {number % leaves(grid_size_[0]) * leaf_side, number / leaves(grid_size_[0]) * leaf_side, first_slice_},
            grid_size_);
        result.size[2] = slices_;
        result.row = grid_size_[0];
        result.slice = grid_size_[0] * grid_size_[1];
        result.begin = static_cast<std::size_t>(result.first[0] + grid_size_[0] * result.first[1]);
        return result;
    }

private:
    static std::int64_t leaves(std::int64_t samples) { return (samples + leaf_side - 1) / leaf_side; }

    Index3 grid_size_;
    std::int64_t first_slice_;
    std::int64_t slices_;
};

/// Bricks of a sparse field whose grid begins with a brick on each axis.
class BrickBlocks final : public Blocks {
public:
    BrickBlocks(const Grid& grid, std::span<const Index3> bricks) : grid_(grid), bricks_(bricks) {}

    std::size_t count() const override { return bricks_.size(); }
    Block operator[](std::size_t number) const override {
        Block block = block_at(in_grid(bricks_[number]), grid_.size);
        block.row = leaf_side;
        block.slice = leaf_side * leaf_side;
        block.begin = number * brick_samples;
        return block;
    }
    Index3 in_grid(const Index3& brick) const {
        return {brick[0] - grid_.first[0], brick[1] - grid_.first[1], brick[2] - grid_.first[2]};
    }

private:
    const Grid& grid_;
    std::span<const Index3> bricks_;
};

/// One output on its way into a tree.
class OutputTree {
public:
    OutputTree() = default;
    OutputTree(const OutputTree&) = delete;
    OutputTree& operator=(const OutputTree&) = delete;
    virtual ~OutputTree() = default;

    /// `distance` and `values` are those of the blocks; a sample is active if its distance is in the band.
    virtual void add(const Blocks& blocks, std::span<const float> distance, std::span<const std::byte> values) = 0;
    /// A block that is inside, beyond the band.
    virtual void add_inside(const Block& block) = 0;
    virtual openvdb::GridBase::Ptr finish() = 0;
};

/// All cores make leaves, which are added to the tree in order.
template <class GridType>
class TreeOf : public OutputTree {
public:
    using Value = typename GridType::ValueType;
    using Leaf = typename GridType::TreeType::LeafNodeType;

    TreeOf(const Fill& fill, const Value& background)
        : fill_(fill), background_(background), grid_(GridType::create(background)) {}

    void add(const Blocks& blocks, std::span<const float> distance, std::span<const std::byte> values) override {
        std::vector<Part> parts(blocks.count());
        constexpr std::size_t grain = 16;
        for_each_index(
            parts.size(),
            [&](std::size_t block) { parts[block] = part_of(blocks[block], distance.data(), values.data()); }, grain);
        for (std::size_t block = 0; block < parts.size(); ++block) {
            if (parts[block].leaf) {
                grid_->tree().addLeaf(parts[block].leaf.get());
                static_cast<void>(parts[block].leaf.release());  // the tree's from now on
            } else if (parts[block].tile)
                add_tile(blocks[block].first, *parts[block].tile);
        }
    }

    void add_inside(const Block&) override {}  // the background says it

    openvdb::GridBase::Ptr finish() override { return grid_; }

protected:
    /// A leaf, a tile, or nothing if the tree's background suffices.
    struct Part {
        std::unique_ptr<Leaf> leaf;
        std::optional<Value> tile;
    };

    void add_tile(const Index3& first, const Value& value) {
        grid_->tree().addTile(1, coordinates(first), value, false);
    }

    /// Both arrays are those of the blocks. Called by many threads.
    virtual Part part_of(const Block& block, const float* distance, const std::byte* values) const = 0;

    Part leaf_of(const Block& block, const float* distance, const std::byte* values) const {
        auto leaf = std::make_unique<Leaf>(coordinates(block.first), background_, false);
        Value* const room = leaf->buffer().data();
        // A leaf's samples lie side by side along z, and its mask has a word for each x.
        std::array<openvdb::Index64, leaf_side> active{};
        block.all_rows([&](std::int64_t j, std::int64_t k, std::size_t sample) {
            const std::int64_t place = j * leaf_side + k;
            for (std::int64_t i = 0; i < block.size[0]; ++i, ++sample) {
                std::memcpy(&room[i * leaf_side * leaf_side + place], values + sample * sizeof(Value), sizeof(Value));
                active[static_cast<std::size_t>(i)] |= openvdb::Index64{!fill_.is_beyond(distance[sample])} << place;
            }
            return true;
        });
        typename Leaf::NodeMaskType mask;
        for (openvdb::Index i = 0; i < active.size(); ++i) mask.template getWord<openvdb::Index64>(i) = active[i];
        leaf->setValueMask(mask);
        return {std::move(leaf), std::nullopt};
    }

    const Fill& fill() const { return fill_; }
    const Value& background() const { return background_; }
    GridType& grid() { return *grid_; }

private:
    Fill fill_;
    Value background_;
    typename GridType::Ptr grid_;
};

/// The samples of the band are active. Tiles fill the inside beyond the band; the outside is the background.
class DistanceTree : public TreeOf<openvdb::FloatGrid> {
public:
    explicit DistanceTree(const Fill& fill) : TreeOf(fill, fill.outside) {}

    void add(const Blocks& blocks, std::span<const float> distance, std::span<const std::byte> values) override {
        if (!std::isfinite(fill().outside)) farthest_ = std::max(farthest_, farthest_of(distance));
        TreeOf::add(blocks, distance, values);
    }

    /// A tile would reach beyond the grid's end.
    void add_inside(const Block& block) override {
        if (block.is_whole()) {
            add_tile(block.first, fill().inside);
            return;
        }
        auto leaf = std::make_unique<Leaf>(coordinates(block.first), background(), false);
        block.all_rows([&](std::int64_t j, std::int64_t k, std::size_t) {
            for (std::int64_t i = 0; i < block.size[0]; ++i)
                leaf->buffer().data()[(i * leaf_side + j) * leaf_side + k] = fill().inside;
            return true;
        });
        grid().tree().addLeaf(leaf.release());
    }

    openvdb::GridBase::Ptr finish() override {
        // Programs compute with the background, so it must be finite: if the band has no end, it is the largest
        // distance.
        if (!std::isfinite(fill().outside)) grid().tree().root().setBackground(farthest_, true);
        // Tiles with equal values are merged, and 0.0 equals -0.0.
        if (fill().outside != 0 && fill().inside != 0) openvdb::tools::pruneTiles(grid().tree());
        return TreeOf::finish();
    }

private:
    Part part_of(const Block& block, const float* distance, const std::byte* values) const override {
        const float one = distance[block.begin];
        if (fill().is_beyond(one) && is_all(block, distance, one)) {
            if (fill().is_outside(one)) return {};
            if (block.is_whole()) return {nullptr, one};
        }
        return leaf_of(block, distance, values);
    }

    static bool is_all(const Block& block, const float* distance, float value) {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        return block.all_rows([&](std::int64_t, std::int64_t, std::size_t sample) {
            std::uint32_t difference = 0;
            for (std::int64_t i = 0; i < block.size[0]; ++i, ++sample)
                difference |= std::bit_cast<std::uint32_t>(distance[sample]) ^ bits;
            return difference == 0;
        });
    }

    static float farthest_of(std::span<const float> distance) {
        float farthest = 0;
        for (const float value : distance)
            if (std::isfinite(value)) farthest = std::max(farthest, value);
        return farthest;
    }

    float farthest_ = 0;
};

/// The tree of another output, whose background means "beyond the band".
template <class GridType>
class ExtraTree : public TreeOf<GridType> {
public:
    using TreeOf<GridType>::TreeOf;
    using typename TreeOf<GridType>::Value;

private:
    using typename TreeOf<GridType>::Part;

    Part part_of(const Block& block, const float* distance, const std::byte* values) const override {
        const bool is_background = block.all_rows([&](std::int64_t, std::int64_t, std::size_t sample) {
            bool is_same = true;
            for (std::int64_t i = 0; i < block.size[0]; ++i, ++sample)
                is_same = is_same && this->fill().is_beyond(distance[sample]) &&
                          std::memcmp(values + sample * sizeof(Value), &this->background(), sizeof(Value)) == 0;
            return is_same;
        });
        if (is_background) return {};
        return this->leaf_of(block, distance, values);
    }
};

/// Throws Error(unsupported), with the file's path, for an output that .vdb cannot store.
std::unique_ptr<OutputTree> tree_for(const OutputInfo& info, const Fill& fill, const std::string& path) {
    if (info.output == Output::distance) return std::make_unique<DistanceTree>(fill);
    if (!fits_grid(info))
        throw Error(ErrorCode::unsupported, fmt::format("{}: .vdb cannot store the output {}", path, info.name));
    // Beyond the band every bit is set.
    const auto single = std::bit_cast<float>(~std::uint32_t{0});
    const auto twice = std::bit_cast<double>(~std::uint64_t{0});
    if (is_whole(info.type)) return std::make_unique<ExtraTree<openvdb::Int32Grid>>(fill, -1);
    if (info.type == ElementType::float64)
        return std::make_unique<ExtraTree<openvdb::Vec3DGrid>>(fill, openvdb::Vec3d(twice));
    return std::make_unique<ExtraTree<openvdb::Vec3SGrid>>(fill, openvdb::Vec3s(single));
}

}  // namespace

}  // namespace clsdf::vdb

namespace clsdf {
namespace {

using namespace vdb;

openvdb::math::Transform::Ptr transform_of(const Grid& grid, const std::string& path) {
    const Vec3 origin = grid.position(0, 0, 0);
    const openvdb::Vec3d translation(origin[0], origin[1], origin[2]);
    const Vec3& h = grid.spacing;
    try {
        openvdb::math::MapBase::Ptr map;
        if (h[0] == h[1] && h[0] == h[2])
            map.reset(new openvdb::math::UniformScaleTranslateMap(h[0], translation));
        else
            map.reset(new openvdb::math::ScaleTranslateMap(openvdb::Vec3d(h[0], h[1], h[2]), translation));
        // A transform that is made from a map rounds the spacing to the last place of the origin; one that is read from
        // a file does not.
        std::stringstream stream;
        openvdb::io::setCurrentVersion(stream);
        openvdb::writeString(stream, map->type());
        map->write(stream);
        auto transform = openvdb::math::Transform::createLinearTransform();
        transform->read(stream);
        return transform;
    } catch (const openvdb::ArithmeticError&) {
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: OpenVDB has no voxels as small as {}; scale the mesh, or choose another format",
                                path, fmt::join(h, " x ")));
    }
}

/// OpenVDB's archive, on a stream that reports a full disk.
class Archive : public openvdb::io::Archive {
public:
    void write_file(const std::string& path, const openvdb::GridCPtrVec& grids) const {
        std::ofstream stream;
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.open(path, std::ios::binary);
        openvdb::io::Archive::write(stream, grids, true);
        stream.close();
    }
};

/// A leaf has the samples of a brick if the grid begins with one. The samples of the other grids' bricks are put into
/// slices first.
class VdbWriter : public FormatWriter, public SparseFormatWriter {
public:
    VdbWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : path_(path),
          field_(field),
          outputs_(outputs),
          infos_(infos_of(outputs)),
          transform_(transform_of(field.grid, path)),
          file_(path) {
        if (field.positive_inside)
            throw Error(ErrorCode::unsupported,
                        fmt::format("{}: OpenVDB's programs take a field to be negative inside; write it so, or choose "
                                    "another format",
                                    path));
        file_.temporary();  // throws if it has none
        const Fill fill(field.band);
        for (const OutputInfo& info : infos_) trees_.push_back(tree_for(info, fill, path));
        pending_.resize(infos_.size());
    }

    // Layers of eight slices, the height of a leaf.
    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        const Index3& size = field_.grid.size;
        const auto slice = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
        const auto slices = static_cast<std::int64_t>(slab.distance().size() / slice);
        for (std::int64_t k = 0; k < slices;) {
            const std::int64_t z = first_slice + k;
            const std::int64_t layer_begin = z / leaf_side * leaf_side;
            const std::int64_t layer_end = std::min(size[2], layer_begin + leaf_side);
            const std::int64_t count = std::min(slices - k, layer_end - z);
            std::vector<std::span<const std::byte>> parts;
            for (const OutputInfo& info : infos_) {
                const std::size_t bytes = slice * info.sample_bytes();
                parts.push_back(
                    slab.bytes(info.output)
                        .subspan(static_cast<std::size_t>(k) * bytes, static_cast<std::size_t>(count) * bytes));
            }
            if (count < layer_end - layer_begin) {
                for (std::size_t i = 0; i < parts.size(); ++i) {
                    pending_[i].insert(pending_[i].end(), parts[i].begin(), parts[i].end());
                    parts[i] = pending_[i];
                }
            }
            k += count;
            if (z + count < layer_end) continue;
            add(LayerBlocks(size, layer_begin, layer_end - layer_begin), parts);
            for (std::vector<std::byte>& values : pending_) values.clear();
        }
    }

    void append(const SparseSlab& slab) override {
        const Grid& grid = field_.grid;
        if (std::ranges::any_of(grid.first, [](std::int64_t first) { return first % brick_side != 0; })) {
            append_slices(slab);
            return;
        }
        const BrickBlocks blocks(grid, slab.bricks);
        std::vector<std::span<const std::byte>> values;
        for (const OutputInfo& info : infos_) values.push_back(slab.values.bytes(info.output));
        add(blocks, values);
        for (const BrickRun& run : slab.inside) {
            Block block = block_at(blocks.in_grid(run.first), grid.size);
            for (std::int64_t n = 0; n < run.count; ++n) {
                trees_[0]->add_inside(block);
                block = block_at({block.first[0] + brick_side, block.first[1], block.first[2]}, grid.size);
            }
        }
    }

    void finish() override {
        openvdb::GridCPtrVec grids;
        for (std::size_t i = 0; i < infos_.size(); ++i) {
            const openvdb::GridBase::Ptr grid = trees_[i]->finish();
            grid->setName(infos_[i].name);
            grid->setTransform(transform_);
            grid->setCreator("clsdf " + version());
            if (i == 0) {
                grid->setGridClass(is_level_set(field_) ? openvdb::GRID_LEVEL_SET : openvdb::GRID_UNKNOWN);
                grid->insertMeta(description_key, openvdb::StringMetadata(description_text(field_)));
            }
            grids.push_back(grid);
        }
        errno = 0;  // OpenVDB does not say why a write fails
        try {
            Archive archive;
            archive.setCompression(compression());
            archive.write_file(file_.temporary(), grids);
            seal_vdb(file_.temporary());
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            const std::string reason = errno == 0 ? "" : std::generic_category().message(errno);
            // The stream's own text names no reason.
            const bool is_stream = dynamic_cast<const std::ios_base::failure*>(&error) != nullptr;
            const std::string what = is_stream && !reason.empty() ? "" : error.what();
            const char* const between = what.empty() || reason.empty() ? "" : ": ";
            throw Error(ErrorCode::output_failure,
                        fmt::format("cannot write '{}': {}{}{}", path_, what, between, reason));
        }
        file_.commit();
    }

private:
    void add(const Blocks& blocks, std::span<const std::span<const std::byte>> values) {
        const std::span distance(reinterpret_cast<const float*>(values[0].data()), values[0].size() / sizeof(float));
        std::vector<std::byte> wide;
        for (std::size_t i = 0; i < infos_.size(); ++i) {
            const std::size_t bytes = i == 0 ? sizeof(float) : sample_bytes_in_grid(infos_[i]);
            std::span<const std::byte> in_grid = values[i];
            if (bytes != infos_[i].sample_bytes()) {
                wide.resize(distance.size() * bytes);
                widen(infos_[i], values[i], wide);
                in_grid = wide;
            }
            trees_[i]->add(blocks, distance, in_grid);
        }
    }

    /// Layer by layer of bricks.
    void append_slices(const SparseSlab& slab) {
        const Grid& grid = field_.grid;
        auto brick = slab.bricks.begin();
        auto run = slab.inside.begin();
        for (std::int64_t z = slab.part.first[2]; z < slab.part.first[2] + slab.part.size[2]; z += brick_side) {
            const std::int64_t begin = std::max(z, grid.first[2]);
            const std::int64_t end = std::min(z + brick_side, grid.first[2] + grid.size[2]);
            const Grid slices = grid.part({0, 0, begin - grid.first[2]}, {grid.size[0], grid.size[1], end - begin});
            Field dense({slices, field_.band, field_.sign, {}}, outputs_ | Output::distance);
            std::ranges::fill(dense.distance(), static_cast<float>(field_.band.outside));
            for (std::size_t i = 1; i < infos_.size(); ++i)
                std::ranges::fill(dense.bytes(infos_[i].output), std::byte{0xFF});
            for (; run != slab.inside.end() && run->first[2] == z; ++run)
                for (std::int64_t n = 0; n < run->count; ++n)
                    put({run->first[0] + n * brick_side, run->first[1], z}, nullptr, dense);
            for (; brick != slab.bricks.end() && (*brick)[2] == z; ++brick) {
                const auto number = static_cast<std::size_t>(brick - slab.bricks.begin());
                const FieldSlab values = slab.values;
                put(
                    *brick,
                    [&](Output output) {
                        const std::size_t bytes = info_of(output).sample_bytes() * brick_samples;
                        return values.bytes(output).data() + number * bytes;
                    },
                    dense);
            }
            append(dense.slab(), begin - grid.first[2]);
        }
    }

    /// The samples of a brick that lie in the slices. values_of: of an output; empty: the brick is inside.
    void put(const Index3& brick, const std::function<const std::byte*(Output)>& values_of, Field& slices) const {
        const Grid& grid = slices.grid;
        const float inside = -static_cast<float>(field_.band.inside);
        for (std::size_t n = 0; n < brick_samples; ++n) {
            const auto at = static_cast<std::int64_t>(n);
            const Index3 sample{brick[0] + at % 8 - grid.first[0], brick[1] + at / 8 % 8 - grid.first[1],
                                brick[2] + at / 64 - grid.first[2]};
            bool is_in_grid = true;
            for (std::size_t axis = 0; axis < 3; ++axis)
                is_in_grid = is_in_grid && sample[axis] >= 0 && sample[axis] < grid.size[axis];
            if (!is_in_grid) continue;
            const std::size_t to = grid.offset(sample[0], sample[1], sample[2]);
            if (!values_of) {
                slices.distance()[to] = inside;
                continue;
            }
            for (const OutputInfo& info : infos_) {
                const std::size_t bytes = info.sample_bytes();
                std::memcpy(slices.bytes(info.output).data() + to * bytes, values_of(info.output) + n * bytes, bytes);
            }
        }
    }

    // OpenVDB leaves out inactive values if a leaf has at most two of them, and compares them as numbers. So this is
    // off if one of them is zero.
    std::uint32_t compression() const {
        const bool has_zero = field_.band.inside == 0 || field_.band.outside == 0;
        const std::uint32_t mask = has_zero ? 0U : std::uint32_t{openvdb::io::COMPRESS_ACTIVE_MASK};
        return mask | (Archive::hasBloscCompression() ? std::uint32_t{openvdb::io::COMPRESS_BLOSC} : 0U);
    }

    std::string path_;
    FieldDescription field_;
    OutputSet outputs_;
    std::vector<OutputInfo> infos_;
    openvdb::math::Transform::Ptr transform_;
    std::vector<std::unique_ptr<OutputTree>> trees_;
    std::vector<std::vector<std::byte>> pending_;  // slices of the layer that is not yet whole
    AtomicFile file_;
};

}  // namespace

static std::unique_ptr<VdbWriter> make_writer(const std::string& path, const FieldDescription& field,
                                              OutputSet outputs) {
    initialise();
    for (const std::int64_t size : field.grid.size)
        if (size > std::numeric_limits<std::int32_t>::max() - leaf_side)
            throw Error(ErrorCode::unsupported,
                        fmt::format("{}: OpenVDB counts the samples of an axis in 32 bits, and {} are too many; choose "
                                    ".nrrd, .npy or .h5",
                                    path, size));
    return std::make_unique<VdbWriter>(path, field, outputs);
}

std::unique_ptr<FormatWriter> vdb_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    return make_writer(path, field, outputs);
}

std::unique_ptr<SparseFormatWriter> sparse_vdb_writer(const std::string& path, const FieldDescription& field,
                                                      OutputSet outputs) {
    return make_writer(path, field, outputs);
}

void check_vdb(const std::string&, OutputSet) {}

}  // namespace clsdf
