// The properties that a device reports.
#include "disguise/gpu.hpp"

#include "disguise/external.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

namespace clsdf::disguise {

namespace {

template <class Value>
void write(const Value& answer, void* value) {
    std::memcpy(value, &answer, sizeof answer);
}

bool is_part_of_another(cl_device_id device) {
    cl_device_id whole = nullptr;
    return CLSDF_NEXT(clGetDeviceInfo)(device, CL_DEVICE_PARENT_DEVICE, sizeof whole, &whole, nullptr) == CL_SUCCESS &&
           whole != nullptr;
}

template <class Value>
Value own(cl_device_id device, cl_device_info name) {
    Value value{};
    CLSDF_NEXT(clGetDeviceInfo)(device, name, sizeof value, &value, nullptr);
    return value;
}

/// Replaces the processor's answer, which has the same size.
void disguise(cl_device_id device, cl_device_info name, void* value) {
    constexpr cl_uint alignment_bits = 8 * 512;
    switch (name) {
        case CL_DEVICE_TYPE:
            write(cl_device_type{CL_DEVICE_TYPE_GPU}, value);
            break;
        case CL_DEVICE_HOST_UNIFIED_MEMORY:
            write(cl_bool{CL_FALSE}, value);
            break;
        case CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT:
        case CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE:
        case CL_DEVICE_NATIVE_VECTOR_WIDTH_INT:
        case CL_DEVICE_PREFERRED_VECTOR_WIDTH_FLOAT:
        case CL_DEVICE_PREFERRED_VECTOR_WIDTH_DOUBLE:
        case CL_DEVICE_PREFERRED_VECTOR_WIDTH_INT:
            write(cl_uint{1}, value);
            break;
        case CL_DEVICE_MEM_BASE_ADDR_ALIGN:
            write(alignment_bits, value);
            break;
        case CL_DEVICE_MAX_WORK_GROUP_SIZE:
            write(std::min(largest_group, own<std::size_t>(device, name)), value);
            break;
        case CL_DEVICE_LOCAL_MEM_TYPE:
            write(cl_device_local_mem_type{CL_LOCAL}, value);
            break;
        case CL_DEVICE_LOCAL_MEM_SIZE:
            write(std::min(local_memory, own<cl_ulong>(device, name)), value);
            break;
        case CL_DEVICE_MAX_COMPUTE_UNITS:
            if (record().settings.compute_units > 0 && !is_part_of_another(device))
                write(cl_uint{record().settings.compute_units}, value);
            break;
        default:
            break;
    }
}

/// Devices in the order in which they were told.
struct Devices {
    std::mutex mutex;
    std::vector<cl_device_id> ids;
};
Devices& devices() {
    static auto* const only = new Devices;
    return *only;
}

/// Null if it has none.
const Answers* answers_of(cl_device_id device) {
    const std::scoped_lock lock(devices().mutex);
    const auto found = std::find(devices().ids.begin(), devices().ids.end(), device);
    const auto index = static_cast<std::size_t>(found - devices().ids.begin());
    const std::vector<Answers>& all = record().settings.devices;
    return found != devices().ids.end() && index < all.size() ? &all[index] : nullptr;
}

/// The answer of PoCL 3.0; empty if it does not differ.
std::string_view platform_of_pocl_3_0(cl_platform_info name) {
    if (name == CL_PLATFORM_NAME) return "Portable Computing Language";
    if (name == CL_PLATFORM_VERSION) return "OpenCL 3.0 PoCL 3.0-rc2  Linux, Release, RELOC, LLVM 14.0.6, SLEEF";
    return {};
}

cl_int answer(std::string_view text, std::size_t size, void* value, std::size_t* needed) {
    if (needed != nullptr) *needed = text.size() + 1;
    if (value == nullptr) return CL_SUCCESS;
    if (size <= text.size()) return CL_INVALID_VALUE;
    std::memcpy(value, text.data(), text.size());
    static_cast<char*>(value)[text.size()] = 0;
    return CL_SUCCESS;
}

cl_int answer(cl_uint number, std::size_t size, void* value, std::size_t* needed) {
    if (needed != nullptr) *needed = sizeof number;
    if (value == nullptr) return CL_SUCCESS;
    if (size < sizeof number) return CL_INVALID_VALUE;
    write(number, value);
    return CL_SUCCESS;
}

std::string text_of_driver(cl_device_id device, cl_device_info name) {
    std::size_t bytes = 0;
    CLSDF_NEXT(clGetDeviceInfo)(device, name, 0, nullptr, &bytes);
    std::string text(bytes, 0);
    CLSDF_NEXT(clGetDeviceInfo)(device, name, bytes, text.data(), nullptr);
    return text.substr(0, text.find('\0'));
}

/// Nothing if the driver is to answer.
std::optional<cl_int> answer(const Answers& answers, unsigned question, std::size_t size, void* value,
                             std::size_t* needed) {
    if (answers.refused.contains(question)) return CL_INVALID_VALUE;
    if (const auto text = answers.texts.find(question); text != answers.texts.end())
        return answer(text->second, size, value, needed);
    return std::nullopt;
}

/// Replaces a driver's number, of as many bytes.
void replace_number(const Answers& answers, unsigned question, std::size_t bytes, void* value) {
    if (const auto number = answers.numbers.find(question); number != answers.numbers.end())
        std::memcpy(value, &number->second, std::min(bytes, sizeof number->second));
}

/// The devices of a type when processors count as GPUs.
cl_device_type undisguised(cl_device_type type) {
    if (type == CL_DEVICE_TYPE_ALL || (type & CL_DEVICE_TYPE_DEFAULT) != 0) return type;
    const cl_device_type others = type & ~cl_device_type{CL_DEVICE_TYPE_CPU};
    return (type & CL_DEVICE_TYPE_GPU) != 0 ? others | CL_DEVICE_TYPE_CPU : others;
}

}  // namespace

}  // namespace clsdf::disguise

