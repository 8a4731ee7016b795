#pragma once

#include "core/brick_order.hpp"
#include "io/fields/level_set.hpp"

#include <clsdf/sparse.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace clsdf {

/// The bricks of a tree that was read: its leaves, and those of tiles that are neither inside nor outside. `Leaf` is
/// where a leaf's values are.
template <class Leaf>
class TreeBricks {
public:
    struct Brick {
        Index3 first;
        Leaf leaf;
        float tile;  ///< the value of all samples if `is_tile`
        bool is_tile;
    };

    explicit TreeBricks(const FieldDescription& field) : whole_(in_whole_bricks(field.grid)), fill_(field.band) {}

    void add_leaf(const Index3& first, const Leaf& leaf) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (first[axis] < whole_.first[axis] || first[axis] >= whole_.first[axis] + whole_.size[axis]) return;
        bricks_.push_back({first, leaf, 0, false});
    }

    /// A cube of equal values.
    void add_tile(const Index3& first, std::int64_t side, float value) {
        if (fill_.is_outside(value)) return;
        Index3 begin{}, end{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            begin[axis] = std::max(first[axis], whole_.first[axis]);
            end[axis] = std::min(first[axis] + side, whole_.first[axis] + whole_.size[axis]);
            if (begin[axis] >= end[axis]) return;
        }
        for (std::int64_t z = begin[2]; z < end[2]; z += brick_side)
            for (std::int64_t y = begin[1]; y < end[1]; y += brick_side) {
                if (fill_.is_inside(value)) {
                    runs_.push_back({{begin[0], y, z}, (end[0] - begin[0]) / brick_side});
                    continue;
                }
                for (std::int64_t x = begin[0]; x < end[0]; x += brick_side)
                    bricks_.push_back({{x, y, z}, Leaf{}, value, true});
            }
    }

    /// Sets the field's bricks and runs. Returns the bricks in the same order.
    const std::vector<Brick>& sort_into(SparseField& field) {
        std::ranges::sort(bricks_, is_before, &Brick::first);
        std::ranges::sort(runs_, is_before, &BrickRun::first);
        field.bricks.clear();
        for (const Brick& brick : bricks_) field.bricks.push_back(brick.first);
        field.inside.clear();
        for (const BrickRun& run : runs_) {
            if (!field.inside.empty()) {
                BrickRun& last = field.inside.back();
                const Index3 next{last.first[0] + last.count * brick_side, last.first[1], last.first[2]};
                if (next == run.first) {
                    last.count += run.count;
                    continue;
                }
            }
            field.inside.push_back(run);
        }
        return bricks_;
    }

private:
    Grid whole_;
    Fill fill_;
    std::vector<Brick> bricks_;
    std::vector<BrickRun> runs_;
};

}  // namespace clsdf
