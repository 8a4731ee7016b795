#include "transform/brick_kernel.hpp"

namespace clsdf::transform {

namespace {

// A launch ends within a fifth of a second. A pair of a polyhedron and a coarse brick is looked at by 64 groups; a
// small GPU does about ten million pairs a second.
constexpr double pairs_per_launch = 2e6;
constexpr std::size_t groups_per_coarse_brick = 64;

class BricksByGroup final : public BrickKernel {
public:
    BricksByGroup(device::Context& context, const Programs& programs, const std::shared_ptr<device::BufferPool>& pool,
                  const BrickInputs& inputs, const BrickVariant& variant)
        : BrickKernel(context, pool, inputs.lists, pairs_per_launch,
                      variant.count ? inputs.lists.order.size() * groups_per_coarse_brick : 0),
          finishing_(inputs.finishing),
          group_size_(programs.group_size),
          kernel_(programs.bricks(context, variant), "bricks_by_group") {
        const CoarseLists& lists = inputs.lists;
        kernel_.setArg(arg_layout, inputs.layout);
        kernel_.setArg(arg_order, order_);
        kernel_.setArg(arg_starts, *lists.starts);
        kernel_.setArg(arg_parts, static_cast<cl_uint>(lists.parts));
        kernel_.setArg(arg_entries, *lists.entries);
        kernel_.setArg(arg_caps, *lists.caps);
        kernel_.setArg(arg_polyhedra, *inputs.mesh.polyhedra);
        kernel_.setArg(arg_sign_bits, inputs.sign_bits);
        kernel_.setArg(arg_computed, inputs.computed);
        if (variant.count)
            kernel_.setArg(variant.nearest ? arg_optional + Finishing::argument_count : arg_optional, *counters_);
    }

    void enqueue_reset(CommandChain& chain, const OutputBuffers& outputs) override {
        kernel_.setArg(arg_distance, outputs.distance);
        if (finishing_ != nullptr) finishing_->set_arguments(kernel_, arg_optional, outputs);
        chain.then_fill(*counters_, counter_sets_ * CLSDF_COUNTERS * sizeof(cl_ulong));
    }

    void enqueue_launch(CommandChain& chain, std::size_t launch) override {
        kernel_.setArg(arg_begin, launches_[launch].begin);
        const std::size_t groups = (launches_[launch].end - launches_[launch].begin) * groups_per_coarse_brick;
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueNDRangeKernel(kernel_, cl::NullRange, cl::NDRange(groups * group_size_),
                                       cl::NDRange(group_size_), wait, event);
        });
    }

private:
    enum Argument : cl_uint {
        arg_layout,
        arg_begin,
        arg_order,
        arg_starts,
        arg_parts,
        arg_entries,
        arg_caps,
        arg_polyhedra,
        arg_sign_bits,
        arg_computed,
        arg_distance,
        arg_optional  // those of finishing, then the counters, if asked for
    };

    const Finishing* finishing_;
    std::size_t group_size_;
    cl::Kernel kernel_;
};

}  // namespace

std::unique_ptr<BrickKernel> make_bricks_by_group(device::Context& context, const Programs& programs,
                                                  const std::shared_ptr<device::BufferPool>& pool,
                                                  const BrickInputs& inputs, const BrickVariant& variant) {
    return std::make_unique<BricksByGroup>(context, programs, pool, inputs, variant);
}

}  // namespace clsdf::transform
