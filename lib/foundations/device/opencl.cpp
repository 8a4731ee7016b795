#include "device/opencl.hpp"

#include <clsdf/tuning.hpp>

#include "core/refuse.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <vector>

namespace clsdf::device {

namespace {

using NamedCode = std::pair<cl_int, const char*>;
#define CLSDF_NAMED(code) NamedCode(code, #code)

constexpr std::array named_codes{
    CLSDF_NAMED(CL_DEVICE_NOT_FOUND),
    CLSDF_NAMED(CL_DEVICE_NOT_AVAILABLE),
    CLSDF_NAMED(CL_COMPILER_NOT_AVAILABLE),
    CLSDF_NAMED(CL_MEM_OBJECT_ALLOCATION_FAILURE),
    CLSDF_NAMED(CL_OUT_OF_RESOURCES),
    CLSDF_NAMED(CL_OUT_OF_HOST_MEMORY),
    CLSDF_NAMED(CL_PROFILING_INFO_NOT_AVAILABLE),
    CLSDF_NAMED(CL_MEM_COPY_OVERLAP),
    CLSDF_NAMED(CL_IMAGE_FORMAT_MISMATCH),
    CLSDF_NAMED(CL_IMAGE_FORMAT_NOT_SUPPORTED),
    CLSDF_NAMED(CL_BUILD_PROGRAM_FAILURE),
    CLSDF_NAMED(CL_MAP_FAILURE),
    CLSDF_NAMED(CL_MISALIGNED_SUB_BUFFER_OFFSET),
    CLSDF_NAMED(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST),
    CLSDF_NAMED(CL_COMPILE_PROGRAM_FAILURE),
    CLSDF_NAMED(CL_LINKER_NOT_AVAILABLE),
    CLSDF_NAMED(CL_LINK_PROGRAM_FAILURE),
    CLSDF_NAMED(CL_DEVICE_PARTITION_FAILED),
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
    CLSDF_NAMED(CL_INVALID_IMAGE_FORMAT_DESCRIPTOR),
    CLSDF_NAMED(CL_INVALID_IMAGE_SIZE),
    CLSDF_NAMED(CL_INVALID_SAMPLER),
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
    CLSDF_NAMED(CL_INVALID_GL_OBJECT),
    CLSDF_NAMED(CL_INVALID_BUFFER_SIZE),
    CLSDF_NAMED(CL_INVALID_MIP_LEVEL),
    CLSDF_NAMED(CL_INVALID_GLOBAL_WORK_SIZE),
    CLSDF_NAMED(CL_INVALID_PROPERTY),
    CLSDF_NAMED(CL_INVALID_IMAGE_DESCRIPTOR),
    CLSDF_NAMED(CL_INVALID_COMPILER_OPTIONS),
    CLSDF_NAMED(CL_INVALID_LINKER_OPTIONS),
    CLSDF_NAMED(CL_INVALID_DEVICE_PARTITION_COUNT),
    // Codes of OpenCL 2, which the headers of 1.2 do not name, of the loader, and of NVIDIA's driver.
    NamedCode(-69, "CL_INVALID_PIPE_SIZE"),
    NamedCode(-70, "CL_INVALID_DEVICE_QUEUE"),
    NamedCode(-71, "CL_INVALID_SPEC_ID"),
    NamedCode(-72, "CL_MAX_SIZE_RESTRICTION_EXCEEDED"),
    NamedCode(-1001, "CL_PLATFORM_NOT_FOUND_KHR"),
    NamedCode(-9999, "OpenCL error -9999 (NVIDIA: illegal read or write to a buffer)"),
};

#undef CLSDF_NAMED

/// The binding's names of calls, and the right ones.
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> corrected_names{{
    {"clEnqueueUnMapMemObject", "clEnqueueUnmapMemObject"},
    {"clGetEventProfileInfo", "clGetEventProfilingInfo"},
    {"Retain Object", "clRetain... (of an object that OpenCL made)"},
    {"Release Object", "clRelease... (of an object that OpenCL made)"},
}};

}  // namespace

std::string code_name(cl_int code) {
    for (const auto& [number, name] : named_codes)
        if (number == code) return name;
    return fmt::format("OpenCL error {}", code);
}

std::string call_name(const cl::Error& error) {
    for (const auto& [misspelt, call] : corrected_names)
        if (misspelt == error.what()) return std::string(call);
    return error.what();
}

namespace {

/// CL_QUEUED if it cannot be found out.
cl_int status_of(const cl::Event& event) {
    cl_int status = CL_QUEUED;
    if (clGetEventInfo(event(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr) != CL_SUCCESS)
        return CL_QUEUED;
    return status;
}

}  // namespace

void wait_until_ended(const cl::Event& event) {
    const cl_int code = clWaitForEvents(1, &event());
    // Intel's runtime waits with success for a command that has failed.
    if (const cl_int status = status_of(event); status < CL_COMPLETE) throw CommandError(status);
    if (code != CL_SUCCESS) throw cl::Error(code, "clWaitForEvents");
}

void wait_for(const cl::Event& event) {
    const cl_int status = status_of(event);
    if (status < CL_COMPLETE) throw CommandError(status);
    if (status != CL_COMPLETE) wait_until_ended(event);
}

void read_blocking(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t begin, std::size_t bytes,
                   void* to, const cl::Event& before) {
    cl::Event is_read;
    const std::vector<cl::Event> wait_list(before() == nullptr ? 0 : 1, before);
    queue.enqueueReadBuffer(from, CL_TRUE, begin, bytes, to, wait_list.empty() ? nullptr : &wait_list, &is_read);
    wait_for(is_read);
}

void throw_device_error(const cl::Error& error) {
    const std::string message = fmt::format("the OpenCL call {} failed: {}", call_name(error), code_name(error.err()));
    switch (error.err()) {
        case CL_MEM_OBJECT_ALLOCATION_FAILURE:
        case CL_OUT_OF_HOST_MEMORY:
        case CL_INVALID_BUFFER_SIZE:
            throw Error(ErrorCode::out_of_memory,
                        message + "; compute a smaller part of the grid or fewer points at a time, or a narrower band",
                        error.err());
        default:
            throw Error(ErrorCode::device_failure, message, error.err());
    }
}

namespace {

constexpr KnownFault known_faults[] = {
    // LLVM 14 takes processors after Zen 3 for a Zen 3, which lacks AVX-512, while PoCL 3.0 links built-in functions
    // made for AVX-512: "Cannot emit physreg copy instruction". With vectors of eight: "Cannot select VFPROUND".
    // PoCL 3.1 names the processor itself.
    {.platform = "Portable Computing Language",
     .version = {"PoCL 3.0", "LLVM 14"},
     .device = "AMD",
     .least_float_width = 16,
     .body = KernelBody::by_vector,
     .symptom = "cannot compile vectors for AMD's processors with AVX-512 and ends the process",
     .remedy =
         "install PoCL 3.1 or later (Debian's pocl-opencl-icd; PyPI's pocl-binary-distribution ends with 3.0), or "
         "choose another device (clsdf devices lists them)"},
    // Mesa 25.0 on llvmpipe: not compiled after five minutes; slopes of polyhedra are wrong with vectors of doubles. As
    // a GPU, with a work-item a sample, it computes right fields.
    {.platform = "rusticl",
     .version = {},
     .device = "",
     .least_float_width = 0,
     .body = KernelBody::by_vector,
     .symptom = "does not compile the kernels for processors in some minutes, and makes some of them wrong",
     .remedy = "install PoCL (Debian's pocl-opencl-icd) for a processor; GPUs are used by rusticl"},
};

bool has(std::string_view text, std::string_view part) {
    return text.find(part) != std::string_view::npos;
}

}  // namespace

Implementation implementation_of(const cl::Device& device) {
    const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
    return {platform.getInfo<CL_PLATFORM_NAME>(), platform.getInfo<CL_PLATFORM_VERSION>(),
            device.getInfo<CL_DEVICE_NAME>(), device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>()};
}

std::string text_of(const Implementation& implementation) {
    return fmt::format("\"{}\" ({})", implementation.platform, implementation.version);
}

const char* name_of(KernelBody body) {
    return body == KernelBody::by_group ? "by_group" : "by_vector";
}

const KnownFault* known_fault(const Implementation& implementation, KernelBody body) {
    const auto found = std::find_if(std::begin(known_faults), std::end(known_faults), [&](const KnownFault& fault) {
        return has(implementation.platform, fault.platform) && has(implementation.version, fault.version[0]) &&
               has(implementation.version, fault.version[1]) && has(implementation.device, fault.device) &&
               implementation.float_width >= fault.least_float_width && body == fault.body;
    });
    return found == std::end(known_faults) ? nullptr : found;
}

void refuse_known_fault(const cl::Device& device, KernelBody body) {
    const Implementation implementation = guarded([&] { return implementation_of(device); });
    if (const KnownFault* fault = known_fault(implementation, body))
        refuse_unsupported("{} on \"{}\" {}, so the kernel body {} is not tried there; {}", text_of(implementation),
                           implementation.device, fault->symptom, name_of(body), fault->remedy);
}

std::string_view options_around_faults(const Implementation& implementation, std::string_view kernel_file) {
    // With optimisation, coarse bricks' lists held numbers of polyhedra that do not exist: PoCL's pass
    // implicit-loop-barriers made coarse_count wrong. Its loops were changed later (coarse_lists.cl); it has not been
    // tested without this option since.
    const bool makes_wrong_lists = has(implementation.platform, "Portable Computing Language") &&
                                   has(implementation.version, "PoCL 7.") && has(implementation.version, "LLVM 19");
    return makes_wrong_lists && kernel_file == "coarse_lists.cl" ? " -cl-opt-disable" : "";
}

}  // namespace clsdf::device
