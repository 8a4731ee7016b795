#include "io/fields/vdb_trees.hpp"

#include "core/parallel.hpp"
#include "core/refuse.hpp"

#pragma GCC visibility push(default)
#include <openvdb/tools/Prune.h>
#include <clsdf/openvdb.hpp>
#pragma GCC visibility pop

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <sstream>
#include <type_traits>
#include <utility>

namespace clsdf::vdb {
namespace {

static_assert(openvdb::FloatTree::LeafNodeType::DIM == brick_side);

/// All cores make leaves, which are added to the tree in order.
template <class GridType>
class TreeOf : public OutputTree {
public:
    using Value = typename GridType::ValueType;
    using Leaf = typename GridType::TreeType::LeafNodeType;

    TreeOf(const OutputInfo& info, const Fill& fill, const Value& background)
        : info_(info), fill_(fill), background_(background), grid_(GridType::create(background)) {}

    void add(const Grid& grid, const SparseSlab& slab) override {
        const std::span<const std::byte> values = in_grid(slab.values.bytes(info_.output));
        std::vector<Node> nodes(slab.bricks.size());
        constexpr std::size_t grain = 16;
        for_each_index(
            nodes.size(),
            [&](std::size_t n) {
                const BrickPart part(slab.bricks[n], grid);
                const float* const distance = slab.values.distance().data() + n * brick_samples;
                const std::byte* const of_brick = values.data() + n * brick_samples * sizeof(Value);
                nodes[n].kind = kind_in_tree(part, distance, of_brick);
                if (needs_leaf(nodes[n].kind, part)) nodes[n].leaf = leaf_of(slab.bricks[n], part, distance, of_brick);
            },
            grain);
        typename GridType::Accessor accessor = grid_->getAccessor();
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            if (nodes[n].leaf)
                accessor.addLeaf(nodes[n].leaf.release());  // the tree's from now on
            else if (nodes[n].kind == BrickKind::inside)
                add_tile(accessor, slab.bricks[n]);
        }
        add_inside(accessor, grid, slab.inside);
    }

    openvdb::GridBase::Ptr finish(float) override { return grid_; }

protected:
    using Accessor = typename GridType::Accessor;

    /// The form of a brick. Called by many threads.
    virtual BrickKind kind_in_tree(const BrickPart& part, const float* distance, const std::byte* values) const = 0;
    virtual void add_tile(Accessor&, const Index3&) {}
    virtual void add_inside(Accessor&, const Grid&, std::span<const BrickRun>) {}  // the background says it

    const Fill& fill() const { return fill_; }
    const Value& background() const { return background_; }
    GridType& grid() { return *grid_; }

private:
    struct Node {
        BrickKind kind = BrickKind::outside;
        std::unique_ptr<Leaf> leaf;
    };

    /// A tile would reach beyond the grid's end.
    static bool needs_leaf(BrickKind kind, const BrickPart& part) {
        return kind == BrickKind::values || (kind == BrickKind::inside && !part.is_whole());
    }

    std::unique_ptr<Leaf> leaf_of(const Index3& brick, const BrickPart& part, const float* distance,
                                  const std::byte* values) const {
        auto leaf = std::make_unique<Leaf>(openvdb::PartialCreate(), coordinates(brick));
        leaf->allocate();
        Value* const room = leaf->buffer().data();
        if (!part.is_whole()) std::fill_n(room, brick_samples, background_);
        std::array<float, brick_samples> ordered;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are set
        order_as_leaf(distance, ordered.data());
        const LeafMasks::Mask active = leaf_masks(ordered.data(), fill_, part).active;
        bool is_filled = false;
        if constexpr (std::is_same_v<Value, float>) {  // these are the distances
            is_filled = part.is_whole();
            if (is_filled) std::ranges::copy(ordered, room);
        }
        if (!is_filled)
            part.all_rows([&](std::size_t sample, std::size_t count) {
                const std::size_t x = sample % 8, place = sample / 8 % 8 * 8 + sample / 64;
                for (std::size_t i = x; i < x + count; ++i, ++sample)
                    std::memcpy(&room[i * 64 + place], values + sample * sizeof(Value), sizeof(Value));
                return true;
            });
        typename Leaf::NodeMaskType mask;
        for (openvdb::Index i = 0; i < active.size(); ++i) mask.template getWord<openvdb::Index64>(i) = active[i];
        leaf->setValueMask(mask);
        return leaf;
    }

