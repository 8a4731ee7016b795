#include "core/brick_order.hpp"
#include "core/outputs.hpp"

#include <clsdf/sparse.hpp>

#include <algorithm>

namespace clsdf {

namespace {

std::int64_t floor_to_brick(std::int64_t index) {
    return index - (index % brick_side + brick_side) % brick_side;
}

Index3 brick_of(const Index3& sample) {
    return {floor_to_brick(sample[0]), floor_to_brick(sample[1]), floor_to_brick(sample[2])};
}

}  // namespace

std::span<std::byte> SparseField::resize(Output output, std::size_t brick_count) {
    FieldArray<std::byte>& array = arrays_[detail::index_of(output)];
    array.resize(brick_count * brick_samples * info_of(output).sample_bytes());
    return array;
}

FieldSlab SparseField::values() const {
    FieldSlab slab;
    for (const OutputInfo& info : output_table()) slab.set(info.output, bytes(info.output));
    return slab;
}

SparseSlab SparseField::slab() const {
    return {in_whole_bricks(grid), bricks, values(), inside};
}

float SparseField::distance_at(const Index3& sample) const {
    const SparseSlab all = slab();
    const float distance = all.distance_at(sample, band);
    return positive_inside && !all.find(sample) ? -distance : distance;  // values are as they were set
}

std::optional<std::size_t> SparseSlab::find(const Index3& sample) const {
    const Index3 brick = brick_of(sample);
    const auto found = std::ranges::lower_bound(bricks, brick, is_before);
    if (found == bricks.end() || *found != brick) return std::nullopt;
    return static_cast<std::size_t>(found - bricks.begin());
}

float SparseSlab::distance_at(const Index3& sample, const Band& band) const {
    const Index3 brick = brick_of(sample);
    if (const std::optional<std::size_t> number = find(sample)) {
        const auto within = static_cast<std::size_t>(
            ((sample[2] - brick[2]) * brick_side + (sample[1] - brick[1])) * brick_side + (sample[0] - brick[0]));
        return values.distance()[*number * brick_samples + within];
    }
    // The last run that does not begin behind the brick.
    const auto behind = std::ranges::upper_bound(inside, brick, is_before, &BrickRun::first);
    const bool is_inside = behind != inside.begin() && std::prev(behind)->holds(brick);
    return static_cast<float>(is_inside ? band.inside_value() : band.outside);
}

Grid in_whole_bricks(const Grid& grid) {
    Grid bricks = grid;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t first = floor_to_brick(grid.first[axis]);
        const std::int64_t last = floor_to_brick(grid.first[axis] + grid.size[axis] - 1);
        bricks.first[axis] = first;
        bricks.size[axis] = last - first + brick_side;
    }
    return bricks;
}

}  // namespace clsdf
