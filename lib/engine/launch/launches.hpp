#pragma once

#include "device/kernel_shelf.hpp"
#include "launch/commands.hpp"

namespace clsdf::engine {

/// Launches of kernels that run one after the other, in a queue in order or as a chain. Does not wait. Its
/// arguments must outlive it.
class Launches {
public:
    Launches(const cl::CommandQueue& in_order, device::KernelShelf& kernels) : queue_(&in_order), kernels_(kernels) {}
    Launches(CommandChain& chain, device::KernelShelf& kernels) : chain_(&chain), kernels_(kernels) {}

    device::LentKernel kernel(const cl::Program& program, const char* name) const { return {kernels_, program, name}; }

    /// With the arguments that the kernel has, whose first ones become these. Throws cl::Error.
    template <class... Arguments>
    void launch(device::LentKernel& kernel, const WorkItems& items, const Arguments&... arguments) const {
        if (chain_ != nullptr) {
            set_arguments(kernel, 0, arguments...);
            chain_->then_launch(kernel, items);
        } else {
            engine::launch(*queue_, kernel, items, arguments...);
        }
    }
    template <class... Arguments>
    void launch(const cl::Program& program, const char* name, const WorkItems& items,
                const Arguments&... arguments) const {
        device::LentKernel lent = kernel(program, name);
        launch(lent, items, arguments...);
    }

private:
    const cl::CommandQueue* queue_ = nullptr;
    CommandChain* chain_ = nullptr;
    device::KernelShelf& kernels_;
};

}  // namespace clsdf::engine
