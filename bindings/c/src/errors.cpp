#include "errors.hpp"

#include "same_version.hpp"

namespace clsdf::c {

namespace {

struct Last {
    std::string text;
    const char* message = "";
    std::int32_t opencl_code = 0;
};

thread_local Last last;

}  // namespace

void record(const char* message, int opencl_code) noexcept {
    last.opencl_code = opencl_code;
    last.message = "";
    if (message == nullptr || *message == 0) return;
    try {
        last.text = message;
        last.message = last.text.c_str();
    } catch (...) {
        last.message = "an error, and the host has not enough memory for its message";
    }
}

}  // namespace clsdf::c

void clsdf_c_same_version() {}

const char* clsdf_last_error() {
    return clsdf::c::last.message;
}

std::int32_t clsdf_last_opencl_error() {
    return clsdf::c::last.opencl_code;
}

void clsdf_set_last_error(const char* message) {
    clsdf::c::record(message, 0);
}
