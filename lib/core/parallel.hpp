#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace clsdf {

/// Calls f(begin, end) for ranges that cover [0, count), on all cores. f writes only what belongs to its indices, so
/// results are the same for any number of threads.
template <typename Function>
void for_each_range(std::size_t count, const Function& f) {
    constexpr std::size_t grain = 512;  // some ten microseconds of work
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                      [&f](const tbb::blocked_range<std::size_t>& range) { f(range.begin(), range.end()); });
}

/// The same, an index at a time.
template <typename Function>
void for_each_index(std::size_t count, const Function& f) {
    for_each_range(count, [&f](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i != end; ++i) f(i);
    });
}

inline std::size_t stretch_count(std::size_t count, std::size_t size) {
    return (count + size - 1) / size;
}

/// Calls f(stretch, begin, end) for stretches of one size, but for the last, that cover [0, count), on all cores: the
/// same ones on any number of them.
template <typename Function>
void for_each_stretch(std::size_t count, std::size_t size, const Function& f) {
    tbb::parallel_for(std::size_t{0}, stretch_count(count, size),
                      [&](std::size_t stretch) { f(stretch, stretch * size, std::min(count, (stretch + 1) * size)); });
}

}  // namespace clsdf
