#pragma once

#include "benchmarks/workload.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace clsdf::bench {

/// Every stride-th brick of the list on all threads. make_query() makes a thread's own query for a run of bricks;
/// query(position, offset) is called for one sample after the other, neighbours mostly following each other.
template <typename MakeQuery>
void for_each_listed(const Workload& workload, std::size_t stride, const MakeQuery& make_query) {
    const SampleList& list = workload.list;
    const Grid& grid = workload.grid;
    const auto nx = static_cast<std::size_t>(grid.size[0]), ny = static_cast<std::size_t>(grid.size[1]);
    const std::size_t bricks = (list.bricks() + stride - 1) / stride;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bricks, 8), [&](const auto& range) {
        auto query = make_query();
        for (std::size_t n = range.begin(); n != range.end(); ++n)
            for (std::size_t m = list.starts[n * stride]; m < list.starts[n * stride + 1]; ++m) {
                const std::size_t offset = list.samples[m];
                query(grid.position(static_cast<std::int64_t>(offset % nx), static_cast<std::int64_t>(offset / nx % ny),
                                    static_cast<std::int64_t>(offset / (nx * ny))),
                      offset);
            }
    });
}

}  // namespace clsdf::bench
