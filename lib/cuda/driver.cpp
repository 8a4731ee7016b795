#include "cuda/driver.hpp"

#include <clsdf/error.hpp>

#include <dlfcn.h>
#include <memory>
#include <mutex>

namespace clsdf::cuda {

namespace {

constexpr int out_of_memory = 2;

[[noreturn]] void refuse_driver(const std::string& reason) {
    throw Error(ErrorCode::no_device,
                "an array in memory of CUDA is used, and libcuda.so.1, NVIDIA's driver of CUDA, " + reason +
                    "; install the driver, or pass a copy of the array in the host's memory");
}

std::string name_of(const Driver& driver, int code) {
    const char* name = nullptr;
    driver.error_name(code, &name);
    return (name != nullptr ? std::string(name) + " (" : "error (") + std::to_string(code) + ")";
}

std::unique_ptr<Driver> opened() {
    void* const library = ::dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) refuse_driver(std::string("cannot be opened: ") + ::dlerror());
    auto driver = std::make_unique<Driver>();
#define CLSDF_CUDA_FUNCTION(member, function, parameters)                                     \
    driver->member = reinterpret_cast<decltype(driver->member)>(::dlsym(library, #function)); \
    if (driver->member == nullptr) refuse_driver("has no " #function ": it is older than CUDA 11.4");
    CLSDF_CUDA_FUNCTIONS(CLSDF_CUDA_FUNCTION)
#undef CLSDF_CUDA_FUNCTION
    if (const int code = driver->init(0)) refuse_driver("finds no device: cuInit: " + name_of(*driver, code));
    return driver;
}

}  // namespace

const Driver& driver() {
    // Never destroyed: the driver outlives every object. A driver that could not be opened is tried again.
    static auto& mutex = *new std::mutex;
    static const Driver* only = nullptr;
    const std::scoped_lock lock(mutex);
    if (only == nullptr) only = opened().release();
    return *only;
}

void check(int code, const char* call) {
    if (code == 0) return;
    throw Error(code == out_of_memory ? ErrorCode::out_of_memory : ErrorCode::device_failure,
                std::string("the CUDA call ") + call + " failed: " + name_of(driver(), code));
}

}  // namespace clsdf::cuda
