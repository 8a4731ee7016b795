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

/// A layer of up to eight slices of one output, and its blocks: a leaf each, cut off at the grid's end.
struct Layer {
    Index3 grid_size{};
    std::int64_t first_slice = 0;
    std::int64_t slices = 0;

    std::size_t block_count() const {
        return static_cast<std::size_t>(leaves(grid_size[0])) * static_cast<std::size_t>(leaves(grid_size[1]));
    }
    Index3 first_of(std::size_t block) const {
        const auto number = static_cast<std::int64_t>(block);
        return {number % leaves(grid_size[0]) * leaf_side, number / leaves(grid_size[0]) * leaf_side, first_slice};
    }
    Index3 size_of(const Index3& first) const {
        return {std::min(leaf_side, grid_size[0] - first[0]), std::min(leaf_side, grid_size[1] - first[1]), slices};
    }

private:
    static std::int64_t leaves(std::int64_t samples) { return (samples + leaf_side - 1) / leaf_side; }
};

/// One output on its way into a tree.
class OutputTree {
public:
    OutputTree() = default;
    OutputTree(const OutputTree&) = delete;
    OutputTree& operator=(const OutputTree&) = delete;
    virtual ~OutputTree() = default;

    /// `distance` and `values` are those of the layer; a sample is active if its distance is in the band.
    virtual void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte> values) = 0;
    virtual openvdb::GridBase::Ptr finish() = 0;
};

constexpr Index3 whole_leaf{leaf_side, leaf_side, leaf_side};

/// The samples of a block, in rows along x.
struct Block {
    Index3 first{};
    Index3 size{};
    Index3 grid_size{};

    Block(const Layer& layer, std::size_t number)
        : first(layer.first_of(number)), size(layer.size_of(first)), grid_size(layer.grid_size) {}

    bool is_whole() const { return size == whole_leaf; }
    std::size_t first_sample() const { return sample(0, 0); }

    /// Whether a predicate holds for all rows; its arguments are j, k and the row's first sample in the layer.
    template <class Predicate>
    bool all_rows(const Predicate& predicate) const {
        for (std::int64_t k = 0; k < size[2]; ++k)
            for (std::int64_t j = 0; j < size[1]; ++j)
                if (!predicate(j, k, sample(j, k))) return false;
        return true;
    }

private:
    std::size_t sample(std::int64_t j, std::int64_t k) const {
        return static_cast<std::size_t>(first[0] + grid_size[0] * (first[1] + j + grid_size[1] * k));
    }
};

/// All cores make leaves, which are added to the tree in order.
template <class GridType>
class TreeOf : public OutputTree {
public:
    using Value = typename GridType::ValueType;
    using Leaf = typename GridType::TreeType::LeafNodeType;

    TreeOf(const Fill& fill, const Value& background)
        : fill_(fill), background_(background), grid_(GridType::create(background)) {}

    void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte> values) override {
        std::vector<Part> parts(layer.block_count());
        for_each_index(
            parts.size(),
            [&](std::size_t block) { parts[block] = part_of(Block(layer, block), distance.data(), values.data()); }, 1);
        for (std::size_t block = 0; block < parts.size(); ++block) {
            if (parts[block].leaf) {
                grid_->tree().addLeaf(parts[block].leaf.get());
                static_cast<void>(parts[block].leaf.release());  // the tree's from now on
            } else if (parts[block].tile)
                grid_->tree().addTile(1, coordinates(layer.first_of(block)), *parts[block].tile, false);
        }
    }

    openvdb::GridBase::Ptr finish() override { return grid_; }

protected:
    /// A leaf, a tile, or nothing if the tree's background suffices.
    struct Part {
        std::unique_ptr<Leaf> leaf;
        std::optional<Value> tile;
    };

    /// Both arrays are those of the block's layer. Called by many threads.
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

    void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte> values) override {
        if (!std::isfinite(fill().outside)) farthest_ = std::max(farthest_, farthest_of(distance));
        TreeOf::add(layer, distance, values);
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
        const float one = distance[block.first_sample()];
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

class VdbWriter : public FormatWriter {
public:
    VdbWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : path_(path),
          field_(field),
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
            add_layer({size, layer_begin, layer_end - layer_begin}, parts);
            for (std::vector<std::byte>& values : pending_) values.clear();
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
    void add_layer(const Layer& layer, std::span<const std::span<const std::byte>> values) {
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
            trees_[i]->add(layer, distance, in_grid);
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
    std::vector<OutputInfo> infos_;
    openvdb::math::Transform::Ptr transform_;
    std::vector<std::unique_ptr<OutputTree>> trees_;
    std::vector<std::vector<std::byte>> pending_;  // slices of the layer that is not yet whole
    AtomicFile file_;
};

}  // namespace

std::unique_ptr<FormatWriter> vdb_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    initialise();
    for (const std::int64_t size : field.grid.size)
        if (size > std::numeric_limits<std::int32_t>::max() - leaf_side)
            throw Error(ErrorCode::unsupported,
                        fmt::format("{}: OpenVDB counts the samples of an axis in 32 bits, and {} are too many; choose "
                                    ".nrrd, .npy or .h5",
                                    path, size));
    return std::make_unique<VdbWriter>(path, field, outputs);
}

void check_vdb(const std::string&, OutputSet) {}

}  // namespace clsdf
