// A driver of OpenCL whose objects do not carry its dispatch table, for tests: REFUSED_DRIVER in the environment says
// what is wrong.
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace {

using Table = std::array<void*, 256>;

struct Object {
    Table* table;
};

Table own_table{}, other_table{};
Object platform{&own_table}, device{&other_table};

bool is(std::string_view what) {
    const char* const value = std::getenv("REFUSED_DRIVER");
    return value != nullptr && what == value;
}

cl_int devices(Object*, cl_device_type, cl_uint room, Object** found, cl_uint* count) {
    if (count != nullptr) *count = 1;
    if (found != nullptr && room > 0) *found = &device;
    return CL_SUCCESS;
}

cl_int platforms(cl_uint room, Object** found, cl_uint* count) {
    if (is("no platform")) return -1001;  // CL_PLATFORM_NOT_FOUND_KHR
    own_table[2] = reinterpret_cast<void*>(&devices);
    if (is("no table")) platform.table = nullptr;
    if (is("the loader's table")) {
        // CL_ICD2_TAG_KHR in the place of clGetPlatformIDs.
        constexpr std::uint64_t mark = 0x4F50454E434C3331;
        std::memcpy(own_table.data(), &mark, sizeof(void*));
    }
    if (count != nullptr) *count = 1;
    if (found != nullptr && room > 0) *found = &platform;
    return CL_SUCCESS;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) void* clGetExtensionFunctionAddress(const char* name) {
    return std::string_view(name) == "clIcdGetPlatformIDsKHR" && !is("no driver") ? reinterpret_cast<void*>(&platforms)
                                                                                  : nullptr;
}
