#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace clsdf::polyhedra {

/// Calls f(i) for every i < count on all cores. f writes only what belongs to i, so results are the same for any number
/// of threads.
template <typename Function>
void for_each_index(std::size_t count, const Function& f) {
    constexpr std::size_t grain = 512;  // some ten microseconds of work
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                      [&f](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i != range.end(); ++i) f(i);
                      });
}

}  // namespace clsdf::polyhedra
