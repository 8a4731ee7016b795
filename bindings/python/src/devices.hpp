#pragma once

#include "binding.hpp"

#include <clsdf/cuda.hpp>

#include <memory>
#include <mutex>
#include <optional>
#include <utility>

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
    explicit PyDevice(Device device) : state_(new State{std::move(device)}, DeleteHere()) {}

    /// Throws in a process that was forked.
    const Device& get() const {
        check_process();
        return state_->device;
    }

    /// The same device of CUDA, opened at the first call. With the GIL, which is released. Throws Error(no_device),
    /// Error(unsupported).
    cuda::SharedDevice cuda() const {
        const Device& device = get();
        const nb::gil_scoped_release no_gil;
        const std::scoped_lock lock(state_->mutex);
        if (!state_->cuda.has_value()) state_->cuda.emplace(device);
        return *state_->cuda;
    }
    /// Gives back what the device keeps for later calls. Returns the bytes. Without the GIL.
    std::size_t release_memory() const {
        const std::scoped_lock lock(state_->mutex);
        return get().release_memory() + (!state_->cuda.has_value() ? 0 : state_->cuda->release_memory());
    }

private:
    struct State {
        Device device;
        std::mutex mutex{};
        std::optional<cuda::SharedDevice> cuda{};
    };
    std::shared_ptr<State> state_;
};

}  // namespace clsdf::python
