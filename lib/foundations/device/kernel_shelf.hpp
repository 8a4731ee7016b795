#pragma once

#include "device/launched_kernels.hpp"
#include "device/opencl.hpp"

#include <exception>
#include <map>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

namespace clsdf::device {

/// Kernels that nobody uses at present, by program and name. To make one takes a driver nearly as long as a launch. A
/// kernel holds arguments, so it is lent to one user at a time.
class KernelShelf {
public:
    /// name: a literal. Throws cl::Error.
    cl::Kernel take(const cl::Program& program, const char* name) {
        {
            const std::scoped_lock lock(mutex_);
            std::vector<cl::Kernel>& kernels = kernels_[{program(), name}];
            if (!kernels.empty()) {
                cl::Kernel kernel = std::move(kernels.back());
                kernels.pop_back();
                return kernel;
            }
        }
        return {program, name};
    }
    void give_back(cl_program program, const char* name, cl::Kernel kernel) noexcept {
        try {
            const std::scoped_lock lock(mutex_);
            kernels_[{program, name}].push_back(std::move(kernel));
        } catch (const std::exception&) {
            // No memory to remember it by: it is released.
        }
    }

    LaunchedKernels& launched() { return launched_; }

private:
    std::mutex mutex_;
    std::map<std::pair<cl_program, std::string_view>, std::vector<cl::Kernel>> kernels_;  // the context keeps programs
    LaunchedKernels launched_;
};

/// A kernel of a context's program, which goes back to the shelf when this is destroyed. It may have arguments of
/// before. The context must outlive it.
class LentKernel : public cl::Kernel {
public:
    LentKernel() = default;
    /// name: a literal. Throws cl::Error.
    LentKernel(KernelShelf& shelf, const cl::Program& program, const char* name)
        : cl::Kernel(shelf.take(program, name)), shelf_(&shelf), program_(program()), name_(name) {}
    LentKernel(LentKernel&& other) noexcept
        : cl::Kernel(std::move(static_cast<cl::Kernel&>(other))),
          shelf_(std::exchange(other.shelf_, nullptr)),
          program_(other.program_),
          name_(other.name_) {}
    LentKernel& operator=(LentKernel&& other) noexcept {
        if (this == &other) return *this;
        give_back();
        cl::Kernel::operator=(std::move(static_cast<cl::Kernel&>(other)));
        shelf_ = std::exchange(other.shelf_, nullptr);
        program_ = other.program_;
        name_ = other.name_;
        return *this;
    }
    ~LentKernel() { give_back(); }

    const char* name() const { return name_; }
    /// It was launched.
    void note_launch() const noexcept { shelf_->launched().add(name_); }

private:
    void give_back() noexcept {
        if (shelf_ != nullptr) shelf_->give_back(program_, name_, std::move(static_cast<cl::Kernel&>(*this)));
        shelf_ = nullptr;
    }

    KernelShelf* shelf_ = nullptr;
    cl_program program_ = nullptr;
    const char* name_ = nullptr;
};

}  // namespace clsdf::device