using namespace clsdf::disguise;

extern "C" {

cl_int clGetPlatformIDs(cl_uint room, cl_platform_id* platforms, cl_uint* found) {
    const InCall in_call;
    if (const cl_int code = begin("clGetPlatformIDs")) return code;
    if (!record().settings.without_platforms) return CLSDF_NEXT(clGetPlatformIDs)(room, platforms, found);
    constexpr cl_int no_platform = -1001;  // CL_PLATFORM_NOT_FOUND_KHR
    if (found != nullptr) *found = 0;
    return no_platform;
}

cl_int clGetPlatformInfo(cl_platform_id platform, cl_platform_info name, std::size_t size, void* value,
                         std::size_t* needed) {
    const InCall in_call;
    if (const cl_int code = begin("clGetPlatformInfo")) return code;
    if (record().settings.pocl_3_0)
        if (const std::string_view text = platform_of_pocl_3_0(name); !text.empty())
            return answer(text, size, value, needed);
    if (const auto code = answer(record().settings.platform, name, size, value, needed)) return *code;
    return CLSDF_NEXT(clGetPlatformInfo)(platform, name, size, value, needed);
}

cl_int clGetDeviceInfo(cl_device_id device, cl_device_info name, std::size_t size, void* value, std::size_t* needed) {
    const InCall in_call;
    if (const cl_int code = begin("clGetDeviceInfo")) return code;
    const bool pocl_3_0 = record().settings.pocl_3_0;
    if (pocl_3_0 && name == CL_DEVICE_NAME) return answer("pthread-AMD EPYC", size, value, needed);
    const Answers* const answers = answers_of(device);
    if (answers != nullptr)
        if (const auto code = answer(*answers, name, size, value, needed)) return *code;
    if (const auto code = external_answer(name, size, value, needed)) return *code;
    if (name == CL_DEVICE_EXTENSIONS && !external_extensions().empty())
        return answer(text_of_driver(device, name) + external_extensions(), size, value, needed);
    std::size_t bytes = 0;
    const cl_int code = CLSDF_NEXT(clGetDeviceInfo)(device, name, size, value, &bytes);
    if (code != CL_SUCCESS && answers != nullptr)
        if (const auto number = answers->numbers.find(name); number != answers->numbers.end())
            return answer(static_cast<cl_uint>(number->second), size, value, needed);
    if (needed != nullptr) *needed = bytes;
    if (code != CL_SUCCESS || value == nullptr) return code;
    if (is_gpu()) disguise(device, name, value);
    if (answers != nullptr) replace_number(*answers, name, bytes, value);
    if (pocl_3_0 && name == CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT) write(cl_uint{16}, value);
    return code;
}

cl_int clGetDeviceIDs(cl_platform_id platform, cl_device_type type, cl_uint room, cl_device_id* devices_found,
                      cl_uint* found) {
    const InCall in_call;
    if (const cl_int code = begin("clGetDeviceIDs")) return code;
    const cl_device_type meant = is_gpu() ? undisguised(type) : type;
    if (record().settings.without_devices || (meant == 0 && type != 0)) {
        if (found != nullptr) *found = 0;
        return CL_DEVICE_NOT_FOUND;
    }
    cl_uint all = 0;
    const cl_int code = CLSDF_NEXT(clGetDeviceIDs)(platform, meant, room, devices_found, &all);
    if (found != nullptr) *found = all;
    if (code == CL_SUCCESS && devices_found != nullptr) {
        const std::scoped_lock lock(devices().mutex);
        for (cl_uint i = 0; i < std::min(room, all); ++i)
            if (std::find(devices().ids.begin(), devices().ids.end(), devices_found[i]) == devices().ids.end())
                devices().ids.push_back(devices_found[i]);
    }
    return code;
}
}
