#include "launch/programs.hpp"

#include "core/refuse.hpp"
#include "device/find/bundled_driver.hpp"
#include "device/opencl.hpp"
#include "layout.h"

#include <fmt/format.h>

#include <algorithm>

namespace clsdf::engine {

namespace {

KernelBody body_for(const device::Context::Capabilities& capabilities, KernelBody asked) {
    if (asked != KernelBody::automatic) return asked;
    return capabilities.is_processor ? KernelBody::by_vector : KernelBody::by_group;
}

/// Lanes of a work-item's vectors: 512 bits if the processor has them, else 256, which narrower ones divide.
std::size_t lanes_for(const device::Context::Capabilities& capabilities, KernelBody body) {
    if (body == KernelBody::by_group) return 1;
    return capabilities.float_width >= 16 ? 16 : 8;
}

/// Refuses what is known to fail before anything is built: a compiler that fails may end the process.
ProgramSources usable_sources(const device::Context& context, KernelBody asked) {
    ProgramSources sources(context.capabilities(), asked);
    device::refuse_known_fault(context.device(), sources.body);
    return sources;
}

device::Implementation implementation_of(const device::Context& context) {
    return device::guarded([&] { return device::implementation_of(context.device()); });
}

/// With options that work around the implementation's faults.
ProgramSource around_faults(const device::Implementation& implementation, ProgramSource source) {
    source.options += device::options_around_faults(implementation, source.kernel_file);
    return source;
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
    if (capabilities.largest_group < group_size)
        refuse_unsupported("the device allows work-groups of {} items, and the kernels need {}; use another device",
                           capabilities.largest_group, group_size);
}

std::string ProgramSources::common_options(std::size_t of_lanes) const {
    return fmt::format("-cl-std=CL1.2 -DLANES={}{}", of_lanes, device_options_);
}

ProgramSource ProgramSources::bricks_source(const BrickVariant& variant) const {
    if (body == KernelBody::by_group)
        return {"bricks_by_group.cl",
                fmt::format("{} -DGROUP={}{}", common_options(lanes), group_size, options_of(variant))};
    // Other variants have no use for it.
    const bool is_scattered = scattered_access_ && lanes == 16 && !variant.nearest;
    return {"bricks_by_vector.cl",
            common_options(lanes) + options_of(variant) + (is_scattered ? " -DSCATTERED_ACCESS" : "")};
}

std::vector<ProgramSource> ProgramSources::every_source() const {
    std::vector<ProgramSource> sources;
#define ADD(name, file, lanes, options, is_used) \
    if (is_used) sources.push_back({file, common_options(lanes) + (options)});
    CLSDF_PROGRAMS(ADD)
#undef ADD
    for (const BrickVariant& variant : every_variant()) sources.push_back(bricks_source(variant));
    // Of cutting::DeviceFractions, whose options are those of all.
    for (const char* const file : {"cut_cells.cl", "store_cells.cl"}) sources.push_back({file, common_options(1)});
    return sources;
}

std::vector<ProgramSource> sources_of_level(device::Context::Capabilities capabilities) {
    std::vector<ProgramSource> sources;
    for (const bool scattered_access : {false, true}) {
        capabilities.scattered_access = scattered_access;
        for (ProgramSource& source : ProgramSources(capabilities, KernelBody::automatic).every_source())
            if (std::none_of(sources.begin(), sources.end(), [&](const ProgramSource& other) {
                    return other.kernel_file == source.kernel_file && other.options == source.options;
                }))
                sources.push_back(std::move(source));
    }
    return sources;
}

cl::Program LazyProgram::get(const device::BuildWatch& watch) const {
    return device::guarded([&] { return context->program(source, watch); });
}

Programs::Programs(device::Context& context, KernelBody asked) : ProgramSources(usable_sources(context, asked)) {
    const device::Implementation implementation = implementation_of(context);
#define MAKE(name, file, lanes, options, is_used) \
    name = {&context, around_faults(implementation, {file, common_options(lanes) + (options)})};
    CLSDF_PROGRAMS(MAKE)
#undef MAKE
}

std::vector<cl::Program> Programs::of_fields(const device::BuildWatch& watch) const {
    std::vector<cl::Program> built;
    for (const LazyProgram& program : {scan, coarse_lists, sign_sweep, fill, face_records})
        built.push_back(program.get(watch));
    if (mesh_lanes() == 1) built.push_back(host_lists.get(watch));
    return built;
}

cl::Program Programs::bricks(device::Context& context, const BrickVariant& variant,
                             const device::BuildWatch& watch) const {
    return context.program(bricks_source(variant), watch);
}

std::size_t Programs::parallel_parts(const device::Context& context, std::size_t histogram) const {
    if (body == KernelBody::by_vector) {
        const std::size_t most = std::max<std::size_t>(most_counters / histogram, 1);
        return std::min(most, 8 * std::size_t{context.capabilities().compute_units});
    }
    return std::clamp<std::size_t>(most_counters / histogram, common_group, 8192) / common_group * common_group;
}

}  // namespace clsdf::engine

namespace clsdf {

void tuning::compile_level(const Device& device) {
    device::Context& context = device::context_of(device);
    engine::usable_sources(context, KernelBody::automatic);
    const device::Implementation implementation = engine::implementation_of(context);
    device::guarded([&] {
        for (const device::ProgramSource& source : engine::sources_of_level(context.capabilities()))
            context.program(engine::around_faults(implementation, source));
    });
}

std::vector<std::string> tuning::missing_programs(const Device& device) {
    const device::Context& context = device::context_of(device);
    std::vector<std::string> missing;
    device::guarded([&] {
        for (const device::BundledLevel& level : device::bundled_levels(context.device())) {
            device::Context::Capabilities capabilities = context.capabilities();
            capabilities.float_width = level.name == "x86-64-v4" ? 16 : 8;
            const device::Records programs(level.folder, device::PreparedPrograms::ending);
            for (const device::ProgramSource& source : engine::sources_of_level(capabilities))
                if (!programs.has(
                        device::program_key(level.target, "", source.options, device::kernel_text(source.kernel_file))))
                    missing.push_back(fmt::format("{} {} {}", level.name, source.kernel_file, source.options));
        }
    });
    return missing;
}

}  // namespace clsdf
