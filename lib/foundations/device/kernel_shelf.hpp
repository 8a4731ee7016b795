#pragma once

#include "device/launched_kernels.hpp"
#include "device/opencl.hpp"

#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

namespace clsdf::device {

/// Kernels that nobody uses at present, by program and name. To make one takes a driver nearly as long as a launch. A
/// kernel holds arguments, so it is lent to one user at a time.
class KernelShelf {
public:
    /// Kernels of one program and name.
    using Place = std::vector<cl::Kernel>;
    struct Lent {
        cl::Kernel kernel;
        Place* place;
    };

    /// name: a literal. Throws cl::Error.
    Lent take(const cl::Program& program, const char* name) {
        Lent lent{{}, nullptr};
        {
            const std::scoped_lock lock(mutex_);
            lent.place = &places_[{program(), name}];
            if (!lent.place->empty()) {
                lent.kernel = std::move(lent.place->back());
                lent.place->pop_back();
                return lent;
            }
        }
        lent.kernel = cl::Kernel(program, name);
        return lent;
    }
    void give_back(Place& place, cl::Kernel kernel) noexcept {
        try {
            const std::scoped_lock lock(mutex_);
            place.push_back(std::move(kernel));
        } catch (const std::exception&) {
            // No memory to remember it by: it is released.
        }
    }

    LaunchedKernels& launched() { return launched_; }

private:
    using Key = std::pair<cl_program, const char*>;
    struct Hash {
        std::size_t operator()(const Key& key) const {
            return std::hash<const void*>()(key.first) * 31 + std::hash<const void*>()(key.second);
        }
    };

    std::mutex mutex_;
    // The context keeps programs. Literals of one name may have several places.
    std::unordered_map<Key, Place, Hash> places_;
    LaunchedKernels launched_;
};

/// A kernel of a context's program, which goes back to the shelf when this is destroyed. It may have arguments of
/// before. The context must outlive it.
class LentKernel : public cl::Kernel {
public:
    LentKernel() = default;
    /// name: a literal. Throws cl::Error.
    LentKernel(KernelShelf& shelf, const cl::Program& program, const char* name)
        : LentKernel(shelf, shelf.take(program, name), name) {}
    LentKernel(LentKernel&& other) noexcept
        : cl::Kernel(std::move(static_cast<cl::Kernel&>(other))),
          shelf_(std::exchange(other.shelf_, nullptr)),
          place_(other.place_),
          name_(other.name_) {}
    LentKernel& operator=(LentKernel&& other) noexcept {
        if (this == &other) return *this;
        give_back();
        cl::Kernel::operator=(std::move(static_cast<cl::Kernel&>(other)));
        shelf_ = std::exchange(other.shelf_, nullptr);
        place_ = other.place_;
        name_ = other.name_;
        return *this;
    }
    ~LentKernel() { give_back(); }

    const char* name() const { return name_; }
    /// It was launched.
    void note_launch() const noexcept { shelf_->launched().add(name_); }

private:
    LentKernel(KernelShelf& shelf, KernelShelf::Lent lent, const char* name)
        : cl::Kernel(std::move(lent.kernel)), shelf_(&shelf), place_(lent.place), name_(name) {}

    void give_back() noexcept {
        if (shelf_ != nullptr) shelf_->give_back(*place_, std::move(static_cast<cl::Kernel&>(*this)));
        shelf_ = nullptr;
    }

    KernelShelf* shelf_ = nullptr;
    KernelShelf::Place* place_ = nullptr;
    const char* name_ = nullptr;
};

}  // namespace clsdf::device
