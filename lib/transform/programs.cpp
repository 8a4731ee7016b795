#include "transform/programs.hpp"

#include "layout.h"

#include <fmt/format.h>

#include <algorithm>

namespace clsdf::transform {

namespace {

/// Lanes of a work-item's vectors: 512 bits where the processor has them, else 256, which narrower ones divide.
int lanes_of(const device::Context& context, KernelBody body) {
    if (body == KernelBody::by_group) return 1;
    return context.capabilities().float_width >= 16 ? 16 : 8;
}

std::string build_options(const device::Context& context, int lanes) {
    const bool rounds_roots =
        (context.device().getInfo<CL_DEVICE_SINGLE_FP_CONFIG>() & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    return fmt::format("-cl-std=CL1.2 -DLANES={}{}", lanes,
                       rounds_roots ? " -cl-fp32-correctly-rounded-divide-sqrt" : "");
}

std::string options_of(const BrickVariant& variant) {
    return fmt::format("{}{}{}", variant.triangle ? " -DNEAREST" : "", variant.count ? " -DCOUNT" : "",
                       variant.long_bricks ? " -DLONG_BRICKS" : "");
}

// Counters of all histograms together: enough for a GPU's work-items, and a few megabytes.
constexpr std::size_t histogram_budget = std::size_t{1} << 22;

}  // namespace

Programs::Programs(device::Context& context, KernelBody asked, const device::BuildWatch& watch)
    : body(asked != KernelBody::automatic        ? asked
           : context.capabilities().is_processor ? KernelBody::by_vector
                                                 : KernelBody::by_group) {
    lanes = static_cast<std::size_t>(lanes_of(context, body));
    const std::string options = build_options(context, lanes_of(context, body));
    scan = context.program("scan.cl", options, watch);
    coarse_lists = context.program("coarse_lists.cl", options, watch);
    sign_sweep = context.program("sign_sweep.cl", options, watch);
    fill = context.program("fill.cl", options, watch);
    group_size = std::min<std::size_t>(128, context.capabilities().largest_group);
    if (body == KernelBody::by_group && group_size < 64)
        throw Error(
            ErrorCode::unsupported,
            fmt::format(
                "the device allows work-groups of {} items, and the kernel body by_group needs 64; use by_vector",
                context.capabilities().largest_group));
    group_size = group_size >= 128 ? 128 : 64;
}

cl::Program Programs::bricks_by_vector(device::Context& context, const BrickVariant& variant,
                                       const device::BuildWatch& watch) const {
    return context.program("bricks_by_vector.cl",
                           build_options(context, lanes_of(context, body)) + options_of(variant) +
                               (context.capabilities().scattered_access ? " -DSCATTERED_ACCESS" : ""),
                           watch);
}

cl::Program Programs::bricks_by_group(device::Context& context, const BrickVariant& variant,
                                      const device::BuildWatch& watch) const {
    return context.program("bricks_by_group.cl",
                           fmt::format("{} -DGROUP={}{}", build_options(context, lanes_of(context, body)), group_size,
                                       options_of(variant)),
                           watch);
}

SliceShape Programs::slice_shape() const {
    return body == KernelBody::by_vector ? SliceShape{1, 8} : SliceShape{64, 64};
}

cl::Program Programs::slices(device::Context& context, const char* kernel_file, const SliceVariant& variant,
                             const device::BuildWatch& watch) const {
    // Rows of a piece are short: a vector is one brick's at most.
    const int brick_lanes = std::min(lanes_of(context, body), CLSDF_BRICK);
    return context.program(
        kernel_file,
        fmt::format("{} -DGROUP={} -DBATCH={}{}{}", build_options(context, brick_lanes), slice_shape().group,
                    slice_shape().batch, options_of(variant.brick), variant.key_64 ? " -DKEY_64" : ""),
        watch);
}

std::size_t Programs::parallel_parts(const device::Context& context, std::size_t histogram) const {
    if (body == KernelBody::by_vector) {
        const std::size_t most = std::max<std::size_t>(histogram_budget / histogram, 1);
        return std::min(most, 8 * std::size_t{context.capabilities().compute_units});
    }
    return std::clamp<std::size_t>(histogram_budget / histogram, common_group, 8192) / common_group * common_group;
}

}  // namespace clsdf::transform
