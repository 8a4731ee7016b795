#pragma once

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cstddef>  // also for __GLIBC__
#include <cstdint>
#include <utility>

namespace clsdf {

/// Indices that are about ten microseconds of work, if each takes 20 nanoseconds.
inline constexpr std::size_t usual_grain = 512;

/// All threads of a loop have the floating-point environment of the thread that begins it, see DefaultFloatingPoint.
inline constexpr std::uintptr_t loop_traits =
    tbb::task_group_context::default_traits | tbb::task_group_context::fp_settings;

/// Calls f(begin, end) for ranges that cover [0, count), on all cores. Ranges of `grain` indices are not divided. f
/// must write only elements of its own indices; then results are the same for any number of threads. A thread that
/// waits here takes no other task: the caller's tasks might lock a mutex that this thread holds. If the caller's tasks
/// are cancelled, the loop goes on to its end.
template <typename Function>
void for_each_range(std::size_t count, const Function& f, std::size_t grain = usual_grain) {
    if (count <= grain) {
        if (count > 0) f(std::size_t{0}, count);
        return;
    }
    tbb::this_task_arena::isolate([&] {
        tbb::task_group_context own(tbb::task_group_context::isolated, loop_traits);
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, count, grain),
            [&f](const tbb::blocked_range<std::size_t>& range) { f(range.begin(), range.end()); }, own);
    });
}

/// The same, an index at a time.
template <typename Function>
void for_each_index(std::size_t count, const Function& f, std::size_t grain = usual_grain) {
    for_each_range(
        count,
        [&f](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i != end; ++i) f(i);
        },
        grain);
}

/// The join of what f(begin, end, part) returns for ranges that cover [0, count), on all cores; `part` is `none` or the
/// result of the range before. Ranges and order do not depend on the number of threads.
template <typename Part, typename Function, typename Join>
Part reduce_ranges(std::size_t count, std::size_t grain, const Part& none, const Function& f, const Join& join) {
    return tbb::this_task_arena::isolate([&] {
        tbb::task_group_context own(tbb::task_group_context::isolated, loop_traits);
        return tbb::parallel_deterministic_reduce(
            tbb::blocked_range<std::size_t>(0, count, grain), none,
            [&f](const tbb::blocked_range<std::size_t>& range, Part part) {
                return f(range.begin(), range.end(), std::move(part));
            },
            join, own);
    });
}

inline std::size_t chunk_count(std::size_t count, std::size_t size) {
    return (count + size - 1) / size;
}

/// The size of a sub-range, a multiple of `unit`: each core gets a few sub-ranges. With one core there is one
/// sub-range.
inline std::size_t chunk_for_all_cores(std::size_t count, std::size_t unit) {
    const auto cores = std::min(static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()),
                                tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    const std::size_t units = chunk_count(count, unit);
    return unit * std::max<std::size_t>(1, cores == 1 ? units : chunk_count(units, 4 * cores));
}

/// Calls f(number, begin, end) for sub-ranges that cover [0, count), on all cores. All have the same size but the last
/// one; they do not depend on the number of cores.
template <typename Function>
void for_each_chunk(std::size_t count, std::size_t size, const Function& f) {
    for_each_range(
        chunk_count(count, size),
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t chunk = begin; chunk != end; ++chunk)
                f(chunk, chunk * size, std::min(count, (chunk + 1) * size));
        },
        1);
}

/// Calls f() while at most `count` other threads call help(), which must return soon after f() has. Some of them may
/// begin after that, or none at all.
template <typename Help, typename Function>
void with_helpers(std::size_t count, const Help& help, const Function& f) {
    tbb::this_task_arena::isolate([&] {
        tbb::task_group_context own(tbb::task_group_context::isolated, loop_traits);
        tbb::task_group group(own);
        for (std::size_t i = 0; i < count; ++i) group.run(help);
        try {
            f();
        } catch (...) {
            group.wait();
            throw;
        }
        group.wait();
    });
}

}  // namespace clsdf

/// An attribute of a function: it is compiled for several vector widths, and the program picks the one of its
/// processor. All give the same bytes, because multiply-adds are not fused. Functions that it calls must be inlined. It
/// belongs in an unnamed namespace: GCC exports others, whatever their visibility is.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && defined(__OPTIMIZE__)
#define CLSDF_SEVERAL_TARGETS __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define CLSDF_SEVERAL_TARGETS
#endif
