#pragma once

#include <clsdf/error.hpp>

// OpenCL's C++ binding, as the whole library sees it.
#define CL_HPP_ENABLE_EXCEPTIONS
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_TARGET_OPENCL_VERSION 120
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#include <CL/opencl.hpp>
#pragma GCC diagnostic pop

#include <string>
#include <utility>

namespace clsdf::device {

/// "CL_OUT_OF_RESOURCES" for -5, and so on.
std::string code_name(cl_int code);

/// The name of the call that failed: the C++ binding misspells some.
std::string call_name(const cl::Error& error);

/// The call that failed and its code's name, as clsdf::Error: out_of_memory for memory, else device_failure.
[[noreturn]] void throw_device_error(const cl::Error& error);

/// Runs OpenCL calls; their errors become clsdf::Error.
template <class Function>
decltype(auto) guarded(Function&& function) {
    try {
        return std::forward<Function>(function)();
    } catch (const cl::Error& error) {
        throw_device_error(error);
    }
}

}  // namespace clsdf::device
