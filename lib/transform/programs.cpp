#include "transform/programs.hpp"

#include "device/known_faults.hpp"

#include <algorithm>

namespace clsdf::transform {

namespace {

// Counters of all histograms together: enough for a GPU's work-items, and a few megabytes.
constexpr std::size_t histogram_budget = std::size_t{1} << 22;

/// Refuses what is known to fail before anything is built: a compiler that fails may end the process.
ProgramSources usable_sources(const device::Context& context, KernelBody asked) {
    ProgramSources sources(context.capabilities(), asked);
    device::refuse_known_fault(context.device(), sources.body == KernelBody::by_vector ? "by_vector" : "by_group");
    return sources;
}

/// With options that work around the implementation's faults, which concern programs for vectors alone.
ProgramSource around_faults(const device::Context& context, ProgramSource source, std::size_t lanes) {
    if (lanes == 1) return source;
    const device::Implementation implementation =
        device::guarded([&] { return device::implementation_of(context.device()); });
    source.options += device::options_around_faults(implementation, source.kernel_file);
    return source;
}

cl::Program compiled(device::Context& context, const ProgramSource& source, const device::BuildWatch& watch) {
    return context.program(source.kernel_file, source.options, watch);
}

}  // namespace

Programs::Programs(device::Context& context, KernelBody asked, const device::BuildWatch& watch)
    : ProgramSources(usable_sources(context, asked)),
      scan(compiled(context, scan_source(), watch)),
      coarse_lists(compiled(context, around_faults(context, coarse_lists_source(), lanes), watch)),
      sign_sweep(compiled(context, sign_sweep_source(), watch)),
      fill(compiled(context, fill_source(), watch)),
      mesh_records(compiled(context, around_faults(context, mesh_records_source(), mesh_lanes()), watch)) {}

cl::Program Programs::bricks(device::Context& context, const BrickVariant& variant,
                             const device::BuildWatch& watch) const {
    return compiled(context, bricks_source(variant), watch);
}

cl::Program Programs::store(device::Context& context, const device::BuildWatch& watch) const {
    return compiled(context, store_source(), watch);
}

cl::Program Programs::points(device::Context& context, const device::BuildWatch& watch) const {
    return compiled(context, points_source(), watch);
}

cl::Program Programs::point_scan(device::Context& context, const device::BuildWatch& watch) const {
    return compiled(context, point_scan_source(), watch);
}

std::size_t Programs::parallel_parts(const device::Context& context, std::size_t histogram) const {
    if (body == KernelBody::by_vector) {
        const std::size_t most = std::max<std::size_t>(histogram_budget / histogram, 1);
        return std::min(most, 8 * std::size_t{context.capabilities().compute_units});
    }
    return std::clamp<std::size_t>(histogram_budget / histogram, common_group, 8192) / common_group * common_group;
}

}  // namespace clsdf::transform
