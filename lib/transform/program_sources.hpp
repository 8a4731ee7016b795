#pragma once

#include <clsdf/distance_transform.hpp>

#include "device/context.hpp"

#include <string>
#include <vector>

namespace clsdf::transform {

/// What a brick kernel is compiled for.
struct BrickVariant {
    bool nearest = false;      ///< keeps the nearest polyhedron: other outputs than the distance are asked for
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

/// A program before it is compiled.
struct ProgramSource {
    const char* kernel_file;
    std::string options;  ///< of clBuildProgram
};

/// The kernel files and options of one body on devices with the same capabilities.
struct ProgramSources {
    KernelBody body;             ///< never automatic
    std::size_t lanes = 1;       ///< of a work-item's vectors
    std::size_t group_size = 0;  ///< of the body by_group

    /// Throws Error(unsupported) if the device's work-groups are too small for the body.
    ProgramSources(const device::Context::Capabilities& capabilities, KernelBody asked);

    ProgramSource scan_source() const {
        return {body == KernelBody::by_group ? "scan_by_group.cl" : "scan.cl", common_options(lanes)};
    }
    ProgramSource coarse_lists_source() const {
        return {body == KernelBody::by_group ? "coarse_lists_by_group.cl" : "coarse_lists.cl", common_options(lanes)};
    }
    ProgramSource sign_sweep_source() const { return {"sign_sweep.cl", common_options(lanes)}; }
    ProgramSource fill_source() const { return {"fill.cl", common_options(lanes)}; }
    ProgramSource bricks_source(const BrickVariant& variant) const;
    /// Of one of the scan's three kernel files.
    ProgramSource slices_source(const char* kernel_file, const SliceVariant& variant) const;
    SliceShape slice_shape() const;

    /// Every program that a transform may ask for, each once.
    std::vector<ProgramSource> every_source() const;

private:
    std::string common_options(std::size_t of_lanes) const;

    bool scattered_access_;
    std::string device_options_;
};

}  // namespace clsdf::transform
