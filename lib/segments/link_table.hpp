#pragma once

#include "core/parallel.hpp"
#include "segments/sample_sides.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::segments {

/// The number of set bits. Without an instruction for it, which not every processor has, std::popcount() is a call.
inline std::size_t count_bits(std::uint64_t bits) {
    bits -= bits >> 1 & 0x5555555555555555U;
    bits = (bits & 0x3333333333333333U) + (bits >> 2 & 0x3333333333333333U);
    bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fU;
    return static_cast<std::size_t>(bits * 0x0101010101010101U >> 56);
}

/// The links whose sample is outside and whose other end is inside, numbered by sample, then by direction: from the
/// sides alone. Finds the number of a link without a search.
class LinkTable {
public:
    /// steps: those of the directions; 0 has no links. The others must outlive this.
    LinkTable(const SampleBox& box, const BoxSides& sides, std::span<const Place> steps);

    std::size_t size() const { return size_; }
    /// The number of the link from a sample of the grid, which is in the table.
    std::size_t number(const Place& sample, std::size_t direction) const {
        const std::size_t row = grid_row(sample), bit = static_cast<std::size_t>(sample[0]) % 64;
        const Word& word = words_[row * words_of_row_ + static_cast<std::size_t>(sample[0]) / 64];
        const Chunk& chunk = chunks_[row / rows_together];
        const Entry& entry = chunk.entries[word.base + count_bits(word.any & ((std::uint64_t{1} << bit) - 1))];
        return chunk.first + entry.first + count_bits(entry.directions & ((1U << direction) - 1));
    }
    /// Calls visit(number, sample, direction) for all links, on all cores; in order within a task.
    template <typename Visit>
    void for_each(const Visit& visit) const;

private:
    static constexpr std::size_t rows_together = 16;

    /// The links of a sample that has any.
    struct Entry {
        Place sample;
        std::uint32_t directions;  ///< bits
        std::uint32_t first;       ///< the number of its first link in the chunk
    };
    struct Chunk {
        std::vector<Entry> entries;
        std::size_t first = 0;
        std::size_t count = 0;
    };
    struct Word {
        std::uint64_t any;   ///< of the samples that have entries
        std::uint32_t base;  ///< the first one's, in the chunk
    };

    /// steps: with their numbers.
    void fill(Chunk& chunk, std::size_t row, std::span<const std::pair<Place, std::size_t>> steps);
    std::size_t grid_row(const Place& sample) const {
        return static_cast<std::size_t>(sample[1] - box_.margin[1]) +
               rows_of_slice_ * static_cast<std::size_t>(sample[2] - box_.margin[2]);
    }

    const SampleBox& box_;
    const BoxSides& sides_;
    std::size_t words_of_row_, rows_of_slice_;
    UninitializedVector<Word> words_;
    std::vector<Chunk> chunks_;
    std::size_t size_ = 0;
};

template <typename Visit>
void LinkTable::for_each(const Visit& visit) const {
    for_each_index(
        chunks_.size(),
        [&](std::size_t i) {
            std::size_t number = chunks_[i].first;
            for (const Entry& entry : chunks_[i].entries)
                for (std::uint32_t rest = entry.directions; rest != 0; rest &= rest - 1)
                    visit(number++, entry.sample, static_cast<std::size_t>(std::countr_zero(rest)));
        },
        4);
}

}  // namespace clsdf::segments
