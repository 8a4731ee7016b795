#include "device/find/opened_driver.hpp"

#include "device/opencl.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <dlfcn.h>
#include <algorithm>
#include <cstdint>
#include <cstring>

namespace clsdf::device {

namespace {

namespace fs = std::filesystem;

constexpr cl_int no_platform = -1001;  // CL_PLATFORM_NOT_FOUND_KHR

std::intptr_t word_at(const void* address) {
    std::intptr_t word = 0;
    std::memcpy(&word, address, sizeof word);
    return word;
}

/// Where an object's dispatch table is; 0 if it has none.
std::intptr_t table_of(const void* object) {
    return word_at(object);
}

/// Whether the loader keeps the table, in a second word of each object that only the loader that lists the platform
/// sets (cl_khr_icd 2.0). Such a table begins with this mark, in the place of clGetPlatformIDs.
bool is_kept_by_loader(std::intptr_t table) {
    constexpr std::intptr_t mark = sizeof(void*) == 4 ? 0x434C3331 : static_cast<std::intptr_t>(0x4F50454E434C3331);
    return word_at(reinterpret_cast<const void*>(table)) == mark;  // NOLINT: the table's address
}

/// Empty if the loader's functions reach the platform and its devices.
const char* wrong_tables(const cl::Platform& platform) {
    const std::intptr_t table = table_of(platform());
    if (table == 0) return "its platform has no dispatch table";
    if (is_kept_by_loader(table)) return "only OpenCL's loader can set the dispatch table of its platform";
    // The binding would already call functions of the devices' tables.
    cl_uint count = 0;
    std::vector<cl_device_id> devices;
    if (clGetDeviceIDs(platform(), CL_DEVICE_TYPE_ALL, 0, nullptr, &count) == CL_SUCCESS) devices.resize(count);
    if (devices.empty() || clGetDeviceIDs(platform(), CL_DEVICE_TYPE_ALL, count, devices.data(), nullptr) != CL_SUCCESS)
        return "";  // whoever lists them is told
    const bool is_own = std::ranges::all_of(devices, [&](cl_device_id one) { return table_of(one) == table; });
    return is_own ? "" : "its devices do not carry the dispatch table of their platform";
}

}  // namespace

std::vector<cl::Platform> open_driver(const fs::path& file) {
    using FunctionAddress = void*(CL_API_CALL*)(const char*);
    using PlatformIds = cl_int(CL_API_CALL*)(cl_uint, cl_platform_id*, cl_uint*);
    void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) throw Error(ErrorCode::no_device, fmt::format("it cannot be loaded: {}", ::dlerror()));
    const auto address = reinterpret_cast<FunctionAddress>(::dlsym(library, "clGetExtensionFunctionAddress"));
    const auto list = address == nullptr ? nullptr : reinterpret_cast<PlatformIds>(address("clIcdGetPlatformIDsKHR"));
    if (list == nullptr) throw Error(ErrorCode::no_device, fmt::format("{} is no driver of OpenCL", file.string()));
    cl_uint count = 0;
    cl_int code = list(0, nullptr, &count);
    std::vector<cl_platform_id> ids(count);
    if (code == CL_SUCCESS && count > 0) code = list(count, ids.data(), nullptr);
    if (code == CL_SUCCESS && count == 0) code = no_platform;
    if (code != CL_SUCCESS || std::ranges::find(ids, nullptr) != ids.end())
        throw Error(ErrorCode::no_device, fmt::format("{} has no platform: {}", file.string(), code_name(code)));
    std::vector<cl::Platform> platforms(ids.begin(), ids.end());
    for (const cl::Platform& platform : platforms)
        if (const std::string_view wrong = wrong_tables(platform); !wrong.empty())
            throw Error(ErrorCode::no_device,
                        fmt::format("{} is refused, since {}; OpenCL's loader can open it if a file "
                                    "/etc/OpenCL/vendors/NAME.icd has its path",
                                    file.string(), wrong));
    return platforms;
}

}  // namespace clsdf::device
