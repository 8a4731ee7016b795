#pragma once

#include <clsdf/tuning.hpp>

#include "device/context.hpp"
#include "launch/short_launches.hpp"

#include <string>
#include <vector>

namespace clsdf::engine {

/// Counters of all histograms of a job together: enough for a GPU's work-items, and a few megabytes.
inline constexpr std::size_t most_counters = std::size_t{1} << 22;

/// Entries of the stack of a GPU's search for points: one for each node between the root of the tree and a leaf.
inline constexpr std::size_t stack_entries = 32, deep_stack_entries = 64;

/// The variant of a brick kernel.
struct BrickVariant {
    bool nearest = false;      ///< keeps the nearest polyhedron: other outputs than the distance are asked for
    bool count = false;        ///< counts its work
    bool long_bricks = false;  ///< spacing so unequal that distances take double
};

/// All variants.
std::vector<BrickVariant> every_variant();
/// The options that a variant adds.
std::string options_of(const BrickVariant& variant);

using device::ProgramSource;

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
    ProgramSource radix_sort_source() const {
        return {"radix_sort.cl", common_options(lanes) + " -DGROUP=" + std::to_string(group_size)};
    }
    ProgramSource coarse_lists_source() const {
        return {body == KernelBody::by_group ? "coarse_lists_by_group.cl" : "coarse_lists.cl", common_options(lanes)};
    }
    ProgramSource sign_sweep_source() const { return {"sign_sweep.cl", common_options(1)}; }
    ProgramSource fill_source() const { return {"fill.cl", common_options(lanes)}; }
    ProgramSource mesh_records_source() const { return {"mesh_records.cl", common_options(mesh_lanes())}; }
    /// For the body by_group alone, as radix_sort.
    ProgramSource mesh_topology_source() const {
        return {"mesh_topology.cl", common_options(lanes) + " -DGROUP=" + std::to_string(group_size)};
    }
    ProgramSource host_lists_source() const {
        return {"host_lists.cl", common_options(lanes) + " -DGROUP=" + std::to_string(group_size)};
    }
    /// Lanes of its vectors of doubles.
    std::size_t mesh_lanes() const { return is_processor_ ? 8 : 1; }
    ProgramSource points_source() const { return {"points.cl", common_options(lanes)}; }
    /// The order of points in memory of the device, and their signs.
    ProgramSource point_order_source() const { return {"point_order.cl", common_options(lanes)}; }
    ProgramSource point_signs_source() const { return {"point_signs.cl", common_options(lanes)}; }
    /// The tree that GPUs search, and the search, with a stack of so many entries. For the body by_group alone.
    ProgramSource binary_tree_source() const { return {"binary_tree.cl", common_options(lanes)}; }
    ProgramSource nearest_source(std::size_t stack) const {
        return {"nearest_by_group.cl", common_options(lanes) + " -DSTACK=" + std::to_string(stack)};
    }
    /// The scan of many points, by vectors.
    ProgramSource point_scan_source() const { return {"point_scan.cl", common_options(lanes)}; }
    /// Copies boxes to targets with strides.
    ProgramSource store_source() const { return {"store_boxes.cl", common_options(1)}; }
    /// Puts the bricks of a sparse field in order.
    ProgramSource order_source() const { return {"order_bricks.cl", common_options(1)}; }
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

/// Every program that a transform may ask for on any model of a processor with these capabilities. Bodies that a call
/// names (TransformOptions::body) are left out.
std::vector<ProgramSource> sources_of_level(device::Context::Capabilities capabilities);

/// A program that is built when it is used first.
struct LazyProgram {
    device::Context* context;
    ProgramSource source;

    /// Throws Error(device_failure) with the build log.
    cl::Program get(const device::BuildWatch& watch = {}) const;
    operator cl::Program() const { return get(); }
};

/// The kernels' programs for one device and body. Kernel objects are lent (DeviceTools::kernel()): they hold arguments,
/// and are not shared between threads.
struct Programs : ProgramSources {
    LazyProgram scan;
    LazyProgram radix_sort;
    LazyProgram coarse_lists;
    LazyProgram sign_sweep;
    LazyProgram fill;
    LazyProgram mesh_records;
    LazyProgram mesh_topology;  ///< of the body by_group
    LazyProgram host_lists;     ///< of the same: lists what is left to the host
    LazyProgram store;          ///< copies boxes to targets with strides
    LazyProgram order;          ///< puts the bricks of a sparse field in order
    LazyProgram points;         ///< looks up points anywhere, but for the body by_group; their outputs
    LazyProgram point_order;    ///< the order of points in memory of the device
    LazyProgram point_signs;    ///< and their signs
    LazyProgram binary_tree;    ///< of the body by_group: the tree that it searches
    LazyProgram nearest;        ///< and the search
    LazyProgram nearest_deep;   ///< in a tree that is deeper than stack_entries
    LazyProgram point_scan;     ///< the scan of many points, by vectors

    /// Programs that every field needs.
    static constexpr std::size_t field_programs = 5;

    /// Throws Error(unsupported) if the device cannot run the body.
    Programs(device::Context& context, KernelBody asked);

    /// Builds the programs of all fields.
    std::vector<cl::Program> of_fields(const device::BuildWatch& watch = {}) const;

    cl::Program bricks(device::Context& context, const BrickVariant& variant,
                       const device::BuildWatch& watch = {}) const;

    /// How many work-items share a job that is divided in ranges, each of which has `histogram` counters of its own.
    std::size_t parallel_parts(const device::Context& context, std::size_t histogram) const;
    /// The size of their groups.
    std::size_t part_group() const { return body == KernelBody::by_group ? common_group : 1; }
};

}  // namespace clsdf::engine
