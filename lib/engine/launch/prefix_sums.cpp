#include "launch/prefix_sums.hpp"

#include "device/opencl.hpp"
#include "launch/programs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace clsdf::scan {

namespace {

/// On a processor so few values are summed by one launch, because three take longer to start. (The self-test's field
/// has sums of more values, too.)
constexpr std::size_t few_values = 512;

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

PrefixSums::PrefixSums(device::Context& context, const Programs& programs,
                       const std::shared_ptr<device::BufferPool>& pool, const cl::Buffer& values,
                       const cl::Buffer& starts, std::size_t count, const char* what)
    : what_(what),
      queue_(context.queue()),
      is_few_(programs.body != KernelBody::by_group && count <= few_values),
      parts_(is_few_ ? 0 : parts_of(count, programs.body == KernelBody::by_group)),
      one_part_(programs.body == KernelBody::by_group ? WorkItems{common_group} : WorkItems{1, 1}),
      all_parts_{parts_ * one_part_.count},
      total_(context, std::make_unique<cl_ulong>(0)) {
    if (count >= std::numeric_limits<cl_uint>::max()) throw too_many(what);
    device::guarded([&] {
        sums_ = pool->lease((parts_ + 1) * sizeof(cl_ulong), "sums of a scan");
        const auto values_count = static_cast<cl_uint>(count);
        write_kernel_ = cl::Kernel(programs.scan, is_few_ ? "scan_few" : "scan_write");
        set_arguments(write_kernel_, 0, values_count, values, *sums_, starts);
        if (is_few_) return;
        sum_kernel_ = cl::Kernel(programs.scan, "scan_sums");
        set_arguments(sum_kernel_, 0, values_count, values, *sums_);
        offset_kernel_ = cl::Kernel(programs.scan, "scan_offsets");
        set_arguments(offset_kernel_, 0, static_cast<cl_uint>(parts_), *sums_);
    });
}

void PrefixSums::enqueue() {
    device::guarded([&] {
        if (is_few_) {
            launch(queue_, write_kernel_, {1, 1});
        } else {
            launch(queue_, sum_kernel_, all_parts_);
            launch(queue_, offset_kernel_, one_part_);
            launch(queue_, write_kernel_, all_parts_);
        }
        total_.begin();
        queue_.enqueueReadBuffer(*sums_, CL_FALSE, parts_ * sizeof(cl_ulong), sizeof(cl_ulong), total_->get(), nullptr,
                                 &total_read_);
    });
}

std::size_t PrefixSums::total() {
    device::guarded([&] { device::wait_for(total_read_); });
    total_.end();
    if (**total_ > std::numeric_limits<cl_uint>::max()) throw too_many(what_);
    return static_cast<std::size_t>(**total_);
}

}  // namespace clsdf::scan
