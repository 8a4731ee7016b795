#include "transform/program_sources.hpp"

#include "layout.h"

#include <fmt/format.h>

#include <algorithm>

namespace clsdf::transform {

namespace {

KernelBody body_for(const device::Context::Capabilities& capabilities, KernelBody asked) {
    if (asked != KernelBody::automatic) return asked;
    return capabilities.is_processor ? KernelBody::by_vector : KernelBody::by_group;
}

/// Lanes of a work-item's vectors: 512 bits where the processor has them, else 256, which narrower ones divide.
std::size_t lanes_for(const device::Context::Capabilities& capabilities, KernelBody body) {
    if (body == KernelBody::by_group) return 1;
    return capabilities.float_width >= 16 ? 16 : 8;
}

}  // namespace

std::vector<BrickVariant> every_variant() {
    std::vector<BrickVariant> variants;
    for (const bool nearest : {false, true})
        for (const bool count : {false, true})
            for (const bool long_bricks : {false, true}) variants.push_back({nearest, count, long_bricks});
    return variants;
}

std::string options_of(const BrickVariant& variant) {
    return fmt::format("{}{}{}", variant.nearest ? " -DNEAREST" : "", variant.count ? " -DCOUNT" : "",
                       variant.long_bricks ? " -DLONG_BRICKS" : "");
}

ProgramSources::ProgramSources(const device::Context::Capabilities& capabilities, KernelBody asked)
    : body(body_for(capabilities, asked)),
      lanes(lanes_for(capabilities, body)),
      group_size(capabilities.largest_group >= 128 ? 128 : 64),
      scattered_access_(capabilities.scattered_access),
      is_processor_(capabilities.is_processor),
      device_options_(fmt::format("{}{}", capabilities.rounds_roots ? " -cl-fp32-correctly-rounded-divide-sqrt" : "",
                                  capabilities.plain_inline ? " -DPLAIN_INLINE" : "")) {
    if (body == KernelBody::by_group && capabilities.largest_group < group_size)
        throw Error(
            ErrorCode::unsupported,
            fmt::format(
                "the device allows work-groups of {} items, and the kernel body by_group needs 64; use by_vector",
                capabilities.largest_group));
}

std::string ProgramSources::common_options(std::size_t of_lanes) const {
    return fmt::format("-cl-std=CL1.2 -DLANES={}{}", of_lanes, device_options_);
}

ProgramSource ProgramSources::bricks_source(const BrickVariant& variant) const {
    if (body == KernelBody::by_group)
        return {"bricks_by_group.cl",
                fmt::format("{} -DGROUP={}{}", common_options(lanes), group_size, options_of(variant))};
    return {"bricks_by_vector.cl",
            common_options(lanes) + options_of(variant) + (scattered_access_ ? " -DSCATTERED_ACCESS" : "")};
}

std::vector<ProgramSource> ProgramSources::every_source() const {
    std::vector<ProgramSource> sources{scan_source(),   coarse_lists_source(), sign_sweep_source(),  fill_source(),
                                       points_source(), store_source(),        mesh_records_source()};
    if (body == KernelBody::by_vector) sources.push_back(point_scan_source());
    for (const BrickVariant& variant : every_variant()) sources.push_back(bricks_source(variant));
    return sources;
}

}  // namespace clsdf::transform
