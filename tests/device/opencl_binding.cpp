// OpenCL's C++ binding as a program has it that wants codes of errors, no exceptions.
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#include <CL/opencl.hpp>
#include <clsdf/clsdf.hpp>

#include <iostream>

// The library's object files are linked before this one: of an inline function that both define, theirs is taken.
int main() try {
    const clsdf::Device device = clsdf::Device::automatic();
    cl_int code = CL_SUCCESS;
    const cl::Context context(cl::Device(device.id(), true), nullptr, nullptr, nullptr, &code);
    if (code != CL_SUCCESS) return 1;
    const cl::Buffer buffer(context, CL_MEM_READ_WRITE, 0, nullptr, &code);
    if (code != CL_INVALID_BUFFER_SIZE) return 1;
    cl::Device().getInfo<CL_DEVICE_NAME>(&code);
    return code == CL_INVALID_DEVICE ? 0 : 1;
} catch (...) {
    std::cout << "OpenCL's binding of this program throws as the library's\n";
    return 1;
}
