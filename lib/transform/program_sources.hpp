#pragma once

#include <clsdf/distance_transform.hpp>

#include "device/context.hpp"
#include "device/kernel_text.hpp"

#include <string>
#include <vector>

namespace clsdf::transform {

/// What a brick kernel is compiled for.
struct BrickVariant {
    bool nearest = false;      ///< keeps the nearest polyhedron: other outputs than the distance are asked for
    bool count = false;        ///< counts its work
    bool long_bricks = false;  ///< spacing so unequal that distances take double
};

/// All that there are.
std::vector<BrickVariant> every_variant();
/// The options that a variant adds.
std::string options_of(const BrickVariant& variant);

/// A program before it is compiled.
struct ProgramSource {
    const char* kernel_file;
    std::string options;          ///< of clBuildProgram
    device::KernelFiles files{};  ///< of another library, beside the core's
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
    ProgramSource mesh_records_source() const { return {"mesh_records.cl", common_options(mesh_lanes())}; }
    /// Of its vectors, which are of doubles.
    std::size_t mesh_lanes() const { return is_processor_ ? 8 : 1; }
    ProgramSource points_source() const { return {"points.cl", common_options(lanes)}; }
    /// Of many points, by vectors.
    ProgramSource point_scan_source() const { return {"point_scan.cl", common_options(lanes)}; }
    /// Of boxes that go to targets with strides.
    ProgramSource store_source() const { return {"store_boxes.cl", common_options(1)}; }
    ProgramSource bricks_source(const BrickVariant& variant) const;
    /// Every program that a transform may ask for, each once.
    std::vector<ProgramSource> every_source() const;

    /// The options of every program, for vectors of so many lanes.
    std::string common_options(std::size_t of_lanes) const;

private:
    bool scattered_access_;
    bool is_processor_;
    std::string device_options_;
};

}  // namespace clsdf::transform
