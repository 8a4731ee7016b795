#pragma once

#include "transform/program_sources.hpp"

namespace clsdf::transform {

/// Work-items of a group where a kernel does not ask for another number. One for all grids, because PoCL compiles a
/// kernel anew for each.
constexpr std::size_t common_group = 64;

/// So many work-items, and what fills the last group.
constexpr std::size_t in_whole_groups(std::size_t items, std::size_t group = common_group) {
    return (items + group - 1) / group * group;
}

/// The kernels' programs for one device and body. Kernel objects are made anew for every use: they hold arguments, and
/// are not shared between threads.
struct Programs : ProgramSources {
    cl::Program scan;
    cl::Program coarse_lists;
    cl::Program sign_sweep;
    cl::Program fill;
    cl::Program mesh_records;

    /// Programs that every computation needs.
    static constexpr std::size_t common_programs = 5;

    Programs(device::Context& context, KernelBody asked, const device::BuildWatch& watch = {});

    cl::Program bricks(device::Context& context, const BrickVariant& variant,
                       const device::BuildWatch& watch = {}) const;

    /// Of boxes that go to targets with strides.
    cl::Program store(device::Context& context, const device::BuildWatch& watch = {}) const;

    /// Of points anywhere.
    cl::Program points(device::Context& context, const device::BuildWatch& watch = {}) const;
    /// Of many points anywhere, by vectors.
    cl::Program point_scan(device::Context& context, const device::BuildWatch& watch = {}) const;

    /// How many work-items share a job that is divided in ranges, each of which has `histogram` counters of its own.
    std::size_t parallel_parts(const device::Context& context, std::size_t histogram) const;
    /// The size of their groups.
    std::size_t part_group() const { return body == KernelBody::by_group ? common_group : 1; }
};

}  // namespace clsdf::transform
