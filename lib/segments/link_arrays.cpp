#include "segments/link_arrays.hpp"

#include "core/parallel.hpp"
#include "core/refuse.hpp"

#include <span>
#include <vector>

namespace clsdf::segments {

namespace {

constexpr std::size_t rows_together = 4096;

void set_part(const targets::ResultArray& array, const auto& item, std::size_t component, double q) {
    if (array.type() == ElementType::float64)
        array.set(item, component, q);
    else
        array.set(item, component, as_float_part(q));
}

}  // namespace

LinkArrays::LinkArrays(const LinkTargets& given, const Grid& grid, std::size_t directions,
                       targets::MappedMemory& memory)
    : field_count_(directions),
      grid_(grid),
      rows_(link_columns, given,
            [&](const OutputArray& array, const char* name, const Index3& size, std::size_t components,
                const ElementTypes& types) {
                return targets::ResultArray(array, name, size, components, types, memory);
            }) {
    using enum ElementType;
    const Index3 samples{given.inside.is_given() ? static_cast<std::int64_t>(grid.sample_count()) : 0, 1, 1};
    inside_ = {given.inside, "the array of inside", samples, 1, {uint8}, memory};
    dense_ = {given.dense, "the dense array of q", grid.size, directions, {float64, float32}, memory, true};
    std::vector<targets::WrittenArray> written;
    rows_.add_to(written);
    for (const targets::ResultArray* array : {&inside_, &dense_})
        if (array->is_given()) written.push_back(array->written());
    targets::refuse_overlap(written);
}

void LinkArrays::require_room(std::size_t links) const {
    if (!rows_.has_rows() && (inside_.is_given() || dense_.is_given())) return;
    if (links > rows_.room())
        refuse("there are {} links, and the arrays have room for {}; give them room for as many", links, rows_.room());
}

void LinkArrays::store(const Links& links, const targets::MappedMemory& memory) {
    rows_.set_mapped(memory);
    inside_.set_mapped(memory);
    dense_.set_mapped(memory);
    rows_.store(links);
    if (inside_.is_given()) store_inside(links.inside);
    if (dense_.is_given()) store_dense(links);
}

void LinkArrays::store_inside(const SampleSides& inside) const {
    for_each_index(
        inside.sample_count(), [&](std::size_t n) { inside_.set(n, 0, std::uint8_t{inside.is_inside(n)}); },
        16 * rows_together);
}

void LinkArrays::store_dense(const Links& links) const {
    const auto rows = static_cast<std::size_t>(grid_.size[1] * grid_.size[2]);
    const auto fill = [&](auto number) {
        for_each_index(
            field_count_ * rows,
            [&](std::size_t n) {
                const auto row = static_cast<std::int64_t>(n % rows);
                dense_.fill_row({0, row % grid_.size[1], row / grid_.size[1]}, grid_.size[0], n / rows, number);
            },
            64);
    };
    if (dense_.type() == ElementType::float64)
        fill(-1.0);
    else
        fill(-1.0F);
    for_each_index(
        links.size(),
        [&](std::size_t n) {
            Index3 sample{};
            for (std::size_t axis = 0; axis < 3; ++axis) sample[axis] = links.samples[n][axis] - grid_.first[axis];
            set_part(dense_, sample, links.directions[n], links.q[n]);
        },
        rows_together);
}

}  // namespace clsdf::segments
