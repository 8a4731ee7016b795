#include "device/opencl.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>

namespace clsdf::device {

namespace {

struct NamedCode {
    cl_int code;
    const char* name;
};

#define CLSDF_NAMED(code) \
    NamedCode {           \
        code, #code       \
    }

constexpr std::array named_codes{
    CLSDF_NAMED(CL_DEVICE_NOT_FOUND),
    CLSDF_NAMED(CL_DEVICE_NOT_AVAILABLE),
    CLSDF_NAMED(CL_COMPILER_NOT_AVAILABLE),
    CLSDF_NAMED(CL_MEM_OBJECT_ALLOCATION_FAILURE),
    CLSDF_NAMED(CL_OUT_OF_RESOURCES),
    CLSDF_NAMED(CL_OUT_OF_HOST_MEMORY),
    CLSDF_NAMED(CL_MEM_COPY_OVERLAP),
    CLSDF_NAMED(CL_BUILD_PROGRAM_FAILURE),
    CLSDF_NAMED(CL_MAP_FAILURE),
    CLSDF_NAMED(CL_MISALIGNED_SUB_BUFFER_OFFSET),
    CLSDF_NAMED(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST),
    CLSDF_NAMED(CL_COMPILE_PROGRAM_FAILURE),
    CLSDF_NAMED(CL_LINKER_NOT_AVAILABLE),
    CLSDF_NAMED(CL_LINK_PROGRAM_FAILURE),
    CLSDF_NAMED(CL_KERNEL_ARG_INFO_NOT_AVAILABLE),
    CLSDF_NAMED(CL_INVALID_VALUE),
    CLSDF_NAMED(CL_INVALID_DEVICE_TYPE),
    CLSDF_NAMED(CL_INVALID_PLATFORM),
    CLSDF_NAMED(CL_INVALID_DEVICE),
    CLSDF_NAMED(CL_INVALID_CONTEXT),
    CLSDF_NAMED(CL_INVALID_QUEUE_PROPERTIES),
    CLSDF_NAMED(CL_INVALID_COMMAND_QUEUE),
    CLSDF_NAMED(CL_INVALID_HOST_PTR),
    CLSDF_NAMED(CL_INVALID_MEM_OBJECT),
    CLSDF_NAMED(CL_INVALID_BINARY),
    CLSDF_NAMED(CL_INVALID_BUILD_OPTIONS),
    CLSDF_NAMED(CL_INVALID_PROGRAM),
    CLSDF_NAMED(CL_INVALID_PROGRAM_EXECUTABLE),
    CLSDF_NAMED(CL_INVALID_KERNEL_NAME),
    CLSDF_NAMED(CL_INVALID_KERNEL_DEFINITION),
    CLSDF_NAMED(CL_INVALID_KERNEL),
    CLSDF_NAMED(CL_INVALID_ARG_INDEX),
    CLSDF_NAMED(CL_INVALID_ARG_VALUE),
    CLSDF_NAMED(CL_INVALID_ARG_SIZE),
    CLSDF_NAMED(CL_INVALID_KERNEL_ARGS),
    CLSDF_NAMED(CL_INVALID_WORK_DIMENSION),
    CLSDF_NAMED(CL_INVALID_WORK_GROUP_SIZE),
    CLSDF_NAMED(CL_INVALID_WORK_ITEM_SIZE),
    CLSDF_NAMED(CL_INVALID_GLOBAL_OFFSET),
    CLSDF_NAMED(CL_INVALID_EVENT_WAIT_LIST),
    CLSDF_NAMED(CL_INVALID_EVENT),
    CLSDF_NAMED(CL_INVALID_OPERATION),
    CLSDF_NAMED(CL_INVALID_BUFFER_SIZE),
    CLSDF_NAMED(CL_INVALID_GLOBAL_WORK_SIZE),
    CLSDF_NAMED(CL_INVALID_PROPERTY),
};

#undef CLSDF_NAMED

struct CorrectedName {
    std::string_view binding;
    std::string_view call;
};

constexpr std::array<CorrectedName, 4> corrected_names{{
    {"clEnqueueUnMapMemObject", "clEnqueueUnmapMemObject"},
    {"clGetEventProfileInfo", "clGetEventProfilingInfo"},
    {"Retain Object", "clRetain... (of an object that OpenCL made)"},
    {"Release Object", "clRelease... (of an object that OpenCL made)"},
}};

}  // namespace

std::string code_name(cl_int code) {
    for (const NamedCode& named : named_codes)
        if (named.code == code) return named.name;
    return fmt::format("OpenCL error {}", code);
}

std::string call_name(const cl::Error& error) {
    const std::string_view name = error.what();
    for (const CorrectedName& corrected : corrected_names)
        if (name == corrected.binding) return std::string(corrected.call);
    return std::string(name);
}

void throw_device_error(const cl::Error& error) {
    const std::string message = fmt::format("the OpenCL call {} failed: {}", call_name(error), code_name(error.err()));
    switch (error.err()) {
        case CL_MEM_OBJECT_ALLOCATION_FAILURE:
        case CL_OUT_OF_HOST_MEMORY:
        case CL_INVALID_BUFFER_SIZE:
            throw Error(ErrorCode::out_of_memory,
                        message + "; compute a smaller part of the grid at a time, or a narrower band", error.err());
        default:
            throw Error(ErrorCode::device_failure, message, error.err());
    }
}

}  // namespace clsdf::device
