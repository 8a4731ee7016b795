#include "targets/sparse_targets.hpp"

#include "core/brick_order.hpp"
#include "core/refuse.hpp"
#include "targets/output_targets.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace clsdf::targets {

FieldTarget::FieldTarget(const HostArrays& wanted, SparseField& field, std::size_t expected)
    : wanted_(wanted), field_(field), capacity_(expected) {
    resize(capacity_);
    resize(0);
}

HostArrays FieldTarget::room(std::size_t bricks) {
    const std::size_t before = field_.bricks.size(), count = before + bricks;
    if (count > capacity_) resize(capacity_ = std::max(count, 2 * capacity_));
    resize(count);
    HostArrays arrays = wanted_;
    for (const OutputInfo& row : output_table())
        if (arrays[row.output].is_wanted)
            arrays[row.output].data = field_.bytes(row.output).data() + before * brick_samples * row.sample_bytes();
    return arrays;
}

void FieldTarget::take(const SparseSlab& slab) {
    field_.bricks.insert(field_.bricks.end(), slab.bricks.begin(), slab.bricks.end());
    field_.inside.insert(field_.inside.end(), slab.inside.begin(), slab.inside.end());
}

void FieldTarget::resize(std::size_t bricks) {
    for (const OutputInfo& row : output_table())
        if (wanted_[row.output].is_wanted) field_.resize(row.output, bricks);
}

SparseArrays::SparseArrays(const SparseTargets& given) : bricks(given.bricks), inside(given.inside) {
    if (bricks.empty()) return;  // no value is written
    const HostTargets checked(given.values, row_of(bricks.size() * brick_samples),
                              "the array of bricks has room for bricks of {} samples");
    for_each_output(
        [](const OutputInfo& row, const HostArray& array) {
            if (may_be_double(row) && array.in_double)
                refuse_unsupported(
                    "the array of the output {} has doubles, and a sparse field has floats; give "
                    "it an array of floats",
                    row.name);
        },
        checked.arrays);
    if (!checked.are_packed)
        refuse_unsupported(
            "an array for the values of a sparse field has strides; give it packed arrays, of 512 samples for "
            "each brick");
    std::vector<WrittenArray> written;
    checked.add_written(0, written);
    const auto add = [&](const char* name, const auto& array) {
        written.push_back(
            {.first = reinterpret_cast<std::uintptr_t>(array.data()), .width = array.size_bytes(), .name = name});
    };
    add("the array of bricks", bricks);
    add("the array of runs", inside);
    refuse_overlap(written);
    values = checked.arrays;
}

void SparseArrays::check_room(const SparseCounts& counts) const {
    if (counts.bricks <= bricks.size() && counts.runs <= inside.size()) return;
    refuse(
        "the sparse field has {} bricks with values and {} runs of bricks inside, and the arrays "
        "have room for {} and {}; give them room for as many as the field has",
        counts.bricks, counts.runs, bricks.size(), inside.size());
}

void ArraysTarget::take(const SparseSlab& slab) {
    std::ranges::copy(slab.bricks, arrays_.bricks.begin() + static_cast<std::ptrdiff_t>(used()));
    count(slab.bricks.size(), slab);
}

void ArraysTarget::count(std::size_t bricks, const SparseSlab& slab) {
    counts_.bricks += bricks;
    for (const BrickRun& run : slab.inside) {
        if (counts_.runs < arrays_.inside.size()) arrays_.inside[counts_.runs] = run;
        ++counts_.runs;
    }
}

void add_part(const SparseSlab& part, const SparseBox& box) {
    SparseField& field = *box.field;
    const Index3 &first = box.bricks.first, &size = box.bricks.size;
    const std::int64_t end_x = first[0] + size[0];
    const std::int64_t begin_z = std::max(first[2], part.part.first[2]);
    const std::int64_t end_z = std::min(first[2] + size[2], part.part.first[2] + part.part.size[2]);
    std::vector<std::size_t> chosen;  // numbers of bricks in the part
    for (std::int64_t z = begin_z; z < end_z; z += brick_side)
        for (std::int64_t y = first[1]; y < first[1] + size[1]; y += brick_side) {
            const Index3 begin{first[0], y, z}, end{end_x, y, z};
            auto brick = std::ranges::lower_bound(part.bricks, begin, is_before);
            for (; brick != part.bricks.end() && is_before(*brick, end); ++brick)
                chosen.push_back(static_cast<std::size_t>(brick - part.bricks.begin()));
            // From the last run on that does not begin behind the row's first brick.
            auto run = std::ranges::upper_bound(part.inside, begin, is_before, &BrickRun::first);
            if (run != part.inside.begin()) --run;
            for (; run != part.inside.end() && is_before(run->first, end); ++run) {
                if (run->first[1] != y || run->first[2] != z) continue;
                const std::int64_t from = std::max(run->first[0], first[0]);
                const std::int64_t to = std::min(run->first[0] + run->count * brick_side, end_x);
                if (from < to) field.inside.push_back({{from, y, z}, (to - from) / brick_side});
            }
        }
    const std::size_t before = field.bricks.size();
    for (const std::size_t n : chosen) field.bricks.push_back(part.bricks[n]);
    for (const OutputInfo& row : output_table()) {
        const std::span<const std::byte> from = part.values.bytes(row.output);
        if (from.empty()) continue;
        const std::size_t bytes = brick_samples * row.sample_bytes();
        std::byte* const to = field.resize(row.output, before + chosen.size()).data() + before * bytes;
        for (std::size_t n = 0; n < chosen.size(); ++n)
            std::memcpy(to + n * bytes, from.data() + chosen[n] * bytes, bytes);
    }
}

}  // namespace clsdf::targets
