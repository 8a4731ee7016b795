#include "transform/scan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace clsdf::transform {

std::size_t scan(device::Context& context, const cl::Program& program, const std::shared_ptr<device::BufferPool>& pool,
                 const cl::Buffer& values, const cl::Buffer& starts, std::size_t count, const char* what) {
    if (count >= std::numeric_limits<cl_uint>::max())
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("lists of {} are more than 2^32; compute a smaller part of the grid at a time", what));
    return device::guarded([&] {
        // A part of some hundred values: enough of them to fill a GPU, few enough for one work-item to scan their sums.
        // In groups of one size, because PoCL compiles a kernel for each size anew.
        constexpr std::size_t group = 64;
        const std::size_t parts = std::clamp<std::size_t>(count / 256 / group, 1, 4096 / group) * group;
        const auto sums = pool->lease((parts + 1) * sizeof(cl_ulong), "sums of a scan");
        const cl::CommandQueue& queue = context.queue();
        const auto values_count = static_cast<cl_uint>(count);

        cl::Kernel sum_kernel(program, "scan_sums");
        sum_kernel.setArg(0, values_count);
        sum_kernel.setArg(1, values);
        sum_kernel.setArg(2, *sums);
        queue.enqueueNDRangeKernel(sum_kernel, cl::NullRange, cl::NDRange(parts), cl::NDRange(group));

        cl::Kernel offset_kernel(program, "scan_offsets");
        offset_kernel.setArg(0, static_cast<cl_uint>(parts));
        offset_kernel.setArg(1, *sums);
        queue.enqueueNDRangeKernel(offset_kernel, cl::NullRange, cl::NDRange(1), cl::NDRange(1));

        cl::Kernel write_kernel(program, "scan_write");
        write_kernel.setArg(0, values_count);
        write_kernel.setArg(1, values);
        write_kernel.setArg(2, *sums);
        write_kernel.setArg(3, starts);
        queue.enqueueNDRangeKernel(write_kernel, cl::NullRange, cl::NDRange(parts), cl::NDRange(group));

        cl_ulong total = 0;
        queue.enqueueReadBuffer(*sums, CL_TRUE, parts * sizeof(cl_ulong), sizeof total, &total);
        if (total > std::numeric_limits<cl_uint>::max())
            throw Error(
                ErrorCode::out_of_memory,
                fmt::format(
                    "{} {} are more than 2^32; compute a smaller part of the grid at a time, or a narrower band", total,
                    what));
        return static_cast<std::size_t>(total);
    });
}

}  // namespace clsdf::transform
