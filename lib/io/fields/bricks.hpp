#pragma once

#include "io/fields/field_files.hpp"
#include "io/fields/level_set.hpp"

#include <clsdf/sparse.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

// Formats that store bricks alone: what they know of a brick, and how a dense field becomes bricks.

namespace clsdf {

/// The samples of a brick that lie in the grid: from `begin` to `end` on each axis, counted from the brick's first one.
struct BrickPart {
    Index3 begin{};
    Index3 end{};

    BrickPart(const Index3& brick, const Grid& grid) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t first = grid.first[axis] - brick[axis];
            begin[axis] = std::clamp<std::int64_t>(first, 0, brick_side);
            end[axis] = std::clamp<std::int64_t>(first + grid.size[axis], 0, brick_side);
        }
    }

    bool is_whole() const { return begin == Index3{} && end == Index3{brick_side, brick_side, brick_side}; }

    /// Whether a predicate holds for all rows along x. Its arguments are the first of 512 samples, x fastest, and the
    /// number of samples.
    template <class Predicate>
    bool all_rows(const Predicate& predicate) const {
        for (std::int64_t z = begin[2]; z < end[2]; ++z)
            for (std::int64_t y = begin[1]; y < end[1]; ++y)
                if (!predicate(static_cast<std::size_t>((z * brick_side + y) * brick_side + begin[0]),
                               static_cast<std::size_t>(end[0] - begin[0])))
                    return false;
        return true;
    }
};

/// The form of a brick in a tree: a leaf of values, a tile that is inside, or nothing, if the background suffices.
enum class BrickKind : std::uint8_t { values, inside, outside };

/// By those of its samples that lie in the grid. So the tree is a function of the field.
inline BrickKind kind_of(const BrickPart& part, const float* distance, const Fill& fill) {
    const float first = distance[(part.begin[2] * brick_side + part.begin[1]) * brick_side + part.begin[0]];
    if (!fill.is_beyond(first)) return BrickKind::values;
    const auto bits = std::bit_cast<std::uint32_t>(first);
    const bool is_uniform = part.all_rows([&](std::size_t sample, std::size_t count) {
        std::uint32_t difference = 0;
        for (std::size_t i = 0; i < count; ++i) difference |= std::bit_cast<std::uint32_t>(distance[sample + i]) ^ bits;
        return difference == 0;
    });
    return !is_uniform ? BrickKind::values : fill.is_outside(first) ? BrickKind::outside : BrickKind::inside;
}

/// The samples of a leaf that are active, and those that are beyond the band and inside. A mask has a word for each x,
/// with bit 8 y + z.
struct LeafMasks {
    using Mask = std::array<std::uint64_t, 8>;
    Mask active{};
    Mask inside{};
};

/// The samples of a brick, x fastest, in the order of a leaf: see place_in_leaf().
inline void order_as_leaf(const float* samples, float* ordered) {
    for (std::size_t z = 0; z < 8; ++z)
        for (std::size_t y = 0; y < 8; ++y)
            for (std::size_t x = 0; x < 8; ++x) ordered[64 * x + 8 * y + z] = samples[64 * z + 8 * y + x];
}

/// ordered: the samples of a leaf. Those beyond the grid are in neither mask.
LeafMasks leaf_masks(const float* ordered, const Fill& fill, const BrickPart& part);

/// Programs compute with the background, the value outside of all leaves and tiles, so it must be finite. It is the
/// half width outside; if the band has no end there, it is the largest distance.
class Background {
public:
    explicit Background(const Fill& fill) : outside_(fill.outside) {}

    void add(const SparseSlab& slab) {
        if (std::isfinite(outside_)) return;
        for (const float value : slab.values.distance())
            if (std::isfinite(value)) farthest_ = std::max(farthest_, value);
    }
    float value() const { return std::isfinite(outside_) ? outside_ : farthest_; }

private:
    float outside_;
    float farthest_ = 0;
};

/// Throws Error(unsupported) unless all samples of the grid's bricks have indices of 32 bits. `reader` is what needs
/// it.
void check_indices(const std::string& path, const Grid& grid, const char* reader);

/// Writes a dense field by the writer of a format that stores bricks alone, layer by layer of bricks. Samples beyond
/// the grid are 0. A band without end, or of signs alone, is written, too: of the first all bricks have values, of the
/// other none.
std::unique_ptr<FormatWriter> slices_as_bricks(const FieldDescription& field, OutputSet outputs,
                                               std::unique_ptr<SparseFormatWriter> bricks);

}  // namespace clsdf
