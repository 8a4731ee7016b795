#include "transform/scan.hpp"

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

std::size_t scan(device::Context& context, const cl::Program& program, const std::shared_ptr<device::BufferPool>& pool,
                 const cl::Buffer& values, const cl::Buffer& starts, std::size_t count, const char* what) {
    if (count >= std::numeric_limits<cl_uint>::max())
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("lists of {} are more than 2^32; compute a smaller part of the grid at a time", what));
    return device::guarded([&] {
        // A part of some hundred values: enough of them to fill a GPU, few enough for one work-item to scan their sums.
        constexpr std::size_t group = common_group;
        const std::size_t parts = std::clamp<std::size_t>(count / 256 / group, 1, 4096 / group) * group;
        const auto sums = pool->lease((parts + 1) * sizeof(cl_ulong), "sums of a scan");
        const cl::CommandQueue& queue = context.queue();
        const auto values_count = static_cast<cl_uint>(count);

        cl::Kernel sum_kernel(program, "scan_sums");
        sum_kernel.setArg(sums_count, values_count);
        sum_kernel.setArg(sums_values, values);
        sum_kernel.setArg(sums_sums, *sums);
        queue.enqueueNDRangeKernel(sum_kernel, cl::NullRange, cl::NDRange(parts), cl::NDRange(group));

        cl::Kernel offset_kernel(program, "scan_offsets");
        offset_kernel.setArg(offsets_parts, static_cast<cl_uint>(parts));
        offset_kernel.setArg(offsets_sums, *sums);
        queue.enqueueNDRangeKernel(offset_kernel, cl::NullRange, cl::NDRange(1), cl::NDRange(1));

        cl::Kernel write_kernel(program, "scan_write");
        write_kernel.setArg(write_count, values_count);
        write_kernel.setArg(write_values, values);
        write_kernel.setArg(write_sums, *sums);
        write_kernel.setArg(write_starts, starts);
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
