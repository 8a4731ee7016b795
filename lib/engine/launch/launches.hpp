#pragma once

#include "launch/commands.hpp"

#include <map>
#include <string_view>
#include <utility>

namespace clsdf::engine {

/// Kernels by program and name, each made once: they hold arguments, so they are for one thread at a time.
class KernelCache {
public:
    /// name: a literal. Throws cl::Error.
    cl::Kernel& get(const cl::Program& program, const char* name) {
        const auto [kernel, is_new] = kernels_.try_emplace({program(), name});
        if (is_new) kernel->second = cl::Kernel(program, name);
        return kernel->second;
    }

private:
    std::map<std::pair<cl_program, std::string_view>, cl::Kernel> kernels_;
};

/// Launches of kernels that run one after the other, in a queue in order or as a chain. Does not wait. Its
/// arguments must outlive it.
class Launches {
public:
    Launches(const cl::CommandQueue& in_order, KernelCache& kernels) : queue_(&in_order), kernels_(kernels) {}
    Launches(CommandChain& chain, KernelCache& kernels) : chain_(&chain), kernels_(kernels) {}

    cl::Kernel& kernel(const cl::Program& program, const char* name) const { return kernels_.get(program, name); }

    /// With the arguments that the kernel has, whose first ones become these. Throws cl::Error.
    template <class... Arguments>
    void launch(cl::Kernel& kernel, const WorkItems& items, const Arguments&... arguments) const {
        set_arguments(kernel, 0, arguments...);
        if (chain_ != nullptr)
            chain_->then_launch(kernel, items);
        else
            queue_->enqueueNDRangeKernel(kernel, cl::NullRange, items.all(), items.of_group());
    }
    template <class... Arguments>
    void launch(const cl::Program& program, const char* name, const WorkItems& items,
                const Arguments&... arguments) const {
        launch(kernel(program, name), items, arguments...);
    }

private:
    const cl::CommandQueue* queue_ = nullptr;
    CommandChain* chain_ = nullptr;
    KernelCache& kernels_;
};

}  // namespace clsdf::engine
