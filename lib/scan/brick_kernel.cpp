#include "scan/brick_kernel.hpp"

#include "device/buffer_pool.hpp"

#include <algorithm>

namespace clsdf::scan {

namespace {

// In a launch. Each has 64 groups of 128 work-items, and some drivers count work-items in 32 bits.
constexpr cl_uint most_coarse_bricks = 1U << 17;

}  // namespace

BrickKernel::BrickKernel(const ScanInputs& inputs, const CoarseLists& lists, double pairs_per_launch,
                         std::size_t counter_sets)
    : finishing_(inputs.finishing), counter_sets_(counter_sets) {
    double before = 0;
    double pairs = 0;
    cl_uint begin = 0;
    const auto count = static_cast<cl_uint>(lists.order.size());
    for (cl_uint i = 0; i < count; ++i) {
        pairs += lists.lengths[i];
        if (pairs < pairs_per_launch && i + 1 - begin < most_coarse_bricks && i + 1 < count) continue;
        launches_.push_back({begin, i + 1, before / static_cast<double>(lists.pairs)});
        before += pairs;
        pairs = 0;
        begin = i + 1;
    }
    if (!lists.order.empty()) order_ = device::copied(inputs.context, lists.order);
    if (counter_sets > 0) counters_ = inputs.pool->lease(counter_sets * CLSDF_COUNTERS * sizeof(cl_ulong), "counters");
}

void BrickKernel::set_outputs(cl::Kernel& kernel, cl_uint first, const OutputBuffers& outputs) const {
    cl_uint next = set_arguments(kernel, first, outputs.distance);
    if (finishing_ != nullptr) next = finishing_->set_arguments(kernel, next, outputs);
    if (counter_sets_ > 0) kernel.setArg(next, *counters_);
}

std::vector<std::size_t> BrickKernel::read_counters(const cl::CommandQueue& queue) const {
    if (counter_sets_ == 0) return {};
    std::vector<cl_ulong> sets(counter_sets_ * CLSDF_COUNTERS);
    queue.enqueueReadBuffer(*counters_, CL_TRUE, 0, sets.size() * sizeof(cl_ulong), sets.data());
    std::vector<std::size_t> sums(CLSDF_COUNTERS);
    for (std::size_t i = 0; i < sets.size(); ++i) sums[i % CLSDF_COUNTERS] += sets[i];
    return sums;
}

}  // namespace clsdf::scan
