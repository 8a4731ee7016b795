#include "benchmarks/floors.hpp"

#include "core/stopwatch.hpp"
#include "device/context.hpp"

#include "kernel_sources.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace clsdf::bench {

namespace {

constexpr int runs = 7;
// Larger than every known cache.
constexpr std::size_t store_bytes = std::size_t{256} << 20;

/// Launches of the floors' kernels in the shape that suits the device.
class Bench {
public:
    explicit Bench(device::Context& context)
        : queue_(context.queue()),
          processor_(context.capabilities().is_processor),
          lanes_(processor_ ? std::clamp(context.capabilities().float_width, 8U, 16U) : 4),
          items_(processor_ ? context.capabilities().compute_units
                            : std::size_t{2048} * context.capabilities().compute_units),
          group_(processor_ ? 1 : std::min<std::size_t>(128, context.capabilities().largest_group)),
          bytes_(std::min(store_bytes, context.capabilities().largest_allocation)),
          program_(context.program(
              {"bench_floors.cl", fmt::format("-cl-std=CL1.2 -DLANES=1 -DFLOATS={}", lanes_), kernels::files})),
          target_(context.context(), CL_MEM_READ_WRITE, bytes_) {}

    bool has(const char* kernel) const {
        return program_.getInfo<CL_PROGRAM_KERNEL_NAMES>().find(kernel) != std::string::npos;
    }

    double bytes_per_second(const char* name) {
        const std::size_t vectors_an_item = bytes_ / (lanes_ * sizeof(float)) / items_;
        cl::Kernel kernel(program_, name);
        kernel.setArg(0, target_);
        kernel.setArg(1, static_cast<cl_ulong>(vectors_an_item));
        kernel.setArg(2, static_cast<cl_ulong>(processor_ ? vectors_an_item : 1));
        kernel.setArg(3, static_cast<cl_ulong>(processor_ ? 1 : items_));
        kernel.setArg(4, 1.0F);
        return static_cast<double>(vectors_an_item * items_ * lanes_ * sizeof(float)) / least_seconds(kernel, items_);
    }

    double operations_per_second() {
        const int rounds = processor_ ? 4'000'000 : 100'000;
        cl::Kernel kernel(program_, "bench_fma");
        kernel.setArg(0, target_);
        kernel.setArg(1, cl_int{rounds});
        kernel.setArg(2, 0.5F);
        kernel.setArg(3, 1.0F);
        constexpr double chains = 12, operations = 2;
        return chains * operations * rounds * static_cast<double>(lanes_ * items_) / least_seconds(kernel, items_);
    }

    double launch_seconds(std::size_t in_row) {
        cl::Kernel kernel(program_, "bench_nothing");
        kernel.setArg(0, target_);
        return least_seconds(kernel, 1, in_row) / static_cast<double>(in_row);
    }

private:
    double least_seconds(const cl::Kernel& kernel, std::size_t items, std::size_t in_row = 1) const {
        const std::size_t group = items % group_ == 0 ? group_ : 1;
        double least = 1e300;
        for (int run = 0; run <= runs; ++run) {
            const Stopwatch watch;
            for (std::size_t launch = 0; launch < in_row; ++launch)
                queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items), cl::NDRange(group));
            queue_.finish();
            if (run > 0) least = std::min(least, watch.seconds());  // the first one compiles, and touches the memory
        }
        return least;
    }

    const cl::CommandQueue& queue_;
    bool processor_;
    unsigned lanes_;
    std::size_t items_, group_, bytes_;
    cl::Program program_;
    cl::Buffer target_;
};

}  // namespace

Floors measure_floors(const Device& device) {
    return device::guarded([&] {
        Bench bench(device::context_of(device));
        Floors floors;
        floors.store_bytes_per_second = bench.bytes_per_second("bench_store");
        if (bench.has("bench_store_past_caches"))
            floors.store_past_caches_bytes_per_second = bench.bytes_per_second("bench_store_past_caches");
        floors.fma_per_second = bench.operations_per_second();
        floors.launch_seconds = bench.launch_seconds(1);
        constexpr std::size_t in_row = 1000;
        floors.launch_in_row_seconds = bench.launch_seconds(in_row);
        return floors;
    });
}

Device with_profiling(const Device& device) {
    return device::guarded([&] {
        const cl::Context& context = device::context_of(device).context();
        const cl::CommandQueue queue(context, device::context_of(device).device(), CL_QUEUE_PROFILING_ENABLE);
        return Device::from_handles(context(), device.id(), queue());
    });
}

}  // namespace clsdf::bench
