#include "device/context.hpp"

#include "device/kernel_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace clsdf::device {

Context::Capabilities capabilities_of(const cl::Device& device) {
    Context::Capabilities capabilities;
    capabilities.compute_units = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
    capabilities.float_width = device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>();
    capabilities.is_processor = (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_CPU) != 0;
    capabilities.largest_group = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
    capabilities.largest_allocation = device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
    // A smaller device can be tried out on a larger one.
    if (const char* limit = std::getenv("CLSDF_MAX_ALLOCATION"))
        if (const std::size_t bytes = std::strtoull(limit, nullptr, 10); bytes > 0)
            capabilities.largest_allocation = std::min(capabilities.largest_allocation, bytes);
    capabilities.memory = device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>();
    return capabilities;
}

Context::Context(cl::Context context, cl::Device device, cl::CommandQueue queue)
    : context_(std::move(context)),
      device_(std::move(device)),
      callers_queue_(std::move(queue)),
      queue_(callers_queue_) {
    guarded([&] {
        capabilities_ = capabilities_of(device_);
        if (callers_queue_.getInfo<CL_QUEUE_PROPERTIES>() & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE)
            queue_ = cl::CommandQueue(context_, device_);
    });
    if (device_.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() == 0)
        throw Error(
            ErrorCode::unsupported,
            fmt::format(
                "the device \"{}\" has no double precision (cl_khr_fp64), which exact offsets need; choose another one",
                device_.getInfo<CL_DEVICE_NAME>()));
}

cl::Program Context::program(std::string_view kernel_file, const std::string& options) {
    const std::scoped_lock lock(programs_mutex_);
    const std::string key = fmt::format("{} {}", kernel_file, options);
    if (const auto found = programs_.find(key); found != programs_.end()) return found->second;

    cl::Program program(context_, kernel_text(kernel_file));
    try {
        program.build(device_, options.c_str());
    } catch (const cl::Error& error) {
        throw Error(
            ErrorCode::device_failure,
            fmt::format("the OpenCL call {} failed for {}: {}; options \"{}\" on \"{}\"; the compiler said:\n{}",
                        error.what(), kernel_file, code_name(error.err()), options, device_.getInfo<CL_DEVICE_NAME>(),
                        program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device_)));
    }
    programs_.emplace(key, program);
    return program;
}

}  // namespace clsdf::device