    /// The values as the grid has them.
    std::span<const std::byte> in_grid(std::span<const std::byte> values) {
        if (sizeof(Value) == info_.sample_bytes()) return values;
        wide_.resize(values.size() / info_.sample_bytes() * sizeof(Value));
        widen(info_, values, wide_);
        return wide_;
    }

    OutputInfo info_;
    Fill fill_;
    Value background_;
    typename GridType::Ptr grid_;
    std::vector<std::byte> wide_;
};

/// The samples of the band are active. Tiles fill the inside beyond the band; the outside is the background.
class DistanceTree final : public TreeOf<openvdb::FloatGrid> {
public:
    DistanceTree(const OutputInfo& info, const Fill& fill) : TreeOf(info, fill, fill.outside) {}

    openvdb::GridBase::Ptr finish(float background) override {
        if (!std::isfinite(fill().outside)) grid().tree().root().setBackground(background, true);
        // Tiles with equal values are merged, and 0.0 equals -0.0.
        if (fill().outside != 0 && fill().inside != 0) openvdb::tools::pruneTiles(grid().tree());
        return TreeOf::finish(background);
    }

private:
    BrickKind kind_in_tree(const BrickPart& part, const float* distance, const std::byte*) const override {
        return kind_of(part, distance, fill());
    }

    void add_tile(Accessor& accessor, const Index3& brick) override {
        accessor.addTile(1, coordinates(brick), fill().inside, false);
    }

    void add_inside(Accessor& accessor, const Grid& grid, std::span<const BrickRun> runs) override {
        for (const BrickRun& run : runs)
            for (std::int64_t n = 0; n < run.count; ++n) {
                const Index3 brick{run.first[0] + n * brick_side, run.first[1], run.first[2]};
                const BrickPart part(brick, grid);
                if (part.is_whole()) {
                    add_tile(accessor, brick);
                    continue;
                }
                auto leaf = std::make_unique<Leaf>(coordinates(brick), background(), false);
                part.all_rows([&](std::size_t sample, std::size_t count) {
                    const std::size_t x = sample % 8, place = sample / 8 % 8 * 8 + sample / 64;
                    for (std::size_t i = x; i < x + count; ++i) leaf->buffer().data()[i * 64 + place] = fill().inside;
                    return true;
                });
                accessor.addLeaf(leaf.release());
            }
    }
};

/// The tree of another output, whose background means "beyond the band".
template <class GridType>
class ExtraTree final : public TreeOf<GridType> {
public:
    using TreeOf<GridType>::TreeOf;
    using typename TreeOf<GridType>::Value;

private:
    BrickKind kind_in_tree(const BrickPart& part, const float* distance, const std::byte* values) const override {
        const bool is_background = part.all_rows([&](std::size_t sample, std::size_t count) {
            bool is_same = true;
            for (const std::size_t end = sample + count; sample < end; ++sample)
                is_same = is_same && this->fill().is_beyond(distance[sample]) &&
                          std::memcmp(values + sample * sizeof(Value), &this->background(), sizeof(Value)) == 0;
            return is_same;
        });
        return is_background ? BrickKind::outside : BrickKind::values;
    }
};

std::unique_ptr<OutputTree> tree_for(const OutputInfo& info, const Fill& fill, const std::string& path) {
    if (info.output == Output::distance) return std::make_unique<DistanceTree>(info, fill);
    if (!fits_grid(info)) refuse_unsupported("{}: .vdb cannot store the output {}", path, info.name);
    // Beyond the band every bit is set.
    const auto single = std::bit_cast<float>(~std::uint32_t{0});
    const auto twice = std::bit_cast<double>(~std::uint64_t{0});
    if (is_whole(info.type)) return std::make_unique<ExtraTree<openvdb::Int32Grid>>(info, fill, -1);
    if (info.type == ElementType::float64)
        return std::make_unique<ExtraTree<openvdb::Vec3DGrid>>(info, fill, openvdb::Vec3d(twice));
    return std::make_unique<ExtraTree<openvdb::Vec3SGrid>>(info, fill, openvdb::Vec3s(single));
}

openvdb::math::Transform::Ptr transform_of(const Grid& grid, const std::string& path) {
    const openvdb::Vec3d translation(grid.origin[0], grid.origin[1], grid.origin[2]);
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
        refuse_unsupported("{}: OpenVDB has no voxels as small as {}; scale the mesh, or choose another format", path,
                           fmt::join(h, " x "));
    }
}

}  // namespace

