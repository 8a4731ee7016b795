#include "segments/link_table.hpp"

#include <algorithm>
#include <array>

namespace clsdf::segments {

namespace {

/// The bits of samples `shift` behind those of word i.
std::uint64_t shifted(const std::uint64_t* row, std::size_t i, std::int32_t shift) {
    const std::uint64_t* const word = row + i;
    if (shift == 0) return word[0];
    if (shift > 0) return word[0] >> shift | word[1] << (64 - shift);
    return word[0] << -shift | word[-1] >> (64 + shift);
}

/// Bits [begin, end) of a row, as far as they are in word i.
std::uint64_t bits_between(std::int64_t begin, std::int64_t end, std::size_t i) {
    const std::int64_t from = std::max<std::int64_t>(begin - 64 * static_cast<std::int64_t>(i), 0),
                       to = std::min<std::int64_t>(end - 64 * static_cast<std::int64_t>(i), 64);
    if (from >= to) return 0;
    return (~std::uint64_t{0} << from) & (~std::uint64_t{0} >> (64 - to));
}

}  // namespace

LinkTable::LinkTable(const SampleBox& box, const BoxSides& sides, std::span<const Place> steps)
    : box_(box),
      sides_(sides),
      words_of_row_(sides.words()),
      rows_of_slice_(static_cast<std::size_t>(box.size[1] - 2 * box.margin[1])) {
    std::vector<std::pair<Place, std::size_t>> leading;  // from their sample
    for (std::size_t direction = 0; direction < steps.size(); ++direction)
        if (steps[direction] != Place{}) leading.emplace_back(steps[direction], direction);
    const std::size_t rows = rows_of_slice_ * static_cast<std::size_t>(box.size[2] - 2 * box.margin[2]);
    words_.resize(rows * words_of_row_);
    chunks_.resize(chunk_count(rows, rows_together));
    for_each_chunk(rows, rows_together, [&](std::size_t number, std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) fill(chunks_[number], row, leading);
    });
    for (Chunk& chunk : chunks_) {
        chunk.first = size_;
        size_ += chunk.count;
    }
}

void LinkTable::fill(Chunk& chunk, std::size_t row, std::span<const std::pair<Place, std::size_t>> steps) {
    const Place first{0, static_cast<std::int32_t>(row % rows_of_slice_) + box_.margin[1],
                      static_cast<std::int32_t>(row / rows_of_slice_) + box_.margin[2]};
    const std::uint64_t* const own = sides_.row(box_.row(first));
    Word* const words = words_.data() + row * words_of_row_;
    // The rows that links lead to, without those that are all outside.
    struct Led {
        const std::uint64_t* row;
        std::int32_t shift;
        std::size_t direction;
    };
    std::array<Led, 32> led{};
    std::size_t count = 0;
    for (const auto& [step, direction] : steps) {
        const std::uint64_t* const other = sides_.row(box_.row({0, first[1] + step[1], first[2] + step[2]}));
        if (std::any_of(other, other + words_of_row_, [](std::uint64_t bits) { return bits != 0; }))
            led[count++] = {other, step[0], direction};
    }
    for (std::size_t i = 0; i < words_of_row_; ++i) {
        words[i] = {0, static_cast<std::uint32_t>(chunk.entries.size())};
        const std::uint64_t outside =
            count == 0 ? 0 : ~own[i] & bits_between(box_.margin[0], box_.size[0] - box_.margin[0], i);
        if (outside == 0) continue;
        std::array<std::uint64_t, 32> links;
        std::uint64_t any = 0;
        for (std::size_t n = 0; n < count; ++n) any |= links[n] = outside & shifted(led[n].row, i, led[n].shift);
        words[i].any = any;
        for (std::uint64_t rest = any; rest != 0; rest &= rest - 1) {
            const int bit = std::countr_zero(rest);
            Entry entry{{static_cast<std::int32_t>(64 * i) + bit, first[1], first[2]},
                        0,
                        static_cast<std::uint32_t>(chunk.count)};
            for (std::size_t n = 0; n < count; ++n)
                entry.directions |= static_cast<std::uint32_t>(links[n] >> bit & 1U) << led[n].direction;
            chunk.count += count_bits(entry.directions);
            chunk.entries.push_back(entry);
        }
    }
}

}  // namespace clsdf::segments
