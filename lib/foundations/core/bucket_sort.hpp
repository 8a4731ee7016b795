#pragma once

#include "core/large_memory.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

/// Sorts the indices [0, count) by bucket_of(index) < buckets, on all cores; indices of one bucket keep their order.
/// Calls put(index, place) for each. Returns the first place of each bucket, and then `count`, which is less than 2^32.
template <typename BucketOf, typename Put>
UninitializedVector<std::uint32_t> bucket_sort(std::size_t count, std::size_t buckets, const BucketOf& bucket_of,
                                               const Put& put) {
    // Each chunk of the indices has its own counters: first of its indices per bucket, then of their places.
    const std::size_t chunk = chunk_for_all_cores(count, std::max(std::size_t{1} << 13, 4 * buckets));
    std::vector<std::vector<std::uint32_t>> places(chunk_count(count, chunk));
    const auto for_each = [&](const auto& visit) {
        for_each_chunk(count, chunk, [&](std::size_t number, std::size_t begin, std::size_t end) {
            std::vector<std::uint32_t>& own = places[number];
            own.resize(buckets);
            for (std::size_t i = begin; i < end; ++i) visit(i, own[bucket_of(i)]);
        });
    };
    for_each([](std::size_t, std::uint32_t& counter) { ++counter; });
    UninitializedVector<std::uint32_t> first(buckets + 1);
    first[buckets] = static_cast<std::uint32_t>(count);
    std::uint32_t place = 0;
    for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
        first[bucket] = place;
        for (std::vector<std::uint32_t>& own : places) place += std::exchange(own[bucket], place);
    }
    for_each([&](std::size_t i, std::uint32_t& next) { put(i, next++); });
    return first;
}

/// An index and a code of three digits.
struct Coded {
    std::uint32_t code;
    std::uint32_t index;
};

/// Writes the indices in the order of their codes; equal codes keep their order. What is in `coded` and in `other`,
/// which has as much room, is lost.
inline void sort_by_code(std::span<Coded> coded, std::span<Coded> other, unsigned digit_bits,
                         std::span<std::uint32_t> order) {
    const std::size_t values = std::size_t{1} << digit_bits;
    for (unsigned digit = 0; digit < 3; ++digit) {
        bucket_sort(
            coded.size(), values, [&](std::size_t i) { return coded[i].code >> digit * digit_bits & (values - 1); },
            [&](std::size_t i, std::size_t place) { other[place] = coded[i]; });
        std::swap(coded, other);
    }
    for_each_index(order.size(), [&](std::size_t i) { order[i] = coded[i].index; });
}

}  // namespace clsdf
