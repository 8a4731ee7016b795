// The calls that are only counted, and may fail.
#include "disguise/failing.hpp"
#include "disguise/gpu.hpp"

#include <array>
#include <cstring>

namespace clsdf::disguise {

namespace {

std::string name_of(cl_kernel kernel) {
    std::array<char, 128> name{};
    CLSDF_NEXT(clGetKernelInfo)(kernel, CL_KERNEL_FUNCTION_NAME, name.size() - 1, name.data(), nullptr);
    return name.data();
}

std::size_t product(cl_uint dimensions, const std::size_t* sizes) {
    std::size_t items = 1;
    for (cl_uint d = 0; d < dimensions; ++d) items *= sizes[d];
    return items;
}

/// Along y or z; a driver that chooses the size of the groups may choose one work-item.
bool has_too_many_groups(cl_uint dimensions, const std::size_t* items, const std::size_t* group) {
    for (cl_uint d = 1; d < dimensions; ++d)
        if (items[d] / (group == nullptr ? 1 : group[d]) > most_groups) return true;
    return false;
}

}  // namespace

}  // namespace clsdf::disguise

using namespace clsdf::disguise;

// clNAME(parameters), which returns a code, or an object by way of an error.
#define CLSDF_PASS(name, parameters, ...)                  \
    cl_int name parameters {                               \
        const InCall in_call;                              \
        if (const cl_int code = begin(#name)) return code; \
        return CLSDF_NEXT(name)(__VA_ARGS__);              \
    }
#define CLSDF_PASS_OBJECT(type, name, parameters, ...)                     \
    type name parameters {                                                 \
        const InCall in_call;                                              \
        if (const cl_int code = begin(#name)) return refused(code, error); \
        return CLSDF_NEXT(name)(__VA_ARGS__);                              \
    }
// clNAME(queue, events in the wait list, wait list, event)
#define CLSDF_PASS_COMMAND(name)                                                                     \
    cl_int name(cl_command_queue queue, cl_uint waits, const cl_event* wait_list, cl_event* event) { \
        const InCall in_call;                                                                        \
        if (const cl_int code = begin(#name)) return code;                                           \
        if (is_failing(queue, waits, wait_list)) return fail_command(queue, false, event);           \
        return CLSDF_NEXT(name)(queue, waits, wait_list, event);                                     \
    }
// clNAME(object, what, size, value, needed)
#define CLSDF_PASS_INFO(name, object_type, info_type)                                                                  \
    CLSDF_PASS(name, (object_type object, info_type what, std::size_t size, void* value, std::size_t* needed), object, \
               what, size, value, needed)

extern "C" {

CLSDF_PASS_INFO(clGetContextInfo, cl_context, cl_context_info)
CLSDF_PASS_INFO(clGetCommandQueueInfo, cl_command_queue, cl_command_queue_info)
CLSDF_PASS_INFO(clGetMemObjectInfo, cl_mem, cl_mem_info)
CLSDF_PASS_INFO(clGetProgramInfo, cl_program, cl_program_info)
CLSDF_PASS_INFO(clGetKernelInfo, cl_kernel, cl_kernel_info)
CLSDF_PASS_INFO(clGetEventProfilingInfo, cl_event, cl_profiling_info)
CLSDF_PASS(clGetProgramBuildInfo,
           (cl_program program, cl_device_id device, cl_program_build_info what, std::size_t size, void* value,
            std::size_t* needed),
           program, device, what, size, value, needed)
CLSDF_PASS(clGetKernelWorkGroupInfo,
           (cl_kernel kernel, cl_device_id device, cl_kernel_work_group_info what, std::size_t size, void* value,
            std::size_t* needed),
           kernel, device, what, size, value, needed)

CLSDF_PASS_OBJECT(cl_context, clCreateContext,
                  (const cl_context_properties* properties, cl_uint count, const cl_device_id* devices,
                   void(CL_CALLBACK* notify)(const char*, const void*, std::size_t, void*), void* user, cl_int* error),
                  properties, count, devices, notify, user, error)
CLSDF_PASS_OBJECT(cl_command_queue, clCreateCommandQueue,
                  (cl_context context, cl_device_id device, cl_command_queue_properties properties, cl_int* error),
                  context, device, properties, error)
CLSDF_PASS_OBJECT(cl_program, clCreateProgramWithSource,
                  (cl_context context, cl_uint count, const char** texts, const std::size_t* lengths, cl_int* error),
                  context, count, texts, lengths, error)
CLSDF_PASS_OBJECT(cl_program, clCreateProgramWithBinary,
                  (cl_context context, cl_uint count, const cl_device_id* devices, const std::size_t* lengths,
                   const unsigned char** binaries, cl_int* status, cl_int* error),
                  context, count, devices, lengths, binaries, status, error)
CLSDF_PASS_OBJECT(cl_event, clCreateUserEvent, (cl_context context, cl_int* error), context, error)
CLSDF_PASS(clCreateSubDevices,
           (cl_device_id device, const cl_device_partition_property* properties, cl_uint room, cl_device_id* parts,
            cl_uint* found),
           device, properties, room, parts, found)

CLSDF_PASS(clSetUserEventStatus, (cl_event event, cl_int status), event, status)
CLSDF_PASS(clSetEventCallback,
           (cl_event event, cl_int status, void(CL_CALLBACK* notify)(cl_event, cl_int, void*), void* user), event,
           status, notify, user)
CLSDF_PASS(clFlush, (cl_command_queue queue), queue)
CLSDF_PASS_COMMAND(clEnqueueMarkerWithWaitList)
CLSDF_PASS_COMMAND(clEnqueueBarrierWithWaitList)

cl_int clBuildProgram(cl_program program, cl_uint count_of_devices, const cl_device_id* devices, const char* options,
                      void(CL_CALLBACK* notify)(cl_program, void*), void* user) {
    const InCall in_call;
    if (const cl_int code = begin("clBuildProgram")) return code;
    count([](Counts& counts) { ++counts.programs_built; });
    return CLSDF_NEXT(clBuildProgram)(program, count_of_devices, devices, options, notify, user);
}

cl_kernel clCreateKernel(cl_program program, const char* name, cl_int* error) {
    const InCall in_call;
    if (const cl_int code = begin("clCreateKernel")) return refused(code, error);
    const cl_kernel kernel = CLSDF_NEXT(clCreateKernel)(program, name, error);
    forget_arguments(kernel);
    return kernel;
}

cl_int clSetKernelArg(cl_kernel kernel, cl_uint index, std::size_t bytes, const void* value) {
    const InCall in_call;
    if (const cl_int code = begin("clSetKernelArg")) return code;
    note_argument(kernel, index, bytes, value);
    return CLSDF_NEXT(clSetKernelArg)(kernel, index, bytes, value);
}

cl_int clGetEventInfo(cl_event event, cl_event_info what, std::size_t size, void* value, std::size_t* needed) {
    const InCall in_call;
    if (const cl_int code = begin("clGetEventInfo")) return code;
    if (what == CL_EVENT_COMMAND_EXECUTION_STATUS) end_failing(1, &event);
    const cl_int code = CLSDF_NEXT(clGetEventInfo)(event, what, size, value, needed);
    cl_int status = 0;
    if (code != CL_SUCCESS || what != CL_EVENT_COMMAND_EXECUTION_STATUS || value == nullptr) return code;
    std::memcpy(&status, value, sizeof status);
    if (status == CL_COMPLETE && record().settings.ends_late) status = CL_RUNNING;
    std::memcpy(value, &status, sizeof status);
    return code;
}

cl_int clFinish(cl_command_queue queue) {
    const InCall in_call;
    if (const cl_int code = begin("clFinish")) return code;
    count_wait();
    end_failing(queue);
    return CLSDF_NEXT(clFinish)(queue);
}

cl_int clWaitForEvents(cl_uint events, const cl_event* list) {
    const InCall in_call;
    if (const cl_int code = begin("clWaitForEvents")) return code;
    if (events == 1 && is_pinned_read(list[0]))
        count([](Counts& counts) { ++counts.pinned_reads; });
    else
        count_wait();
    end_failing(events, list);
    return CLSDF_NEXT(clWaitForEvents)(events, list);
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, std::size_t offset,
                           std::size_t bytes, void* target, cl_uint waits, const cl_event* wait_list, cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueReadBuffer")) return code;
    if (const cl_int code = use(buffer)) return code;
    if (blocking != CL_FALSE) count_wait();
    count_command();
    count_down(bytes);
    note_transfer(target, bytes);
    if (is_failing(queue, waits, wait_list)) return fail_command(queue, blocking != CL_FALSE, event);
    const cl_int code =
        CLSDF_NEXT(clEnqueueReadBuffer)(queue, buffer, blocking, offset, bytes, target, waits, wait_list, event);
    if (code == CL_SUCCESS && event != nullptr) note_read(*event, target, bytes);
    return code;
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, std::size_t offset,
                            std::size_t bytes, const void* source, cl_uint waits, const cl_event* wait_list,
                            cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueWriteBuffer")) return code;
    if (const cl_int code = use(buffer)) return code;
    if (blocking != CL_FALSE) count_wait();
    count_command();
    count_up(bytes);
    note_transfer(source, bytes);
    if (is_failing(queue, waits, wait_list)) return fail_command(queue, blocking != CL_FALSE, event);
    return CLSDF_NEXT(clEnqueueWriteBuffer)(queue, buffer, blocking, offset, bytes, source, waits, wait_list, event);
}

cl_int clEnqueueFillBuffer(cl_command_queue queue, cl_mem buffer, const void* pattern, std::size_t pattern_bytes,
                           std::size_t offset, std::size_t bytes, cl_uint waits, const cl_event* wait_list,
                           cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueFillBuffer")) return code;
    if (const cl_int code = use(buffer)) return code;
    count_command();
    count([](Counts& counts) { ++counts.fills; });
    if (is_failing(queue, waits, wait_list)) return fail_command(queue, false, event);
    return CLSDF_NEXT(clEnqueueFillBuffer)(queue, buffer, pattern, pattern_bytes, offset, bytes, waits, wait_list,
                                           event);
}

cl_int clEnqueueCopyBuffer(cl_command_queue queue, cl_mem from, cl_mem to, std::size_t from_offset,
                           std::size_t to_offset, std::size_t bytes, cl_uint waits, const cl_event* wait_list,
                           cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueCopyBuffer")) return code;
    for (cl_mem buffer : {from, to})
        if (const cl_int code = use(buffer)) return code;
    count_command();
    count([](Counts& counts) { ++counts.copies; });
    if (is_failing(queue, waits, wait_list)) return fail_command(queue, false, event);
    return CLSDF_NEXT(clEnqueueCopyBuffer)(queue, from, to, from_offset, to_offset, bytes, waits, wait_list, event);
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const std::size_t* offsets,
                              const std::size_t* items, const std::size_t* group, cl_uint waits,
                              const cl_event* wait_list, cl_event* event) {
    const InCall in_call;
    cl_int status = CL_SUCCESS;  // of the kernel
    if (const cl_int code = begin("clEnqueueNDRangeKernel", &status)) return code;
    if (is_gpu()) {
        if (group != nullptr && product(dimensions, group) > largest_group) return CL_INVALID_WORK_GROUP_SIZE;
        if (has_too_many_groups(dimensions, items, group) || product(dimensions, items) > most_items)
            return CL_INVALID_VALUE;
        if (const cl_int code = use_arguments(kernel)) return code;
    }
    const std::string name = name_of(kernel);
    count_launch(name, product(dimensions, items));
    if (status != CL_SUCCESS) {
        count([&](Counts& counts) { counts.failed = name; });
        return fail_kernel(queue, status, event);
    }
    if (is_failing(queue, waits, wait_list)) return fail_command(queue, false, event);
    return CLSDF_NEXT(clEnqueueNDRangeKernel)(queue, kernel, dimensions, offsets, items, group, waits, wait_list,
                                              event);
}

// Calls that are neither counted nor fail.
#define CLSDF_PASS_UNCOUNTED(name, type) \
    cl_int name(type object) {           \
        const InCall in_call;            \
        return CLSDF_NEXT(name)(object); \
    }
CLSDF_PASS_UNCOUNTED(clRetainEvent, cl_event)
CLSDF_PASS_UNCOUNTED(clReleaseEvent, cl_event)
CLSDF_PASS_UNCOUNTED(clRetainKernel, cl_kernel)
CLSDF_PASS_UNCOUNTED(clReleaseKernel, cl_kernel)
CLSDF_PASS_UNCOUNTED(clRetainProgram, cl_program)
CLSDF_PASS_UNCOUNTED(clReleaseProgram, cl_program)
CLSDF_PASS_UNCOUNTED(clRetainCommandQueue, cl_command_queue)
CLSDF_PASS_UNCOUNTED(clReleaseCommandQueue, cl_command_queue)
CLSDF_PASS_UNCOUNTED(clRetainContext, cl_context)
CLSDF_PASS_UNCOUNTED(clReleaseContext, cl_context)
}
