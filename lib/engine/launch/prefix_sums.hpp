#pragma once

#include <clsdf/error.hpp>

#include "device/buffer_pool.hpp"
#include "device/read_back.hpp"
#include "launch/commands.hpp"
#include "launch/device_tools.hpp"

#include <cstddef>

namespace clsdf::engine {

/// For lists of `what` that 32 bits cannot count.
Error too_many(const char* what);

/// The launches of exclusive prefix sums: of `count` 32-bit values into starts[0, count), and their total, if it fits
/// 32 bits, into starts[count].
class SumLaunches {
public:
    /// Throws Error(out_of_memory), naming `what`, if the values are too many to be counted in 32 bits.
    SumLaunches(const DeviceTools& tools, const cl::Buffer& values, const cl::Buffer& starts, std::size_t count,
                const char* what);

    /// launch(kernel, items) for each, whose arguments are set.
    template <class Launch>
    void each(const Launch& launch) {
        launch(sum_, all_);
        if (!by_group_) launch(offset_, {1, 1});
        launch(write_, all_);
    }

    /// 64-bit sums of parts of the values, and behind them the total.
    const cl::Buffer& sums() const { return *sums_; }
    std::size_t parts() const { return parts_; }
    std::size_t bytes() const { return sums_.bytes(); }

private:
    bool by_group_;  ///< then each group sums the parts before its own
    std::size_t parts_;
    WorkItems all_;
    device::BufferPool::Lease sums_;
    device::LentKernel sum_, offset_, write_;
};

/// The same sums, enqueued once, with their total for the host.
class PrefixSums {
public:
    /// Enqueues the sums and does not wait: what else the host must know can be asked for before it waits for all.
    /// Throws Error(out_of_memory), naming `what`, if the values are too many to be counted in 32 bits.
    PrefixSums(const DeviceTools& tools, const cl::Buffer& values, const cl::Buffer& starts, std::size_t count,
               const char* what);

    /// The sum of all values; waits for it. Throws Error(out_of_memory), naming `what`, if it exceeds 32 bits, so that
    /// the starts are wrong.
    std::size_t total();

private:
    const char* what_;
    SumLaunches launches_;
    device::ReadBack<cl_ulong> total_;
};

}  // namespace clsdf::engine
