#pragma once

#include <clsdf/distance_transform.hpp>

#include "device/context.hpp"

namespace clsdf::transform {

/// What a brick kernel is compiled for.
struct BrickVariant {
    bool triangle = false;     ///< keeps the nearest triangle
    bool count = false;        ///< counts its work
    bool long_bricks = false;  ///< spacing so unequal that distances take double
};

/// What the kernels of the scan by slices are compiled for.
struct SliceVariant {
    BrickVariant brick;   ///< the same options as there
    bool key_64 = false;  ///< distance and triangle in one 64-bit number
};

/// A group of `group` work-items takes `batch` intersections of a piece and a slice.
struct SliceShape {
    std::size_t group;
    std::size_t batch;
};

/// Work-items of a group where a kernel does not ask for another number. One for all grids, because PoCL compiles a
/// kernel anew for each.
constexpr std::size_t common_group = 64;

/// So many work-items, and what fills the last group.
constexpr std::size_t in_whole_groups(std::size_t items, std::size_t group = common_group) {
    return (items + group - 1) / group * group;
}

/// The kernels' programs for one device and body. Kernel objects are made anew for every use: they hold arguments, and
/// are not shared between threads.
struct Programs {
    KernelBody body;  ///< never automatic
    cl::Program scan;
    cl::Program coarse_lists;
    cl::Program sign_sweep;
    cl::Program fill;
    std::size_t group_size = 0;  ///< of the body by_group
    std::size_t lanes = 1;       ///< of a work-item's vectors

    /// Programs that every computation needs.
    static constexpr std::size_t common_programs = 4;

    Programs(device::Context& context, KernelBody asked, const device::BuildWatch& watch = {});

    cl::Program bricks_by_vector(device::Context& context, const BrickVariant& variant,
                                 const device::BuildWatch& watch = {}) const;
    cl::Program bricks_by_group(device::Context& context, const BrickVariant& variant,
                                const device::BuildWatch& watch = {}) const;

    cl::Program slices(device::Context& context, const char* kernel_file, const SliceVariant& variant,
                       const device::BuildWatch& watch = {}) const;
    SliceShape slice_shape() const;

    /// How many work-items share a job that is divided in ranges, each of which has `histogram` counters of its own.
    std::size_t parallel_parts(const device::Context& context, std::size_t histogram) const;
    /// The size of their groups.
    std::size_t part_group() const { return body == KernelBody::by_group ? common_group : 1; }
};

}  // namespace clsdf::transform
