#pragma once

#include "field/vdb_grids.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace clsdf::vdb {

inline constexpr std::int64_t leaf_side = openvdb::FloatTree::LeafNodeType::DIM;

/// What samples beyond the band carry, compared bit by bit: -0.0 is not 0.0. Where the band has no end, none is beyond.
struct Fill {
    float outside;
    float inside;

    static bool is_same(float one, float other) {
        return std::isfinite(one) && std::bit_cast<std::uint32_t>(one) == std::bit_cast<std::uint32_t>(other);
    }
    bool is_outside(float value) const { return is_same(outside, value); }
    bool is_inside(float value) const { return is_same(inside, value); }
    bool is_beyond(float value) const { return is_outside(value) || is_inside(value); }
};

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

    /// `distance` and `values` are those of the layer; a sample is active where its distance is in the band.
    virtual void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte> values) = 0;
    virtual openvdb::GridBase::Ptr finish() = 0;
};

/// Throws Error(unsupported), with the file's path, for an output that .vdb has no place for.
std::unique_ptr<OutputTree> tree_for(const OutputKind& kind, const Fill& fill, const std::string& path);

}  // namespace clsdf::vdb
