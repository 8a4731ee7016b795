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

// The programs, but for those of bricks, which have variants: ROW(member of Programs, kernel file, lanes of its
// vectors, further options, whether every_source() has it). The last four are expressions of ProgramSources.
#define CLSDF_PROGRAMS(ROW)                                                                          \
    ROW(scan, by_body("scan.cl", "scan_by_group.cl"), lanes, "", true)                               \
    ROW(radix_sort, "radix_sort.cl", lanes, group_option(), true)                                    \
    ROW(coarse_lists, by_body("coarse_lists.cl", "coarse_lists_by_group.cl"), lanes, "", true)       \
    ROW(sign_sweep, "sign_sweep.cl", 1, "", true)                                                    \
    /* exact sides of samples, on GPUs */                                                            \
    ROW(exact_sides, "exact_sides.cl", 1, "", is_by_group())                                         \
    /* links of a lattice, on GPUs */                                                                \
    ROW(links, "links.cl", 1, "", is_by_group())                                                     \
    ROW(fill, "fill.cl", lanes, "", true)                                                            \
    ROW(face_records, "face_records.cl", mesh_lanes(), "", true)                                     \
    ROW(mesh_topology, "mesh_topology.cl", lanes, group_option(), is_by_group())                     \
    /* lists what is left to the host */                                                             \
    ROW(host_lists, "host_lists.cl", lanes, group_option(), is_by_group())                           \
    /* copies boxes to targets with strides */                                                       \
    ROW(store, "box_store.cl", 1, "", true)                                                          \
    /* puts the bricks of a sparse field in order */                                                 \
    ROW(order, "brick_order.cl", 1, "", true)                                                        \
    /* the search of processors, and the outputs of points */                                        \
    ROW(points, "points.cl", lanes, "", true)                                                        \
    /* the order of points in memory of the device, and their signs */                               \
    ROW(point_order, "point_order.cl", lanes, "", true)                                              \
    ROW(point_signs, "point_signs.cl", lanes, "", true)                                              \
    /* frames of faces, the tree that GPUs search, the search, and that of a deeper tree */          \
    ROW(point_faces, "point_faces.cl", 1, "", is_by_group())                                         \
    ROW(binary_tree, "binary_tree.cl", lanes, "", is_by_group())                                     \
    ROW(nearest, "nearest_by_group.cl", lanes, stack_option(stack_entries), is_by_group())           \
    ROW(nearest_deep, "nearest_by_group.cl", lanes, stack_option(deep_stack_entries), is_by_group()) \
    /* the scan of many points */                                                                    \
    ROW(point_scan, "point_scan.cl", lanes, "", !is_by_group())

/// The kernel files and options of one body on devices with the same capabilities.
struct ProgramSources {
    KernelBody body;             ///< never automatic
    std::size_t lanes = 1;       ///< in a work-item's vectors
    std::size_t group_size = 0;  ///< work-items of a group, in the body by_group

    /// Throws Error(unsupported) if the device's work-groups are too small for the body.
    ProgramSources(const device::Context::Capabilities& capabilities, KernelBody asked);

    /// Lanes of vectors of doubles, in face_records.
    std::size_t mesh_lanes() const { return is_processor_ ? 8 : 1; }
    ProgramSource bricks_source(const BrickVariant& variant) const;
    /// Every program that a transform may ask for, each once.
    std::vector<ProgramSource> every_source() const;

    /// The options of every program, for vectors of so many lanes.
    std::string common_options(std::size_t of_lanes) const;

protected:
    /// For the rows of CLSDF_PROGRAMS.
    bool is_by_group() const { return body == KernelBody::by_group; }
    const char* by_body(const char* by_vector, const char* by_group) const {
        return is_by_group() ? by_group : by_vector;
    }
    std::string group_option() const { return " -DGROUP=" + std::to_string(group_size); }
    static std::string stack_option(std::size_t entries) { return " -DSTACK=" + std::to_string(entries); }

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
    device::Context* context = nullptr;
    ProgramSource source;

    /// Throws Error(device_failure) with the build log.
    cl::Program get(const device::BuildWatch& watch = {}) const;
    operator cl::Program() const { return get(); }
};

/// The kernels' programs for one device and body. Kernel objects are lent (DeviceTools::kernel()): they hold arguments,
/// and are not shared between threads.
struct Programs : ProgramSources {
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
    std::size_t part_group() const { return is_by_group() ? common_group : 1; }

#define PROGRAM(name, file, lanes, options, is_used) LazyProgram name;
    CLSDF_PROGRAMS(PROGRAM)
#undef PROGRAM
};

}  // namespace clsdf::engine
