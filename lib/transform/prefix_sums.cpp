#include "transform/prefix_sums.hpp"

#include "transform/programs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace clsdf::transform {

namespace {

enum SumsArgument : cl_uint { sums_count, sums_values, sums_sums };
enum OffsetsArgument : cl_uint { offsets_parts, offsets_sums };
enum WriteArgument : cl_uint { write_count, write_values, write_sums, write_starts };

}  // namespace

PrefixSums::PrefixSums(device::Context& context, const cl::Program& program,
                       const std::shared_ptr<device::BufferPool>& pool, const cl::Buffer& values,
                       const cl::Buffer& starts, std::size_t count, const char* what)
    : what_(what) {
    if (count >= std::numeric_limits<cl_uint>::max())
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("lists of {} are more than 2^32; compute a smaller part of the grid at a time", what));
    device::guarded([&] {
        // A part of some hundred values: enough of them to fill a GPU, few enough for one work-item to scan their sums.
        constexpr std::size_t group = common_group;
        const std::size_t parts = std::clamp<std::size_t>(count / 256 / group, 1, 4096 / group) * group;
        sums_ = pool->lease((parts + 1) * sizeof(cl_ulong), "sums of a scan");
        const cl::CommandQueue& queue = context.queue();
        const auto values_count = static_cast<cl_uint>(count);

        cl::Kernel sum_kernel(program, "scan_sums");
        sum_kernel.setArg(sums_count, values_count);
        sum_kernel.setArg(sums_values, values);
        sum_kernel.setArg(sums_sums, *sums_);
        queue.enqueueNDRangeKernel(sum_kernel, cl::NullRange, cl::NDRange(parts), cl::NDRange(group));

        cl::Kernel offset_kernel(program, "scan_offsets");
        offset_kernel.setArg(offsets_parts, static_cast<cl_uint>(parts));
        offset_kernel.setArg(offsets_sums, *sums_);
        queue.enqueueNDRangeKernel(offset_kernel, cl::NullRange, cl::NDRange(1), cl::NDRange(1));

        cl::Kernel write_kernel(program, "scan_write");
        write_kernel.setArg(write_count, values_count);
        write_kernel.setArg(write_values, values);
        write_kernel.setArg(write_sums, *sums_);
        write_kernel.setArg(write_starts, starts);
        queue.enqueueNDRangeKernel(write_kernel, cl::NullRange, cl::NDRange(parts), cl::NDRange(group));

        queue.enqueueReadBuffer(*sums_, CL_FALSE, parts * sizeof(cl_ulong), sizeof total_, &total_, nullptr,
                                &total_read_);
    });
}

PrefixSums::~PrefixSums() {
    if (total_read_() != nullptr) clWaitForEvents(1, &total_read_());
}

std::size_t PrefixSums::total() const {
    device::guarded([&] { total_read_.wait(); });
    if (total_ > std::numeric_limits<cl_uint>::max())
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("{} {} are more than 2^32; compute a smaller part of the grid at a time, or a narrower "
                                "band",
                                total_, what_));
    return static_cast<std::size_t>(total_);
}

}  // namespace clsdf::transform
