// Memory of other interfaces, by OpenCL's extension cl_khr_external_memory.
#include "core/refuse.hpp"
#include "device/context.hpp"
#include "device/opencl.hpp"

#include <clsdf/device.hpp>
#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <array>
#include <cstdint>
#include <string>

// A function of OpenCL 3.0: null with loaders before 2020, which do not have it.
extern "C" CL_API_ENTRY cl_mem CL_API_CALL clCreateBufferWithProperties(cl_context context, const cl_ulong* properties,
                                                                        cl_mem_flags flags, std::size_t bytes,
                                                                        void* host, cl_int* error)
    __attribute__((weak));

namespace clsdf {

namespace {

constexpr cl_ulong external_memory_handle_opaque_fd = 0x2060;  // CL_EXTERNAL_MEMORY_HANDLE_OPAQUE_FD_KHR

bool has_extension(const cl::Device& device, const std::string& name) {
    return (' ' + device.getInfo<CL_DEVICE_EXTENSIONS>() + ' ').find(' ' + name + ' ') != std::string::npos;
}

}  // namespace

cl_mem Device::import_memory(int descriptor, std::size_t bytes) const {
    return device::guarded([&] {
        const device::Context& context = device::context_of(*this);
        if (bytes == 0) refuse("memory of 0 bytes cannot be imported; give its size");
        if (::fcntl(descriptor, F_GETFD) < 0)
            refuse(
                "the descriptor {} is not open; export the memory, and import it before the "
                "descriptor is closed",
                descriptor);
        const std::string extension = "cl_khr_external_memory_opaque_fd";
        if (!has_extension(context.device(), extension))
            refuse_unsupported(
                "the device \"{}\" has no {}, so it takes no memory of CUDA or Vulkan; NVIDIA's "
                "drivers from 510 on have it",
                name(), extension);
        if (clCreateBufferWithProperties == nullptr)
            refuse_unsupported(
                "the loader of OpenCL, libOpenCL.so.1, has no clCreateBufferWithProperties, which imports "
                "memory; install one of OpenCL 3.0 (Debian: ocl-icd-libopencl1)");
        const std::array<cl_ulong, 3> properties{external_memory_handle_opaque_fd,
                                                 static_cast<cl_ulong>(static_cast<unsigned>(descriptor)), 0};
        cl_int code = CL_SUCCESS;
        const cl_mem memory = clCreateBufferWithProperties(context.context()(), properties.data(), CL_MEM_READ_WRITE,
                                                           bytes, nullptr, &code);
        if (code == CL_SUCCESS) return memory;
        constexpr const char* call = "clCreateBufferWithProperties";
        if (code == CL_MEM_OBJECT_ALLOCATION_FAILURE || code == CL_OUT_OF_HOST_MEMORY || code == CL_OUT_OF_RESOURCES)
            throw cl::Error(code, call);
        throw Error(
            ErrorCode::invalid_argument,
            fmt::format("the driver of \"{}\" does not take the descriptor {} as memory of {} bytes ({}: {}); it "
                        "must be of memory of this device that has at least this size, exported as by CUDA's "
                        "cuMemExportToShareableHandle",
                        name(), descriptor, bytes, call, device::code_name(code)),
            code);
    });
}

}  // namespace clsdf
