#include "field/vdb_trees.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <openvdb/tools/Prune.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace clsdf::vdb {
namespace {

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

    /// Whether it holds for all rows: calls with j, k and the row's first sample in the layer.
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

/// Leaves are made on all cores, and hung into the tree in their order.
template <class GridType>
class TreeOf : public OutputTree {
public:
    using Value = typename GridType::ValueType;
    using Leaf = typename GridType::TreeType::LeafNodeType;

    TreeOf(const Fill& fill, const Value& background)
        : fill_(fill), background_(background), grid_(GridType::create(background)) {}

    void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte> values) override {
        std::vector<Part> parts(layer.block_count());
        tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t block) {
            parts[block] = part_of(Block(layer, block), distance.data(), values.data());
        });
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
    /// A leaf, a tile, or what the tree has without either.
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

/// The samples of the band are active; what lies inside beyond it is filled by tiles, and outside is the background.
class DistanceTree : public TreeOf<openvdb::FloatGrid> {
public:
    explicit DistanceTree(const Fill& fill) : TreeOf(fill, fill.outside) {}

    void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte> values) override {
        if (!std::isfinite(fill().outside)) farthest_ = std::max(farthest_, farthest_of(distance));
        TreeOf::add(layer, distance, values);
    }

    openvdb::GridBase::Ptr finish() override {
        // Programs do arithmetic with the background: a field without end has its largest distance there.
        if (!std::isfinite(fill().outside)) grid().tree().root().setBackground(farthest_, true);
        // Tiles are merged where values compare equal, as 0.0 and -0.0 do.
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

/// Another output, with a background that means "beyond the band".
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

}  // namespace

std::unique_ptr<OutputTree> tree_for(const OutputKind& kind, const Fill& fill, const std::string& path) {
    constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
    if (std::string_view(kind.name) == distance_kind().name) return std::make_unique<DistanceTree>(fill);
    if (is_index(kind)) return std::make_unique<ExtraTree<openvdb::Int32Grid>>(fill, -1);  // no_triangle
    if (is_vector(kind)) return std::make_unique<ExtraTree<openvdb::Vec3SGrid>>(fill, openvdb::Vec3s(nothing));
    throw Error(ErrorCode::unsupported, fmt::format("{}: .vdb has no place for the output {}", path, kind.name));
}

}  // namespace clsdf::vdb