FieldTrees::FieldTrees(const std::string& path, const FieldDescription& field, OutputSet outputs)
    : field_(field), infos_(infos_of(outputs)), background_(Fill(field.band)) {
    initialise();
    check_indices(path, field.grid, "an OpenVDB index");
    if (field.positive_inside)
        refuse_unsupported(
            "{}: OpenVDB's programs take a field to be negative inside; write it so, or choose another "
            "format",
            path);
    transform_ = transform_of(field.grid, path);
    const Fill fill(field.band);
    for (const OutputInfo& info : infos_) trees_.push_back(tree_for(info, fill, path));
}

void FieldTrees::add(const SparseSlab& slab) {
    background_.add(slab);
    for (const std::unique_ptr<OutputTree>& tree : trees_) tree->add(field_.grid, slab);
}

std::vector<openvdb::GridBase::Ptr> FieldTrees::finish() {
    std::vector<openvdb::GridBase::Ptr> grids;
    for (std::size_t i = 0; i < infos_.size(); ++i) {
        const openvdb::GridBase::Ptr& grid = grids.emplace_back(trees_[i]->finish(background_.value()));
        grid->setName(infos_[i].name);
        grid->setTransform(transform_);
        if (i == 0) grid->setGridClass(is_level_set(field_) ? openvdb::GRID_LEVEL_SET : openvdb::GRID_UNKNOWN);
    }
    return grids;
}

}  // namespace clsdf::vdb

namespace clsdf {

class LevelSetBuilder::Trees : public vdb::FieldTrees {
public:
    using FieldTrees::FieldTrees;
};

LevelSetBuilder::LevelSetBuilder(const FieldDescription& field, OutputSet outputs) {
    field.grid.validate();
    field.band.validate();
    outputs.erase(Output::distance);
    if (!outputs.empty() && outputs != Output::triangle)
        refuse_unsupported(
            "level set: of the outputs it has the distance and the triangle; ask for no others, or write a .vdb "
            "file");
    trees_ = std::make_unique<Trees>("level set", field, outputs);
}

LevelSetBuilder::LevelSetBuilder(LevelSetBuilder&&) noexcept = default;
LevelSetBuilder& LevelSetBuilder::operator=(LevelSetBuilder&&) noexcept = default;
LevelSetBuilder::~LevelSetBuilder() = default;

void LevelSetBuilder::append(const SparseSlab& slab) {
    if (!trees_) refuse("level set: nothing can be appended after finish()");
    for (const OutputInfo& info : trees_->infos())
        if (const std::size_t bytes = slab.values.bytes(info.output).size();
            bytes != slab.bricks.size() * brick_samples * info.sample_bytes())
            refuse("level set: {} has {} bytes in a part of {} bricks; compute this output, too", info.name, bytes,
                   slab.bricks.size());
    trees_->add(slab);
}

LevelSet LevelSetBuilder::finish() {
    if (!trees_) refuse("level set: finish() was called before");
    const std::vector<openvdb::GridBase::Ptr> grids = trees_->finish();
    trees_.reset();
    LevelSet result;
    result.distance = openvdb::gridPtrCast<openvdb::FloatGrid>(grids.front());
    if (grids.size() > 1) result.triangle = openvdb::gridPtrCast<openvdb::Int32Grid>(grids.back());
    return result;
}

LevelSet make_level_set(const SparseField& field) {
    OutputSet outputs = field.outputs();
    outputs.erase(Output::distance);
    LevelSetBuilder builder(field, outputs.contains(Output::triangle) ? OutputSet(Output::triangle) : OutputSet());
    builder.append(field.slab());
    return builder.finish();
}

}  // namespace clsdf
