#pragma once

#include <cstddef>
#include <memory>
#include <string>

// The handles of OpenCL's C interface, so that this header needs none of OpenCL's.
typedef struct _cl_context* cl_context;
typedef struct _cl_device_id* cl_device_id;
typedef struct _cl_command_queue* cl_command_queue;

namespace clsdf {

namespace device {
class Context;
}

/// An OpenCL device with a context and a queue. Cheap to copy; copies share them.
class Device {
public:
    /// The strongest GPU, else the processor. Throws Error(no_device) that says what to install.
    static Device best();

    /// The caller's own objects; they are retained, and released with the last copy.
    static Device from_handles(cl_context context, cl_device_id device, cl_command_queue queue);

    std::string name() const;
    std::string platform() const;
    cl_context context() const;
    cl_device_id id() const;
    cl_command_queue queue() const;

    /// For the library's own stages.
    device::Context& internal() const { return *context_; }
    const std::shared_ptr<device::Context>& shared() const { return context_; }

private:
    explicit Device(std::shared_ptr<device::Context> context) : context_(std::move(context)) {}

    std::shared_ptr<device::Context> context_;
};

}  // namespace clsdf
