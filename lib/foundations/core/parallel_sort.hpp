#pragma once

#include "core/parallel.hpp"

#include <tbb/parallel_sort.h>

namespace clsdf {

/// Sorts by operator<, on all cores. If the caller's tasks are cancelled, the sort goes on to its end, as
/// for_each_range(): oneTBB's own takes no context, but inherits that of the task that calls it.
template <typename Items>
void sort_on_all_cores(Items& items) {
    tbb::this_task_arena::isolate([&] {
        tbb::task_group_context own(tbb::task_group_context::isolated, loop_traits);
        tbb::task_group group(own);
        group.run_and_wait([&] { tbb::parallel_sort(items.begin(), items.end()); });
    });
}

}  // namespace clsdf
