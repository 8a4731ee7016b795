#pragma once

#include "binding.hpp"

#include <memory>

namespace clsdf::python {

/// Deletes an object of the device, but for a process that was forked: there it is left alone.
struct DeleteHere {
    template <typename Object>
    void operator()(Object* object) const noexcept {
        if (is_process_of_devices()) {
            const nb::gil_scoped_release no_gil;
            delete object;
        }
    }
};
template <typename Object>
using Owner = std::unique_ptr<Object, DeleteHere>;

/// A device of the library, which ends with the process that opened it.
class PyDevice {
public:
    explicit PyDevice(Device device) : device_(new Device(std::move(device)), DeleteHere()) {}

    /// Throws in a process that was forked.
    const Device& get() const {
        check_process();
        return *device_;
    }

private:
    std::shared_ptr<Device> device_;
};

}  // namespace clsdf::python
