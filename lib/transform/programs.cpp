#include "transform/programs.hpp"

#include <fmt/format.h>

namespace clsdf::transform {

namespace {

std::string build_options(const device::Context& context) {
    // 512 bits where the device has them, else 256; narrower ones divide these.
    const int lanes = context.capabilities().float_width >= 16 ? 16 : 8;
    const bool rounds_roots =
        (context.device().getInfo<CL_DEVICE_SINGLE_FP_CONFIG>() & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    return fmt::format("-cl-std=CL1.2 -DLANES={}{}", lanes,
                       rounds_roots ? " -cl-fp32-correctly-rounded-divide-sqrt" : "");
}

}  // namespace

Programs::Programs(device::Context& context) {
    const std::string options = build_options(context);
    scan = context.program("scan.cl", options);
    coarse_lists = context.program("coarse_lists.cl", options);
    sign_sweep = context.program("sign_sweep.cl", options);
    fill = context.program("fill.cl", options);
}

cl::Program Programs::bricks(device::Context& context, bool with_triangle, bool count) const {
    return context.program("bricks_by_vector.cl",
                           build_options(context) + (with_triangle ? " -DNEAREST" : "") + (count ? " -DCOUNT" : ""));
}

std::size_t parallel_parts(const device::Context& context) {
    return 8 * std::size_t{context.capabilities().compute_units};
}

}  // namespace clsdf::transform
