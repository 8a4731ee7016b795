#include "launch/prefix_sums.hpp"

#include "device/opencl.hpp"
#include "launch/programs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace clsdf::engine {

namespace {

/// A part is a work-item's on a processor: some hundred values, and few enough parts for one work-item to scan their
/// sums. On a GPU it is a work-group's.
std::size_t parts_of(std::size_t count, bool by_group) {
    constexpr std::size_t most_parts = 4096, values_of_a_group = 1024;
    if (by_group) return std::clamp<std::size_t>(count / values_of_a_group, 1, most_parts);
    return std::clamp<std::size_t>(count / 256 / common_group, 1, most_parts / common_group) * common_group;
}

}  // namespace

Error too_many(const char* what) {
    return {ErrorCode::out_of_memory,
            fmt::format("there are more than 2^32 {}; compute a smaller part of the grid at a time", what)};
}

SumLaunches::SumLaunches(const DeviceTools& tools, const cl::Buffer& values, const cl::Buffer& starts,
                         std::size_t count, const char* what)
    : by_group_(tools.programs.body == KernelBody::by_group),
      parts_(parts_of(count, by_group_)),
      all_{by_group_ ? parts_ * common_group : parts_} {
    if (count >= std::numeric_limits<cl_uint>::max()) throw too_many(what);
    device::guarded([&] {
        sums_ = tools.pool->lease((parts_ + 1) * sizeof(cl_ulong), "sums of a scan");
        const cl::Program program = tools.programs.scan;
        sum_ = tools.kernel(program, "scan_sums");
        if (!by_group_) offset_ = tools.kernel(program, "scan_offsets");
        write_ = tools.kernel(program, "scan_write");
        const auto values_count = static_cast<cl_uint>(count);
        set_arguments(sum_, 0, values_count, values, *sums_);
        if (!by_group_) set_arguments(offset_, 0, static_cast<cl_uint>(parts_), *sums_);
        set_arguments(write_, 0, values_count, values, *sums_, starts);
    });
}

PrefixSums::PrefixSums(const DeviceTools& tools, const cl::Buffer& values, const cl::Buffer& starts, std::size_t count,
                       const char* what)
    : what_(what), launches_(tools, values, starts, count, what), total_(tools.context) {
    device::guarded([&] {
        const cl::CommandQueue& queue = tools.queue();
        launches_.each([&](device::LentKernel& kernel, const WorkItems& items) { launch(queue, kernel, items); });
        total_.enqueue(launches_.sums(), launches_.parts() * sizeof(cl_ulong));
    });
}

std::size_t PrefixSums::total() {
    device::guarded([&] { total_.wait(); });
    constexpr cl_ulong step = 4096;  // kernels go beyond the end by one
    if (total_.value() > std::numeric_limits<cl_uint>::max() - step) throw too_many(what_);
    return static_cast<std::size_t>(total_.value());
}

}  // namespace clsdf::engine
